"""Paired comparisons: what their intervals hold, what a failed run does, and who is best."""

import csv
import io

import numpy as np
import pytest
from scipy import stats

from tests.support.compared_laws import DRAWS, LAWS, sample
from workbench.report.table_text import grid, to_csv
from workbench.study.document.phrases_and_tables import BoldCell, MissingCell, ValueWithError
from workbench.study.evidence import (
    Mean,
    Tail,
    ablation_table,
    compare,
    comparison_table,
    pair_samples,
    ranks,
    same_draws,
)


def with_failed(law: str, count: int) -> dict[str, np.ndarray]:
    """The laws, of which one failed in the first runs."""
    return LAWS | {law: np.where(np.arange(200) < count, np.nan, LAWS[law])}


def test_pairing_sees_what_the_spread_of_the_draws_hides():
    found = compare(pair_samples(LAWS, metric="error"), Mean())
    i, j = 0, 2
    assert found.level.high[i] > found.level.low[j]  # the levels overlap
    assert found.order("good", "poor") == "below"
    assert found.order("poor", "good") == "above"
    assert found.difference.value[i, j] == pytest.approx(np.mean(LAWS["good"] - LAWS["poor"]))


def test_nobody_is_best_where_two_are_alike():
    found = compare(pair_samples(LAWS, metric="error"))
    assert found.best is None
    assert found.leaders == ("good", "twin")
    rest = compare(pair_samples({name: LAWS[name] for name in ("good", "poor")}, metric="error"))
    assert rest.best == "good"


def test_a_difference_within_the_errors_of_the_step_is_open():
    exact = {"good": 0.0, "twin": 0.0, "poor": 0.0}
    for error, order in ((0.0, "below"), (0.25, "undecided"), (np.nan, "undecided"), (np.inf, "undecided")):
        found = compare(pair_samples(LAWS, metric="error", errors=exact | {"poor": error}))
        assert found.order("good", "poor") == order


@pytest.mark.parametrize("estimand", [Mean(), Tail(0.9)])
def test_a_failed_run_makes_a_mean_and_a_tail_infinite_and_so_worse_than_any_other(estimand):
    found = compare(
        pair_samples(with_failed("good", 1) | {"lost": with_failed("twin", 1)["twin"]}, metric="error"), estimand
    )
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
    found = compare(pair_samples(with_failed("good", 1), metric="error"), estimand)
    alone = compare(pair_samples(rest, metric="error"), estimand)
    assert found.difference.low[1, 2] == pytest.approx(alone.difference.low[0, 1], rel=1e-12)


def test_medians_count_a_failed_run_as_worse_than_any_other():
    few = compare(pair_samples(with_failed("good", 10) | {"poor": LAWS["poor"] + 0.3}, metric="error"))
    assert few.level.value[0] == np.sort(np.where(np.arange(200) < 10, np.inf, LAWS["good"]))[99]
    assert few.order("good", "poor") == "below"
    many = compare(pair_samples(with_failed("good", 150), metric="error"))
    assert many.level.value[0] == np.inf
    assert many.order("good", "poor") == "above"


def test_a_sure_difference_within_the_margin_is_none():
    values = {"a": np.abs(DRAWS) + 1, "b": 1.01 * (np.abs(DRAWS) + 1)}
    exact, close = (compare(pair_samples(values, metric="error"), margin=margin) for margin in (0.0, 0.02))
    assert exact.order("a", "b") == "below"
    assert not exact.alike("a", "b")
    assert close.order("a", "b") == "undecided"
    assert close.alike("a", "b")
    assert close.best is None
    assert "a difference counts beyond 2 %" in close.footnote
    off = compare(pair_samples(values, metric="error", errors={"a": 1.0, "b": 0.0}), margin=0.02)
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
        held = pair_samples(values, metric="error", errors=dict(zip(values, errors, strict=True)))
        assert compare(held, margin=margin).order("a", "b") == order


@pytest.mark.parametrize("error", [0.0, np.nan, np.inf])
def test_a_law_that_always_fails_is_worst_whatever_its_step(error):
    values = LAWS | {"lost": np.full(200, np.nan)}
    held = pair_samples(values, metric="error", errors={"good": 0.0, "twin": 0.0, "poor": 0.0, "lost": error})
    found = compare(held)
    assert found.order("poor", "lost") == "below"
    assert found.order("lost", "poor") == "above"
    assert "lost" not in found.leaders
    assert "lost in 200" in held.footnote
    assert ("of lost not known" in held.footnote) == np.isnan(error)


def test_laws_that_fail_in_the_same_draws_are_equal_there():
    lost = np.where(np.arange(200) < 120, np.nan, 1.0)
    found = compare(pair_samples({"a": lost, "b": lost, "c": np.ones(200)}, metric="error"))
    assert np.isnan(found.difference.value[0, 1])
    assert found.order("a", "b") == "undecided"
    assert not found.alike("a", "b")
    assert found.order("c", "a") == "below"


