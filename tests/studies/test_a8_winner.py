"""The findings of a8 on who costs least, from given costs."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a8_fair_comparison import changes, findings
from studies.a8_fair_comparison.ablations import RICCATI
from studies.a8_fair_comparison.changes import NOBODY
from studies.a8_fair_comparison.evidence import by_mean_costs
from studies.paper.costs import FAMILY, OTHERS, PRIMARY, judge_laws, judge_means
from studies.paper.entrants import BOTH, PROPOSED_LAW, READINGS
from studies.paper.scenarios import HELD_OUT
from tests.support.given_costs import LONG, LOSES, WINS, costs, evidence, standings
from workbench.study.evidence import compare, pair_samples
from workbench.study.evidence.pooling import WAYS

RESAMPLES = 400  # a tenth of the report's: factors of two decide here, and not the tails of an interval


@pytest.fixture(autouse=True, scope="module")
def few_resamples():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("studies.paper.costs.RESAMPLES", RESAMPLES)
        yield


def test_intervals_of_all_scenarios_hold_at_once():
    values = pair_samples({"a": LONG, "b": 1.001 * LONG}, metric="cost")
    one = judge_laws(values).by[PRIMARY.words]
    assert len(HELD_OUT) * (1 - one.confidence) == pytest.approx(1 - FAMILY)  # the union bound
    alone = compare(values, PRIMARY, confidence=FAMILY, resamples=RESAMPLES, seed=88)
    assert (one.level.low < alone.level.low).all()
    assert (one.level.high > alone.level.high).all()


TIED, FAILS = {PROPOSED_LAW: 1.0, "SMC": 1.001, "PID": 3.0}, {PROPOSED_LAW: None, "SMC": 1.0, "PID": 2.0}


@pytest.mark.parametrize(
    ("figures", "answer"),
    [
        ({"a": WINS, "b": WINS}, PROPOSED_LAW),
        ({"a": WINS, "b": TIED}, NOBODY),
        ({"a": WINS, "b": WINS, "c": LOSES}, PROPOSED_LAW),
        ({"a": WINS, "b": LOSES}, NOBODY),
        ({"a": LOSES, "b": LOSES, "c": TIED}, "SMC"),
        ({"a": TIED, "b": TIED}, NOBODY),
        ({"a": WINS, "b": WINS, "c": FAILS}, PROPOSED_LAW),
    ],
)
def test_who_is_best_follows_from_the_figures(figures, answer):
    finding = findings.winner(evidence(costs(**figures)), READINGS)
    assert finding.answer == answer
    assert f"{answer} has the significantly lowest mean cost" in finding.statement


def test_a_law_that_leads_by_every_count_is_found_and_not_said_to_depend():
    finding = findings.winner(evidence(costs(a=WINS, b=WINS, c=WINS)), READINGS)
    assert (finding.kind, finding.reversals) == ("found", ())


# Of half of the draws SMC is better, and much worse in a few: median and mean have other answers.
HEAVY = np.where(np.arange(160) % 8 == 0, 20.0, 0.8) * LONG


def heavy_tails():
    return {s: pair_samples({PROPOSED_LAW: LONG, "SMC": HEAVY}, metric="cost") for s in ("a", "b", "c")}


LOST = standings(costs(a=LOSES, b=LOSES, c=LOSES))


@pytest.mark.parametrize(
    ("members", "again", "weighted", "words"),
    [
        (heavy_tails(), None, None, "median in place of the mean"),
        (
            costs(a=WINS, b=WINS, c=WINS),
            {"another search": standings(costs(a=LOSES, b=LOSES, c=LOSES))},
            None,
            "search",
        ),
        (costs(a=WINS, b=WINS, c=WINS), None, {"error alone": standings(costs(a=LOSES, b=LOSES, c=LOSES))}, "weight"),
        (costs(a=WINS, b=WINS, c={**LOSES, PROPOSED_LAW: 90.0}), None, None, "together, arithmetic mean"),
        (costs(a=WINS, b=WINS, c=LOSES), None, None, "without scenario 'a'"),
    ],
    ids=["median", "search", "weights", "together", "scenario"],
)
def test_an_answer_that_a_variation_changes_depends_on_it(members, again, weighted, words):
    finding = findings.winner(evidence(members, again, weighted), READINGS)
    assert (finding.kind, finding.answer) == ("depends", PROPOSED_LAW)
    assert any(words in one.words for one in finding.reversals)


def test_no_variation_is_skipped_fewer_laws_alone_count_and_say_why_they_may_differ():
    """The referee's case: open among all laws, and another law best where fewer are compared."""
    few = standings({s: pair_samples({PROPOSED_LAW: LONG, "SMC": 2 * LONG}, metric="cost") for s in ("a", "b")})
    finding = findings.winner(evidence(costs(a=TIED, b=TIED), {"two laws alone": few}), READINGS)
    assert (finding.answer, finding.kind) == (NOBODY, "depends")
    (one,) = finding.reversals
    assert one.words == "two laws alone"
    assert one.detail == f"{PROPOSED_LAW} in 2; 1 pair of laws in place of 3"
    assert one.answer == PROPOSED_LAW


def test_the_variations_of_a_finding_are_all_that_was_computed():
    """Statistics, other numbers, weights, each scenario left out, and each pool with each scenario left out."""
    members = costs(a=WINS, b=WINS, c=LOSES)
    again, weighted = ({words: standings(members) for words in some} for some in (("r", "s"), ("w",)))
    finding = findings.winner(evidence(members, again, weighted), BOTH)
    assert len(finding.variations) == len(OTHERS) + 2 + 1 + 3 + len(WAYS) * (1 + 3)


