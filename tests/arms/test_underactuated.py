"""Arms with joints that have no motor: what drives them, in which units, and what is designed for them."""

import casadi as ca
import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.laws import ArmPID, ArmStateFeedback, ComputedTorque, Rise, SlidingMode, SuperTwisting
from workbench.arms.manipulator import DirectDrive, FirstOrderLag, Friction, Manipulator
from workbench.arms.mechanics import Link, PlanarArm, SpatialArm, SpatialLink, robot
from workbench.arms.observers import ArmFullState, Luenberger, MomentumObserver, StateAndDisturbanceObserver
from workbench.arms.properties import positive_definite
from workbench.blocks.loop import AbstractReference, ClosedLoop, open_loop
from workbench.blocks.signals import Sines
from workbench.core import Signals, layout, lift
from workbench.design.linear import equilibria, linearize
from workbench.design.riccati import lqr

CART, POLE, HALF, INERTIA, DRAG, G = 0.5, 0.2, 0.3, 0.006, 0.1, 9.8


def cart_pole(passive=("hinge",)):
    """A cart of 0.5 kg with a pole of 0.2 kg, upright at q = 0."""
    none = np.zeros(3)
    cart = SpatialLink("slide", CART, none, np.zeros(6), axis=(1.0, 0.0, 0.0), joint="prismatic", viscous=DRAG)
    moments = (INERTIA, 0.0, 0.0, INERTIA, 0.0, 0.0)
    pole = SpatialLink("hinge", POLE, (0.0, 0.0, HALF), moments, axis=(0.0, 1.0, 0.0), parent=0)
    return SpatialArm((cart, pole), G, passive=passive)


class Upright(AbstractReference):
    """The cart at its place and the pole upright."""

    gives = layout(q=("m, rad", [0, 0]), qd=("m/s, rad/s", [0, 0]), qdd=("m/s^2, rad/s^2", [0, 0]))

    def at(self, t):
        return Signals({name: ca.SX.zeros(2) for name in self.gives.names})


def test_the_cart_pole_has_one_input_a_force_and_states_in_metres_and_radians():
    ode = open_loop(Manipulator(robot("cart-pole"), [0.0, 0.1]))
    assert [(name, ode.parameters[name].size, ode.parameters[name].unit) for name in ode.inputs] == [("tau", 1, "N")]
    for port in (ode.states, ode.outputs):
        assert [port[name].units for name in ("q", "qd")] == [("m", "rad"), ("m/s", "rad/s")]


def test_m_c_and_g_are_those_that_lagrange_gives_by_hand():
    """T = (M + m) x'^2 / 2 + m l x' a' cos a + (I + m l^2) a'^2 / 2, U = m g l cos a."""
    x, angle, rate = 0.7, 0.4, -1.3
    M, C, gravity = Dynamics.of(cart_pole()).matrices([x, angle], [0.2, rate])
    across = POLE * HALF * np.cos(angle)
    np.testing.assert_allclose(M, [[CART + POLE, across], [across, INERTIA + POLE * HALF**2]], rtol=1e-14)
    np.testing.assert_allclose(C, [[0, -POLE * HALF * np.sin(angle) * rate], [0, 0]], rtol=1e-14, atol=1e-16)
    np.testing.assert_allclose(gravity, [0, -POLE * G * HALF * np.sin(angle)], rtol=1e-14, atol=1e-16)


def upright(arm):
    return linearize(open_loop(Manipulator(arm, [0.0, 0.0])), 0.0, np.zeros(4), at_rest=True)


