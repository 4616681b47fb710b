"""The findings of b4 on errors and periods, from given figures, and the periods that a9 searches, too."""

from dataclasses import replace

import numpy as np
import pytest

from studies.a9_sampling import period_findings
from studies.a9_sampling.evidence import Evidence
from studies.b4_handover import findings, machines, margins, missed_periods
from studies.b4_handover.loops import ERROR, NEAR_START, PID, SIZE, SMC, TV, TWISTING, WHOLE, handover_loops
from studies.b4_handover.margins import BOTH, Loss, Losses, Scan, searches
from studies.paper.card import PROPOSED_LAW
from studies.paper.period_rules import PeriodRules
from studies.paper.quiet_periods import ON_REFERENCE, PAPERS, TRUTH, QuietPeriod, quiet_period
from tests.support.handed_loops import BY_NAME, M4F
from workbench.handover.replays import TargetResult
from workbench.handover.targets.target import TargetCost
from workbench.study import Results
from workbench.study.evidence import LargestSetting, LoopTrial, Threshold


def scan_of(one, at, error):
    """A scan over shares of the period of a loop."""
    values = tuple(one.period * np.array(at))
    return Scan(Threshold(values, tuple(e <= 1.1 for e in error)), np.array(error), np.ones(len(at)))


@pytest.fixture(scope="module")
def both_studies():
    """a9 and b4, imported where they are asked for: all their loops and sweeps take ten seconds."""
    from studies.a9_sampling import study as a9
    from studies.b4_handover import study as b4

    return a9, b4


@pytest.mark.heavy
def test_the_sweeps_have_names_of_their_own_and_the_laws_at_the_period_of_aosmc_rgs_are_among_them(both_studies):
    names = [sweep.name for sweep in both_studies[1].study.sweeps]
    assert len(set(names)) == len(names)
    assert {missed_periods.name_of(one) for one in missed_periods.shared_period()} <= set(names)


@pytest.mark.heavy
def test_both_pages_search_the_longest_period_by_the_same_function_on_the_same_loops(both_studies):
    a9, b4 = both_studies
    (own,) = (work for work in b4.study.works if work.name == "quiet")
    (other,) = (work for work in a9.study.works if work.name == "quiet")
    assert own.function is other.function is quiet_period
    unlimited = {search for search in own.over if search.limit is None}
    assert unlimited < set(other.over)
    assert {(search.law, search.start) for search in unlimited} == {
        (law, start) for law in (PROPOSED_LAW, SMC, TWISTING, PID) for start in (ON_REFERENCE, PAPERS)
    }
    assert all(search.delay for search in unlimited)


# Findings from given figures


def all_of(value):
    return Losses(*[Loss(value, 0.0)] * 6)


def quiet_at(search, longest):
    """A search that ends with a longest period in s."""
    trials = tuple((LoopTrial({TV: np.full(2, share)}, {TV: np.zeros(2)}),) for share in (0.5, 50.0))
    found = LargestSetting(Threshold((longest, 1.1 * longest), (True, False)), trials)
    return QuietPeriod(search, found, np.ones(2), PeriodRules(5.0, 1e-3, 1e-3))


@pytest.fixture
def figures(monkeypatch):
    """The losses and the longest periods of all loops, to be changed: 1 % and twice the declared period."""
    held = {one.name: all_of(0.01) for one in handover_loops()}
    quiet = {search: quiet_at(search, 2 * BY_NAME[search.law].period) for search in searches()}
    scans = {
        key: scan_of(one, [0.5, 2.0, 3.0], [1.0, 1.0, 2.0])
        for one in handover_loops()
        for key in [(one.key, s) for s in BOTH]
    }
    monkeypatch.setattr(findings, "all_losses", lambda results, *given, **named: held)
    monkeypatch.setattr(findings, "error_of", lambda results, name, **named: (1e-5, 1e-4, "rad"))
    monkeypatch.setattr(
        findings,
        "scans",
        lambda results: margins.Scans({key: scans[key] for key in margins.digital_design_items()}, {}),
    )
    return held, quiet, scans


def results_of(quiet):
    return Results(works={"quiet": tuple(quiet.values())})


def test_the_finding_on_errors_names_the_loop_whose_error_grows_most(figures):
    held, quiet, _ = figures
    held[TWISTING] = replace(all_of(0.01), together=Loss(0.37, 0.01))
    found = findings.loss_finding(results_of(quiet))
    assert "chatters" not in found.evidence
    assert found.answer == TWISTING
    assert "raise the error of super-twisting most: by 37 %, from 10 µrad to 13.7" in found.statement
    assert "raise the error of the other loops by at most 1 %" in found.statement
    assert found.kind == "depends"  # by each effect alone all grow alike, and the first is named