def test_the_same_seed_gives_the_same_intervals_in_blocks_of_any_size(monkeypatch):
    one = compare(pair_samples(LAWS, metric="error"), Mean(), resamples=800, seed=5)
    monkeypatch.setattr("workbench.study.evidence.bootstrap.BLOCK", 700)
    two = compare(pair_samples(LAWS, metric="error"), Mean(), resamples=800, seed=5)
    np.testing.assert_allclose(one.difference.low, two.difference.low, rtol=1e-12)  # sums in another order
    other = compare(pair_samples(LAWS, metric="error"), Mean(), resamples=800, seed=6)
    assert (one.difference.low[0, 1:] != other.difference.low[0, 1:]).all()


def test_ranks_are_counted_and_failed_runs_are_last():
    # every place of one law in 20 draws is given by hand
    values = {
        "a": np.array([1.0] * 10 + [2.0] * 5 + [np.nan] * 5),
        "b": np.array([2.0] * 10 + [1.0] * 5 + [np.nan] * 5),
        "c": np.array([3.0] * 20),
    }
    found = ranks(pair_samples(values, metric="error"))
    np.testing.assert_allclose(found.ranks.value, [[0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.0, 0.75]])
    assert found.below.value[0, 1] == 0.5
    assert found.below.value[1, 0] == 0.25
    exact = stats.binomtest(10, 20).proportion_ci(0.95, "exact")
    assert found.ranks.low[0, 0] == pytest.approx(exact.low)
    assert found.ranks.high[0, 0] == pytest.approx(exact.high)


def test_equal_laws_share_the_worse_rank():
    found = ranks(pair_samples({"a": np.ones(20), "b": np.ones(20), "c": np.full(20, 2.0)}, metric="error"))
    np.testing.assert_array_equal(found.ranks.value, [[0, 1, 0], [0, 1, 0], [0, 0, 1]])
    assert found.below.value[0, 1] == 0


def test_bold_follows_from_significance():
    alike = comparison_table("t", "c", (compare(pair_samples(LAWS, metric="error")),))
    assert not any(isinstance(row[1], BoldCell) for row in alike.rows)
    apart = comparison_table("t", "c", (compare(pair_samples(LAWS | {"good": LAWS["good"] - 1}, metric="error")),))
    assert [isinstance(row[1], BoldCell) for row in apart.rows] == [True, False, False]
    assert any("200 draws; no run failed" in str(note) for note in apart.notes)
    assert "Median over the draws; all intervals hold at once with a confidence of 95 %." in apart.notes


def test_tables_say_what_failed():
    held = pair_samples(with_failed("good", 150), metric="error", unit="rad", note="seed 3")
    table = comparison_table("t", "c", (compare(held), compare(held, Mean())))
    assert table.rows[0][1:] == (np.inf, np.inf, 150)  # numbers alone: the last column says why
    assert [column.header for column in table.columns[1:3]] == ["median error", "mean error"]
    assert any("good in 150" in str(note) for note in table.notes)
    assert "seed 3" in table.notes


def test_the_ranks_of_a_law_add_up_to_all_draws():
    found = ranks(pair_samples(LAWS, metric="error"))
    np.testing.assert_allclose(found.ranks.value.sum(axis=1), 1, rtol=1e-15)  # rounding


def test_an_ablation_says_what_a_block_is_worth():
    values = {"whole": np.abs(LAWS["good"]) + 1, "adaptation": 2 * (np.abs(LAWS["good"]) + 1)}
    held = pair_samples(values | {"nothing": values["whole"]}, metric="error")
    table = ablation_table("t", "c", (compare(held),), "whole")
    assert [row[0] for row in table.rows] == ["without adaptation", "without nothing"]
    assert table.columns[1].unit == "%"
    assert table.rows[0][1].cell.value == pytest.approx(100)  # twice as much is 100 % more
    assert isinstance(table.rows[0][1], BoldCell)
    assert table.rows[1][1] == ValueWithError(0.0, 0.0, ends=(0.0, 0.0))


def test_a_wide_interval_stays_a_number_in_the_files():
    """Its ends are printed on the page; a CSV has them in columns of their own, and no words among the numbers."""
    lost = np.where(np.arange(200) < 3, 400.0, 1.0)
    table = comparison_table("t", "c", (compare(pair_samples({"a": lost, "b": np.ones(200)}, metric="error"), Mean()),))
    head, wide, exact = csv.reader(io.StringIO(to_csv(table)))
    assert head[1:4] == ["error", "error (from)", "error (to)"]
    value, low, high = map(float, wide[1:4])
    assert (value, low < value < high) == (pytest.approx(lost.mean()), True)
    assert list(map(float, exact[1:4])) == [1.0, 1.0, 1.0]
    assert f"{value:.3g} ({low:.3g} to " in str(grid(table)[0][1].content)


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
    table = ablation_table("t", "c", (compare(pair_samples(values, metric="error")),), "whole")
    assert table.rows[0][1] == MissingCell("not known")
