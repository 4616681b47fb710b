"""Metrics accumulated inside the loop, with their errors."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay, explosion, oscillator, staircase
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.arms.torque_metrics import peak_torque
from workbench.blocks.loop import ClosedLoop, open_loop
from workbench.blocks.signals import Constant, Ramp, Sines, SquareWave
from workbench.core import Entry, Layout
from workbench.engine.metrics import (
    effort,
    energy,
    iae,
    ise,
    itae,
    late_error,
    measure,
    observer_error,
    overshoot,
    peak_error,
    rmse,
    sampled_rmse,
    settling_time,
    step_with_metrics,
    total_variation,
)

TIME = ca.SX.sym("time")


def test_integral_metrics_of_a_decay_agree_with_their_closed_forms():
    a, T = 3.0, 2.0
    found = measure(decay(a), (rmse(), iae(), ise(), itae()), until=T, h=1e-3)
    square = (1 - np.exp(-2 * a * T)) / (2 * a)
    exact = {
        "RMSE": np.sqrt(square / T),
        "IAE": (1 - np.exp(-a * T)) / a,
        "ISE": square,
        "ITAE": (1 - (1 + a * T) * np.exp(-a * T)) / a**2,
    }
    for name, value in exact.items():
        # RK4 at 0.5 ms on a mode of 3 1/s: (1.5e-3)^4 is 5e-12
        assert found.score(name).value[0] == pytest.approx(value, rel=1e-10), name


def test_the_error_of_a_smooth_metric_covers_the_true_error():
    a, T = 3.0, 2.0
    score = measure(decay(a), (ise(),), until=T, h=0.1).score("ISE")
    exact = (1 - np.exp(-2 * a * T)) / (2 * a)
    assert 0 < abs(score.value[0] - exact) < score.error[0]


def test_the_error_falls_with_the_fourth_power_of_the_step():
    errors = [measure(decay(3.0), (ise(),), until=2.0, h=h).score("ISE").error[0] for h in (0.1, 0.05)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.2)


def test_peak_and_total_variation_of_an_oscillation_are_those_of_a_cosine():
    # tau_applied = -2 sin(2t) over two periods: total variation 4 * 2 per period of pi seconds
    T = 2 * np.pi
    h = T / 8000
    found = measure(oscillator(), (peak_error(), total_variation(h), effort()), until=T, h=h)
    assert found.score("peak error").value[0] == pytest.approx(1.0, abs=1e-9)
    # the grid can miss a crest by half a sample: 2 (2h/2)^2 / 2 of amplitude 2, eight times
    assert found.score("TV").value[0] == pytest.approx(16 / T, rel=1e-6)
    assert found.score("effort").value[0] == pytest.approx(np.sqrt(2), rel=1e-9)


def test_total_variation_is_that_of_its_own_grid_and_not_of_the_step():
    T, sample = 2 * np.pi, 2 * np.pi / 40
    grid = -2 * np.sin(2 * np.linspace(0, T, 41))
    for h in (sample, sample / 4, sample / 32):
        score = measure(oscillator(), (total_variation(sample),), until=T, h=h).score("TV")
        exact = np.abs(np.diff(grid)).sum() / T
        # at the coarsest step RK4 errs by (2 * 0.157)^5 / 120 a step
        assert score.value[0] == pytest.approx(exact, rel=2e-3)


def test_the_mean_over_samples_is_that_of_its_own_grid_with_the_first_sample_at_zero():
    a, T, sample = 3.0, 2.0, 0.1
    grid = np.exp(-a * np.linspace(0, T, 21))
    for h in (sample, sample / 8):
        score = measure(decay(a), (sampled_rmse(sample),), until=T, h=h).score("sampled RMSE")
        # at the coarsest step RK4 errs by (0.3)^5 / 120 a step, over 20 steps
        assert score.value[0] == pytest.approx(np.sqrt(np.mean(grid**2)), rel=1e-4)


def test_the_late_error_forgets_the_start():
    found = measure(decay(3.0), (late_error(1.0), peak_error()), until=2.0, h=1e-3)
    assert found.score("peak error").value[0] == 1.0
    assert found.score("late error").value[0] == pytest.approx(np.exp(-3.0), rel=1e-9)


def test_a_time_is_known_to_one_step_at_best():
    q = 1 - ca.exp(-10 * TIME)
    score = measure(staircase(q, (1.0,), 1.0), (settling_time(),), until=2.0, h=1e-3).score("settling time")
    assert score.error[0] >= 1e-3


def test_energy_counts_work_done_and_work_taken_alike():
    ode = oscillator()
    ode = replace(
        ode, outputs=ode.outputs + Layout((Entry("qd", np.zeros(())),)), output=ca.vertcat(ode.output, ode.x[1])
    )
    metric = energy(("tau_applied", "qd"))
    score = measure(ode, [metric], until=np.pi, h=np.pi / 4000).score("energy of tau_applied qd")
    # integral of 4 sin^2(2t) over one period
    assert score.value[0] == pytest.approx(2 * np.pi, rel=1e-9)


def test_a_diverged_run_has_no_number_in_any_metric():
    result = measure(explosion(), (ise(), peak_error()), until=2.0, h=1e-3)
    assert result.trajectories.has_diverged[0]
    assert np.isnan(result.score("ISE").value).all()
    assert np.isnan(result.score("peak error").error).all()


def test_each_run_has_its_own_score():
    ode = decay()
    p = ode.parameters.pack({"rate": np.array([1.0, 2.0, 5.0])})
    values = measure(ode, (iae(),), p, until=4.0, h=1e-2).score("IAE").value
    np.testing.assert_allclose(values, (1 - np.exp(-4 * p[:, 0])) / p[:, 0], rtol=1e-6)


def test_two_metrics_of_one_name_are_refused():
    with pytest.raises(ValueError, match="distinct names"):
        step_with_metrics(decay(), (iae(), iae()), 0.01)


def test_a_grid_that_is_no_multiple_of_the_step_is_refused():
    with pytest.raises(ValueError, match=r"multiple of the step 0.003 s; got 0.01 s"):
        step_with_metrics(oscillator(), (total_variation(0.01),), 0.003)


def test_overshoot_is_the_largest_excursion_as_a_share_of_its_jump():
    # from 0 to 1 with 25 % beyond, then from 1 to -1 with 0.3 beyond a jump of 2: 15 %
    q = ca.if_else(TIME < 1, 1.25 * ca.sin(np.pi * TIME), -1.3 * ca.sin(np.pi * (TIME - 1)))
    score = measure(staircase(q, (1.0, -1.0), 1.0), (overshoot(),), until=2.0, h=1e-3).score("overshoot")
    assert score.value[0] == pytest.approx(25.0, abs=1e-3)


def test_settling_time_is_the_longest_after_any_jump():
    # e decays as exp(-10 t) after each jump: inside 2 % after ln(50) / 10 s
    q = ca.if_else(TIME < 1, 1 - ca.exp(-10 * TIME), -1 + 2 * ca.exp(-10 * (TIME - 1)))
    ode = staircase(q, (1.0, -1.0), 1.0)
    score = measure(ode, (settling_time(),), until=2.0, h=1e-3).score("settling time")
    assert score.value[0] == pytest.approx(np.log(50) / 10, abs=1e-3)  # one step


def test_what_does_not_settle_has_an_infinite_settling_time():
    q = ca.sin(20 * TIME)
    for levels in ((1.0,), (1.0, -1.0)):
        ode = staircase(q, levels, 1.0)
        score = measure(ode, (settling_time(),), until=2.0, h=1e-3).score("settling time")
        assert np.isinf(score.value[0])
        assert score.error[0] == 0


def loop(reference) -> ClosedLoop:
    controller = ArmPID(Kp=[60.0, 60.0], Ki=[0.0, 0.0], Kd=[10.0, 10.0])
    return ClosedLoop(Manipulator(paper_arm(), q=[0.0, 0.0]), ArmFullState(2), controller, reference)


@pytest.mark.parametrize("reference", [SquareWave("q", "rad", [1.0, 0.5], 0.5), Constant("q", "rad", [1.0, 0.5])])
def test_overshoot_and_settling_time_take_a_reference_that_is_piecewise_constant(reference):
    ode = loop(reference).ode()
    step = step_with_metrics(ode, (overshoot(), settling_time()), 0.01)
    assert step.states.size > ode.states.size  # what the metrics remember


@pytest.mark.parametrize("reference", [Sines("q", "rad", [1.0, 0.5], [1.0, 2.0]), Ramp("q", "rad", [1.0, 0.5])])
def test_overshoot_and_settling_time_refuse_a_reference_that_moves(reference):
    ode = loop(reference).ode()
    for metric in (overshoot(), settling_time()):
        with pytest.raises(ValueError, match=f"'{metric.name}' needs a piecewise constant reference, as .* q_ref of"):
            step_with_metrics(ode, (metric,), 0.01)


def test_a_reference_that_is_a_state_of_its_own_is_one_that_moves():
    ode = oscillator()
    ode = replace(ode, output=ca.vertcat(ode.x[0], ode.x[0], ode.x[1], ode.x[1]))
    with pytest.raises(ValueError, match="needs a piecewise constant reference"):
        step_with_metrics(ode, (overshoot(),), 0.01)


def test_a_start_at_the_level_up_to_rounding_is_no_jump():
    q = 1.0 + 1e-16 + 0.3 * ca.sin(TIME) + 4e-16 * ca.cos(TIME)
    found = measure(staircase(q, (1.0,), 1.0), (overshoot(), settling_time()), until=2.0, h=1e-2)
    assert found.score("overshoot").value[0] == 0
    assert found.score("settling time").value[0] == 0


def test_a_level_that_changes_by_rounding_leaves_the_last_jump_in_force():
    q = 1.25 * ca.sin(np.pi * TIME / 2)
    score = measure(staircase(q, (1.0, 1.0 + 1e-15), 0.5), (overshoot(),), until=2.0, h=1e-3).score("overshoot")
    assert score.value[0] == pytest.approx(25.0, abs=1e-3)


def test_rows_of_another_width_are_refused_before_anything_runs():
    ode = decay()
    for x0 in (np.ones((1, 2)), np.ones((3, 0)), np.ones(5)):
        with pytest.raises(ValueError, match=r"`measure\(x0=...\)` takes one row per run: \(B, 1\)\. Got"):
            measure(ode, (rmse(),), x0=x0, until=1.0, h=0.1)
    with pytest.raises(ValueError, match=r"`measure\(p=...\)` takes one row per run: \(B, 1\)\. Got \(2, 4\)"):
        measure(ode, (rmse(),), np.ones((2, 4)), until=1.0, h=0.1)
    with pytest.raises(ValueError, match=r"`measure\(x0=...\)` must be numbers, .* got 'one'"):
        measure(ode, (rmse(),), x0="one", until=1.0, h=0.1)


def test_a_mean_has_the_unit_and_the_name_of_its_signal():
    found = measure(
        loop(Constant("q", "rad", [1.0, 0.5])).ode(),
        (rmse(), rmse("tau"), sampled_rmse(0.1), sampled_rmse(0.1, "ed"), rmse("e_hat", name="mine")),
        until=0.2,
        h=0.1,
    )
    assert {score.metric: score.unit for score in found.scores} == {
        "RMSE": "rad",
        "RMSE of tau": "N m",
        "sampled RMSE": "rad",
        "sampled RMSE of ed": "rad/s",
        "mine": "rad",
    }


def test_total_variation_is_per_second_of_the_time_that_it_sums():
    # samples at 0, 0.3, 0.6 and 0.9 s; the last tenth of a second belongs to none
    score = measure(oscillator(), (total_variation(0.3),), until=1.0, h=0.01).score("TV")
    grid = -2 * np.sin(2 * np.array([0, 0.3, 0.6, 0.9]))
    assert score.value[0] == pytest.approx(np.abs(np.diff(grid)).sum() / 0.9, rel=1e-8)
    with pytest.raises(ValueError, match=r"'TV' needs a horizon of one sample time at least, which is 2 s; got 1 s"):
        measure(oscillator(), (total_variation(2.0),), until=1.0, h=0.01)


def test_the_late_total_variation_forgets_the_start():
    # samples every 0.3 s, those from 0.5 s on at 0.6, 0.9, 1.2 and 1.5 s; before 0.9 s there is no change to count
    metric = total_variation(0.3, after=0.5)
    grid = np.abs(np.diff(-2 * np.sin(2 * np.array([0.6, 0.9, 1.2, 1.5]))))  # RK4 errs by 0.02^5 / 120 a step
    for until, count in ((1.6, 3), (0.9, 1)):
        score = measure(oscillator(), (metric,), until=until, h=0.01).score("late TV")
        assert score.value[0] == pytest.approx(grid[:count].sum() / (0.3 * count), rel=1e-7)
    with pytest.raises(ValueError, match=r"'late TV' needs .* at least from 0\.5 s on, which is 0\.3 s; got 0\.8 s"):
        measure(oscillator(), (metric,), until=0.8, h=0.01)
    with pytest.raises(ValueError, match=r"`total_variation\(after=...\)` must be a finite number of seconds"):
        total_variation(0.3, after=-1.0)


def test_a_metric_of_an_output_that_is_not_there_is_answered_with_the_nearest():
    ode = loop(Constant("q", "rad", [1.0, 0.5])).ode()
    with pytest.raises(LookupError, match=r"'RMSE of e_hot' needs the output 'e_hot', .* Did you mean 'e_hat'\?"):
        step_with_metrics(ode, (rmse("e_hot"),), 0.1)
    with pytest.raises(LookupError, match=r"'peak torque' needs the output 'tau_applied', .* It has: q, qd\."):
        step_with_metrics(open_loop(Manipulator(paper_arm(), q=[0.0, 0.0])), (peak_torque(),), 0.1)
    with pytest.raises(LookupError, match=r"'RMS q_eror' needs the output 'q_eror', .* Did you mean 'q_error'\?"):
        step_with_metrics(ode, (observer_error("q_eror"),), 0.1)


def test_a_metric_is_as_wide_as_the_output_that_it_watches():
    ode = open_loop(Manipulator(paper_arm(), q=[0.1, 0.2]))
    found = measure(ode, (sampled_rmse(0.1, "qd"),), until=0.2, h=0.01)
    assert [score.label for score in found.scores] == ["joint 1", "joint 2"]
    assert found.score("sampled RMSE of qd", "joint 2").value.shape == (1,)


@pytest.mark.parametrize("bad", [-1.0, 0.0, np.nan, np.inf, "1", None])
def test_a_band_or_a_sample_time_that_is_none_is_refused(bad):
    for made in (settling_time, sampled_rmse, total_variation):
        with pytest.raises(ValueError, match=rf"`{made.__name__}\((band|sample)=...\)` must be"):
            made(band=bad) if made is settling_time else made(bad)


def test_a_loop_is_measured_by_its_equations():
    closed = loop(Constant("q", "rad", [1.0, 0.5]))
    found, other = (measure(one, (rmse(),), until=1.0, h=1e-3) for one in (closed, closed.ode()))
    np.testing.assert_array_equal(found.values, other.values)
