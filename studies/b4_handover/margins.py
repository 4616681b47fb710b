"""The margins of the six loops: sweeps over the effects of computers from two starts, and scans over the delay."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

import workbench as wb
from studies.b4_handover.loops import (
    CARD,
    EKF,
    ERROR,
    FAR_START,
    LQG,
    NEAR_START,
    PID,
    SEED,
    SMC,
    TV,
    TWISTING,
    HandoverLoop,
    by_key,
    handover_loops,
)
from studies.paper.card import PROPOSED_LAW
from studies.paper.quiet_periods import (
    ACTING_TORQUE,
    MOMENTUM,
    QUIET,
    TRUTH,
    QuietPeriod,
    QuietSearch,
    paper_searches,
    quiet_period,
)

DRAWS = 16
JITTER, MISSED_SHARE = 0.05, 1e-3  # declared: the largest delay in parts of the period, and the share of missed periods
SHORTEST, RATIO, LONGEST = 1 / 4, 1.25, 40.0  # of the declared period: the scan over periods
MOST_LATE = 40  # periods
SUBSTEP = 2.5e-3  # s, at most, as in a9
DIGITAL_DESIGNS = (LQG, EKF)  # for their period, and so without a loop in continuous time
NEAR = 0.01  # rad or m: starts differ by so much either way
WAYS = ("double", "single", "exact")  # the computers that are swept
BOTH = (NEAR_START, FAR_START)
MEAN = "mean"
OVER_DRAWS: Mapping[str, Callable[[wb.Array], float]] = {MEAN: np.mean, "median": np.median, "largest": np.max}


def loop_of(one: HandoverLoop, way: str, start: str = NEAR_START) -> wb.SampledSystem:
    """A loop with a computer that may be late: as declared, in single precision, or with exact readings."""
    plain = punctual(one, way == "exact", start)
    if way == "single":
        return wb.handover.in_single_precision(plain, plain.law()).with_timing_faults()
    return plain.with_timing_faults()


@cache
def punctual(one: HandoverLoop, exact: bool, start: str) -> wb.SampledSystem:
    """A loop with a computer that is never late, written down once for all that may be late."""
    return one.digital(exact=exact, start=start)


def effects(one: HandoverLoop, way: str) -> tuple[wb.evidence.ComputerEffect, ...]:
    """All effects with all levels in double precision, and those of the clock at their declared levels elsewhere."""
    own = effects_of(one)
    if way == "double":
        return own
    return tuple(
        replace(effect, levels=(effect.declared_level,)) for effect in own if effect.declared_level != effect.least
    )


@cache
def effects_of(one: HandoverLoop) -> tuple[wb.evidence.ComputerEffect, ...]:
    """The effects on a loop."""
    return wb.evidence.computer_effects(loop_of(one, "double"), JITTER * one.period, MISSED_SHARE)


def starts(one: HandoverLoop, start: str = NEAR_START) -> tuple[wb.Factor, ...]:
    """The initial positions, near those of the loop from one of its two starts."""
    states = one.computer_loop(start=start).loop.plant.states
    port = states.entries[0]  # of an arm q, of a cart x
    near = [(label, value) for label, value in zip(port.labels(), np.ravel(port.default), strict=True)]
    spread = ((label, wb.Uniform(value - NEAR, value + NEAR)) for label, value in near)
    return tuple(wb.Factor(label, (f"plant.{label}",), values) for label, values in spread)


def sweeps() -> tuple[wb.Sweep, ...]:
    """Each loop under each computer from each of its two starts, with the same draws about it."""
    made = []
    for one in handover_loops():
        for start in BOTH:
            near = starts(one, start)
            for way in WAYS:
                run = wb.Run(loop_of(one, way, start), one.metrics, one.until, h=one.period, seed=SEED)
                made.append(
                    wb.evidence.computer_sweep(sample_name(one, way, start), run, effects(one, way), near, DRAWS)
                )
    return tuple(made)


def sample_name(one: HandoverLoop, way: str, start: str) -> str:
    """The name of the sweep of a loop under a computer from a start."""
    return f"{one.key}_{way}" if start == NEAR_START else f"{one.key}_{start}_{way}"


def margins(
    results: wb.Results, one: HandoverLoop, way: str = "double", metric: str = ERROR, start: str = NEAR_START
) -> wb.evidence.ComputerMargins:
    """The margins of a loop, by the samples of its sweeps."""
    return wb.evidence.computer_margins(results.sample(sample_name(one, way, start)), effects(one, way), metric)


@dataclass(frozen=True)
class Loss:
    """The growth of an error in parts of it, with twice its standard error; infinite if a run diverged."""

    value: float
    error: float

    @staticmethod
    def of(values: wb.Array, base: wb.Array, over: str = MEAN) -> Loss:
        """Of (draws, numbers) over those of the same draws without it, the worst of the numbers in each draw."""
        ratios = wb.evidence.worst_ratio(values, base)
        if np.isinf(ratios).any():
            return Loss(np.inf, 0.0)
        return Loss(float(OVER_DRAWS[over](ratios) - 1), float(2 * ratios.std(ddof=1) / np.sqrt(ratios.size)))


@dataclass(frozen=True)
class Losses:
    """The growths of the error of a loop, by what makes it grow.

    `readings`: exact readings become those of the instruments. `single`, `jitter`, `missed_periods`: from there on
    single precision, jitter, and missed periods. `together`: these three at once; `noisier` is the growth of the total
    variation of the commands by these three.
    """

    readings: Loss
    single: Loss
    jitter: Loss
    missed_periods: Loss
    together: Loss
    noisier: Loss


def losses(
    results: wb.Results,
    one: HandoverLoop,
    metric: str = ERROR,
    start: str = NEAR_START,
    joint: int | None = None,
    over: str = MEAN,
) -> Losses:
    """The losses of a loop at the declared effects: by a metric, from a start, of one joint or the worst joint."""
    double, single, exact = (margins(results, one, way, metric, start) for way in WAYS)
    clock = {
        each.effect.name: each.values[each.effect.levels.index(each.effect.declared_level)] for each in double.each[1:]
    }
    busy = [margins(results, one, way, TV, start) for way in ("double", "single")]

    def loss(values: wb.Array, base: wb.Array) -> Loss:
        kept = slice(None) if joint is None else slice(min(joint, values.shape[1] - 1), None)
        kept = kept if joint is None else slice(kept.start, kept.start + 1)
        return Loss.of(values[:, kept], base[:, kept], over)

    return Losses(
        loss(double.without, exact.without),
        loss(single.without, double.without),
        loss(clock["jitter"], double.without),
        loss(clock["missed periods"], double.without),
        loss(single.declared_values, double.without),
        Loss.of(busy[1].declared_values, busy[0].without, over),
    )


@dataclass(frozen=True, eq=False)
class Scan:
    """A search over periods in s or delays in periods, and the ratios of error and total variation (N,) to those of
    the first.
    """

    threshold: wb.evidence.Threshold
    error: wb.Array
    TV: wb.Array | None = None  # where it has a limit

    @staticmethod
    def of(search: wb.evidence.LargestSetting) -> Scan:
        """The scan of a search."""
        busy = QUIET * search.worst(TV) if TV in search.trials[0][0].shares else None
        return Scan(search.threshold, wb.evidence.KEEPS_RATIO * search.worst(ERROR), busy)


@dataclass(frozen=True, eq=False)
class Scans:
    """The scans over the period of the loops of `DIGITAL_DESIGNS`, by key and start; over the delay of all, by key."""

    periods: dict[tuple[str, str], Scan]
    delays: dict[str, Scan]


def scans(results: wb.Results) -> Scans:
    """All scans."""
    periods, delays = (map(Scan.of, results.work(name)) for name in ("periods", "delays"))
    keys = [one.key for one in handover_loops()]
    return Scans(dict(zip(digital_design_items(), periods, strict=True)), dict(zip(keys, delays, strict=True)))


def quiet_periods(results: wb.Results) -> dict[tuple[str, str], QuietPeriod]:
    """The longest quiet periods of the laws of the paper's arm, a period late, by their names and starts."""
    found = results.work("quiet")
    handed_over = (each for each in found if each.search.limit is None and each.search.counts_on == ACTING_TORQUE)
    return {(each.search.law, each.search.start): each for each in handed_over}


