"""The findings of a9 from given figures: their answers change with the runs."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a9_sampling import findings, pages, period_findings, trust
from studies.a9_sampling.evidence import Curve, Evidence, plan, printed_pairs
from studies.a9_sampling.loops import NOISY, Audit, Computer
from studies.paper.card import LAWS, PUBLISHED_COLUMNS
from studies.paper.linearization import SEVEN
from studies.paper.period_rules import GAINLESS, PeriodRules
from studies.paper.quiet_periods import RMSE, SCENARIOS, TV, QuietPeriod, QuietSearch, ends, paper_searches
from workbench.study.evidence import LargestSetting, LoopTrial, Threshold


def flat(rmse, tv, errors=1e-3):
    """Figures that are the same for each joint and run, with errors relative to them, a thousandth if not given."""
    values = {name: np.full(2, float(size)) for name, size in {RMSE: rmse, TV: tv}.items()}
    noisy = {name: np.tile(array, (NOISY, 1)) for name, array in values.items()}
    return Audit(values, {name: errors * array for name, array in values.items()}, noisy)


def order_of(law):
    return 1.0 + 0.1 * SEVEN.index(law)


def quiet(law):
    return flat(order_of(law), 10 * order_of(law))


def turned(law):
    return flat(3 - order_of(law), 30 - 10 * order_of(law))


def lost(law):
    return flat(np.nan, np.nan)


def always(law, scenario, computer):
    return True


def found_at(low, high):
    """A search that ends between two periods in s, quiet at the first and not at the second."""
    trials = tuple((LoopTrial({TV: np.full(2, share)}, {TV: np.zeros(2)}),) for share in (0.5, 50.0))
    return LargestSetting(Threshold((low, high), (True, False)), trials)


def quiet_of(search, low=1e-3, high=1.1e-3, rule=1e-3):
    """The answer of a search: all laws are quiet up to 1 ms, and half of that a period late, if not given."""
    size = 0.5 if search.delay else 1.0
    rules = None if search.law in GAINLESS else PeriodRules(5.0, rule, rule / 2)
    return QuietPeriod(search, found_at(size * low, size * high), np.ones(2), rules)


def evidence(changed=quiet, matches=always, **ends):
    """Laws that no computer touches, AOSMC-RGS first, the others in their order, but for what is changed."""
    still = {(law, scenario, None): quiet(law) for law in SEVEN for scenario in SCENARIOS}
    audits = {key: (changed if matches(*key) else quiet)(key[0]) for key in plan()}
    return Evidence(still | audits, tuple(quiet_of(search, **ends) for search in paper_searches()))


def words(finding):
    """The statement of a finding, its formulas left out."""
    parts = (finding.statement,) if isinstance(finding.statement, str) else finding.statement
    return "".join(part for part in parts if isinstance(part, str))


def lost_by(*ways):
    """Evidence in which AOSMC-RGS is lost at 10 ms in the first scenario, where its memories step in these ways."""
    where = ("AOSMC-RGS", "FS", 1e-2)
    return evidence(lost, lambda law, at, computer: (law, at, computer.period) == where and computer.stepping in ways)


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("chattering", "AOSMC-RGS, ASMC, Fuzzy-ASMC, RBF-ASMC, PID, SMC and super-twisting"),
        ("rule_of_thumb", "too long for none"),
        ("lost_runs", "no run is lost"),
        ("longest_period", "quiet at 0.25 ms"),
    ],
)
def test_every_finding_is_calm_of_laws_that_no_computer_touches(name, answer):
    assert getattr(findings, name)(evidence()).answer == answer


@pytest.mark.parametrize(
    ("name", "changed", "matches", "answer"),
    [
        ("chattering", lambda law: flat(1.0, 1e3), lambda law, *_: law != "PID", "PID"),
        ("published_order", turned, always, "0"),
    ],
)
def test_a_finding_changes_with_the_runs(name, changed, matches, answer):
    assert getattr(findings, name)(evidence(changed, matches)).answer == answer


@pytest.mark.parametrize(
    ("low", "high", "inside", "long"),
    [(1.2e-3, 1.3e-3, 0, False), (0.97e-3, 1.04e-3, 10, False), (0.7e-3, 0.8e-3, 0, True)],
)
def test_a_rule_is_too_long_where_both_ends_of_its_search_are_below_it(low, high, inside, long):
    found = findings.rule_of_thumb(evidence(low=low, high=high))
    assert f"in {inside} of 10 loops" in words(found)
    assert ("AOSMC-RGS in FS" in found.answer) is long
    assert found.answer.endswith("none") is not long
    answers = {one.words: one.answer for one in found.variations}
    assert answers["the bound in place of the eigenvalue"] == "too long for none"  # it is half of the rule here


def test_the_rule_is_compared_within_each_scenario():
    made = evidence()
    short = quiet_of(QuietSearch("SMC", "SS"), 1e-4, 1.1e-4, 5e-5)
    quiet = tuple(short if one.search == short.search else one for one in made.quiet)
    ratios = period_findings.ratios_of(replace(made, quiet=quiet).searches_with(start="paper", delay=False))
    assert ratios["SMC", "FS"] == pytest.approx((1.0, 1.1))
    assert ratios["SMC", "SS"] == pytest.approx((2.0, 2.2))
    assert set(ratios) == {(law, at) for law in SEVEN if law not in GAINLESS for at in SCENARIOS}


@pytest.mark.parametrize(
    ("ways", "kind", "answer"),
    [
        (("euler",), "found", "the integrator"),
        (("euler", "cayley34"), "depends", "the integrator"),
        (("euler", "fine"), "open", "unsettled"),
        (("euler", "cayley34", "cayley", "fine"), "found", "the law"),
        ((), "open", "no run is lost"),
    ],
)
def test_a_loss_is_the_integrators_where_finer_steps_keep_the_run(ways, kind, answer):
    found = findings.lost_runs(lost_by(*ways))
    assert (found.answer, found.kind) == (answer, kind)


def test_a_run_counts_as_lost_by_its_error_too():
    wild = evidence(
        lambda law: flat(3 * order_of(law), 10.0),
        lambda law, at, computer: (law, at, computer.period, computer.stepping) == ("AOSMC-RGS", "FS", 1e-2, "euler"),
    )
    found = findings.lost_runs(wild)
    assert found.answer == "no run is lost"
    answers = {one.words: one.answer for one in found.variations}
    assert answers["a run is lost if its RMSE is more than 2 times the value in continuous time"] == "the integrator"
    assert answers["a run is lost if its RMSE is more than 5 times the value in continuous time"] == "no run is lost"


def test_the_runs_lost_a_period_late_are_blamed_as_the_others():
    where = ("AOSMC-RGS", "FS", Computer(5e-3, True, "euler"))
    found = findings.lost_runs(evidence(lost, lambda *one: one == where))
    assert found.answer == "no run is lost"  # without a delay
    (late,) = (one for one in found.variations if one.words == "torque one period late")
    assert (late.answer, late.detail) == ("the integrator", "of 8 runs 8 by the integrator, 0 by the law")


def test_the_lost_runs_are_counted_and_named():
    euler = lost_by("euler")
    found = findings.lost_runs(euler)
    assert "With explicit Euler 8 of 784 runs diverge, all of AOSMC-RGS" in words(found)
    assert "Of these 8 stay finite if only (34) takes a Cayley step, and 8 with 16 Runge-Kutta steps" in words(found)
    assert "16 Runge-Kutta steps); the run by explicit Euler diverges." in found.evidence
    rows = {row[0]: row[1:] for row in pages.lost_table(euler).rows}
    assert rows["AOSMC-RGS, Euler"] == (0, 0, 0, 0, 0, 0, 8)
    assert rows["AOSMC-RGS, Cayley"] == (0,) * 7
    smc = evidence(lost, lambda law, scenario, computer: law == "SMC" and computer.period == 1e-2)
    assert "With explicit Euler 16 of 784 runs diverge, 0 of them of AOSMC-RGS" in words(findings.lost_runs(smc))


def test_the_runs_that_the_late_searches_lose_are_named():
    assert "these runs diverge: none." in findings.lost_runs(evidence()).evidence
    made = evidence()
    trials = tuple((LoopTrial({TV: np.full(2, share)}, {TV: np.zeros(2)}),) for share in (0.5, np.nan))
    lost = LargestSetting(Threshold((1e-3, 5e-3), (True, False)), trials)
    searched = (replace(one, largest_setting=lost) if one.search == period_findings.BASE else one for one in made.quiet)
    found = findings.lost_runs(replace(made, quiet=tuple(searched)))
    assert "these runs diverge: AOSMC-RGS in FS at 5 ms." in found.evidence


def test_the_longest_period_is_answered_for_every_start_scenario_and_delay():
    found = period_findings.longest_period(evidence())
    searches = [one for one in paper_searches() if one.law == "AOSMC-RGS"]
    assert len(found.variations) == len(searches) - 1 + 3  # but for the answer itself, with three other limits
    assert found.kind == "found"
    assert period_findings.longest_period(evidence(low=4e-4, high=5e-4)).kind == "depends"  # 0.2 ms a period late


def test_another_limit_of_the_total_variation_is_read_from_the_same_search():
    found = quiet_of(QuietSearch("SMC"))
    assert ends(found) == (1e-3, 1.1e-3)
    assert ends(found, 0.9) == (0.0, 1e-3)  # at the first period TV is as large as in continuous time
    assert ends(found, 200.0) == (1.1e-3, np.inf)


def test_the_published_figures_put_in_for_ours_turn_no_printed_pair():
    found = printed_pairs(lambda law, scenario, joint: (PUBLISHED_COLUMNS[scenario, joint + 1].values[law], 0.0))
    assert len(found["below"]) + len(found["undecided"]) == 60
    assert not found["above"]


def test_a_law_that_diverges_falls_behind_all_that_do_not():
    found = printed_pairs(evidence(lost, lambda law, _, computer: law == LAWS[0]).computer_scores(RMSE, 5e-3))
    assert {pair for pair in found["below"] if pair[2] == LAWS[0]} == set()
    assert len([pair for pair in found["above"] if pair[2] == LAWS[0]]) == 4 * (len(LAWS) - 1)


@pytest.mark.parametrize(("later", "ratio"), [((100.1, 100.2), 1.002), ((150, 300), 3.0), ((50, 25), 4.0)])
def test_the_change_with_the_step_is_the_largest_total_variation_over_the_smallest(later, ratio):
    TVs = np.tile(np.array([100.0, *later])[:, np.newaxis], (1, 2))
    steps = Curve("SMC", "clip", True, np.array([1e-3, 5e-4, 2e-4]), TVs)
    (row,) = trust.steps_table([steps]).rows
    assert row[-1] == pytest.approx(ratio)
