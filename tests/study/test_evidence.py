"""Paired comparisons: what their intervals hold, what a failed run does, and who is best."""

import csv
import io

import numpy as np
import pytest
from scipy import stats

from tests.support.samples import made_sample
from workbench.report.table_text import grid, to_csv
from workbench.study.document.phrases import Emphasis, Measured, Missing
from workbench.study.evidence import (
    Intervals,
    Mean,
    Paired,
    Quantile,
    Tail,
    ablation_table,
    compare,
    comparison_table,
    paired,
    ranks,
    same_draws,
)
from workbench.study.evidence.bootstrap import means, order_statistics
from workbench.study.uncertainty import Estimate, MonteCarlo, SobolDesign

RNG = np.random.default_rng(7)
DRAWS = RNG.normal(size=200)  # what all laws of a draw have in common
LAWS = {
    "good": 1.0 + DRAWS + 0.1 * RNG.normal(size=200),
    "twin": 1.0 + DRAWS + 0.1 * RNG.normal(size=200),
    "poor": 1.2 + DRAWS + 0.1 * RNG.normal(size=200),
}


def with_failed(law: str, count: int) -> dict[str, np.ndarray]:
    """The laws, of which one failed in the first runs."""
    return LAWS | {law: np.where(np.arange(200) < count, np.nan, LAWS[law])}


def coverage(summary, draw, truth, runs: int) -> float:
    """How often all intervals at once hold the truth, over 400 samples."""
    rng = np.random.default_rng(1)
    held = []
    for seed in range(400):
        found = summary(draw(rng, runs), confidence=0.9, resamples=400, seed=seed)
        held.append(((found.low <= truth) & (truth <= found.high)).all())
    return float(np.mean(held))


def exact_means(columns, confidence, resamples, seed):
    return means(columns, np.zeros(columns.shape[1]), confidence, resamples, seed)


def medians(columns, confidence, resamples, seed):
    return order_statistics(columns, 0.5, confidence, resamples, seed)


NOISE = np.array([[1.0, 0.8, 0.0], [0.0, 0.6, 0.0], [0.0, 0.0, 1.0]])


def normal(rng, runs):
    return np.array([1.0, -1.0, 0.0]) + rng.normal(size=(runs, 3)) @ NOISE


def skewed(rng, runs):
    return rng.exponential(size=(runs, 3)) @ NOISE


def test_a_column_with_a_heavy_tail_widens_no_other():
    """Beside eight columns in which one of fifty draws is a hundred times as large; Bonferroni for nine is 1.24."""
    rng = np.random.default_rng(7)
    plain = rng.normal(size=(160, 1))
    heavy = rng.normal(size=(160, 8)) * np.where(rng.uniform(size=(160, 8)) < 0.02, 100.0, 1.0)
    alone, beside = (exact_means(y, 0.995, 4000, 3) for y in (plain, np.hstack([plain, heavy])))
    wider = (beside.high - beside.low)[0] / (alone.high - alone.low)[0]
    assert 1 <= wider < 1.6


# 0.9 within three standard errors of a share over 400 samples, 0.045; a median's steps are whole draws, and so wider
@pytest.mark.parametrize(
    ("summary", "draw", "truth", "low", "high"),
    [
        (exact_means, normal, [1.0, -1.0, 0.0], 0.855, 0.945),
        (exact_means, skewed, [1.0, 1.4, 1.0], 0.855, 0.945),
        (medians, normal, [1.0, -1.0, 0.0], 0.855, 0.99),
    ],
)
def test_all_intervals_at_once_hold_the_truth_as_often_as_they_say(summary, draw, truth, low, high):
    assert low <= coverage(summary, draw, np.array(truth), 60) <= high


def test_one_interval_at_a_time_would_miss_some_of_many_more_often():
    rng, truth = np.random.default_rng(2), np.zeros(10)
    together, alone = [], []
    for seed in range(200):
        y = rng.normal(size=(40, 10))
        found = exact_means(y, 0.9, 300, seed)
        together.append(((found.low <= truth) & (truth <= found.high)).all())
        half = stats.t.ppf(0.95, 39) * y.std(axis=0, ddof=1) / 40**0.5
        alone.append((np.abs(y.mean(axis=0)) <= half).all())
    # ten independent intervals of 90 % hold together in 35 %
    assert np.mean(alone) < 0.5 < 0.84 < np.mean(together)


def test_a_single_mean_has_students_interval():
    y = RNG.normal(size=(400, 1))
    found = exact_means(y, 0.95, 6000, 3)
    half = stats.t.ppf(0.975, 399) * y.std(ddof=1) / 400**0.5
    # the quantile of 6,000 resamples is known to 2.5 %, and 400 draws are not quite normal
    assert (found.high - found.low)[0] / 2 == pytest.approx(half, rel=0.05)


