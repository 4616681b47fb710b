"""The margins of the six loops: sweeps over what computers do, and scans over the period and the delay."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from studies.b4_handover.loops import ERROR, SEED, TV, Handed, handed
from workbench.core import Sampled
from workbench.handover.single.single_precision_loop import in_single_precision
from workbench.metrics import measured, total_variation
from workbench.metrics.accumulators import final_values
from workbench.simulate import simulate
from workbench.study import Factor, Results, Run, Sweep, Uniform
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
    """Ratios of the error and of the total variation (N,) over periods in s or delays in periods (N,)."""

    at: Array
    error: Array
    TV: Array
    quiet: float = np.inf

    @property
    def good(self) -> Array:
        """True where the error is kept and the commands are quiet."""
        return np.asarray((self.error <= KEPT) & (np.asarray(self.TV) <= self.quiet))

    @property
    def largest(self) -> float:
        """The largest value up to which all are good."""
        return float(self.at[: int(np.argmin(self.good)) or len(self.at)][-1])

    @property
    def next(self) -> float:
        """The first value that is not good, infinite where none was tried."""
        return float(self.at[int(np.argmin(self.good))]) if not self.good.all() else np.inf


def ends(one: Handed, period: float, delay: int, *, exact: bool) -> tuple[Array, Array]:
    """Error and total variation with another period and delay, to about the same horizon; infinite if lost."""
    until = period * round(one.until / period)
    sampled = one.digital(period, delay, exact=exact)
    asked = (one.metrics[0], total_variation(period))
    step = measured(sampled, asked, period / int(np.ceil(period / SUBSTEP - 1e-9)))
    values = final_values(simulate(step, until=until, every=until, seed=SEED), asked)
    return tuple(np.where(np.isnan(values[name][0]), np.inf, values[name][0]) for name in (ERROR, TV))


def scan(one: Handed, points: Sequence[tuple[float, int]], at: Sequence[float], quiet: float, *, exact: bool) -> Scan:
    """From the first point on until two in a row are no longer good."""
    base, rows = ends(one, *points[0], exact=exact), []
    for period, delay in points:
        here = ends(one, period, delay, exact=exact)
        rows.append([float(worst_ratio(now, then)) for now, then in zip(here, base, strict=True)])
        if all(error > KEPT or busy > quiet for error, busy in rows[-2:]) and len(rows) > 2:
            break
    error, busy = np.array(rows).T
    return Scan(np.array(at[: len(rows)]), error, busy, quiet)


@dataclass(frozen=True, eq=False)
class Scans:
    """Of each loop by its key, over the period with exact readings, and over the delay with its own."""

    periods: dict[str, Scan]
    delays: dict[str, Scan]


@cache
def scans() -> Scans:
    """All scans, two loops at a time."""
    with ThreadPoolExecutor(2) as pool:
        periods = pool.map(over_periods, handed())
        delays = pool.map(over_delays, handed())
        keys = [one.key for one in handed()]
        return Scans(dict(zip(keys, periods, strict=True)), dict(zip(keys, delays, strict=True)))


def over_periods(one: Handed) -> Scan:
    """Longer and longer periods, from a quarter of the declared one on; commands are a period late in each."""
    count = int(np.log(LONGEST / SHORTEST) / np.log(RATIO))
    periods = [one.period * SHORTEST * RATIO**i for i in range(count + 1)]
    return scan(one, [(period, 1) for period in periods], periods, QUIET, exact=True)


def over_delays(one: Handed) -> Scan:
    """More and more periods between reading and command, from one on; the period is the declared one."""
    late = range(1, MOST_LATE + 1)
    return scan(one, [(one.period, count) for count in late], list(map(float, late)), np.inf, exact=False)
