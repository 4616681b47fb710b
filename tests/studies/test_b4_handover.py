"""The study of handing laws over: its loops, its scans and losses, and a shortened run."""

from dataclasses import replace

import numpy as np
import pytest

from studies.b4_handover import findings, margins
from studies.b4_handover.loops import (
    EKF,
    ERROR,
    FAR_START,
    LQG,
    NEAR_START,
    PID,
    SIZE,
    SMC,
    TRANSIENT_SHARE,
    TV,
    handover_loops,
    settled_rmse,
    settled_size,
)
from studies.b4_handover.margins import Loss, Scan, effects, growth, periods_of, searches, starts
from tests.support.handed_loops import BY_NAME
from workbench.engine import simulate
from workbench.engine.metrics import measure
from workbench.study import Results, Run
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.evidence.computer_margins import computer_sweep

EACH = pytest.mark.parametrize("one", handover_loops(), ids=lambda one: one.key)


@EACH
def test_no_law_needs_what_no_instrument_gives(one):
    law = one.digital().law()
    assert not any("no instrument" in note for note in law.notes)
    assert law.delay
    assert set(law.limits) == set(law.commands.names)


@pytest.mark.parametrize(
    "one",
    [
        pytest.param(one, marks=[pytest.mark.heavy] * (one.name not in (PID, SMC)), id=one.key)
        for one in handover_loops()
    ],
)
def test_every_loop_stays_near_its_reference_in_its_computer(one):
    found = measure(one.digital(), one.metrics, until=one.until, every=one.until, h=one.period)
    error, busy = (np.array([each.pair[0] for each in found.scores if each.metric == name]) for name in (ERROR, TV))
    size = {LQG: 0.5, EKF: 0.2}.get(one.name, 0.5)
    assert error.max() < size / 2
    assert np.isfinite(busy).all()


@pytest.mark.heavy
def test_the_error_after_the_approach_is_the_root_of_the_mean_square_from_there_on():
    one = BY_NAME[PID]
    sampled, until = one.digital(), 2.0
    found = measure(sampled, [settled_rmse("q", TRANSIENT_SHARE * until)], until=until, h=one.period / 2)
    run = simulate(sampled.step(2), until=until)
    late = run.t > TRANSIENT_SHARE * until
    sizes = measure(sampled, [settled_size("q", TRANSIENT_SHARE * until)], until=until, h=one.period / 2).scores_of(
        SIZE
    )
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
    declared = {effect.name: effect.declared_level for effect in effects(one, "double")}
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
    assert (scan.error[: sum(found.threshold.meets_criterion)] <= 1.1).all()


def test_a_loss_is_the_mean_of_the_worst_ratio_of_each_draw():
    base = np.array([[1.0, 2.0], [2.0, 2.0], [1.0, 1.0]])
    values = np.array([[1.1, 2.0], [2.0, 2.6], [1.2, 1.0]])
    loss = Loss.of(values, base)
    assert loss.value == pytest.approx(0.2)
    assert loss.error == pytest.approx(2 * 0.1 / np.sqrt(3))
    assert np.isinf(Loss.of(np.array([[np.inf, 1.0], [1.0, 1.0], [1.0, 1.0]]), base).value)


@pytest.mark.parametrize("start", [NEAR_START, pytest.param(FAR_START, marks=pytest.mark.heavy)])
def test_a_search_is_about_the_loop_that_is_handed_over(start):
    for search in searches():
        one, path = BY_NAME[search.law], findings.PATHS[start]
        if search.start == path:
            loops = search.loop.ode(), one.computer_loop(start=start).loop.ode()
            assert len({ode.fingerprint for ode in loops}) == 1
            np.testing.assert_array_equal(loops[0].states.default, loops[1].states.default)
            np.testing.assert_array_equal(loops[0].parameters.default, loops[1].parameters.default)


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