@pytest.mark.parametrize("runs", [50, 51])
def test_a_single_median_has_the_interval_of_the_sign_test(runs):
    y = np.arange(1.0, runs + 1)[:, None]
    found = medians(RNG.permutation(y), 0.95, 6000, 4)
    exact = stats.binom.ppf([0.025, 0.975], runs, 0.5)
    # order statistics are whole draws: the bootstrap may end one further out
    assert abs(found.low[0] - exact[0]) <= 1
    assert abs(found.high[0] - (exact[1] + 1)) <= 1


def test_pairing_sees_what_the_spread_of_the_draws_hides():
    found = compare(paired(LAWS, metric="error"), Mean())
    i, j = 0, 2
    assert found.level.high[i] > found.level.low[j]  # the levels overlap
    assert found.order("good", "poor") == "below"
    assert found.order("poor", "good") == "above"
    assert found.difference.value[i, j] == pytest.approx(np.mean(LAWS["good"] - LAWS["poor"]))


def test_nobody_is_best_where_two_are_alike():
    found = compare(paired(LAWS, metric="error"))
    assert found.best is None
    assert found.leaders == ("good", "twin")
    rest = compare(paired({name: LAWS[name] for name in ("good", "poor")}, metric="error"))
    assert rest.best == "good"


def test_a_difference_within_the_errors_of_the_step_is_open():
    exact = {"good": 0.0, "twin": 0.0, "poor": 0.0}
    for error, order in ((0.0, "below"), (0.25, "undecided"), (np.nan, "undecided"), (np.inf, "undecided")):
        found = compare(paired(LAWS, metric="error", errors=exact | {"poor": error}))
        assert found.order("good", "poor") == order


@pytest.mark.parametrize("estimand", [Mean(), Tail(0.9)])
def test_a_failed_run_makes_a_mean_and_a_tail_infinite_and_so_worse_than_any_other(estimand):
    found = compare(paired(with_failed("good", 1) | {"lost": with_failed("twin", 1)["twin"]}, metric="error"), estimand)
    assert found.level.value[0] == found.level.low[0] == np.inf
    assert found.order("good", "poor") == "above"
    assert found.order("poor", "good") == "below"
    assert found.order("twin", "poor") == "below"
    assert found.order("good", "lost") == "undecided"
    assert not found.alike("good", "lost")
    assert found.best == "twin"


@pytest.mark.parametrize("estimand", [Mean(), Tail(0.9)])
def test_a_law_that_fails_widens_no_interval_of_the_others(estimand):
    rest = {law: LAWS[law] for law in ("twin", "poor")}
    found = compare(paired(with_failed("good", 1), metric="error"), estimand)
    alone = compare(paired(rest, metric="error"), estimand)
    assert found.difference.low[1, 2] == pytest.approx(alone.difference.low[0, 1], rel=1e-12)


def test_medians_count_a_failed_run_as_worse_than_any_other():
    few = compare(paired(with_failed("good", 10) | {"poor": LAWS["poor"] + 0.3}, metric="error"))
    assert few.level.value[0] == np.sort(np.where(np.arange(200) < 10, np.inf, LAWS["good"]))[99]
    assert few.order("good", "poor") == "below"
    many = compare(paired(with_failed("good", 150), metric="error"))
    assert many.level.value[0] == np.inf
    assert many.order("good", "poor") == "above"


def test_a_sure_difference_within_the_margin_is_none():
    values = {"a": np.abs(DRAWS) + 1, "b": 1.01 * (np.abs(DRAWS) + 1)}
    exact, close = (compare(paired(values, metric="error"), margin=margin) for margin in (0.0, 0.02))
    assert exact.order("a", "b") == "below"
    assert not exact.alike("a", "b")
    assert close.order("a", "b") == "undecided"
    assert close.alike("a", "b")
    assert close.best is None
    assert "a difference counts beyond 2 %" in close.said
    off = compare(paired(values, metric="error", errors={"a": 1.0, "b": 0.0}), margin=0.02)
    assert not off.alike("a", "b")


def test_errors_of_the_step_and_the_margin_add_up():
    values = {"a": np.abs(DRAWS) + 1, "b": np.abs(DRAWS) + 1.1}  # 0.1 apart in each draw
    level = float(np.sort(values["a"])[99])
    for errors, margin, order in (
        ((0.0, 0.0), 0.06, "below"),
        ((0.03, 0.03), 0.0, "below"),
        ((0.03, 0.03), 0.06, "undecided"),
    ):
        assert level * 0.06 < 0.1 < level * 0.06 + 0.06
        held = paired(values, metric="error", errors=dict(zip(values, errors, strict=True)))
        assert compare(held, margin=margin).order("a", "b") == order


