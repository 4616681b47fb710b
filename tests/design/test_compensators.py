"""Poles that are placed, and compensators that give a margin; what has no derivative is refused by name."""

import casadi as ca
import control
import numpy as np
import pytest

from workbench.blocks.laws import StateFeedback
from workbench.blocks.loop import AbstractPlant, ClosedLoop, LinearLaw, LinearPlant, open_loop
from workbench.core import block, layout
from workbench.design.linear import lead_lag, linearize, place
from workbench.design.matrices import DesignError
from workbench.design.riccati import lqg

MASSES = control.ss([[0, 0, 1, 0], [0, 0, 0, 1], [-1, 1, 0, 0], [1, -1, 0, 0]], [[0], [0], [1], [0]], [[0, 1, 0, 0]], 0,
                    inputs="f", outputs="x2", states=["x1", "x2", "v1", "v2"], name="masses")  # fmt: skip
MOTOR = control.tf([10], [1, 1, 0], inputs="v", outputs="theta", name="motor")


@pytest.mark.parametrize("poles", [[-1, -2, -1 + 1j, -1 - 1j], [-2, -2, -2, -2], [-1 + 2j, -1 - 2j, -1 + 2j, -1 - 2j]])
def test_the_characteristic_polynomial_is_that_of_the_poles(poles):
    K = place(MASSES, poles).K
    # the coefficients, unlike the poles, are moved by rounding alone
    np.testing.assert_allclose(np.poly(MASSES.A - MASSES.B @ K), np.poly(poles).real, rtol=0, atol=1e-9)


def test_two_inputs_have_room_for_a_pole_twice():
    both = control.ss(MASSES.A, np.vstack([np.zeros((2, 2)), np.eye(2)]), np.eye(4), 0)
    placed = place(both, [-1, -1, -2, -2])
    np.testing.assert_allclose(np.sort(placed.poles.real), [-2, -2, -1, -1], atol=1e-6)
    with pytest.raises(DesignError, match="python-control has no such gain"):
        place(both, [-1, -1, -1, -2])


def test_a_placed_gain_runs_in_the_loop():
    plant = LinearPlant(control.ss(MASSES.A, MASSES.B, np.eye(4), 0, inputs="f", outputs=["x1", "x2", "v1", "v2"],
                                   states=["x1", "x2", "v1", "v2"]))  # fmt: skip
    ode = ClosedLoop(plant, controller=StateFeedback.of(plant, place(MASSES, [-1, -2, -3, -4]).K)).ode()
    poles = np.linalg.eigvals(np.array(ode.A(0, np.zeros(4), ode.parameters.default)))
    np.testing.assert_allclose(np.sort(poles.real), [-4, -3, -2, -1], rtol=1e-9)


@pytest.mark.parametrize(("crossover", "boost"), [(2.0, 1.0), (5.0, 1.0), (5.0, 10.0)])
def test_a_lead_lag_loop_has_the_crossover_and_the_margin(crossover, boost):
    C = lead_lag(MOTOR, crossover, 50.0, boost)
    _, margin, _, wc = control.margin(MOTOR * C)
    np.testing.assert_allclose([wc, margin], [crossover, 50.0], rtol=1e-6)  # python-control finds the crossing by roots
    assert (C.input_labels, C.output_labels) == (["theta"], ["v"])
    if boost > 1:
        steady = lead_lag(MOTOR, crossover, 50.0)
        assert C.dcgain() > 0.8 * boost * steady.dcgain()  # the lead pays for six degrees of the lag


