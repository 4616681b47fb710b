"""A linear plant beneath a computer: its exact discretisation, its metrics in closed form, and what is refused."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import cont2discrete

from tests.support.arms import arm_instruments
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Friction, Manipulator
from workbench.arms.mechanics import PlanarArm
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.arms.observers import ArmFullState
from workbench.arms.torque_metrics import peak_torque
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant
from workbench.core import Entry, Layout, Ode, SampledSystem
from workbench.engine import simulate
from workbench.engine.metrics import (
    effort,
    ise,
    measure,
    observer_error,
    overshoot,
    rmse,
    sampled_rmse,
    total_variation,
)

# One link without weight, with viscous friction, under proportional and derivative action

J, FRICTION, KP, KD = 0.8, 1.5, 30.0, 6.0
A, B, K = np.array([[0.0, 1.0], [0.0, -FRICTION / J]]), np.array([[0.0], [1 / J]]), np.array([[KP, KD]])
X0 = np.array([0.7, -0.4])


def linear():
    arm = PlanarArm((PointMass(J, 1.0),), gravity=0.0)
    plant = Manipulator(arm, [X0[0]], [X0[1]], friction=Friction([FRICTION], [0.0]))
    return ClosedLoop(plant, ArmFullState(1), ArmPID([KP], [0.0], [KD]), Constant("q", "rad", [0.0]))


def exact(period, steps):
    """The states at the instants, by the matrix exponential."""
    Ad, Bd, *_ = cont2discrete((A, B, np.eye(2), np.zeros((2, 1))), period, method="zoh")
    rows = [X0]
    for _ in range(steps):
        rows.append((Ad - Bd @ K) @ rows[-1])
    return np.array(rows)


def test_a_linear_loop_is_its_exact_discretisation_up_to_the_fourth_order_of_the_substeps():
    period, counts = 0.1, np.array([1, 2, 4, 8])
    theirs = exact(period, 10)
    errors = []
    for substeps in counts:
        ours = simulate(linear().digital(period).step(int(substeps)), until=1.0).x[0, :, :2]
        errors.append(np.abs(ours - theirs).max())
    assert errors[-1] < 1e-8  # (period / 8 * 1.9)^5 / 120, ten times
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(-4, abs=0.1)


# Metrics


def exact_ise(period, steps):
    """The integral of q^2, by quadrature of the closed form between two instants: tau held, v' = (tau - b v) / J."""
    total, a = 0.0, FRICTION / J
    for q, v in exact(period, steps)[:-1]:
        rest = -(KP * q + KD * v) / FRICTION  # the speed that the torque would reach

        def square(t, q=q, v=v, rest=rest):
            return (q + rest * t + (v - rest) * (1 - np.exp(-a * t)) / a) ** 2

        total += quad(square, 0, period, epsabs=1e-13)[0]
    return total


def test_integrals_run_along_in_the_substeps_and_samples_are_taken_at_the_instants():
    period, T = 0.1, 1.0
    tau = -(exact(period, 10) @ K.T).ravel()  # at the horizon too, where the samples end
    metrics = (rmse(), ise(), effort(), peak_torque(), total_variation(period), sampled_rmse(period, "tau"))
    result = measure(linear().digital(period), metrics, until=T, h=period / 4)
    got = {name: np.array([s.value[0] for s in result.scores_of(name)]) for name in result.names}
    # RK4 at 25 ms: 5e-6 in the integrals, 2e-8 in the states
    assert got["ISE"] == pytest.approx(exact_ise(period, 10), rel=1e-5)
    assert got["RMSE"] == pytest.approx(np.sqrt(exact_ise(period, 10) / T), rel=1e-5)
    assert got["effort"] == pytest.approx(np.sqrt(np.mean(tau[:-1] ** 2)), rel=2e-6)
    assert got["peak torque"] == pytest.approx(np.abs(tau).max(), rel=2e-6)
    assert got["TV"] == pytest.approx(np.abs(np.diff(tau)).sum() / T, rel=2e-6)
    assert got["sampled RMSE of tau"] == pytest.approx(np.sqrt(np.mean(tau**2)), rel=2e-6)


def test_the_halved_run_halves_the_substep_and_never_the_period():
    result = measure(linear().digital(0.1), (ise(),), until=1.0, h=0.05)
    assert result.trajectories.step.h == 0.1
    assert result.trajectories.step.substeps == 2
    assert result.h == 0.05
    score = result.score("ISE")
    assert 0 < abs(score.value - exact_ise(0.1, 10)) < score.error