@pytest.mark.parametrize("error", [0.0, np.nan, np.inf])
def test_a_law_that_always_fails_is_worst_whatever_its_step(error):
    values = LAWS | {"lost": np.full(200, np.nan)}
    held = paired(values, metric="error", errors={"good": 0.0, "twin": 0.0, "poor": 0.0, "lost": error})
    found = compare(held)
    assert found.order("poor", "lost") == "below"
    assert found.order("lost", "poor") == "above"
    assert "lost" not in found.leaders
    assert "lost in 200" in held.said
    assert ("of lost not known" in held.said) == np.isnan(error)


def test_laws_that_fail_in_the_same_draws_are_equal_there():
    lost = np.where(np.arange(200) < 120, np.nan, 1.0)
    found = compare(paired({"a": lost, "b": lost, "c": np.ones(200)}, metric="error"))
    assert np.isnan(found.difference.value[0, 1])
    assert found.order("a", "b") == "undecided"
    assert not found.alike("a", "b")
    assert found.order("c", "a") == "below"


def test_the_same_seed_gives_the_same_intervals_in_blocks_of_any_size(monkeypatch):
    one = compare(paired(LAWS, metric="error"), Mean(), resamples=800, seed=5)
    monkeypatch.setattr("workbench.study.evidence.bootstrap.BLOCK", 700)
    two = compare(paired(LAWS, metric="error"), Mean(), resamples=800, seed=5)
    np.testing.assert_allclose(one.difference.low, two.difference.low, rtol=1e-12)  # sums in another order
    other = compare(paired(LAWS, metric="error"), Mean(), resamples=800, seed=6)
    assert (one.difference.low[0, 1:] != other.difference.low[0, 1:]).all()


def test_ranks_are_counted_and_failed_runs_are_last():
    # every place of one law in 20 draws is given by hand
    values = {
        "a": np.array([1.0] * 10 + [2.0] * 5 + [np.nan] * 5),
        "b": np.array([2.0] * 10 + [1.0] * 5 + [np.nan] * 5),
        "c": np.array([3.0] * 20),
    }
    found = ranks(paired(values, metric="error"))
    np.testing.assert_allclose(found.ranks.value, [[0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.0, 0.75]])
    assert found.below.value[0, 1] == 0.5
    assert found.below.value[1, 0] == 0.25
    exact = stats.binomtest(10, 20).proportion_ci(0.95, "exact")
    assert found.ranks.low[0, 0] == pytest.approx(exact.low)
    assert found.ranks.high[0, 0] == pytest.approx(exact.high)


def test_equal_laws_share_the_worse_rank():
    found = ranks(paired({"a": np.ones(20), "b": np.ones(20), "c": np.full(20, 2.0)}, metric="error"))
    np.testing.assert_array_equal(found.ranks.value, [[0, 1, 0], [0, 1, 0], [0, 0, 1]])
    assert found.below.value[0, 1] == 0


def test_bold_follows_from_significance():
    alike = comparison_table("t", "c", (compare(paired(LAWS, metric="error")),))
    assert not any(isinstance(row[1], Emphasis) for row in alike.rows)
    apart = comparison_table("t", "c", (compare(paired(LAWS | {"good": LAWS["good"] - 1}, metric="error")),))
    assert [isinstance(row[1], Emphasis) for row in apart.rows] == [True, False, False]
    assert any("200 draws; no run failed" in str(note) for note in apart.notes)
    assert "Median over the draws; intervals hold all at once with 95 %." in apart.notes


def test_tables_say_what_failed():
    held = paired(with_failed("good", 150), metric="error", unit="rad", note="seed 3")
    table = comparison_table("t", "c", (compare(held), compare(held, Mean())))
    assert table.rows[0][1:] == (np.inf, np.inf, 150)  # numbers alone: the last column says why
    assert [column.header for column in table.columns[1:3]] == ["median error", "mean error"]
    assert any("good in 150" in str(note) for note in table.notes)
    assert "seed 3" in table.notes


def test_the_ranks_of_a_law_add_up_to_all_draws():
    found = ranks(paired(LAWS, metric="error"))
    np.testing.assert_allclose(found.ranks.value.sum(axis=1), 1, rtol=1e-15)  # rounding


