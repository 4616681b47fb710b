"""The study of handing laws over: its loops, scans and sentences from figures that are put in, and a shortened run."""

from dataclasses import replace

import numpy as np
import pytest

from studies.b4_handover import findings, machines, margins, operations, pages
from studies.b4_handover.loops import EKF, ERROR, LQG, PID, SETTLED, SMC, TV, TWISTING, handed, settled_rmse
from studies.b4_handover.margins import Loss, Losses, Scan, effects, growth, periods_of, starts
from workbench.handover.replays import TargetResult
from workbench.handover.targets import TARGETS
from workbench.handover.targets.contract import Figures
from workbench.metrics import measure
from workbench.simulate import simulate
from workbench.study import Results, Run
from workbench.study.compiled import compile_sweep
from workbench.study.evidence import Threshold
from workbench.study.evidence.computer_margins import computer_sweep

BY_NAME = {one.name: one for one in handed()}
EACH = pytest.mark.parametrize("one", handed(), ids=lambda one: one.key)


@EACH
def test_no_law_needs_what_no_instrument_gives(one):
    law = one.digital().law()
    assert not any("no instrument" in note for note in law.notes)
    assert law.delay
    assert set(law.limits) == set(law.commands.names)


@EACH
def test_every_loop_stays_near_what_is_wanted_in_its_computer(one):
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
    # a sum over the instants in place of the integral, of an error that changes with some rad/s
    values = [one.value[0] for one in found.scores_of(ERROR)]
    np.testing.assert_allclose(values, np.sqrt((run["e"][0, late] ** 2).mean(axis=0)), rtol=5e-3)


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
    assert [effect.name for effect in effects(one, "single")] == ["jitter", "missed periods"]
    assert all(len(effect.levels) == 1 for effect in effects(one, "single"))
    declared = {effect.name: effect.declared for effect in effects(one, "double")}
    assert declared["jitter"] == 0.05 * one.period
    assert declared["missed periods"] == 1e-3


# A scan, and a loss


def test_a_scan_ends_where_error_or_variation_first_grows_too_much():
    one = BY_NAME[PID]
    found = growth(periods_of(one.key), [one.period, 4 * one.period, 16 * one.period, 32 * one.period], {ERROR: 1.1})
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


# Sentences from figures


def all_of(value):
    return Losses(*[Loss(value, 0.0)] * 6)


@pytest.fixture
def figures(monkeypatch):
    """The losses and scans of all loops, to be changed."""
    held = {one.name: all_of(0.01) for one in handed()}
    found = {one.key: scan_of(one, [0.5, 2.0, 3.0], [1.0, 1.0, 2.0]) for one in handed()}
    monkeypatch.setattr(findings, "all_losses", lambda results: held)
    monkeypatch.setattr(findings, "sizes", lambda results, name: (1e-5, 1e-4, "rad"))
    for module in (findings, machines, pages):
        monkeypatch.setattr(module, "scans", lambda results: margins.Scans(found, found))
    return held, found


def test_the_end_names_the_law_that_loses_most(figures):
    held, _ = figures
    told = findings.loss_finding(Results())
    assert "6 of 6 loops keep their error within 10 %" in told.statement
    held[TWISTING] = replace(all_of(0.01), together=Loss(0.37, 0.01))
    told = findings.loss_finding(Results())
    assert "5 of 6 loops" in told.statement
    assert "most is lost by super-twisting, 37 %" in told.statement
    held[PID] = replace(all_of(0.01), together=Loss(np.inf, 0.0))
    told = findings.loss_finding(Results()).statement
    assert "4 of 6 loops" in told
    assert "most is lost by PID, a whole run." in told


def test_precision_is_told_by_the_law_it_changes_most(figures):
    held, _ = figures
    held[SMC] = replace(all_of(0.01), single=Loss(-0.2, 0.01))
    held[PID] = replace(all_of(0.01), readings=Loss(0.5, 0.01))
    told = findings.precision_finding(Results()).statement
    assert "most for SMC, by \N{MINUS SIGN}20 %" in told
    assert "most for PID, by 50 %" in told


