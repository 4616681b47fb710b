"""The largest value that meets a criterion: its bracket, what was looked at, and criteria that are not monotone."""

from math import inf, isqrt, log2

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.study.evidence import Threshold, bisect, find_largest

SCAN = tuple(2.0**i for i in range(-3, 8))


@given(edge=st.floats(0.2, 100.0), ratio=st.floats(1.0001, 1.5))
def test_the_bracket_holds_the_edge_of_a_monotone_criterion_and_is_as_narrow_as_asked(edge, ratio):
    found = find_largest(lambda x: x <= edge, SCAN, ratio=ratio)
    assert found.largest <= edge < found.next <= ratio * found.largest
    assert not found.beyond


def test_the_root_of_a_polynomial_lies_in_the_bracket():
    # x^3 - x - 1 has one real root, by Cardano's formula
    u = np.sqrt(23 / 108)
    root = np.cbrt(0.5 + u) + np.cbrt(0.5 - u)
    found = bisect(lambda x: x**3 - x - 1 <= 0, 1.0, 2.0, ratio=1 + 1e-12)
    assert found.largest <= root * (1 + 1e-15)  # as the formula rounds
    assert root <= found.next * (1 + 1e-15)
    assert found.next <= (1 + 1e-12) * found.largest
    assert len(found.values) <= 2 + np.ceil(log2(1 / log2(1 + 1e-12)))  # halvings of one octave


def test_each_value_is_asked_once():
    asked = []
    found = find_largest(lambda x: asked.append(x) or x <= 3.0, SCAN, ratio=1.01)
    assert sorted(asked) == sorted(set(asked)) == list(found.values)


def test_a_criterion_that_is_met_again_is_said_and_the_first_edge_is_the_answer():
    found = find_largest(lambda x: x <= 3 or 20 < x < 70, SCAN, ratio=1.01)
    assert found.largest <= 3 < found.next
    assert found.beyond == (32.0, 64.0)
    assert found.sentence.endswith("; the criterion is met again at 32, 64")
    assert f"{len(found.values)} values were tried, from 0.125 to 128" in found.sentence


def test_patience_ends_the_scan():
    found = find_largest(lambda x: x <= 3, SCAN, ratio=None, patience=2)
    assert found.values == SCAN[:7]
    assert (found.largest, found.next) == (2.0, 4.0)


def test_one_failure_does_not_exhaust_a_patience_of_two():
    found = find_largest(lambda x: x != 1.0, SCAN, ratio=None, patience=2)
    assert found.values == SCAN
    assert (found.largest, found.next, found.beyond) == (0.5, 1.0, SCAN[4:])


def test_ends_that_were_not_met_are_said():
    none, all_ = find_largest(lambda x: False, SCAN), find_largest(lambda x: True, SCAN)
    assert (none.largest, none.next) == (0.0, 0.125)
    assert (all_.largest, all_.next) == (128.0, inf)
    assert none.sentence.startswith("the least value, 0.125, does not meet the criterion; 11 values")
    assert all_.sentence.startswith("all values up to 128 meet the criterion; 11 values")


@given(edge=st.integers(1, 10**6))
def test_a_bisection_between_whole_numbers_ends_at_neighbours(edge):
    def between(low, high):
        return float(isqrt(int(low) * int(high)) if high > low + 3 else low + 1) if high > low + 1 else None

    found = bisect(lambda n: n <= edge, 1.0, 2.0**20, ratio=1 + 1e-12, between=between)
    assert (found.largest, found.next) == (edge, edge + 1)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: find_largest(lambda x: True, ()), "one value or several, positive and rising"),
        (lambda: find_largest(lambda x: True, (1.0, 1.0)), "positive and rising"),
        (lambda: find_largest(lambda x: True, (-1.0, 1.0)), "positive and rising"),
        (lambda: find_largest(lambda x: x < 1.5, (1.0, 2.0), ratio=1.0), "above 1"),
        (
            lambda: find_largest(lambda x: x, (1.0, 2.0)),
            r"`find_largest\(criterion=...\)\(1\)` must say by True or False",
        ),
        (lambda: find_largest(lambda x: 1 / 0, (1.0, 2.0)), "ZeroDivisionError"),
        (
            lambda: find_largest(lambda x: x < 1.5, (1.0, 2.0), between=lambda a, b: b),
            "a value between the two, or None",
        ),
        (lambda: find_largest(lambda x: True, (1.0, 2.0), patience=0), "patience"),
        (lambda: bisect(lambda x: x < 1, 2.0, 1.0), "the second larger than the first"),
        (lambda: bisect(lambda x: True, 1.0, 2.0), "got: 1 meets it, 2 meets it"),
        (lambda: bisect(lambda x: x > 1.5, 1.0, 2.0), "got: 1 does not, 2 meets it"),
        (lambda: Threshold((1.0, 2.0), (True,)), "each with its answer"),
        (lambda: Threshold((), ()), "each with its answer"),
    ],
)
def test_a_search_that_means_nothing_is_refused(call, words):
    with pytest.raises(ValueError, match=words):
        call()
