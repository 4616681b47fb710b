"""Evidence that does not fit together, and values, errors and options that mean nothing, are refused."""

import numpy as np
import pytest

from tests.support.compared_laws import LAWS, sample
from workbench.study.evidence import (
    Intervals,
    Mean,
    PairedSamples,
    Quantile,
    Tail,
    ablation_table,
    compare,
    comparison_table,
    pair_samples,
    ranks,
    same_draws,
)
from workbench.study.uncertainty import Estimate, SobolDesign


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (
            lambda: PairedSamples("e", "", ("a", "b"), np.ones((30, 3)), np.ones(2), np.zeros(2)),
            "a column for each law; got",
        ),
        (
            lambda: PairedSamples("e", "", ("a", "b"), np.full((30, 2), 1.7e308), np.ones(2), np.zeros(2)),
            "sums a double holds",
        ),
        (lambda: Intervals(np.ones(2), np.ones(3), np.ones(2)), "two ends for each value; got shapes"),
        (lambda: Estimate(np.full(2, np.inf), np.ones(2)), r"`Estimate\(value=...\)` must be numbers up to 1e\+304"),
        (lambda: Estimate(np.ones(2), np.ones(1)), "a half-width for each value; got shapes"),
    ],
)
def test_evidence_that_does_not_fit_together_is_refused(made, why):
    with pytest.raises(ValueError, match=why):
        made()


@pytest.mark.parametrize(
    ("other", "why"),
    [
        ({"drawn": np.arange(30.0)[::-1, None]}, "'a' and 'b' differ in them"),
        ({"factors": ("y",)}, "'a' and 'b' differ in them"),
        ({"design": SobolDesign(1, 8)}, "points of a SobolDesign"),
        ({"t": np.full(1, 2.0)}, "'a' runs for 1 s and 'b' for 2 s"),
    ],
)
def test_samples_that_are_not_paired_are_refused(other, why):
    with pytest.raises(ValueError, match=why):
        same_draws({"a": sample(), "b": sample(**other)})


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"a": np.ones(30)}, "two laws or more"),
        ({"a": np.ones(30), "b": np.ones(29)}, "got 30 of a, 29 of b"),
        ({"a": np.ones(19), "b": np.ones(19)}, "at least 20 draws"),
        ({"a": np.ones((30, 1)), "b": np.ones(30)}, "one number a draw for 'a'"),
        ({"a": ["x"] * 30, "b": np.ones(30)}, "one number a draw for 'a'"),
        ({"a": np.full(30, -np.inf), "b": np.ones(30)}, "one number a draw for 'a'"),
        ({1: np.ones(30), "b": np.ones(30)}, r"a mapping from `str` to .*; got 1 at \[1\]"),
    ],
)
def test_values_that_cannot_be_compared_are_refused(values, why):
    with pytest.raises(ValueError, match=why):
        pair_samples(values, metric="error")


@pytest.mark.parametrize(
    ("errors", "why"),
    [
        ({"good": 0.1}, "one error for each"),
        ([0.1, 0.1, 0.1], "a mapping from `str` to `float`"),
        (dict.fromkeys(LAWS, -1.0), "that are not negative"),
        (dict.fromkeys(LAWS, "x"), "got 'x' at"),
        (dict.fromkeys(LAWS), "got None at"),
    ],
)
def test_errors_that_fit_no_law_are_refused(errors, why):
    with pytest.raises(ValueError, match=why):
        pair_samples(LAWS, metric="error", errors=errors)


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"estimand": "mean"}, r"`compare\(estimand=...\)` must be a `Mean` or a `Median`.*; got 'mean'"),
        ({"estimand": Quantile(0.99)}, "at least 10 draws beyond it for an interval that holds; 200 draws have 2"),
        ({"estimand": Quantile(0.01)}, "at least 10 draws beyond it"),
        ({"estimand": Tail(0.96)}, "at least 10 draws in the tail"),
        ({"confidence": 1.0}, "between 0 and 1"),
        ({"margin": -0.1}, "a share from 0 to 1"),
        ({"margin": "2 %"}, "a number; got '2 %'"),
        ({"resamples": 99}, "from 100 to 1000000"),
        ({"seed": -1}, "whole number from 0"),
    ],
)
def test_a_comparison_refuses_what_means_nothing(options, why):
    with pytest.raises(ValueError, match=why):
        compare(pair_samples(LAWS, metric="error"), **options)


@pytest.mark.parametrize(
    ("call", "why"),
    [
        (lambda: ranks(pair_samples(LAWS, metric="error"), 2.0), r"`ranks\(confidence=...\)` must be"),
        (lambda: same_draws({"a": 3}), r"to `Sample`, as a dict is; got 3 at \['a'\]"),
    ],
)
def test_what_is_none_of_its_kind_is_refused(call, why):
    with pytest.raises(ValueError, match=why):
        call()


def test_where_all_laws_fail_once_their_means_are_open():
    all_lost = {law: np.where(np.arange(200) < 1, np.nan, y) for law, y in LAWS.items()}
    found = compare(pair_samples(all_lost, metric="e"), Mean())
    assert found.best is None
    assert found.leaders == tuple(LAWS)


def test_tables_of_other_laws_are_refused():
    one = compare(pair_samples(LAWS, metric="error"))
    other = compare(pair_samples({"x": LAWS["good"], "y": LAWS["twin"]}, metric="error"))
    with pytest.raises(ValueError, match="comparisons of the same laws"):
        comparison_table("t", "c", (one, other))
    with pytest.raises(LookupError, match="no 'goood' among the 3 laws. Did you mean 'good'"):
        ablation_table("t", "c", (one,), "goood")
