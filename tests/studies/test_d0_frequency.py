"""The study of the loops over frequency: its predictions by closed forms, its runs by other hands, its sentences."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from studies.d0_frequency import draws, findings, limit_cycles, loops, period_limits, rest_answers, step_sizes, tables
from studies.d0_frequency.loops import ARM_POSES, RUN_POSES, RUNS, AtPose
from studies.d0_frequency.period_limits import SHARES, PeriodLimit
from studies.paper.card import CARD, PROPOSED_LAW
from studies.paper.linearization import LEVEL, at_rest
from workbench.engine.metrics import measure, settling_time

K, PHI, LAMBDA = 5.0, 0.01, 6.0
G = 9.81


def mass_matrix(q2):
    """Of the paper's arm, two point masses of 1 kg on links of 1 m."""
    off = 1 + np.cos(q2)
    return np.array([[3 + 2 * np.cos(q2), off], [off, 1.0]])


@cache
def at_level(law):
    return rest_answers.answer_of(loops.linear(AtPose(law, LEVEL)))


@pytest.mark.parametrize(
    "pose", [pytest.param(pose, marks=[pytest.mark.heavy] * (pose != "start of FS")) for pose in RUN_POSES]
)
def test_the_map_of_smc_becomes_unstable_where_its_late_mode_does(pose):
    # s_(k+1) = s_k - T rho / phi s_(k-1) has poles on the circle at T = phi / rho
    rho = K * np.linalg.eigvals(np.linalg.inv(mass_matrix(ARM_POSES[pose][1]))).real.max()
    one = AtPose("SMC", pose)
    # s decays by Lambda too, and the reference of the law is held: both move the limit by T Lambda, 1 % or less
    assert period_limits.radius(one, 0.97 * PHI / rho) < 1 < period_limits.radius(one, 1.03 * PHI / rho)


@pytest.mark.heavy
def test_a_run_of_smc_rests_below_that_period_and_chatters_above_it():
    one = AtPose("SMC", LEVEL)
    rho = K * np.linalg.eigvals(np.linalg.inv(mass_matrix(ARM_POSES[LEVEL][1]))).real.max()
    (below, _), (above, _) = (period_limits._run(one, share * PHI / rho) for share in (0.95, 1.05))
    assert (below < 1e-3).all()
    assert (above > 100 * period_limits.REST).all()


@pytest.mark.parametrize("law", [PROPOSED_LAW, "PID", "SMC"])
def test_the_linear_answers_are_those_of_the_loop_that_a5_cuts(law):
    ours, theirs = at_level(law), at_rest(law)
    # of two roads to the same matrices, with rounding grown by their condition
    assert ours.alpha == pytest.approx(theirs.alpha, rel=1e-7)
    assert 1e3 * ours.delay == pytest.approx(theirs.delay, rel=1e-7)
    # both joints at once leave no more margin than one of them by itself
    assert ours.alpha <= ours.single * (1 + 1e-9)


def test_the_linear_settling_time_of_smc_is_that_of_its_surface():
    # e' = -Lambda e once s has decayed, which takes some 1 / 400 s
    assert step_sizes.predict_settling(AtPose("SMC", LEVEL)) == pytest.approx(np.log(20) / LAMBDA, abs=0.02)


@pytest.mark.parametrize("size", [1e-3, 0.3])
def test_pid_settles_as_scipy_integrates_it(size):
    one, want = AtPose("PID", LEVEL), np.array(ARM_POSES[LEVEL])
    Kp, Ki, Kd = (np.asarray(CARD[f"PID: {name}"]) for name in ("Kp", "Ki", "Kd"))

    def gravity(q):
        second = G * np.sin(q[0] + q[1])
        return np.array([2 * G * np.sin(q[0]) + second, second])

    def rate(t, z):
        q, qd, total = z[:2], z[2:4], z[4:]
        e = q - want
        sine = np.sin(q[1])
        spin = np.array([-sine * qd[1] * (2 * qd[0] + qd[1]), sine * qd[0] ** 2])
        torque = -(Kp * e + Ki * total + Kd * qd)
        return [*qd, *np.linalg.solve(mass_matrix(q[1]), torque - spin - gravity(q)), *e]

    start = np.concatenate([want + size, np.zeros(2), -gravity(want) / Ki])
    t = np.arange(0.0, 6.0, 1e-3)
    out = solve_ivp(rate, (0.0, 6.0), start, "LSODA", t, rtol=1e-9, atol=1e-12)
    outside = (np.abs(out.y[:2].T - want) > step_sizes.BAND * size).any(axis=1)
    equation = loops.loop_at_rest(one).ode()
    x = loops.start_states(equation, one, np.array([size]))
    found = measure(equation, [settling_time("q", step_sizes.BAND)], x0=x, until=6.0, h=2.5e-4)
    ours = max(float(score.value[0]) for score in found.scores_of("settling time of q"))
    assert ours == pytest.approx(t[np.flatnonzero(outside).max() + 1], abs=2e-3)  # both on grids of 1 ms or less