def test_a_loop_that_chatters_at_its_declared_period_has_no_growth_from_there(figures):
    held, quiet, _ = figures
    held[PROPOSED_LAW] = replace(all_of(0.01), together=Loss(0.37, 0.01))
    far = next(search for search in quiet if (search.law, search.start, search.limit) == (PROPOSED_LAW, PAPERS, None))
    quiet[far] = quiet_at(far, 3.3e-5)
    found = findings.loss_finding(results_of(quiet))
    assert (
        "From the far start AOSMC-RGS chatters at its declared period, and the error is 10 µrad and changes by 37 %."
        in (found.evidence)
    )
    assert "From the far start, the runs of AOSMC-RGS with a perfect clock chatter" in found.statistic


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (-1, "not at any level tried, from 0.1 % on"),
        (0, "up to 0.1 % but not at"),
        (-2, "the largest level tried"),
    ],
)
def test_a_level_that_keeps_an_error_is_printed_with_the_next_one_tried(place, words):
    levels = (*missed_periods.missed_levels(), 0.0)
    assert words in missed_periods.level_words(levels[place])


def test_the_variations_of_the_errors_hold_all_starts_and_statistics(figures):
    words = [one.words for one in findings.loss_finding(results_of(figures[1])).variations]
    for start in findings.START_WORDS.values():
        for statistic in (ERROR, SIZE, WHOLE):
            asked = f"{statistic}, {start}"
            assert (asked in words) is (asked != f"{ERROR}, {findings.START_WORDS[NEAR_START]}")


def test_the_longest_period_is_answered_by_start(figures):
    _, quiet, _ = figures
    found = findings.longest_period(results_of(quiet))
    assert (found.answer, found.kind) == ("quiet at 0.25 ms", "found")
    assert "too long: none from the near start, none from the far start" in found.evidence[-1]
    far = next(search for search in quiet if (search.law, search.start, search.limit) == (PROPOSED_LAW, PAPERS, None))
    quiet[far] = quiet_at(far, 3.3e-5)
    found = findings.longest_period(results_of(quiet))
    assert (found.answer, found.kind) == ("not quiet at 0.25 ms", "depends")
    assert "0.5 ms from a start on the reference but up to 0.033 ms from the paper's start" in found.statement
    assert "too long: none from the near start, AOSMC-RGS from the far start" in found.evidence[-1]


@pytest.mark.heavy
def test_both_pages_give_the_same_answer_for_the_same_searches(figures, both_studies):
    a9, b4 = both_studies
    _, quiet, _ = figures
    for search in quiet:
        if search.law == PROPOSED_LAW:
            quiet[search] = quiet_at(search, 3.3e-5 if search.start == PAPERS else 3e-4)
    own = findings.longest_period(results_of(quiet))
    others = {
        replace(search, observer=TRUTH): replace(found, search=replace(search, observer=TRUTH))
        for search, found in quiet.items()
        if search.limit is None
    }
    (cited,) = own.cites
    other = period_findings.longest_period(Evidence({}, tuple(others.values())))
    assert cited == f"{a9.study.name}/{other.name}"
    assert other.cites == (f"{b4.study.name}/{own.name}",)
    assert (own.answer, own.kind) == (other.answer, other.kind)


def test_a_count_is_a_share_of_the_longest_period_from_a_named_start(figures):
    _, quiet, _ = figures
    far = next(search for search in quiet if (search.law, search.start, search.limit) == (PROPOSED_LAW, PAPERS, None))
    quiet[far] = quiet_at(far, 3.3e-5)
    rows = {
        one.name: (TargetResult(M4F, bits=1, figures=TargetCost(168e6 * 1e-4, stack=4000)),) for one in handover_loops()
    }
    works = {"quiet": tuple(quiet.values()), "replays": tuple(rows.values()), "single_replays": tuple(rows.values())}
    own = BY_NAME[PROPOSED_LAW]
    near, far_fit = (machines.fit_of(Results(works=works), own, "cortex-m4f", start) for start in BOTH)
    assert near.share == pytest.approx(1e-4 / 5e-4)  # 0.1 ms of twice the declared period
    assert far_fit.share == pytest.approx(1e-4 / 3.3e-5)
    found = machines.fit_finding(Results(works=works), near, far_fit)
    assert found.answer == f"{PROPOSED_LAW} does not fit"
    assert (
        "takes 0.1 ms per period on a Cortex-M4F: 20 % of the longest period allowed from a start on the reference"
        in (found.statement)
    )
    assert "303 % from the paper's start" in found.statement
