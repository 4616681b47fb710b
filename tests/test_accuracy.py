"""What halving every step of a schedule does to the metrics."""

import numpy as np
import pytest
from equations import explosion
from test_schedule import RATES, RELAXATION, STARTS, chosen, maker, relaxed
from workbench.simulate.stepping.schedule import Schedule, Segment, run

from workbench.simulate.step_size import Accuracy, accuracy, change, check_by_halving


def score(runs):
    """x and the integral of x^2 at the horizon."""
    end = np.where(runs.diverged[:, np.newaxis], np.nan, runs.x[:, -1])
    return {"x": end[:, :1], "ISE": end[:, 1:2]}


def test_halving_tells_the_error_of_the_longer_step():
    schedule = Schedule(0.1, (Segment("rk4", 20, 5),))
    p = np.linspace(20.0, 60.0, 9)[:, np.newaxis]
    check = check_by_halving(schedule, RELAXATION, p, STARTS[:9], score, 1.0)
    x = run(schedule, RELAXATION, p, STARTS[:9]).x[:, -1]
    errors = np.abs(x / np.column_stack(relaxed(p[:, 0], 0.5)) - 1)
    for found, error in zip(check.metrics, errors.T, strict=True):
        # order four: a sixteenth of the error is left
        assert found.worst == pytest.approx(15 / 16 * error.max(), rel=0.2)
        assert found.median == pytest.approx(15 / 16 * np.median(error), rel=0.2)


def test_the_check_passes_what_was_chosen_for_its_tolerance():
    check = check_by_halving(chosen(1e-3).schedule, RELAXATION, RATES, STARTS, score, 1e-3)
    assert check.passed, str(check)
    lines = str(check).splitlines()
    assert lines[0].startswith("x: tolerance 0.001 met: median")
    assert "is within its limit of" in lines[2]


def test_a_tolerance_that_is_missed_and_a_step_that_is_too_long_are_said():
    schedule = Schedule(0.1, (Segment("rk4", 20, 4),))
    check = check_by_halving(schedule, RELAXATION, np.array([[50.0], [600.0]]), STARTS[:2], score, 1e-7)
    assert not check.passed
    text = str(check)
    assert "x: tolerance 1e-07 NOT met: median" in text
    assert "stability: the step of 5 ms at 0 s is BEYOND its limit of 4.64 ms" in text


def test_a_run_without_a_value_is_counted_and_never_averaged():
    schedule = Schedule(0.25, (Segment("rk4", 250, 6),))
    starts = np.array([[1.0], [0.1]])

    def end(runs):
        return {"x": runs.x[:, -1]}

    (one,) = check_by_halving(schedule, maker(explosion()), np.zeros((2, 0)), starts, end, 1e-3).metrics
    assert (one.runs, one.lost) == (1, 1)
    assert "1 of 2 runs have no value" in str(one)
    (nothing,) = check_by_halving(schedule, maker(explosion()), np.zeros((1, 0)), starts[:1], end, 1e-3).metrics
    assert not nothing.met
    assert "NOT tested: none of 1 runs has a value" in str(nothing)


def test_a_tolerance_that_some_runs_meet_names_their_share():
    text = str(Accuracy("RMSE", 1e-3, 5e-4, 2e-2, 0.934, 500, 0))
    assert text == "RMSE: tolerance 0.001 met by 93.4 % only: median 5.0e-04, worst 2.0e-02 of 500 runs."


def test_changes_are_relative_to_values_and_infinite_where_only_the_longer_step_has_none():
    value = np.array([[2.0, 1.0], [np.nan, 1.0], [0.0, 0.0], [1.0, 1.0], [np.inf, 1.0]])
    coarse = np.array([[2.2, 1.0], [1.0, 1.0], [0.0, 0.0], [np.nan, 1.0], [np.inf, 1.1]])
    found = accuracy("RMSE", change(value, coarse), value, 0.11)
    assert (found.runs, found.lost) == (4, 1)
    # 0.1 of 2 and of 1, nothing of nothing, and what the longer step lost
    assert found.within == 3 / 4
    assert found.median == pytest.approx(0.1)
    assert found.worst == np.inf
    assert found.miss == "RMSE beyond its tolerance 0.11: it changes by inf at half the step"
