"""The arm that is identified from its own logs: the logs, the estimates, and the laws that are made for them."""

import numpy as np
import pytest

import workbench as wb
from studies.c0_identify_arm.arm import BASE, NOMINAL, ODD, SHORT, SPEED, TRUTH, arm_of, plant_of
from studies.c0_identify_arm.estimates import (
    CUTOFFS,
    as_numbers,
    base_numbers,
    output_error,
    repeated_output_errors,
    repeated_regressions,
)
from studies.c0_identify_arm.judgement import MISLED, TOLD, verdict
from studies.c0_identify_arm.logs import Excitation, law_loop, played_loop, record
from studies.c0_identify_arm.own_laws import FrictionCompensation
from studies.c0_identify_arm.repeated_section import coverage_band
from studies.c0_identify_arm.requirements import SPECIFICATION, check_true
from studies.c0_identify_arm.worth import TRIALS, arm_factors, gains


@pytest.fixture(scope="module")
def short_log():
    """A log of two seconds under the law of the paper."""
    return record(law_loop(SHORT), "log", SHORT, seed=5)


def test_a_log_under_the_law_of_the_paper_tells_the_true_arm(short_log):
    repeats = repeated_output_errors(iter([short_log]), SHORT)
    assert repeats.distances[0] < 26.1  # the 99.9 % quantile of chi-square with 8 degrees of freedom
    assert verdict(repeats, TRUTH) == TOLD


def test_a_torque_that_acts_later_than_logged_misleads_the_fit_which_warns():
    late = next(case for case in ODD if case.name == "late")
    repeats = repeated_output_errors(iter([record(law_loop(late), "log", late, seed=5)]), late)
    assert verdict(repeats, TRUTH) == MISLED
    assert repeats.has_warning[0]


def test_a_regression_of_noisy_positions_shrinks_the_inertias(short_log):
    truth = base_numbers(np.array([TRUTH]))[0]
    wide = repeated_regressions(iter([short_log]), CUTOFFS[-1])
    assert abs(wide.theta[0, 0] / truth[0] - 1) > 0.5  # of 40 Hz; output errors are off by less than 0.001


def test_the_factors_of_a_study_are_those_of_the_fit(short_log):
    fit = output_error(short_log, SHORT)
    own, given = arm_factors(as_numbers(fit)), fit.factors(path="plant.")
    assert [one.paths for one in own] == [one.paths for one in given]
    for one, other in zip(own, given, strict=True):
        assert one.direction == other.direction
        assert one.distribution == other.distribution


def test_the_computer_plays_the_sines_of_a_design():
    plan = Excitation(
        np.array([1.0, -0.5]),
        np.array([[2.0, 1.0], [0.5, 0.3]]),
        np.array([1.0, 3.0]),
        np.array([[0.1, 0.2], [0.3, 0.4]]),
        *((),) * 5,
    )
    log = record(played_loop(SHORT, plan), "log", SHORT, seed=1)
    t = log.experiments[0].t[:, np.newaxis, np.newaxis]
    wanted = plan.constant + np.sum(plan.amplitudes * np.sin(plan.frequencies * t + plan.phases), axis=2)
    np.testing.assert_allclose(log["tau"], wanted, atol=1e-12)  # rounding


def test_the_friction_is_added_at_the_velocity_of_the_reference():
    inner = wb.arms.laws.ComputedTorque(arm_of(TRUTH), np.zeros(2), np.zeros(2))
    friction = plant_of(TRUTH).friction
    wanted = wb.Sines("q", "rad", (1.0, 0.5), (2.0, 3.0))
    loops = [
        wb.ClosedLoop(plant_of(TRUTH), wb.ArmFullState(2), law, wanted).ode()
        for law in (inner, FrictionCompensation(inner, friction))
    ]
    first, second = (loop.outputs_at(0.0, loop.states.default)["tau"] for loop in loops)
    qd = np.array([2.0, 1.5])  # of the reference at t = 0
    expected = np.array(TRUTH[4:6]) * qd + np.array(TRUTH[6:]) * np.tanh(qd / SPEED)
    np.testing.assert_allclose(np.ravel(second - first), expected, rtol=1e-12)  # rounding


def test_gains_for_the_true_arm_hold_the_limits_and_those_for_the_paper_s_arm_do_not():
    for model, held in ((TRUTH, True), (NOMINAL, False)):
        checked = check_true("gains", model)
        assert checked.holds.shape == (1, len(SPECIFICATION.limits))
        assert bool(checked.holds.all()) is held


def test_the_gains_of_the_regulator_follow_the_model():
    assert gains(TRUTH).shape == (2, 4)
    assert not np.allclose(gains(TRUTH), gains(NOMINAL), rtol=0.01)


def test_the_band_of_a_coverage_is_that_of_the_binomial_distribution():
    low, high = coverage_band(1000)
    assert (low, high) == pytest.approx((92.6, 97.1), abs=0.11)  # as the theory of fits has it, to one of 1,000 logs


def test_each_trial_has_a_name_of_its_own():
    assert len({trial.name for trial in TRIALS}) == len(TRIALS)


def test_the_noise_of_a_fit_is_that_of_the_encoder():
    rng = np.random.default_rng(2)
    step = 2 * np.pi / 4096
    read = np.round((0.3 + BASE.noise * step * rng.standard_normal(100_000)) / step) * step
    assert np.std(read) == pytest.approx(BASE.sigma, rel=0.01)  # four standard errors of 100,000 readings
