"""Judgements: who is best by what was asked, what other statistics reverse, and who wins how often."""

import numpy as np
import pytest

from workbench.study.document.phrases_and_tables import BoldCell
from workbench.study.evidence import (
    LawJudgement,
    Mean,
    Median,
    Quantile,
    Standings,
    Success,
    Tail,
    compare,
    judge,
    pair_samples,
    statistics_table,
)

RNG = np.random.default_rng(5)
BASE = np.exp(0.2 * RNG.normal(size=160))
CHATTERS = RNG.random(160) < 0.16
OTHERS = (Median(), Quantile(0.9), Tail(0.9), Success(5.0))
STEADY, TAILED = 3.4 * BASE, np.where(CHATTERS, 20.0, 2.5) * BASE  # less in most draws, and far more in a few
BEST = {"steady": STEADY, "slow": 1.5 * STEADY}
DEPENDS = {"steady": STEADY, "tailed": TAILED}
OPEN = {"steady": STEADY, "twin": STEADY * np.exp(0.01 * RNG.normal(size=160))}


def judged(values, asked=Mean(), others=OTHERS, **options):
    return judge(pair_samples(values, metric="cost"), asked, others, **options)


def test_a_law_that_is_least_by_every_statistic_is_best_and_said_to_be_with_its_figures():
    found = judged(BEST)
    level = found.by["mean"].level
    assert (found.kind, found.best, found.reversals) == ("best", "steady", ())
    figures = f"{level.value[0]:.3g} ({level.low[0]:.3g} to {level.high[0]:.3g})"
    assert found.sentence == f"least mean cost: steady, {figures}; best by every other statistic too"


def test_a_winner_by_the_median_alone_is_refused_where_the_mean_reverses_it():
    for asked, others, first, second in (
        (Median(), (Mean(),), "tailed", "steady"),
        (Mean(), (Median(),), "steady", "tailed"),
    ):
        found = judged(DEPENDS, asked, others)
        assert found.by[asked.words].best == first
        assert (found.kind, found.best) == ("depends", None)
        assert found.reversals == ((first, second, asked.words, others[0].words),)
        assert f"depends on the statistic: {first} by {asked.words}; {second} by {others[0].words}" == found.sentence


def test_it_depends_where_two_statistics_that_were_not_asked_have_other_laws_best():
    rare = {"steady": STEADY, "tailed": np.where(np.arange(160) % 8 == 0, 10.0, 2.5) * BASE}
    found = judged(rare, Mean(), (Median(), Tail(0.9)))
    assert found.by["mean"].best is None
    assert [found.by[words].best for words in list(found.by)[1:]] == ["tailed", "steady"]
    assert found.kind == "depends"


def test_laws_that_no_statistic_tells_apart_are_open():
    found = judged(OPEN, others=(Median(),), margin=0.02)
    assert (found.kind, found.best) == ("open", None)
    assert found.sentence == "least mean cost: open between steady and twin"


def test_one_failed_run_makes_it_depend_on_whether_the_mean_is_asked():
    lost = np.where(np.arange(160) < 1, np.nan, 0.5 * STEADY)
    found = judged({"steady": STEADY, "fails": lost}, Mean(), (Median(),))
    assert found.kind == "depends"
    assert found.by["mean"].order("steady", "fails") == "below"


def test_success_is_said_and_shown_as_such():
    found = judged(DEPENDS, Success(6.0), ())
    assert found.best == "steady"
    assert found.sentence.startswith("highest success (cost <= 6): steady, 100 % (")
    table = statistics_table("t", "c", found)
    tailed = table.rows[1][1]
    assert tailed.value == pytest.approx(100 * np.mean(TAILED <= 6.0))
    assert (table.columns[1].header, table.columns[1].unit) == ("success (cost <= 6), which decides", "%")


def test_errors_of_the_step_that_may_cross_the_limit_leave_a_success_open():
    values = {"steady": np.full(160, 3.0), "close": np.full(160, 5.1)}
    for error, order in ((0.05, "below"), (0.2, "undecided"), (np.nan, "undecided")):
        held = pair_samples(values, metric="cost", errors={"steady": 0.0, "close": error})
        assert compare(held, Success(5.0)).order("steady", "close") == order


def test_a_table_of_statistics_has_a_column_each_and_says_where_they_disagree():
    table = statistics_table("t", "c", judged(DEPENDS), ("a note",))
    assert [column.header for column in table.columns[1:4]] == [
        "mean cost, which decides",
        "median cost",
        "90 % quantile of cost",
    ]
    assert [isinstance(cell, BoldCell) for cell in table.rows[0][1:3]] == [True, False]
    assert [isinstance(cell, BoldCell) for cell in table.rows[1][1:3]] == [False, True]
    assert str(table.notes[0]).startswith("Depends on the statistic: steady by mean, 90 % quantile, mean of the worst")
    assert "By mean steady is below tailed, but by median significantly above." in table.notes
    assert "a note" in table.notes


def test_standings_count_the_scenarios_in_which_a_law_is_best():
    mixed = {"steady": STEADY, "slow": np.where(CHATTERS, 20.0, 2.5) * BASE}
    close = {"steady": STEADY, "slow": OPEN["twin"]}
    found = Standings({"a": judged(BEST), "b": judged(mixed), "c": judged(close, margin=0.02)})
    assert found.wins["mean"] == {"steady": ("a", "b"), "slow": ()}
    assert found.wins["median"]["slow"] == ("b",)


def test_what_cannot_be_judged_together_is_refused():
    with pytest.raises(ValueError, match="different estimands; got mean, mean"):
        judged(BEST, Mean(), (Mean(),))
    with pytest.raises(ValueError, match="the same laws and the same estimands"):
        Standings({"a": judged(BEST), "b": judged(OPEN)})
    with pytest.raises(ValueError, match="the same laws and the same estimands"):
        Standings({})
    one = judged(BEST).by["mean"]
    with pytest.raises(ValueError, match="name each comparison by its estimand"):
        LawJudgement({"median": one})
    with pytest.raises(ValueError, match="of the same paired values"):
        LawJudgement({"mean": one, "median": judged(BEST).by["median"]})
