"""The accuracy of metrics, and the step that is chosen by halving."""

import numpy as np
import pytest
from equations import decay, explosion

from workbench.core import rk4
from workbench.simulate.pilots import pilot_runs
from workbench.simulate.step_size import Accuracy, accuracy, change, step_for_tolerance


def test_the_step_for_a_tolerance_is_the_first_half_that_keeps_it():
    def make(h):
        return rk4(decay(), h)

    p, x0 = np.array([[1.0], [5.0]]), np.ones((2, 1))
    h = step_for_tolerance(make, p, x0, 1.0, 1e-6, 0.25)
    halves = [0.25 / 2**k for k in range(12)]
    # order four: the change from h to h / 2 is 15 / 16 of the error, which is a t h^4 a^4 / 120 exp(-a t) at most
    assert h in halves
    assert step_for_tolerance(make, p, x0, 1.0, 1e-8, 0.25) < h
    with pytest.raises(ValueError, match="No step `h` keeps the tolerance of 1e-20: that of"):
        step_for_tolerance(make, p, x0, 1.0, 1e-20, 0.25, halvings=3)
    with pytest.raises(ValueError, match="none of the 1 pilot runs stays finite up to 2 s at steps down to"):
        step_for_tolerance(lambda h: rk4(explosion(), h), np.zeros((1, 0)), np.ones((1, 1)), 2.0, 1e-3, 0.5)


def test_pilots_are_spread_over_the_numbers_of_a_batch_whatever_its_order():
    p, x0 = np.random.default_rng(1).permutation(100.0 * np.arange(50))[:, np.newaxis], np.ones((50, 1))
    few, turned = pilot_runs(p, x0, 5), pilot_runs(p[::-1], x0, 5)
    np.testing.assert_array_equal(np.sort(p[few, 0]), [0, 1200, 2400, 3700, 4900])
    np.testing.assert_array_equal(np.sort(p[few]), np.sort(p[::-1][turned]))


def test_a_tolerance_that_some_runs_meet_names_their_share():
    text = str(Accuracy("RMSE", 1e-3, 5e-4, 2e-2, 0.934, 500, 0))
    assert (
        text
        == "RMSE: tolerance 0.001 NOT met by 93.4 % of 500 runs: median 5.0e-04, worst 2.0e-02; 0 runs have no value."
    )


def test_changes_are_relative_to_values_and_infinite_where_only_the_longer_step_has_none():
    value = np.array([[2.0, 1.0], [np.nan, 1.0], [0.0, 0.0], [1.0, 1.0], [np.inf, 1.0]])
    coarse = np.array([[2.2, 1.0], [1.0, 1.0], [0.0, 0.0], [np.nan, 1.0], [np.inf, 1.1]])
    found = accuracy("RMSE", change(value, coarse), value, 0.11)
    assert (found.runs, found.lost) == (4, 1)
    # 0.1 of 2 and of 1, nothing of nothing, and what the longer step lost
    assert found.within == 3 / 4
    assert found.median == pytest.approx(0.1)
    assert found.worst == np.inf
    assert found.miss == "RMSE beyond its tolerance 0.11: its error is inf"
