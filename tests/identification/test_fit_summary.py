"""A summary of a fit: plain data that a ledger keeps, with the errors of an experiment that is run once more."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.support.fitted_motor import MOTOR, motor_fit, motor_log
from workbench.study.ledger.answers import answer_of, chunk_of_answer, classes_of

FitSummary = wb.identification.FitSummary
NOISE = {"omega": 0.05, "i": 0.05}


@pytest.fixture(scope="module")
def fit():
    return motor_fit()


def test_the_ledger_of_a_study_keeps_a_summary_bit_by_bit(fit):
    full = FitSummary.of(fit, profiles=[fit.profile("R")], bootstrap=fit.bootstrap(40))
    for summary in (full, FitSummary.of(wb.fit(MOTOR, motor_log(), ["J"], hold_out=0.0))):
        classes = classes_of(FitSummary)
        back = answer_of(chunk_of_answer("fits/item/0", "the motor", summary, classes), classes)
        assert wb.fit_page(back).text == wb.fit_page(summary).text


def test_an_experiment_run_once_more_has_the_errors_that_were_promised():
    log = motor_log()
    free = ["J", "R", "omega(0)"]
    alone = FitSummary.of(wb.fit(MOTOR, log, free, noise=NOISE))
    twin = wb.Dataset(tuple(replace(one, name="twin") for one in log.experiments))
    both = wb.fit(MOTOR, log.with_experiments(twin), free, noise=NOISE)
    errors = [both.standard_errors[name] for name in ("J", "R", "omega(0) of log")]
    assert np.allclose([one.repeated_error for one in alone.numbers], errors, rtol=1e-4)  # where the searches end


def test_the_residuals_of_each_sensor_are_those_of_the_fit(fit):
    first, second = FitSummary.of(fit).sensors
    assert (first.name, first.unit, first.count, first.hold_out_count) == ("omega", "rad/s", 97, 24)
    assert (second.root_mean_square, second.misfit) == (fit.root_mean_squares["i"], fit.misfit["i"])


def test_parts_of_another_fit_are_refused(fit):
    other = wb.fit(MOTOR, motor_log(seed=5), ["J", "b", "R"])
    with pytest.raises(ValueError, match="profiles of this fit"):
        FitSummary.of(fit, profiles=[other.profile("R")])
    with pytest.raises(ValueError, match="drawn from this fit"):
        FitSummary.of(fit, bootstrap=other.bootstrap(40))
    with pytest.raises(ValueError, match="at least 39 draws"):
        FitSummary.of(fit, bootstrap=fit.bootstrap(10))
    single = wb.fit(MOTOR, motor_log(), ["K"])
    with pytest.raises(LookupError, match="numbers of this fit"):
        FitSummary.of(single, profiles=[fit.profile("R")])


def test_a_plan_for_none_of_the_numbers_is_refused_and_another_is_summarised(fit):
    plan = wb.design_experiment(
        MOTOR,
        ["J"],
        ["v"],
        ["omega"],
        noise={"omega": 0.05},
        limits={"v": (-12.0, 12.0)},
        until=2.0,
        every=0.1,
        steps=4,
        starts=1,
    )
    summary = FitSummary.of(fit, plan=plan)
    assert summary.plan.errors == plan.standard_errors
    assert np.isclose(summary.plan.duration, 2.0, rtol=1e-9)
    with pytest.raises(ValueError, match="a design for numbers of this fit, K"):
        FitSummary.of(wb.fit(MOTOR, motor_log(), ["K"]), plan=plan)