def searches() -> tuple[QuietSearch, ...]:
    """The searches of a9 that are about the laws that are handed over here, and these with a limited torque."""
    ours = {(PROPOSED_LAW, MOMENTUM), *((law, TRUTH) for law in (SMC, TWISTING, PID))}
    shared = [one for one in paper_searches() if one.scenario == "FS" and one.delay and (one.law, one.observer) in ours]
    most = float(CARD["limit of tau"])
    limited = [
        replace(one, limit=most) for one in shared if one.law in (PROPOSED_LAW, SMC) and one.counts_on == ACTING_TORQUE
    ]
    return (*shared, *limited)


def digital_design_items() -> tuple[tuple[str, str], ...]:
    """The loops whose law is designed for its period and has no continuous time, with their starts."""
    return tuple((one.key, start) for one in handover_loops() if one.name in DIGITAL_DESIGNS for start in BOTH)


def scan_works() -> tuple[wb.Work, ...]:
    """The searches over the period, and the scans over the period and the delay."""
    keys = tuple(one.key for one in handover_loops())
    return (
        wb.Work("quiet", quiet_period, searches(), seconds=10.0),
        wb.Work("periods", over_periods, digital_design_items(), seconds=8.0),
        wb.Work("delays", over_delays, keys, seconds=8.0),
    )