def test_the_linear_model_is_the_printed_one_of_an_inverted_pendulum():
    """Control Tutorials for MATLAB and Simulink, Inverted Pendulum: System Modeling, its x'' and phi'' of (x', phi, u).

    Its angle counts from upright towards -x, ours towards +x.
    """
    model = upright(cart_pole())
    p = INERTIA * (CART + POLE) + CART * POLE * HALF**2
    inertia, ml = INERTIA + POLE * HALF**2, POLE * HALF
    np.testing.assert_allclose(model.A[2], [0, -(ml**2) * G / p, -inertia * DRAG / p, 0], rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(model.A[3], [0, ml * G * (CART + POLE) / p, ml * DRAG / p, 0], rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(model.B, [[0], [0], [inertia / p], [-ml / p]], rtol=1e-13, atol=1e-15)


def test_the_regulator_has_one_row_and_the_published_numbers():
    """K of the same page for Q = diag(5000, 0, 100, 0) on (x, x', phi, phi'), R = 1, its angle turned round."""
    K = lqr(upright(cart_pole()), Q=np.diag([5000.0, 100.0, 0.0, 0.0]), R=np.eye(1)).K
    np.testing.assert_allclose(K, [[-70.7107, -105.5298, -37.8345, -20.9238]], rtol=0, atol=5e-5)  # four decimals


def test_the_regulator_is_a_law_for_the_loop_and_holds_the_pole_up():
    arm = cart_pole()
    K = lqr(upright(arm), Q=np.diag([5000.0, 100.0, 0.0, 0.0]), R=np.eye(1)).K
    law = ArmStateFeedback.of(arm, K)
    ode = ClosedLoop(Manipulator(arm, [0.1, 0.2]), ArmFullState(2), law, Upright()).ode()
    A = np.array(ode.A(0.0, np.zeros(4), ode.parameters.default))
    plant = upright(arm)
    np.testing.assert_allclose(A, plant.A - plant.B @ K, rtol=1e-12, atol=1e-12)
    assert np.linalg.eigvals(A).real.max() < -1
    assert ode.parameters["controller.Kp"].units == ("N/m", "N/rad")
    assert ode.parameters["controller.Kd"].units == ("N s/m", "N s/rad")


def test_a_law_for_every_joint_is_refused_where_one_has_no_motor():
    arm = cart_pole()
    with pytest.raises(ValueError, match="'tau' as 2 numbers, where `Manipulator` has as inputs it as one number"):
        ClosedLoop(
            Manipulator(arm, [0.0, 0.1]), ArmFullState(2), ComputedTorque(arm, [1.0, 1.0], [1.0, 1.0]), Upright()
        )
    with pytest.raises(ValueError, match="must have 1 row, one a motor, and 4 columns"):
        ArmStateFeedback.of(arm, np.ones((2, 4)))
    with pytest.raises(ValueError, match=r"must have a row for each motor of `model`, which has 1; got shape \(2, 2\)"):
        ArmStateFeedback(arm, np.eye(2), np.eye(2))


def test_a_passive_joint_moves_as_if_its_motor_gave_nothing():
    driven, free = (open_loop(Manipulator(cart_pole(passive), [0.1, 0.4], [0.3, -0.2])) for passive in ((), ("hinge",)))
    x = driven.states.default
    rates = [
        ode.rate_at(0.0, x, ode.parameters.pack({"tau": tau})[0])
        for ode, tau in ((driven, np.array([2.0, 0.0])), (free, np.array([2.0])))
    ]
    np.testing.assert_array_equal(*rates)


def test_the_acrobot_is_a_planar_arm_without_a_motor_at_the_shoulder():
    """M of Spong (1995), The swing up control problem for the acrobot, and a torque that acts at the elbow alone."""
    link = Link(1.0, 1.0, 0.5, 0.0, 1 / 12)
    arm = PlanarArm((link, link), passive=(0,))
    ode = open_loop(Manipulator(arm, [0.3, 0.5]))
    B = np.array(ode.B(0.0, ode.states.default, ode.parameters.default))
    M, _, _ = Dynamics.of(arm).matrices([0.3, 0.5], [0.0, 0.0])
    np.testing.assert_allclose(M @ B[2:], [[0.0], [1.0]], atol=1e-15)


@pytest.mark.parametrize(
    ("make", "error", "says"),
    [
        (lambda: cart_pole(("hing",)), LookupError, "no 'hing' among the 2 joints of this arm. Did you mean 'hinge'"),
        (lambda: cart_pole(("hinge", "slide")), ValueError, "must leave a joint with a motor; got all joints"),
        (lambda: cart_pole("hinge"), ValueError, r"`SpatialArm\(passive=...\)` must be a tuple of `str`"),
        (lambda: PlanarArm((Link(1.0, 1.0, 0.5),), passive=(1,)), ValueError, "whole number from 0 to 0, as the links"),
        (lambda: PlanarArm((Link(1.0, 1.0, 0.5),), passive=(0,)), ValueError, "must leave a joint with a motor"),
    ],
)
def test_passive_joints_that_cannot_be_are_refused(make, error, says):
    with pytest.raises(error, match=says):
        make()


def test_every_number_of_a_plant_that_slides_is_in_metres_and_newtons():
    drag = Friction([1.0, 2.0], [0.1, 0.2])
    lag = FirstOrderLag(0.1, [5.0])
    ode = open_loop(Manipulator(cart_pole(), [0.0, 0.1], friction=drag, actuator=lag))
    units = {name: ode.parameters[name].units for name in ode.parameters.names}
    assert units["arm.links[0].viscous"] == ("N s/m",)
    assert (units["friction.viscous"], units["friction.coulomb"]) == (("N s/m", "N m s/rad"), ("N", "N m"))
    assert (units["friction.speed"], units["actuator.limit"]) == (("m/s or rad/s",), ("N",))
    assert ode.states["tau_m"].unit == "N"


def test_an_arm_that_only_turns_keeps_its_units():
    ode = open_loop(Manipulator(robot("planar-2r"), [0.0, 0.1], friction=Friction(1.0 * np.ones(2), np.zeros(2))))
    assert ode.parameters["friction.viscous"].unit == "N m s/rad"
    assert ode.parameters["friction.speed"].unit == "rad/s"
    assert ode.parameters["tau"].unit == "N m"
    assert ode.states["q"].unit == "rad"


SLIDE_AND_HINGE = cart_pole(passive=())
LAWS = [
    (ArmPID([1.0, 1.0], [1.0, 1.0], [1.0, 1.0], SLIDE_AND_HINGE), "Ki", ("N/(m s)", "N m/(rad s)")),
    (ArmPID([1.0, 1.0], [1.0, 1.0], [1.0, 1.0]), "Ki", ("N m/(rad s)",) * 2),
    (SlidingMode(SLIDE_AND_HINGE, [1.0, 1.0], [1.0, 1.0], 0.1), "K", ("N", "N m")),
    (SlidingMode(SLIDE_AND_HINGE, [1.0, 1.0], [1.0, 1.0], 0.1), "phi", ("m/s or rad/s",)),
    (Rise([1.0, 1.0], [1.0, 1.0], [1.0, 1.0], [1.0, 1.0], 0.1, model=SLIDE_AND_HINGE), "beta", ("N/s", "N m/s")),
    (SuperTwisting(SLIDE_AND_HINGE, [1.0, 1.0], [1.0, 1.0], [1.0, 1.0], 0.1), "k2", ("m/s^3", "rad/s^3")),
]


@pytest.mark.parametrize(("law", "name", "units"), LAWS, ids=lambda given: given if isinstance(given, str) else "")
def test_the_numbers_of_a_law_have_the_units_of_its_joints(law, name, units):
    assert lift(law).layout[name].units == units


def test_the_memory_and_the_signals_of_blocks_have_the_units_of_their_joints():
    observer = StateAndDisturbanceObserver(
        Luenberger(SLIDE_AND_HINGE, np.eye(2), np.eye(2), q_hat=[0.1, 0.2]), MomentumObserver(SLIDE_AND_HINGE, l=10.0)
    )
    law = SlidingMode(SLIDE_AND_HINGE, [1.0, 1.0], [1.0, 1.0], 0.1)
    ode = ClosedLoop(Manipulator(SLIDE_AND_HINGE, [0.0, 0.1]), observer, law, Upright()).ode()
    units = {name: ode.states[f"observer.{name}"].units for name in observer.memory.names}
    assert (units["state.q_hat"], units["state.qd_hat"]) == (("m", "rad"), ("m/s", "rad/s"))
    assert units["disturbance.p_hat"] == ("N s", "N m s")
    assert ode.outputs["s"].units == ("m/s", "rad/s")


def test_a_drive_has_a_number_for_each_motor():
    assert Manipulator(cart_pole(), [0.0, 0.1], actuator=DirectDrive([5.0])).inputs.size == 1
    with pytest.raises(ValueError, match="needs one number a motor: its 'limit' has 2, the arm has 1 motor"):
        Manipulator(cart_pole(), [0.0, 0.1], actuator=DirectDrive([5.0, 5.0]))


def test_a_claim_about_all_joints_has_the_unit_of_its_joints():
    turning, both = robot("planar-1r"), cart_pole()
    slide = SpatialArm((both.links[0],), G)
    said = [positive_definite(Dynamics.of(arm), -1.0, 1.0).evidence for arm in (turning, slide, both)]
    for evidence, unit in zip(said, ("kg m^2", "kg", "in mixed units"), strict=True):
        assert f" {unit} at q = " in evidence


def test_the_rest_points_of_the_cart_pole_are_a_continuum_and_are_called_so():
    ode = open_loop(Manipulator(cart_pole(), [0.0, 0.1]))
    box = {"q[0]": (-1.0, 1.0), "q[1]": (-1.0, 4.0), "qd": (-1.0, 1.0)}
    found = equilibria(ode, box, starts=16, boxes=0)
    assert found.points
    assert {point.along for point in found.points} == {("q[0]",)}
    assert f"{len(found.points)} of them on a continuum of rest points, along which 'q[0]' changes" in str(found)


def test_a_reference_in_radians_alone_does_not_fit_a_slide():
    arm = cart_pole()
    law = ArmStateFeedback.of(arm, np.ones((1, 4)))
    with pytest.raises(ValueError, match=r"follows 'q' in \[m, rad\], where `Sines` gives it in \[rad\]"):
        ClosedLoop(Manipulator(arm, [0.0, 0.1]), ArmFullState(2), law, Sines("q", "rad", [0.1, 0.1], [1.0, 1.0]))