def test_a_lead_lag_law_runs_in_the_loop_and_in_a_computer():
    from workbench.blocks.loop import AbstractReference
    from workbench.core import parameter

    @block
    class Angle(AbstractReference):
        theta: float = parameter(default=1.0, unit="rad")
        gives = layout(theta="rad")

        def at(self, t):
            return {"theta": self.theta}

    C = lead_lag(MOTOR, 5.0, 50.0)
    ode = ClosedLoop(MOTOR, controller=LinearLaw(C, error=True), reference=Angle()).ode()
    poles = np.linalg.eigvals(np.array(ode.A(0, ode.states.default, ode.parameters.default)))
    np.testing.assert_allclose(np.sort_complex(poles), np.sort_complex(control.feedback(MOTOR * C).poles()), rtol=1e-9)
    loop = ClosedLoop(MOTOR, controller=LinearLaw(control.c2d(C, 0.02, "tustin"), error=True), reference=Angle())
    sampled = loop.digital(0.02, inputs=True)
    ours = linearize(sampled, 0.0, np.zeros(sampled.states.size))
    z = np.exp(1j * np.array([1.0, 10.0]) * 0.02)
    theirs = control.feedback(control.c2d(MOTOR, 0.02) * control.c2d(C, 0.02, "tustin"))
    np.testing.assert_allclose(ours["theta", "theta_ref"](z), theirs(z), rtol=1e-9)


def test_a_discrete_lqg_law_closes_the_sampled_loop_about_its_operating_point():
    plant = control.ss(MASSES, name="masses")
    design = lqg(control.c2d(plant, 0.1), np.eye(4), [[1.0]], 0.1 * np.eye(4), [[0.01]])
    law = LinearLaw(design.controller, u0=[0.0], v0=[2.0])  # the masses may rest anywhere: at 2 m, say
    sampled = ClosedLoop(plant, controller=law).digital(0.1, inputs=True)
    rest = sampled.states.pack({"plant.x1": 2.0, "plant.x2": 2.0})[0]
    poles = linearize(sampled, 0.0, rest, at_rest=True).poles()
    ours = sorted(poles, key=abs)[-8:]  # those of what the computer only holds are zero
    np.testing.assert_allclose(np.sort_complex(ours), np.sort_complex(design.poles), atol=1e-9)


@block
class Tank(AbstractPlant):
    """One that empties by Torricelli's law, and whose valve is shut below a command of one."""

    states = outputs = layout(h="m")
    inputs = layout(v="V")

    def rate(self, t, x, u):
        return {"h": ca.if_else(u.v > 1, 1, 0) - ca.sqrt(x.h)}


REFUSED = [
    (lambda: place(MASSES, [-1, -2, -3]), r"`place\(poles=...\)` must be 4 finite numbers"),
    (lambda: place(MASSES, [-1, -2, -3, -1 + 1j]), "conjugate pairs"),
    (lambda: place(MASSES, [-1, -2, -3, np.nan]), "4 finite numbers"),
    (lambda: place(MASSES, "left"), "a vector of numbers; got 'left'"),
    (lambda: place(np.eye(2), [-1, -2]), r"`place\(system=...\)` must be a `StateSpace`"),
    (
        lambda: place(control.ss(np.diag([-1.0, 2.0]), [[1], [0]], [[1, 1]], 0, name="two"), [-1, -2]),
        "the pole 2[^ ]* of 'two' is reached by none",
    ),
    (lambda: lead_lag(MOTOR, 0.0, 50.0), "must be a finite number of rad/s, at least 1e-12"),
    (lambda: lead_lag(MOTOR, 5.0, 100.0), "at most 90"),
    (lambda: lead_lag(MOTOR, 5.0, 50.0, 0.5), "at least 1"),
    (lambda: lead_lag(control.c2d(MOTOR, 0.1), 5.0, 50.0), "in continuous time with one input"),
    (lambda: lead_lag(control.tf([1], [1, 0, 0, 0]), 1.0, 50.0), "140 degrees lack at 1 rad/s"),
    (lambda: lead_lag(control.tf([1], [1, -1]), 0.5, 50.0), "so it is not stable"),
    (lambda: linearize(open_loop(Tank()), 0.0, [0.0], u=[0.0]), "the rate of 'h' has no derivative by 'h' there"),
    (lambda: linearize(open_loop(Tank()), 0.0, [1.0], u=[1.0]), "the rate of 'h' jumps by 1 as 'v' changes"),
    (lambda: linearize(open_loop(Tank()), 0.0, [-1.0], u=[0.0]), "the rate of 'h' has no derivative by 'h' there"),
]


@pytest.mark.parametrize(("make", "message"), REFUSED)
def test_what_has_no_design_is_refused_with_the_reason(make, message):
    with pytest.raises(ValueError, match=message):
        make()