def test_a_declared_period_that_is_too_long_fails(figures):
    _, found = figures
    assert findings.period_finding(Results()).kind == "holds"
    found[BY_NAME[LQG].key] = scan_of(BY_NAME[LQG], [0.5, 0.8], [1.0, 1.3])
    told = findings.period_finding(Results())
    assert told.kind == "fails"
    assert "longer than sampling allows for LQG." in told.statement
    assert "Least room: LQG, 0.50 times its own." in told.evidence


# The machines


M4F = TARGETS["cortex-m4f"].name


def replays(**changes):
    """Each law on two targets with equal bits, of which one result is changed."""
    fine = {"periods": 10, "bits": 640}
    here = TargetResult("gcc -O0", **fine, figures=Figures(900.0, stack=300, code=10, data=0))
    there = replace(here, target=M4F, **changes)
    return {one.name: (here, there if one.name == PID else replace(here, target=M4F)) for one in handed()}


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        ({}, "holds", "All 6 laws have the bits of the portable arithmetic on all 2 targets that ran."),
        ({"differing": 3, "first": "period 4"}, "fails", "11 of 12 replays have the bits"),
        ({"memories": 1, "first": "period 4"}, "fails", "11 of 12 replays have the bits"),
        ({"reason": "install it"}, "holds", "on all 2 targets that ran"),
    ],
)
def test_the_bits_are_told_as_they_are(monkeypatch, changes, kind, words):
    monkeypatch.setattr(machines, "replays", lambda results: replays(**changes))
    told = machines.bits_finding(Results())
    assert told.kind == kind
    assert words in told.statement


def test_a_target_that_is_not_installed_is_named(monkeypatch):
    absent = TargetResult("gcc -O0", reason="install gcc with `apt-get install gcc`")
    rows = {one.name: (absent,) for one in handed()}
    monkeypatch.setattr(machines, "replays", lambda results: rows)
    told = machines.bits_finding(Results())
    assert told.kind == "open"
    assert "Not run: gcc -O0." in told.evidence
    assert machines.bits_table(Results()).rows == (("gcc -O0", None, None, None, None, None, "not run"),)


def test_a_count_is_held_against_the_longest_period_at_a_stated_clock(monkeypatch, figures):
    monkeypatch.setattr(machines, "replays", lambda results: replays(figures=Figures(168e6 * 2e-3 * 2, stack=4000)))
    fit = machines.fit_of(Results(), BY_NAME[PID], "cortex-m4f")
    assert fit.period == 2e-3  # the longest of the scan that is put in
    assert fit.share == pytest.approx(2.0)
    assert not fit.fits


def test_operands_reach_the_roundings_that_are_hard():
    a, b = operations.operands().T
    apart = np.frexp(a)[1] - np.frexp(b)[1]
    two = np.frexp(np.abs(a))[0] == 0.5
    assert (np.bincount(apart[two & (apart > 0)], minlength=60)[1:60] > 100).all()
    assert not two[1::2].any()


def test_operations_that_round_otherwise_are_told():
    good, bad = TargetResult("one", bits=5), TargetResult("two", bits=5, differing=7, first="period 3")
    assert operations.operations_finding(Results(works={"operations": (good,)})).kind == "holds"
    told = operations.operations_finding(Results(works={"operations": (good, bad)}))
    assert told.kind == "fails"
    assert "of two are not those of IEEE 754" in told.statement
    assert "7 bits" in told.evidence


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


def test_an_error_is_told_beside_the_step_of_its_reading(short):
    error, step, unit = findings.sizes(short, PID)
    assert (step, unit) == (2 * np.pi / 2**16, "rad")
    assert error == pytest.approx(
        max(short.sample("pid_double").score(ERROR, joint).value[:3].mean() for joint in (0, 1))
    )


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


def test_missed_periods_change_the_error_the_more_the_more_they_are(short):
    missed = next(m for m in margins.margins(short, BY_NAME[PID]).each if m.effect.name == "missed periods")
    # for the better here: a torque that stays behind makes up for a lag of the law
    change = np.abs(missed.ratios - 1).max(axis=1)
    assert change[0] < 5e-3 < 2e-2 < change[-1]
