"""The study of handing laws over: its loops and scans, its findings from given figures, and a shortened run."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from studies.a9_sampling import period_findings
from studies.a9_sampling.evidence import Evidence
from studies.b4_handover import findings, machine_tables, machines, margins, missed_periods, operations
from studies.b4_handover.loops import (
    EKF,
    ERROR,
    FAR_START,
    LQG,
    NEAR_START,
    PID,
    SETTLED,
    SIZE,
    SMC,
    TV,
    TWISTING,
    WHOLE,
    handed,
    settled_rmse,
    settled_size,
)
from studies.b4_handover.margins import BOTH, Loss, Losses, Scan, effects, growth, periods_of, searches, starts
from studies.paper.card import PROPOSED
from studies.paper.period_rules import PeriodRules
from studies.paper.quiet_periods import ON_REFERENCE, PAPERS, TRUTH, QuietPeriod, quiet_period
from workbench.engine import simulate
from workbench.engine.metrics import measure
from workbench.handover.replays import TargetResult
from workbench.handover.targets import TARGETS
from workbench.handover.targets.contract import Figures
from workbench.study import Results, Run
from workbench.study.compiled import compile_sweep
from workbench.study.evidence import LargestSetting, LoopTrial, Threshold
from workbench.study.evidence.computer_margins import computer_sweep

BY_NAME = {one.name: one for one in handed()}
EACH = pytest.mark.parametrize("one", handed(), ids=lambda one: one.key)


@EACH
def test_no_law_needs_what_no_instrument_gives(one):
    law = one.digital().law()
    assert not any("no instrument" in note for note in law.notes)
    assert law.delay
    assert set(law.limits) == set(law.commands.names)


@pytest.mark.parametrize(
    "one",
    [pytest.param(one, marks=[pytest.mark.heavy] * (one.name not in (PID, SMC)), id=one.key) for one in handed()],
)
def test_every_loop_stays_near_its_reference_in_its_computer(one):
    found = measure(one.digital(), one.metrics, until=one.until, every=one.until, h=one.period)
    error, busy = (np.array([each.pair[0] for each in found.scores if each.metric == name]) for name in (ERROR, TV))
    size = {LQG: 0.5, EKF: 0.2}.get(one.name, 0.5)
    assert error.max() < size / 2
    assert np.isfinite(busy).all()


def test_the_error_after_the_approach_is_the_root_of_the_mean_square_from_there_on():
    one = BY_NAME[PID]
    sampled, until = one.digital(), 2.0
    found = measure(sampled, [settled_rmse("q", SETTLED * until)], until=until, h=one.period / 2)
    run = simulate(sampled.step(2), until=until)
    late = run.t > SETTLED * until
    sizes = measure(sampled, [settled_size("q", SETTLED * until)], until=until, h=one.period / 2).scores_of(SIZE)
    np.testing.assert_allclose([each.value[0] for each in sizes], np.abs(run["e"][0, late]).mean(axis=0), rtol=5e-3)
    # a sum over the instants in place of the integral, of an error that changes with some rad/s
    values = [one.value[0] for one in found.scores_of(ERROR)]
    np.testing.assert_allclose(values, np.sqrt((run["e"][0, late] ** 2).mean(axis=0)), rtol=5e-3)


@pytest.mark.heavy
def test_a_longer_period_chatters_where_the_rule_of_thumb_of_a9_is_broken():
    one = BY_NAME[SMC]
    phi, K = 0.01, 5.0
    least = np.linalg.eigvalsh(np.array([[3 + 2, 1 + 1], [1 + 1, 1.0]])).min()  # of M with the arm stretched
    rule = 2 * phi * least / K
    calm, loud = (periods_of(one.key).at(period).shares[TV] for period in (rule / 3, 2 * rule))
    assert (loud > 20 * calm).all()


def test_starts_differ_and_effects_are_those_of_the_clock_where_precision_is_compared():
    one = BY_NAME[EKF]
    assert [factor.paths for factor in starts(one)] == [("plant.x",)]
    assert [factor.paths for factor in starts(BY_NAME[PID])] == [("plant.q[0]",), ("plant.q[1]",)]
    for start, middle in ((NEAR_START, 0.0), (FAR_START, np.pi)):  # on the reference, and where the paper starts
        first = starts(BY_NAME[PID], start)[0].distribution
        assert (first.low + first.high) / 2 == pytest.approx(middle, abs=1e-12)
    assert [effect.name for effect in effects(one, "single")] == ["jitter", "missed periods"]
    assert all(len(effect.levels) == 1 for effect in effects(one, "single"))
    declared = {effect.name: effect.declared for effect in effects(one, "double")}
    assert declared["jitter"] == 0.05 * one.period
    assert declared["missed periods"] == 1e-3


# A scan, and a loss


@pytest.mark.heavy
def test_a_scan_ends_where_error_or_variation_first_grows_too_much():
    one = BY_NAME[PID]
    found = growth(periods_of(one.key), [one.period, 8 * one.period, 32 * one.period], {ERROR: 1.1})
    assert found.worst(ERROR)[0] == pytest.approx(1 / 1.1)
    scan = Scan.of(found)
    assert scan.TV is None
    assert scan.error[0] == pytest.approx(1.0)
    assert scan.threshold.largest in found.threshold.values
    assert (scan.error[: sum(found.threshold.met)] <= 1.1).all()


def scan_of(one, at, error):
    """A scan over shares of the period of a loop."""
    values = tuple(one.period * np.array(at))
    return Scan(Threshold(values, tuple(e <= 1.1 for e in error)), np.array(error), np.ones(len(at)))


def test_a_loss_is_the_mean_of_the_worst_ratio_of_each_draw():
    base = np.array([[1.0, 2.0], [2.0, 2.0], [1.0, 1.0]])
    values = np.array([[1.1, 2.0], [2.0, 2.6], [1.2, 1.0]])
    loss = Loss.of(values, base)
    assert loss.value == pytest.approx(0.2)
    assert loss.error == pytest.approx(2 * 0.1 / np.sqrt(3))
    assert np.isinf(Loss.of(np.array([[np.inf, 1.0], [1.0, 1.0], [1.0, 1.0]]), base).value)


# The periods that both pages search


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
        (law, start) for law in (PROPOSED, SMC, TWISTING, PID) for start in (ON_REFERENCE, PAPERS)
    }
    assert all(search.delay for search in unlimited)


@pytest.mark.parametrize("start", [NEAR_START, pytest.param(FAR_START, marks=pytest.mark.heavy)])
def test_a_search_is_about_the_loop_that_is_handed_over(start):
    for search in searches():
        one, path = BY_NAME[search.law], findings.PATHS[start]
        if search.start == path:
            loops = search.loop.ode(), one.computed(start=start).loop.ode()
            assert len({ode.fingerprint for ode in loops}) == 1
            np.testing.assert_array_equal(loops[0].states.default, loops[1].states.default)
            np.testing.assert_array_equal(loops[0].parameters.default, loops[1].parameters.default)


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
    held = {one.name: all_of(0.01) for one in handed()}
    quiet = {search: quiet_at(search, 2 * BY_NAME[search.law].period) for search in searches()}
    scans = {
        key: scan_of(one, [0.5, 2.0, 3.0], [1.0, 1.0, 2.0]) for one in handed() for key in [(one.key, s) for s in BOTH]
    }
    monkeypatch.setattr(findings, "all_losses", lambda results, *given, **named: held)
    monkeypatch.setattr(findings, "error_of", lambda results, name, **named: (1e-5, 1e-4, "rad"))
    monkeypatch.setattr(
        findings, "scans", lambda results: margins.Scans({key: scans[key] for key in margins.designed()}, {})
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
    assert "of the other loops by at most 1 %" in found.statement
    assert found.kind == "depends"  # by each effect alone all grow alike, and the first is named


def test_a_loop_that_chatters_at_its_declared_period_has_no_growth_from_there(figures):
    held, quiet, _ = figures
    held[PROPOSED] = replace(all_of(0.01), together=Loss(0.37, 0.01))
    far = next(search for search in quiet if (search.law, search.start, search.limit) == (PROPOSED, PAPERS, None))
    quiet[far] = quiet_at(far, 3.3e-5)
    found = findings.loss_finding(results_of(quiet))
    assert "From a farther start it chatters at its declared period: its error is 10 µrad, and changes by 37 %." in (
        found.evidence
    )
    assert found.statistic.endswith("no sound base there: AOSMC-RGS.")


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (-1, "at none of the levels tried, from 0.1 % on"),
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
    assert "too long: none from near starts, none from farther ones" in found.evidence[-1]
    far = next(search for search in quiet if (search.law, search.start, search.limit) == (PROPOSED, PAPERS, None))
    quiet[far] = quiet_at(far, 3.3e-5)
    found = findings.longest_period(results_of(quiet))
    assert (found.answer, found.kind) == ("not quiet at 0.25 ms", "depends")
    assert "0.5 ms from a start on the reference but up to 0.033 ms from the paper's start" in found.statement
    assert "too long: none from near starts, AOSMC-RGS from farther ones" in found.evidence[-1]


@pytest.mark.heavy
def test_both_pages_give_the_same_answer_for_the_same_searches(figures, both_studies):
    a9, b4 = both_studies
    _, quiet, _ = figures
    for search in quiet:
        if search.law == PROPOSED:
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


# The machines


M4F = TARGETS["cortex-m4f"].name


def replays(**changes):
    """Each law on two targets with equal bits, of which one result is changed."""
    fine = {"periods": 10, "bits": 640}
    here = TargetResult("gcc -O0", **fine, figures=Figures(900.0, stack=300, code=10, data=0))
    there = replace(here, target=M4F, **changes)
    return {one.name: (here, there if one.name == PID else replace(here, target=M4F)) for one in handed()}


def replayed(**changes):
    """Results with these replays, in single precision too, and with one operation that rounds otherwise."""
    each = tuple(replays(**changes).values())
    alone = TargetResult("gcc -O0", bits=5), TargetResult(M4F, bits=5, differing=7, first="period 3")
    return {"replays": each, "single_replays": tuple(replays().values()), "operations": alone}


@pytest.mark.parametrize(
    ("changes", "answer", "words"),
    [
        ({}, "none", "on 2 of 2 targets."),
        ({"differing": 3, "first": "period 4"}, "Cortex-M4F with mended sums", "on 1 of 2 targets; on Cortex-M4F"),
        ({"memories": 1, "first": "period 4"}, "Cortex-M4F with mended sums", "1 of 6 laws differs (PID)"),
        ({"reason": "install it"}, "none", "on 2 of 2 targets."),
    ],
)
def test_the_targets_with_other_bits_are_counted_and_named(changes, answer, words):
    found = machines.bits_finding(Results(works=replayed(**changes)))
    assert found.answer == answer
    assert words in found.statement
    variations = {one.words: one.answer for one in found.variations}
    assert variations["PID alone"] == answer
    assert variations["SMC alone"] == "none"
    assert variations["single operations in place of laws"] == "Cortex-M4F with mended sums"


def test_every_target_is_replayed_also_the_library_with_a_fault(monkeypatch):
    asked = {}
    monkeypatch.setattr(wb, "replay", lambda sampled, **how: asked.update(how) or replace_results())
    machines.in_doubles(BY_NAME[PID].key)
    assert asked["targets"] == tuple(TARGETS)
    assert "cortex-m4f-libgcc" in asked["targets"]


def replace_results():
    """A replay without results."""
    return type("Replay", (), {"results": ()})()


def test_a_target_that_is_not_installed_is_named():
    absent = TargetResult("gcc -O0", reason="install gcc with `apt-get install gcc`")
    works = dict.fromkeys(("replays", "single_replays"), ((absent,),) * 6) | {"operations": (absent,)}
    found = machines.bits_finding(Results(works=works))
    assert found.kind == "open"
    assert "Not run: gcc -O0." in found.evidence
    rows = machine_tables.bits_table(Results(works=works)).rows
    assert rows == (("gcc -O0", None, None, None, None, None, "not run"),)


def test_a_count_is_a_share_of_the_longest_period_from_a_named_start(figures):
    _, quiet, _ = figures
    far = next(search for search in quiet if (search.law, search.start, search.limit) == (PROPOSED, PAPERS, None))
    quiet[far] = quiet_at(far, 3.3e-5)
    rows = {one.name: (TargetResult(M4F, bits=1, figures=Figures(168e6 * 1e-4, stack=4000)),) for one in handed()}
    works = {"quiet": tuple(quiet.values()), "replays": tuple(rows.values()), "single_replays": tuple(rows.values())}
    own = BY_NAME[PROPOSED]
    near, far_fit = (machines.fit_of(Results(works=works), own, "cortex-m4f", start) for start in BOTH)
    assert near.share == pytest.approx(1e-4 / 5e-4)  # 0.1 ms of twice the declared period
    assert far_fit.share == pytest.approx(1e-4 / 3.3e-5)
    found = machines.fit_finding(Results(works=works), near, far_fit)
    assert found.answer == PROPOSED
    assert (
        "takes 0.1 ms a period on a Cortex-M4F: 20 % of the longest period allowed from a start on the reference"
        in (found.statement)
    )
    assert "303 % from the paper's start" in found.statement


def test_operands_reach_the_roundings_that_are_hard():
    a, b = operations.operands().T
    apart = np.frexp(a)[1] - np.frexp(b)[1]
    two = np.frexp(np.abs(a))[0] == 0.5
    assert (np.bincount(apart[two & (apart > 0)], minlength=60)[1:60] > 100).all()
    assert not two[1::2].any()


def test_operations_that_round_otherwise_are_listed():
    good, bad = TargetResult("one", bits=5), TargetResult("two", bits=5, differing=7, first="period 3")
    results = Results(works={"operations": (good, bad)})
    assert operations.operations_by_target(results) == {"one": 0, "two": 7}
    assert operations.operations_table(results).rows == (("one", 5, 0, "none"), ("two", 5, 7, "period 3"))


# A shortened run


@pytest.fixture(scope="module")
def short():
    """The samples of PID alone, 1 s and three draws each."""
    one, samples = BY_NAME[PID], []
    short = replace(one, until=1.0)
    for way in margins.WAYS:
        run = Run(margins.loop_of(one, way), short.metrics, 1.0, h=one.period, seed=1)
        sweep = compile_sweep(computer_sweep(f"{one.key}_{way}", run, effects(one, way), starts(one), 3))
        samples.append(sweep.sample([sweep.chunk(0, sweep.size)]))
    return Results(samples=tuple(samples))


@pytest.mark.heavy
def test_an_error_is_stated_beside_the_step_of_its_reading(short):
    error, step, unit = findings.error_of(short, PID)
    assert (step, unit) == (2 * np.pi / 2**16, "rad")
    assert error == pytest.approx(
        max(short.sample("pid_double").score(ERROR, joint).value[:3].mean() for joint in (0, 1))
    )


@pytest.mark.heavy
def test_the_losses_of_a_shortened_run_are_ratios_of_its_own_samples(short):
    one = BY_NAME[PID]
    own = margins.losses(short, one)
    double, single = (short.sample(f"{one.key}_{way}") for way in ("double", "single"))

    def errors(sample, rows):
        return np.stack([sample.score(ERROR, joint).value[rows] for joint in (0, 1)], axis=1)

    start, last = slice(0, 3), slice(-3, None)
    ratio = (errors(single, start) / errors(double, start)).max(axis=1)
    assert own.single.value == pytest.approx(ratio.mean() - 1)
    ratio = (errors(single, last) / errors(double, start)).max(axis=1)
    assert own.together.value == pytest.approx(ratio.mean() - 1)
    assert 0 < abs(own.single.value) < 1e-2  # 24 bits of a law with a gain of 300 and an error of some mrad
    joints = [margins.losses(short, one, joint=joint).single.value for joint in (0, 1)]
    apart = (errors(single, start) / errors(double, start)).mean(axis=0) - 1
    np.testing.assert_allclose(joints, apart, rtol=1e-12)
    largest = margins.losses(short, one, over="largest").together.value
    assert largest == pytest.approx(ratio.max() - 1)


@pytest.mark.heavy
def test_missed_periods_change_the_error_the_more_the_more_they_are(short):
    missed = next(m for m in margins.margins(short, BY_NAME[PID]).each if m.effect.name == "missed periods")
    # for the better here: a torque that stays behind makes up for a lag of the law
    change = np.abs(missed.ratios - 1).max(axis=1)
    assert change[0] < 5e-3 < 2e-2 < change[-1]
