"""The run of a fitted model along its log, with the squares of its errors summed in the step itself."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from tests.support.fitted_motor import MOTOR, T, motor_log
from workbench.identification.summaries.compared_run import FIT, HELD_OUT, ComparedRun

EVERY = ["J", "b", "R", "scale of omega", "offset of i", "omega(0)"]
LOG = motor_log()
UNEVEN = wb.Dataset.of(
    np.delete(T, [7, 30, 31]),
    {name: np.delete(LOG[name], [7, 30, 31]) for name in ("v", "omega", "i")},
    {"v": "V", "omega": "rad/s", "i": "A"},
    name="uneven",
)


@pytest.fixture(scope="module")
def fit():
    both = LOG.with_experiments(UNEVEN)
    return wb.fit(MOTOR, both, EVERY, answers={"gap": "samples were lost"})


@pytest.mark.parametrize("experiment", [0, 1])
def test_the_sums_of_the_step_are_the_errors_of_the_fit(fit, experiment):
    run = ComparedRun.of(fit, experiment)
    found = run.root_mean_squares("fused")
    errors = fit.errors[experiment]
    for part, masks in ((FIT, fit.data.weighs), (HELD_OUT, fit.held_out)):
        own = [np.sqrt(np.mean(column[seen] ** 2)) for column, seen in zip(errors.T, masks[experiment].T, strict=True)]
        np.testing.assert_allclose(found[part], own, rtol=1e-12)  # rounding of sums
        assert run.counts[part].tolist() == masks[experiment].sum(axis=0).tolist()


def test_other_values_of_the_numbers_give_the_errors_of_the_model_there(fit):
    values = {"J": 0.02, "R": 1.3, "scale of omega": 1.1, "offset of i": -0.2, "omega(0) of uneven": 0.7}
    z = np.array([values.get(name, value) for name, value in fit.values.items()])
    found = ComparedRun.of(fit, 1).at(values).root_mean_squares("fused")[FIT]
    errors = fit.data.errors(z)[1]
    own = [np.sqrt(np.mean(column[seen] ** 2)) for column, seen in zip(errors.T, fit.data.weighs[1].T, strict=True)]
    np.testing.assert_allclose(found, own, rtol=1e-12)  # rounding of sums


def test_kept_rows_are_the_samples_of_an_even_log_and_all_instants_of_another(fit):
    even, uneven = (ComparedRun.of(fit, experiment) for experiment in (0, 1))
    np.testing.assert_allclose(even.kept_times, T, atol=1e-12)  # rounding of times that begin at zero
    assert set(np.round(np.delete(T, [7, 30, 31]), 9)) <= set(np.round(uneven.kept_times, 9))
    assert even.rows == 120


def test_half_the_step_has_the_same_samples_and_moves_the_sums_by_the_error_of_the_step(fit):
    whole, half = (ComparedRun.of(fit, 0, is_halved) for is_halved in (False, True))
    assert (half.rows, half.stride) == (whole.rows, 2 * whole.stride)
    np.testing.assert_array_equal(half.kept_times, whole.kept_times)
    a, b = whole.root_mean_squares()[FIT], half.root_mean_squares()[FIT]
    assert 0 < np.abs(a / b - 1).max() < 1e-3  # a fit halves its step until its numbers stay within 1 % of an error


def test_a_delay_and_the_initial_state_of_another_experiment_have_no_place(fit):
    assert "omega(0) of log" not in ComparedRun.of(fit, 1).places
    delayed = wb.fit(MOTOR, LOG, ["J", "delay of v"], start={"delay of v": 0.01})
    run = ComparedRun.of(delayed, 0)
    assert [*run.places] == ["J"]
    with pytest.raises(LookupError, match="'delay of v'"):
        run.at({"delay of v": 0.1})


def test_an_experiment_without_a_sample_that_counts_has_no_mean(fit):
    none = replace(fit.data, weighs=(fit.data.weighs[0], np.zeros_like(fit.data.weighs[1])))
    assert np.isnan(ComparedRun.of(replace(fit, data=none), 1).root_mean_squares()[FIT]).all()
