"""A robot arm with disturbance, friction and drives."""

import casadi as ca
import numpy as np
import pytest

from workbench.arms.dynamics import Dynamics
from workbench.arms.manipulator import DirectDrive, FirstOrderLag, Friction, Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.blocks.loop import open_loop
from workbench.blocks.signals import SineTorque


def friction(qd, **numbers):
    drag = Friction(**{"viscous": [0.5, 1.0], "coulomb": [2.0, 3.0], "speed": 0.1, **numbers})
    return np.array(ca.evalf(drag.torque(ca.SX(qd)))).ravel()


def test_friction_takes_energy_at_every_speed():
    rng = np.random.default_rng(0)
    for qd in rng.normal(size=(50, 2)) * np.logspace(-4, 1, 50)[:, None]:
        assert (friction(qd) * qd > 0).all()


def test_friction_is_odd_and_ends_as_viscous_plus_coulomb():
    np.testing.assert_array_equal(friction([0.3, -0.2]), -friction([-0.3, 0.2]))
    np.testing.assert_allclose(friction([5.0, -5.0]), [2.5 + 2, -5 - 3], rtol=1e-14)  # tanh(50) = 1
    np.testing.assert_array_equal(friction([0.0, 0.0]), [0, 0])


def test_the_plant_obeys_equation_1_with_every_torque_that_acts():
    arm, drag, D = paper_arm(), Friction([0.5, 1.0], [2.0, 3.0], 0.1), SineTorque([4.0, 5.0], [2.0, 3.0])
    plant = Manipulator(arm, [0.4, -0.7], [1.0, 2.0], disturbance=D, friction=drag, actuator=DirectDrive([6.0, 6.0]))
    ode = open_loop(plant)
    t, tau = 0.9, np.array([10.0, -3.0])
    rate = ode.rate_at(t, ode.states.default, ode.parameters.pack({"tau": tau})[0])
    M, C, G = Dynamics.of(arm).matrices([0.4, -0.7], [1.0, 2.0])
    qd = np.array([1.0, 2.0])
    F = drag.viscous * qd + drag.coulomb * np.tanh(qd / 0.1)
    balance = M @ rate[2:] + C @ qd + G + F + [4 * np.sin(1.8), 5 * np.sin(2.7)] - [6.0, -3.0]
    np.testing.assert_array_equal(rate[:2], qd)
    np.testing.assert_allclose(balance, 0, atol=1e-13)  # rounding of terms up to 30, cond(M) up to 34


def test_every_number_of_the_plant_is_a_parameter_by_its_path():
    plant = Manipulator(
        paper_arm(),
        [0.0, 0.0],
        disturbance=SineTorque([4.0, 5.0], [2.0, 3.0]),
        friction=Friction([0.5, 1.0], [2.0, 3.0]),
        actuator=FirstOrderLag(0.1, [9.0, 9.0]),
    )
    names = open_loop(plant).parameters.names
    assert {"arm.links[1].mass", "disturbance.amplitude", "friction.coulomb", "actuator.limit", "tau"} <= set(names)


def test_the_memory_begins_where_the_user_says():
    states = open_loop(Manipulator(paper_arm(), [0.3, 0.4], 0.5, actuator=FirstOrderLag(0.1))).states
    assert states.names == ("q", "qd", "tau_m")
    np.testing.assert_array_equal(states.default, [0.3, 0.4, 0.5, 0.5, 0, 0])


def test_the_instruments_show_the_true_disturbance_to_those_who_may_see_it():
    plant = Manipulator(paper_arm(), [0.0, 0.0], disturbance=SineTorque([4.0, 5.0], [2.0, 3.0]))
    seen = plant.measure(ca.SX(0.5), {"q": ca.SX([1.0, 2.0]), "qd": ca.SX([3.0, 4.0])})
    np.testing.assert_allclose(np.array(ca.evalf(seen.d)).ravel(), [4 * np.sin(1), 5 * np.sin(1.5)], rtol=1e-14)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Manipulator(paper_arm(), [0.0]), r"`Manipulator\(q=...\)` must be an array of shape \(n = 2\)"),
        (lambda: Manipulator(paper_arm(), [0.0, np.nan]), "must be finite"),
        (
            lambda: Manipulator(robot("planar-3r"), np.zeros(3), disturbance=SineTorque([1.0, 1.0], 2.0)),
            "acts on 2 joints, the arm has 3",
        ),
        (
            lambda: Manipulator(robot("planar-3r"), np.zeros(3), friction=Friction([1.0, 1.0], [1.0, 1.0])),
            r"`Manipulator\(friction=...\)`",
        ),
        (
            lambda: Manipulator(robot("planar-3r"), np.zeros(3), actuator=DirectDrive([1.0, 1.0])),
            r"`Manipulator\(actuator=...\)`",
        ),
        (lambda: Friction([1.0, 1.0], [1.0, 1.0, 1.0]), r"`Friction\(coulomb=...\)`"),
        (lambda: Friction([1.0, -1.0], [1.0, 1.0]), r"`Friction\(viscous=...\)`"),
    ],
)
def test_a_plant_that_cannot_be_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_the_input_of_the_open_loop_is_the_torque():
    ode = open_loop(Manipulator(paper_arm(), [0.1, 0.2]))
    assert ode.inputs == ("tau",)
    assert ode.input_symbols.shape == (2, 1)
    assert ode.parameters["tau"].unit == "N m"
    M, _, _ = Dynamics.of(paper_arm()).matrices([0.1, 0.2], [0, 0])
    B = np.array(ode.B(0, ode.states.default, ode.parameters.default))
    np.testing.assert_allclose(B[2:] @ M, np.eye(2), atol=1e-14)
    np.testing.assert_array_equal(B[:2], 0)