def late_oscillation(period):
    """Half the swing of s and its frequency, of e'' = -Lambda ed - K sat(s / phi), held, one period late."""
    e, ed, waiting, kept = 0.0, 0.1, 0.0, []
    for k in range(round(6.0 / period)):
        s = ed + LAMBDA * e
        command = -LAMBDA * ed - K * np.clip(s / PHI, -1, 1)
        if k * period >= 4.0:
            kept.append(s)
        e, ed = e + period * ed + period**2 / 2 * waiting, ed + period * waiting
        waiting = command
    s = np.array(kept)
    rising = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
    return np.ptp(s) / 2, 2 * np.pi / (period * np.diff(rising).mean())


@pytest.mark.parametrize("period", [2.5e-3, 5e-3])
def test_the_limit_cycle_is_that_of_a_double_integrator_in_its_layer(period):
    found = limit_cycles.limit_cycle(period)
    amplitude, frequency = late_oscillation(period)
    # gravity is compensated a period late; it moves s by far less than a hundredth
    assert found.runs[1].amplitude == pytest.approx(amplitude, rel=0.02)
    assert found.runs[1].frequency == pytest.approx(frequency, rel=0.02)
    assert found.prediction is not None
    assert found.prediction[0] == pytest.approx(frequency, rel=0.05)
    assert all(found.agrees(run) for run in range(len(found.runs)))


def test_a_period_at_which_the_layer_is_wide_enough_is_at_rest():
    found = limit_cycles.limit_cycle(1.5e-3)
    assert found.rest
    assert found.prediction is None
    assert [run.amplitude < limit_cycles.QUIET for run in found.runs] == [True] * 4


def test_the_draws_move_arm_model_and_gains_apart_and_rest_at_states_of_their_own():
    one = AtPose("SMC", LEVEL)
    loop = loops.linear(one)
    rows = draws.values(loop, "SMC")
    assert {"plant.arm.links[0].mass", "controller.model.links[0].mass", "controller.K"} <= rows.keys()
    assert not any(name.startswith("plant.disturbance") for name in rows)
    for name, values in rows.items():
        own = loop.parameters.unpack(loop.p0[np.newaxis])[name][0]
        assert (np.abs(values / own - 1) <= 0.5 + 1e-12).all()  # the widest factor is 1.5 of an assumed number


def limit(small, large, learned=None):
    """A law whose runs rest at the first shares, so many from either start."""
    late = np.array([[0.0] * count + [1e4] * (len(SHARES) - count) for count in (small, large)])
    return PeriodLimit(0.99e-3, 1.01e-3, late, (None, learned))


def test_loops_are_counted_where_their_runs_rest_up_to_the_predicted_period_and_no_longer_beyond():
    inside = SHARES.index(1.03)
    every = {one: limit(inside, inside - 2, True) for one in RUNS} | {RUNS[0]: limit(len(SHARES), 0, False)}
    assert findings.agreement_count(every, RUNS, "small") == f"{len(RUNS) - 1} of {len(RUNS)}"
    assert findings.agreement_count(every, RUNS, "large") == f"0 of {len(RUNS)}"
    assert findings.learned_gain_count(every, "large") == f"{len(RUNS) - 1} of {len(RUNS)}"
    assert every[RUNS[0]].ends("small") == (SHARES[-1], float("inf"))
    assert every[RUNS[0]].ends("large") == (0.0, SHARES[0])
    assert tables.bracket((0.0, 0.25), 1e-3) == "none tried, 0.25"


def test_a_run_that_diverged_does_not_rest():
    late = np.full((2, len(SHARES)), np.nan)
    assert not any(PeriodLimit(1e-3, 1.01e-3, late, (None, None)).rests("small"))


def test_ranges_are_printed_once_where_both_ends_look_alike():
    assert tables.span([1.0, 1.0001]) == "1"
    assert tables.span([0.1, -2.0]) == "\N{MINUS SIGN}2 to 0.1"
    assert tables.number(float("inf")) == "any"


def test_the_phase_turns_by_small_steps_about_a_lightly_damped_pole():
    pole = -1e-3 + 2j
    omega = rest_answers.closer(np.geomspace(0.1, 10.0, 20), np.array([pole, pole.conjugate(), 3j, -1.0 + 0j]))
    assert omega[0] == 0.1
    assert omega[-1] == 10.0
    values = 1 / ((1j * omega - pole) * (1j * omega - pole.conjugate()))
    # arctan(2 x) - arctan(x) is at most 19.5 degrees, and the steps grow by a factor below 2
    assert np.abs(np.diff(np.degrees(np.angle(values)))).max() < 20
    # no frequency lies where an undamped pole is
    assert np.abs(omega - 3.0).min() > 1e-3


def test_the_poles_of_a_loop_in_a_computer_are_those_of_the_arm_in_continuous_time():
    one = AtPose("SMC", LEVEL)
    both = [np.sort(rest_answers.rates(loops.linear(one, period)).imag)[-1] for period in (None, loops.SHORT)]
    # the arm alone, which a zero-order hold samples exactly but for the error of the Runge-Kutta step
    assert both[0] == pytest.approx(both[1], rel=1e-6)
