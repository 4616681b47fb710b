"""Pareto sets, held against their definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from workbench.study.pareto import pareto

# few different numbers, so that ties and equal points abound
TABLES = st.tuples(st.integers(0, 12), st.integers(1, 4)).flatmap(
    lambda shape: arrays(float, shape, elements=st.sampled_from([-1.0, 0.0, 1.0, 2.0, np.inf, np.nan]))
)


def by_definition(points):
    """All points without a NaN that no other one dominates."""

    def dominated(point):
        return any((other <= point).all() and (other < point).any() for other in points if not np.isnan(other).any())

    return {i for i, point in enumerate(points) if not np.isnan(point).any() and not dominated(point)}


@given(TABLES)
def test_a_front_is_what_no_other_point_dominates(points):
    assert set(pareto(points).tolist()) == by_definition(points)


def test_a_front_of_two_measures_falls_in_one_as_it_rises_in_the_other():
    points = np.random.default_rng(1).random((500, 2))
    front = points[pareto(points)]
    assert len(front) > 2
    assert (np.diff(front[:, 0]) > 0).all()
    assert (np.diff(front[:, 1]) < 0).all()


@pytest.mark.parametrize("wrong", [[1.0, 2.0], np.empty((3, 0)), [["a"]], [[1.0], [1.0, 2.0]]])
def test_what_is_no_table_of_measures_is_refused(wrong):
    with pytest.raises(
        ValueError, match=r"`pareto\(points\)` takes points \(B, m\)|`pareto\(points=...\)` must be numbers"
    ):
        pareto(wrong)
