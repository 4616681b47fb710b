"""Integral action with anti-windup, loop transfer recovery, and robust controllers as they stand in a loop."""

import control
import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError
from workbench.design.synthesis import loop_transfer_recovery, lqi

MOTOR = wb.DCMotor()
LAG = control.tf([1.0], [0.01, 1.0])  # white noise passes no direct term of an H2 problem


@pytest.fixture(scope="module")
def motor():
    return wb.linearize(wb.open_loop(MOTOR), 0.0, [0.0, 0.0])


@pytest.fixture(scope="module")
def servo(motor):
    return wb.lqg_integral(motor, Q=np.diag([1.0, 0.0, 400.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]], Tt=0.1)


def run_of(law, until=6.0):
    loop = wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    return wb.simulate(wb.rk4(loop.ode(), 1e-3), until=until)


def test_lqi_is_lqr_of_the_plant_with_its_integral():
    G = control.ss([[0.0, 1.0], [-2.0, -0.5]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    whole = control.ss(np.block([[G.A, np.zeros((2, 1))], [G.C, 0.0]]), [[0.0], [1.0], [0.0]], np.eye(3), 0.0)
    answer, other = lqi(G, np.diag([1.0, 2.0, 5.0]), [[0.5]]), wb.lqr(whole, np.diag([1.0, 2.0, 5.0]), [[0.5]])
    assert np.hstack([answer.K, answer.Ki]) == pytest.approx(other.K, rel=1e-12)


def test_the_loop_with_integral_action_follows_a_step_and_has_the_poles_of_its_halves(servo):
    halves = np.concatenate([servo.regulator.regulator.poles, servo.estimator.poles])
    assert np.sort_complex(servo.poles) == pytest.approx(np.sort_complex(halves), rel=1e-7)
    assert run_of(servo.controller)["omega"][0, -1, 0] == pytest.approx(1.0, abs=1e-3)  # exp(-1.7 * 6) is 4e-5


def test_anti_windup_keeps_the_overshoot_of_a_limited_loop_small(motor):
    # this fast servo asks for more than 10 V, which hold omega = 1 rad/s
    fast = wb.lqg_integral(motor, Q=np.diag([1.0, 0.0, 4e3]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]], Tt=0.1)
    law = wb.LinearLaw(fast.controller)
    tops = [
        run_of(wb.LimitedLaw(law, share * fast.anti_windup, low=-10.5, high=10.5))["omega"].max()
        for share in (1.0, 0.0)
    ]
    free = run_of(law)["omega"].max()
    assert 1.0 < tops[0] < 1.01 < free < 1.04 < tops[1]


def test_a_limited_law_within_its_limits_is_the_linear_law(servo):
    law = wb.LinearLaw(servo.controller)
    wide = run_of(wb.LimitedLaw(law, servo.anti_windup, low=-1e3, high=1e3))
    assert wide["omega"] == pytest.approx(run_of(law)["omega"], rel=1e-12)


def test_a_sampled_servo_holds_its_output_in_a_computer(motor):
    sampled = wb.c2d(motor, 0.02)
    answer = wb.lqg_integral(sampled, Q=np.diag([1.0, 0.0, 400.0]), R=[[1.0]], Qn=np.eye(2), Rn=[[1e-3]])
    assert np.abs(answer.poles).max() < 1
    law = wb.LimitedLaw(wb.LinearLaw(answer.controller), answer.anti_windup, low=-12.0, high=12.0)
    loop = wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.02)
    assert wb.simulate(loop, until=6.0)["omega"][0, -1, 0] == pytest.approx(1.0, abs=1e-2)


def test_outputs_that_cannot_be_held_are_refused():
    zero_at_rest = control.ss([[0.0, 1.0], [-1.0, -1.0]], [[0.0], [1.0]], [[0.0, 1.0]], 0.0)
    with pytest.raises(DesignError, match="zero at s = 0"):
        lqi(zero_at_rest, np.eye(3), [[1.0]])
    with pytest.raises(ValueError, match="different places from 0 to 0"):
        lqi(zero_at_rest, np.eye(3), [[1.0]], outputs=(1,))


@pytest.mark.parametrize("at", ["input", "output"])
def test_recovery_brings_the_loop_to_its_target_and_tells_the_distance(at):
    G = control.ss([[0.0, 1.0], [0.0, -1.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    gain = wb.lqr(G, np.diag([10.0, 1.0]), [[1.0]]).K if at == "input" else np.array([[2.0], [3.0]])
    s = 1j * np.logspace(-2, 4, 300)
    entry, exit_row = (G.B, gain) if at == "input" else (gain, G.C)
    target = [(exit_row @ np.linalg.solve(x * np.eye(2) - G.A, entry)).item() for x in s]
    T0 = np.array(target) / (1 + np.array(target))
    distances = []
    for q in (1e2, 1e4, 1e6):
        answer = loop_transfer_recovery(G, gain, q, at)
        L = -answer.controller(s) * G(s)
        distances.append(answer.distance.gain.value)
        assert np.abs(L / (1 + L) - T0).max() == pytest.approx(distances[-1], rel=2e-3)  # of the grid
    # two poles of the filter go out as sqrt(q), and the distance falls as their inverse
    assert distances[1] / distances[2] == pytest.approx(10.0, rel=0.1)


@pytest.mark.parametrize(
    ("B", "words"), [([[0.0], [1.0]], "not minimum-phase: its zero 1"), ([[0.0, 1.0], [1.0, 0.0]], "as many outputs")]
)
def test_recovery_is_refused_where_the_loop_cannot_be_recovered(B, words):
    G = control.ss([[0.0, 1.0], [-2.0, -3.0]], B, [[-1.0, 1.0]], 0.0)
    with pytest.raises(DesignError, match=words):
        loop_transfer_recovery(G, np.zeros((G.ninputs, 2)), 10.0)


@pytest.mark.parametrize("design", ["hinf", "h2", "coprime"])
def test_a_robust_controller_stands_in_a_loop_about_its_point(design):
    plant = wb.CartPole(phi=0.1)
    upright = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(4), at_rest=True)[["x", "phi"], ["F"]]
    plants = {weight: wb.mixed_sensitivity(upright, W1=weight, W2=0.01, input_disturbance=0.1) for weight in (1.0, LAG)}
    controller = {
        "hinf": lambda: wb.hinf_controller(plants[1.0], gamma=1.2 * wb.hinf_controller(plants[1.0]).gamma.value),
        "h2": lambda: wb.h2_controller(plants[LAG]),
        "coprime": lambda: wb.coprime_margin(upright, fraction=0.8),
    }[design]().controller
    loop = wb.ClosedLoop(plant, controller=controller).ode()
    A = np.array(loop.A(0.0, np.zeros(loop.states.size), loop.parameters.default))
    assert np.linalg.eigvals(A).real.max() < 0
