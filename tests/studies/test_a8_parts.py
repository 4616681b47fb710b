"""The findings of a8 on the parts of the proposed law, from given costs: what the Riccati equation is worth."""

import json
from pathlib import Path

import casadi as ca
import pytest

import workbench as wb
from studies.a8_fair_comparison import changes, findings
from studies.a8_fair_comparison.ablations import RICCATI
from studies.a8_fair_comparison.conditions_section import MEANINGS
from studies.a8_fair_comparison.evidence import Parts
from studies.a8_fair_comparison.other_numbers import PLAIN
from studies.a8_fair_comparison.riccati_worth import A3, costly_draws_table, failures, more_or_less
from studies.paper.card import CARD
from studies.paper.costs import judge_means
from studies.paper.entrants import PROPOSED_LAW
from studies.paper.scenarios import TERMS
from tests.support.given_costs import PART, WINS, costs, evidence, searched
from workbench.study.evidence import leave_one_out

RESAMPLES = 400  # a tenth of the report's: factors of two decide here, and not the tails of an interval


@pytest.fixture(autouse=True, scope="module")
def few_resamples():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("studies.paper.costs.RESAMPLES", RESAMPLES)
        yield


@pytest.mark.parametrize(
    ("without", "answer", "words"),
    [
        (1.5, "better with (34)", "rises by 50 %"),
        (1.001, "no difference", "rises by 0.10 %"),
        (0.5, "worse with (34)", "falls by 50 %"),
        (200.0, "better with (34)", "rises to 200 times its value"),
    ],
)
def test_the_riccati_equation_is_judged_by_the_law_that_is_tuned_again_without_it(without, answer, words):
    """P kept at P(0) is a variation, whatever it costs."""
    frozen, retuned = ({s: PART | {RICCATI: c} for s in "ab"} for c in (214.0, without))
    finding = findings.riccati(evidence(costs(a=WINS, b=WINS), frozen=costs(**frozen), retuned=costs(**retuned)))
    assert finding.answer == answer
    assert words in finding.statement
    assert "rises to 214 times its value if P is kept at the tuned P(0)" in finding.evidence
    assert f"Plain {PLAIN} costs 4.0 % more, and 4.0 % more without" in finding.evidence
    at_start = next(one for one in finding.variations if one.words.startswith("P at the tuned P(0)"))
    assert at_start.answer == "better with (34)"
    assert finding.cites == (("a3_riccati_gains/riccati_gain",) if answer == A3 else ())
    assert ("without noise; its answer is 'better with (34)'." in finding.evidence) == (answer != A3)


def test_what_34_is_worth_is_not_decided_if_another_search_has_another_answer():
    """With its second best search the law without (34) costs a tenth less than the whole law, and not a half more."""
    retuned = costs(**{s: PART | {RICCATI: 1.5} for s in "ab"})
    held = evidence(costs(a=WINS, b=WINS), retuned=retuned, **{f"{RICCATI}_other": 0.6})
    finding = findings.riccati(held)
    assert (finding.answer, finding.kind, finding.cites) == ("undecided", "open", ())
    assert (
        "costs 10 % less to 50 % more over all scenarios together, depending on which of the three searches"
        in finding.statement
    )
    by = {one.words: one.answer for one in finding.variations}
    assert by["the best search of each law, geometric mean"] == "better with (34)"
    assert by["the law without (34) by the second best search, the whole law by the best search"] == "worse with (34)"
    line = findings.answer(held)
    assert line.endswith(f"{PROPOSED_LAW} costs 10 % less to 50 % more, depending on the search.")


@pytest.mark.parametrize(
    ("span", "words"),
    [
        ((-33.0, 43.0), "33 % less to 43 % more"),
        ((4.0, 40.0), "4.0 to 40 % more"),
        ((-40.0, -4.0), "4.0 to 40 % less"),
        ((7.5, 7.5), "7.5 % more"),
        ((-0.5, 0.0), "0.50 % less to 0 % more"),
    ],
)
def test_changes_of_a_cost_are_told_as_more_and_less(span, words):
    assert more_or_less(span) == words


def test_a_search_by_which_a_law_fails_in_most_draws_of_a_scenario_is_named():
    members = searched(costs(limit=PART, slow=PART), **{f"{PROPOSED_LAW}_third": 100.0})
    parts = Parts(None, {}, leave_one_out(members, judge_means), ())
    assert failures(parts) == (
        f" In 'limit' and {changes.scenario_words('slow')}, some searches end at a law that costs more than 20 in up "
        "to 160 of 160 draws."
    )
    (table,) = costly_draws_table(parts)
    whole, less = ("the whole law", 0, 0, 160), ("the law without (34)", 0, 0, 0)
    assert table.rows == tuple((name, *row) for name in ("limit", "slow") for row in (whole, less))


def test_the_answer_of_a3_is_the_one_that_its_report_has():
    place = Path(__file__).parents[2] / "reports" / "a3_riccati_gains" / "findings.json"
    found = {one["name"]: one["answer"] for one in json.loads(place.read_text("utf-8"))["findings"]}
    assert found["riccati_gain"] == A3


def test_a_change_that_rests_on_one_scenario_is_also_given_without_it():
    """Five times the cost in one of two scenarios, the same in the other: 124 % over both, nothing without the one."""
    retuned = costs(a=PART | {RICCATI: 5.0}, b=PART)
    held = evidence(costs(a=WINS, b=WINS), retuned=retuned)
    finding = findings.riccati(held)
    assert "rises by 124 %" in finding.statement  # the square root of five
    assert finding.statement.endswith("and changes by +0 % without 'a'.")
    assert finding.reversals
    assert findings.answer(held).endswith(f"Retuned without its Riccati equation, {PROPOSED_LAW} costs 124 % more.")


def test_the_acceptable_effort_is_twice_the_torque_that_holds_a_level_of_the_second_scenario():
    q = ca.SX(CARD["SS: a1, a2"])
    held = float(ca.norm_2(ca.evalf(wb.paper_arm().gravity_vector(q))))
    assert f"{held:.0f} N m" in MEANINGS["effort"]
    (acceptable,) = [term.acceptable for term in TERMS if term.metric == "effort"]
    assert acceptable == pytest.approx(2 * held, rel=0.01)  # it is a round number
