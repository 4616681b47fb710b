"""The margins of the six loops: sweeps over what computers do, and scans over the period and the delay."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from studies.b4_handover.loops import ERROR, SEED, TV, Handed, by_key, handed
from workbench.core import Sampled
from workbench.handover.single.single_precision_loop import in_single_precision
from workbench.loop import DigitalLoop
from workbench.metrics import AbstractMetric, total_variation
from workbench.study import Factor, Results, Run, Sweep, Uniform, Work
from workbench.study.evidence import LargestSetting, LoopLimits, Threshold, largest_setting
from workbench.study.evidence.computer_margins import (
    KEPT,
    ComputerEffect,
    ComputerMargins,
    computer_effects,
    computer_margins,
    computer_sweep,
    worst_ratio,
)
from workbench.validation.refusals import Array

DRAWS = 16
JITTER, MISSED = 0.05, 1e-3  # declared: the largest delay in parts of the period, and the share of missed periods
QUIET = 2.0  # times the total variation with the shortest period, at most, as in a9
SHORTEST, RATIO, LONGEST = 1 / 4, 1.25, 40.0  # of the declared period: the scan over periods
MOST_LATE = 40  # periods
SUBSTEP = 2.5e-3  # s, at most, as in a9
NEAR = 0.01  # rad or m: starts differ by so much either way
WAYS = ("double", "single", "exact")  # the computers that are swept


def loop_of(one: Handed, way: str) -> Sampled:
    """A loop with a computer that may be late: as declared, in single precision, or with exact readings."""
    if way == "single":
        plain = one.digital()
        return in_single_precision(plain, plain.law()).disturbed()
    return one.digital(exact=way == "exact").disturbed()


def effects(one: Handed, way: str) -> tuple[ComputerEffect, ...]:
    """All effects with all levels in double precision, and those of the clock at their declared levels elsewhere."""
    own = effects_of(one)
    if way == "double":
        return own
    return tuple(replace(effect, levels=(effect.declared,)) for effect in own if effect.declared != effect.least)


@cache
def effects_of(one: Handed) -> tuple[ComputerEffect, ...]:
    """The effects on a loop."""
    return computer_effects(one.digital().disturbed(), JITTER * one.period, MISSED)


def starts(one: Handed) -> tuple[Factor, ...]:
    """The initial positions, near those of the loop."""
    states = one.made(one.period).plant.states
    port = states.entries[0]  # of an arm q, of a cart x
    near = [(label, value) for label, value in zip(port.labels(), np.ravel(port.default), strict=True)]
    spread = ((label, Uniform(value - NEAR, value + NEAR)) for label, value in near)
    return tuple(Factor(label, (f"plant.{label}",), values) for label, values in spread)


def sweeps() -> tuple[Sweep, ...]:
    """Each loop under each computer, with the same starts."""
    made = []
    for one in handed():
        for way in WAYS:
            run = Run(loop_of(one, way), one.metrics, one.until, h=one.period, seed=SEED)
            own = effects(one, way)
            made.append(computer_sweep(f"{one.key}_{way}", run, own, starts(one), DRAWS))
    return tuple(made)


def margins(results: Results, one: Handed, way: str = "double", metric: str = ERROR) -> ComputerMargins:
    """The margins of a loop, by the samples of its sweeps."""
    return computer_margins(results.sample(f"{one.key}_{way}"), effects(one, way), metric)


@dataclass(frozen=True)
class Loss:
    """The mean growth over the draws, in parts, with twice its standard error; infinite if a run was lost."""

    value: float
    error: float

    @staticmethod
    def of(values: Array, base: Array) -> Loss:
        """Of (draws, numbers) over those of the same draws without it, the worst of the numbers in each."""
        ratios = worst_ratio(values, base)
        if np.isinf(ratios).any():
            return Loss(np.inf, 0.0)
        return Loss(float(ratios.mean() - 1), float(2 * ratios.std(ddof=1) / np.sqrt(ratios.size)))


@dataclass(frozen=True)
class Losses:
    """Of the error of a loop: from exact readings to those of the instruments, and from there by single precision, by
    jitter, by missed periods, and by these three together; `noisier` is that of the commands' total variation, by the
    three.
    """

    readings: Loss
    single: Loss
    jitter: Loss
    missed: Loss
    together: Loss
    noisier: Loss


def losses(results: Results, one: Handed) -> Losses:
    """The losses of a loop at what is declared."""
    double, single, exact = (margins(results, one, way) for way in WAYS)
    clock = {each.effect.name: each.values[each.effect.levels.index(each.effect.declared)] for each in double.each[1:]}
    busy = [margins(results, one, way, TV) for way in ("double", "single")]
    return Losses(
        Loss.of(double.without, exact.without),
        Loss.of(single.without, double.without),
        Loss.of(clock["jitter"], double.without),
        Loss.of(clock["missed periods"], double.without),
        Loss.of(single.declared, double.without),
        Loss.of(busy[1].declared, busy[0].without),
    )


@dataclass(frozen=True, eq=False)
class Scan:
    """A search over periods in s or delays in periods, and the ratios of error and total variation (N,) to those of
    the first.
    """

    threshold: Threshold
    error: Array
    TV: Array | None = None  # where it has a limit

    @staticmethod
    def of(found: LargestSetting) -> Scan:
        """The scan of a search."""
        busy = QUIET * found.worst(TV) if TV in found.trials[0][0].shares else None
        return Scan(found.threshold, KEPT * found.worst(ERROR), busy)


@dataclass(frozen=True, eq=False)
class Scans:
    """The scan of each loop by its key, over the period with exact readings, and over the delay with its own."""

    periods: dict[str, Scan]
    delays: dict[str, Scan]


def scans(results: Results) -> Scans:
    """All scans."""
    periods, delays = (map(Scan.of, results.work(name)) for name in ("periods", "delays"))
    keys = [one.key for one in handed()]
    return Scans(dict(zip(keys, periods, strict=True)), dict(zip(keys, delays, strict=True)))


def scan_works() -> tuple[Work, Work]:
    """The scans of all loops."""
    keys = tuple(one.key for one in handed())
    return Work("periods", over_periods, keys, seconds=8.0), Work("delays", over_delays, keys, seconds=8.0)


def over_periods(key: str) -> LargestSetting:
    """Longer and longer periods, from a quarter of the declared one on; commands are a period late in each."""
    one = by_key(key)
    count = int(np.log(LONGEST / SHORTEST) / np.log(RATIO))
    periods = [one.period * SHORTEST * RATIO**i for i in range(count + 1)]
    return growth(periods_of(key), periods, {ERROR: KEPT, TV: QUIET})


def periods_of(key: str) -> LoopLimits:
    """The runs of a loop with other periods."""
    limits = {ERROR: 1.0, TV: 1.0}  # until those of the first run are known
    return LoopLimits(partial(with_period, key), partial(metrics_of, key), limits, by_key(key).until, SUBSTEP, SEED)


def over_delays(key: str) -> LargestSetting:
    """More and more periods between reading and command, from one on; the period is the declared one."""
    one = by_key(key)
    late = [float(count) for count in range(1, MOST_LATE + 1)]
    looked_at = LoopLimits(partial(with_delay, key), lambda _: one.metrics, {ERROR: 1.0}, one.until, SUBSTEP, SEED)
    return growth(looked_at, late, {ERROR: KEPT})


def growth(looked_at: LoopLimits, settings: list[float], most: dict[str, float]) -> LargestSetting:
    """From the first setting on until two in a row have a metric more than `most` times as large as the first."""
    first = looked_at.at(settings[0]).shares
    limits = {metric: times * first[metric] for metric, times in most.items()}
    return largest_setting(replace(looked_at, limits=limits), settings, ratio=None, patience=2)


def with_period(key: str, period: float) -> DigitalLoop:
    """A loop with exact readings and another period."""
    return by_key(key).computed(period, exact=True)


def with_delay(key: str, delay: float) -> DigitalLoop:
    """A loop with another delay, in periods."""
    return by_key(key).computed(delay=delay)


def metrics_of(key: str, period: float) -> tuple[AbstractMetric, ...]:
    """The error of a loop, and the total variation of its commands at the instants of a period."""
    return by_key(key).metrics[0], total_variation(period)