def test_an_observer_is_held_against_the_motion_between_its_samples():
    """q_hat = q(t_k) until t_(k+1): RMS of v (t - t_k) over a period is v period / sqrt 3."""
    plant = Manipulator(PlanarArm((PointMass(1.0, 1.0),), gravity=0.0), [0.0], [2.0])
    coasting = ClosedLoop(plant, ArmFullState(1), ArmPID([0.0], [0.0], [0.0]), Constant("q", "rad", [0.0]))
    score = measure(coasting.digital(0.1), (observer_error("q_error"),), until=1.0, h=0.1).score("RMS q_error")
    assert score.value[0] == pytest.approx(2.0 * 0.1 / np.sqrt(3), rel=1e-12)


def test_a_metric_of_steps_looks_at_a_sampled_loop_once_a_period():
    score = measure(linear().digital(0.1), (overshoot(),), until=2.0, h=0.05).score("overshoot")
    q = exact(0.1, 20)[:, 0]
    assert score.value[0] == pytest.approx(100 * max(0.0, (q / -q[0]).max()), rel=1e-4)  # RK4 at 25 ms


# What is refused


def test_times_that_do_not_fit_the_period_are_refused():
    digital = linear().digital(0.01)
    with pytest.raises(ValueError, match=r"`substeps\(h=...\)` must divide the sampling period 0.01 s, .* got 0.003 s"):
        measure(digital, (rmse(),), until=1.0, h=0.003)
    with pytest.raises(ValueError, match=r"must divide the sampling period 0.01 s, .* got 0.02 s"):
        measure(digital, (rmse(),), until=1.0, h=0.02)
    with pytest.raises(ValueError, match=r"`substeps\(h=...\)` must be a positive, finite number of seconds; got nan"):
        measure(digital, (rmse(),), until=1.0, h=np.nan)
    with pytest.raises(ValueError, match=r"`measure\(until=...\)` must be a multiple of the step 0.01 s; got 0.015 s"):
        measure(digital, (rmse(),), until=0.015, h=0.01)
    with pytest.raises(ValueError, match=r"sample=...\)` must be a multiple of the step 0.01 s; got 0.005 s"):
        measure(digital, (total_variation(0.005),), until=1.0, h=0.005)


def test_a_jump_of_more_than_its_symbols_is_refused():
    digital = linear().digital(0.1)
    with pytest.raises(
        ValueError, match=r"`SampledSystem\(jump=...\)` must be of k, x, p, w alone, .* symbol 'stranger'"
    ):
        SampledSystem(digital.flow, 0.1, digital.k, digital.w, digital.jump + ca.SX.sym("stranger"))
    with pytest.raises(
        ValueError, match=r"`SampledSystem\(jump=...\)` must have shape \(m, 1\), for the first m of 7 states"
    ):
        SampledSystem(digital.flow, 0.1, digital.k, digital.w, ca.vertcat(digital.jump, 0))


def test_the_fingerprint_tells_loops_of_other_periods_instruments_and_delays_apart():
    made = [
        linear().digital(0.1),
        linear().digital(0.2),
        linear().digital(0.1, delay=True),
        linear().digital(0.1, arm_instruments(1)),
    ]
    assert len({digital.fingerprint for digital in made}) == 4
    assert linear().digital(0.1, arm_instruments(1, noise_q=0.1)).fingerprint == made[3].fingerprint


def test_a_flow_of_a_single_state_jumps_and_flows():
    states = Layout((Entry("x", 1.0),))
    t, x, k = ca.SX.sym("t"), states.symbols(), ca.SX.sym("k")
    flow = Ode.of("decay", states, Layout(), (t, x, ca.SX(0, 1)), {"x": -x}, {"y": x})
    step = SampledSystem(flow, 0.1, k, ca.SX(0, 1), x / 2).step(2)
    assert float(step.y(0, 1.0, [], [])) == 0.5  # after the jump
    h = 0.05
    factor = 1 - h + h**2 / 2 - h**3 / 6 + h**4 / 24
    assert float(step.F(0, 1.0, [], [])) == pytest.approx(0.5 * factor**2, rel=1e-15)  # a few roundings
