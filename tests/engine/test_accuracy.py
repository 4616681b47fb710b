"""The accuracy of metrics, and the pilots of a batch."""

import numpy as np
import pytest

from workbench.engine.pilot_selection import pilot_runs
from workbench.engine.step_limits import Accuracy, accuracy, change


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
    assert (found.runs, found.lost_runs) == (4, 1)
    # 0.1 of 2 and of 1, nothing of nothing, and what the longer step lost
    assert found.within == 3 / 4
    assert found.median == pytest.approx(0.1)
    assert found.worst == np.inf
    assert found.miss == "RMSE beyond its tolerance 0.11: its error is inf"