def test_an_ablation_says_what_a_block_is_worth():
    values = {"whole": np.abs(LAWS["good"]) + 1, "adaptation": 2 * (np.abs(LAWS["good"]) + 1)}
    held = paired(values | {"nothing": values["whole"]}, metric="error")
    table = ablation_table("t", "c", (compare(held),), "whole")
    assert [row[0] for row in table.rows] == ["without adaptation", "without nothing"]
    assert table.columns[1].unit == "%"
    assert table.rows[0][1].cell.value == pytest.approx(100)  # twice as much is 100 % more
    assert isinstance(table.rows[0][1], Emphasis)
    assert table.rows[1][1] == Measured(0.0, 0.0, ends=(0.0, 0.0))


def test_a_wide_interval_stays_a_number_in_the_files():
    """Its ends are printed on the page; a CSV has them in columns of their own, and no words among the numbers."""
    lost = np.where(np.arange(200) < 3, 400.0, 1.0)
    table = comparison_table("t", "c", (compare(paired({"a": lost, "b": np.ones(200)}, metric="error"), Mean()),))
    head, wide, exact = csv.reader(io.StringIO(to_csv(table)))
    assert head[1:4] == ["error", "error (from)", "error (to)"]
    value, low, high = map(float, wide[1:4])
    assert (value, low < value < high) == (pytest.approx(lost.mean()), True)
    assert list(map(float, exact[1:4])) == [1.0, 1.0, 1.0]
    assert f"{value:.3g} ({low:.3g} to " in str(grid(table)[0][1].content)


def sample(design=None, drawn=None, **changes):
    given = {
        "name": "s",
        "factors": ("x",),
        "columns": (("error", 0, "rad"),),
        "t": np.ones(1),
        "h": 0.01,
        "seed": 0,
        "fingerprint": "",
        "drawn": np.arange(30.0)[:, None] if drawn is None else drawn,
        "values": np.zeros((30, 1, 1)),
        "again": np.arange(2),
        "errors": np.zeros((2, 1, 1)),
        "limits": np.ones(2),
        "diverged_at": np.full(30, np.nan),
        "design": design or MonteCarlo(1, 30, seed=9),
    }
    return made_sample(**(given | changes))


def test_samples_of_the_same_draws_say_so():
    assert "; step 0.01 s, and half" in same_draws({"a": sample(), "b": sample()})
    note = same_draws({"a": sample(), "b": sample(h=0.02)})
    assert note == (
        "30 draws of 1 factors, the same for each law; seed 9; steps 0.01 s for a; 0.02 s for b, and half of it in 2 "
        "runs."
    )


def test_a_step_beyond_the_stability_limit_is_said_beside_a_comparison():
    note = same_draws({"a": sample(), "b": sample(limits=np.array([0.005, np.nan]))})
    assert note.endswith(
        "and half of it in 2 runs; b: stability limit not known of 1; BEYOND the stability limit in 1 of these, down "
        "to 0.005 s."
    )


def test_nothing_is_so_many_percent_of_zero():
    values = {"whole": np.zeros(30), "adaptation": np.ones(30)}
    table = ablation_table("t", "c", (compare(paired(values, metric="error")),), "whole")
    assert table.rows[0][1] == Missing("not known")


@pytest.mark.parametrize(
    ("made", "why"),
    [
        (lambda: Paired("e", "", ("a", "b"), np.ones((30, 3)), np.ones(2), np.zeros(2)), "a column for each law; got"),
        (
            lambda: Paired("e", "", ("a", "b"), np.full((30, 2), 1.7e308), np.ones(2), np.zeros(2)),
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
        paired(values, metric="error")


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
        paired(LAWS, metric="error", errors=errors)


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
        compare(paired(LAWS, metric="error"), **options)


@pytest.mark.parametrize(
    ("call", "why"),
    [
        (lambda: ranks(paired(LAWS, metric="error"), 2.0), r"`ranks\(confidence=...\)` must be"),
        (lambda: same_draws({"a": 3}), r"to `Sample`, as a dict is; got 3 at \['a'\]"),
    ],
)
def test_what_is_none_of_its_kind_is_refused(call, why):
    with pytest.raises(ValueError, match=why):
        call()


def test_where_all_laws_fail_once_their_means_are_open():
    all_lost = {law: np.where(np.arange(200) < 1, np.nan, y) for law, y in LAWS.items()}
    found = compare(paired(all_lost, metric="e"), Mean())
    assert found.best is None
    assert found.leaders == tuple(LAWS)


def test_tables_of_other_laws_are_refused():
    one = compare(paired(LAWS, metric="error"))
    other = compare(paired({"x": LAWS["good"], "y": LAWS["twin"]}, metric="error"))
    with pytest.raises(ValueError, match="comparisons of the same laws"):
        comparison_table("t", "c", (one, other))
    with pytest.raises(LookupError, match="no 'goood' among the 3 laws. Did you mean 'good'"):
        ablation_table("t", "c", (one,), "goood")