def over_periods(item: tuple[str, str]) -> wb.evidence.LargestSetting:
    """Longer and longer periods, from a quarter of the declared one on; commands are a period late in each."""
    one = by_key(item[0])
    count = int(np.log(LONGEST / SHORTEST) / np.log(RATIO))
    periods = [one.period * SHORTEST * RATIO**i for i in range(count + 1)]
    return growth(periods_of(*item), periods, {ERROR: wb.evidence.KEEPS_RATIO, TV: QUIET})


def periods_of(key: str, start: str = NEAR_START) -> wb.LoopLimits:
    """The runs of a loop with other periods."""
    limits = {ERROR: 1.0, TV: 1.0}  # until those of the first run are known
    loop = partial(with_period, key, start)
    return wb.LoopLimits(loop, partial(metrics_of, key), limits, by_key(key).until, SUBSTEP, SEED)


def over_delays(key: str) -> wb.evidence.LargestSetting:
    """More and more periods between reading and command, from one on; the period is the declared one."""
    one = by_key(key)
    late = [float(count) for count in range(1, MOST_LATE + 1)]
    looked_at = wb.LoopLimits(partial(with_delay, key), lambda _: one.metrics, {ERROR: 1.0}, one.until, SUBSTEP, SEED)
    return growth(looked_at, late, {ERROR: wb.evidence.KEEPS_RATIO})


def growth(looked_at: wb.LoopLimits, settings: list[float], most: dict[str, float]) -> wb.evidence.LargestSetting:
    """From the first setting on until two in a row have a metric more than `most` times as large as the first."""
    first = looked_at.at(settings[0]).shares
    limits = {metric: times * first[metric] for metric, times in most.items()}
    return wb.largest_setting(replace(looked_at, limits=limits), settings, ratio=None, patience=2)


def with_period(key: str, start: str, period: float) -> wb.DigitalLoop:
    """A loop with exact readings and another period."""
    return by_key(key).computer_loop(period, exact=True, start=start)


def with_delay(key: str, delay: float) -> wb.DigitalLoop:
    """A loop with another delay, in periods."""
    return by_key(key).computer_loop(delay=delay)


def metrics_of(key: str, period: float) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The settled error of a loop, and the total variation of its commands at the instants of a period."""
    return by_key(key).metrics[0], wb.total_variation(period)