def test_the_pooled_cost_is_also_judged_with_other_numbers_weights_and_order_of_means():
    members = costs(a=WINS, b=WINS, c=WINS)
    again, weighted = {"another search": LOST}, {"error alone": LOST}
    finding = findings.pooled_cost(evidence(members, again, weighted))
    found = {one.words: one.answer for one in finding.variations}
    assert (finding.answer, found["another search"], found["weights: error alone"]) == (PROPOSED_LAW, "SMC", "SMC")
    assert found["the geometric mean of the mean costs"] == PROPOSED_LAW
    assert "in 2 of 5 variations over all scenarios" in finding.change


def test_the_geometric_mean_of_the_mean_costs_is_that_of_the_levels_in_the_figure():
    rng = np.random.default_rng(2)
    members = {s: pair_samples({law: rng.lognormal(size=160) for law in "xyz"}, metric="cost") for s in "ab"}
    one = by_mean_costs(members).by[PRIMARY.words]
    levels = [judge_means(held).by[PRIMARY.words].level.value for held in members.values()]
    np.testing.assert_allclose(one.level.value, np.sqrt(levels[0] * levels[1]), rtol=1e-12)


def test_the_laws_that_cost_more_and_less_than_the_proposed_one_are_both_counted():
    finding = findings.proposed_finding(evidence(costs(a=WINS, b=WINS, c=LOSES)))
    assert "lower mean cost than AOSMC-RGS, by the number of scenarios: SMC in 1." in finding.evidence
    assert finding.evidence.endswith("significantly higher mean cost: PID in 3; SMC in 2.")


def test_the_scenario_on_which_a_sum_rests_is_named_with_its_part():
    members = costs(
        calm={PROPOSED_LAW: 1.0, "SMC": 1.2}, push={PROPOSED_LAW: 1.0, "SMC": 1.2}, slow={PROPOSED_LAW: 9.0, "SMC": 1.0}
    )
    finding = findings.pooled_cost(evidence(members))
    assert "'slow' makes up 82 % of the sum for 1 law." in finding.evidence  # 9 of 11
    changed = {one.words: one.answer for one in finding.variations}
    assert (changed["the arithmetic mean"], changed["the arithmetic mean without 'slow'"]) == ("SMC", PROPOSED_LAW)


def test_each_statistic_stands_beside_the_one_asked():
    by = judge_laws(pair_samples({"a": LONG, "b": LONG}, metric="cost")).by
    assert list(by) == ["mean", "median", "90 % quantile", "mean of the worst 10 %", "success (<= 4)"]
    assert len(by) == 1 + len(OTHERS)


def test_the_scenarios_with_a_motion_of_the_tuning_are_also_left_out():
    assert changes.SEEN_SCENARIOS == ("paper", "push", "limit", "slow")
    members = costs(paper=WINS, slow=WINS, fast=LOSES)
    words = "without 'paper' and 'slow', which have a motion of the tuning"
    (one,) = (one for one in changes.changes(evidence(members), BOTH.key) if one.words == words)
    assert (one.answer, one.scenarios, one.counts) == ("SMC", 1, {"SMC": 1})


@pytest.mark.parametrize(
    ("figures", "words"),
    [
        (
            {"a": WINS, "b": WINS, "c": LOSES},
            f"{PROPOSED_LAW} is significantly best in 2 of 3 scenarios; behind both observers, in 2.",
        ),
        (
            {"a": LOSES, "b": TIED},
            "SMC is significantly best in 1 of 2 scenarios; behind both observers, in 1 (1 undecided), AOSMC-RGS in "
            "none.",
        ),
        (
            {"a": TIED, "b": TIED},
            "no law is significantly best in any of 2 scenarios; behind both observers, no law in any.",
        ),
    ],
)
def test_the_line_under_the_title_is_short_and_of_the_same_figures(figures, words):
    """Another search of the law without (34) costs 40 % less than the whole law, and the others cost the same."""
    line = findings.answer(evidence(costs(**figures), **{f"{RICCATI}_other": 0.6}))
    assert len(line.split()) <= 40
    assert line == (
        f"With raw readings, {words} Retuned without its Riccati equation, {PROPOSED_LAW} costs 40 % less to 0 % more, "
        "depending on the search."
    )


def test_another_law_behind_both_observers_is_named():
    held = evidence(costs(a=WINS, b=WINS))
    other = replace(held, cost={**held.cost, READINGS.key: LOST})
    assert "SMC is significantly best in 3 of 3 scenarios; behind both observers, AOSMC-RGS in 2." in findings.answer(
        other
    )


def test_a_scenario_with_the_least_mean_and_no_best_law_is_named_with_the_tied_laws():
    finding = findings.proposed_finding(evidence(costs(a=WINS, b=TIED)))
    assert "significantly better than all others in 1 of" in finding.statement
    assert finding.statement.endswith("Its mean is the lowest in 'b', where it is tied with SMC.")
    assert "Its mean is the lowest" not in findings.proposed_finding(evidence(costs(a=WINS, b=LOSES))).statement


def test_the_laws_that_run_as_another_search_tuned_them_are_named():
    members = costs(a=WINS, b=WINS)
    again = {"three laws alone": standings(members), "the second best search of each of three laws": standings(members)}
    finding = findings.winner(evidence(members, again), BOTH)
    names = f"{PROPOSED_LAW}, SMC and PID"
    assert (
        f"If {names} run as tuned by their second best search, the best laws are: {PROPOSED_LAW} in 2."
        in finding.evidence
    )
