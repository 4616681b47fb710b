"""Margins of a loop for its computer: the largest level of each effect, and the error that a declared level adds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core import SampledSystem
from workbench.core.validation.refusals import Array, known_name, refusal, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.study.document.phrases_and_tables import Cell, ReportTable, TableColumn
from workbench.study.document.source import Source
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.sample import Sample
from workbench.study.uncertainty.designs import ListedPoints, MonteCarlo

KEEPS_RATIO, STANDS_RATIO = 1.1, 2.0  # times the metric without the effect: kept, and still standing
MOST_QUANTUM = 64.0  # times the declared steps of the readings
MOST_MISSED = 0.5
LEVELS = (1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 1.0)  # of the largest value of an effect


@dataclass(frozen=True)
@check_arguments
class ComputerEffect:
    """An effect of a computer, such as jitter, at rising `levels`; at the level `least` a loop has none of it.

    `paths` name the numbers of the loop that it sets, in `unit`. The growth of the error is computed at the level
    `declared_level`. With `share`, levels are multiples of the loop's numbers.

    Raises
    ------
    ValueError
        If the levels do not rise from above `least`, or `declared_level` is neither one of them nor `least`.

    Examples
    --------
    >>> wb.evidence.ComputerEffect("jitter", ("computer.jitter",), (1e-3, 2e-3), 1e-3, "s").levels
    (0.001, 0.002)
    """

    name: str
    paths: tuple[str, ...]
    levels: tuple[float, ...]
    declared_level: float
    unit: str = ""
    least: float = 0.0
    share: bool = False

    def __post_init__(self) -> None:
        rises = bool(self.levels) and bool((np.diff((self.least, *self.levels)) > 0).all())
        if not rises or self.declared_level not in (self.least, *self.levels):
            raise refusal(
                f"ComputerEffect({self.name!r}, levels=...)",
                "levels that rise from `least`, with the declared one among them",
                (self.least, self.levels, self.declared_level),
            )

    @property
    def factor(self) -> Factor:
        """The effect as a number that a sweep varies."""
        return Factor(self.name, self.paths, Uniform(self.least, self.levels[-1]), share=self.share)

    @check_arguments
    def coordinate(self, level: float) -> float:
        """The coordinate of a level in the unit cube."""
        return (level - self.least) / (self.levels[-1] - self.least)


@check_arguments
def computer_effects(sampled_loop: SampledSystem, jitter: float, missed_share: float) -> tuple[ComputerEffect, ...]:
    """Coarser readings, jitter and missed periods of a loop that `SampledSystem.with_timing_faults` gave.

    Readings are at least as coarse as declared; those without a quantum stay exact. Jitter goes to half of the period.

    Parameters
    ----------
    jitter
        The declared largest delay of an instant, in s.
    missed_share
        The declared share of missed periods.

    Raises
    ------
    LookupError
        If the loop was not made by `SampledSystem.with_timing_faults`.
    ValueError
        If `jitter` is beyond half of the period, or `missed_share` beyond half of all periods.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)
    >>> sampled = loop.with_timing_faults()
    >>> effects = wb.evidence.computer_effects(sampled, jitter=1e-3, missed_share=0.1)
    >>> [effect.name for effect in effects]
    ['jitter', 'missed periods']
    """
    rows = sampled_loop.parameters
    known_name("computer.jitter", rows.names, "parameters of the loop")
    coarse = tuple(name for name in rows.names if name.endswith(".quantum") and rows[name].default.all())
    ladders = (
        ("jitter", "computer.jitter", sampled_loop.period / 2, jitter, "s"),
        ("missed periods", "computer.missed", MOST_MISSED, missed_share, "1"),
    )
    effects = tuple(
        ComputerEffect(name, (path,), tuple(sorted({declared, *(most * level for level in LEVELS)})), declared, unit)
        for name, path, most, declared, unit in ladders
    )
    shares = tuple(MOST_QUANTUM * level for level in LEVELS[1:])
    own = ComputerEffect("coarser readings", coarse, shares, 1.0, "times", 1.0, share=True)
    return (own, *effects) if coarse else effects


@check_arguments
def computer_sweep(
    name: str, run: Run, effects: Sequence[ComputerEffect], starts: Sequence[Factor] = (), draws: int = 8
) -> Sweep:
    """A sweep without effects, with each level of each effect alone, and with all effects at their declared levels.

    Parameters
    ----------
    run
        A run of a loop made by `SampledSystem.with_timing_faults`, with a metric; its seed is that of the starts, too.
    starts
        Factors that differ from draw to draw; draw k has the same values in all kinds of runs.
    draws
        The number of runs of each kind; each run has its own noise.

    Raises
    ------
    ValueError
        If there is no effect, or no draw.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=20.0)
    >>> loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)).digital(0.01)
    >>> sampled = loop.with_timing_faults()
    >>> effects = wb.evidence.computer_effects(sampled, jitter=1e-3, missed_share=0.1)
    >>> run = wb.Run(sampled, (wb.rmse(),), until=1.0)
    >>> wb.evidence.computer_sweep("motor", run, effects, draws=2).name
    'motor'
    """
    whole("computer_sweep(draws=...)", draws)
    if not effects:
        raise refusal("computer_sweep(effects=...)", "at least one effect", tuple(effects))
    kinds = [np.zeros(len(effects))]
    for i, effect in enumerate(effects):
        for level in effect.levels:
            kinds.append(np.zeros(len(effects)))
            kinds[-1][i] = effect.coordinate(level)
    kinds.append(np.array([effect.coordinate(effect.declared_level) for effect in effects]))
    points = np.repeat(kinds, draws, axis=0)
    if starts:
        drawn = MonteCarlo(len(starts), draws, run.seed).points()
        points = np.hstack([points, np.tile(drawn, (len(kinds), 1))])
    factors = (*(effect.factor for effect in effects), *starts)
    return Sweep(name, replace(run, every=None), factors, ListedPoints(points))


@dataclass(frozen=True, eq=False)
@check_arguments
class ComputerMargin:
    """A metric under an effect: `values` (levels, draws, numbers), infinite where a run diverged.

    `ratios` (levels, draws) are the values divided by those without the effect: the worst of the metric's numbers.
    """

    effect: ComputerEffect
    values: Array
    ratios: Array

    @check_arguments
    def largest(self, most: float) -> float:
        """The largest level up to which no run has more than `most` times the metric; the least one if none has."""
        good = np.asarray((self.ratios <= most).all(axis=1))
        count = good.size if good.all() else int(np.argmin(good))
        return (self.effect.least, *self.effect.levels)[count]

    @check_arguments
    def is_unbounded(self, most: float) -> bool:
        """True if the metric grows at most by the factor `most` at every level, in every run."""
        return bool((self.ratios <= most).all())

    @property
    def loss(self) -> float:
        """The mean ratio at the declared level, less 1."""
        if self.effect.declared_level == self.effect.least:
            return 0.0
        return float(self.ratios[self.effect.levels.index(self.effect.declared_level)].mean() - 1)


@dataclass(frozen=True, eq=False)
@check_arguments
class ComputerMargins:
    """The margins of a loop by a metric, for `each` effect, and its values (draws, numbers) without effects.

    `declared_values` have all declared effects. `sources` are the sample with each number of the metric.
    """

    each: tuple[ComputerMargin, ...]
    without: Array
    declared_values: Array  # infinite where a run diverged
    sources: tuple[Source, ...] = ()


@check_arguments
def computer_margins(sample: Sample, effects: Sequence[ComputerEffect], metric: str) -> ComputerMargins:
    """The margins of a loop for each effect by a metric.

    Parameters
    ----------
    sample
        The sample of a sweep that `computer_sweep` made of the same effects.

    Raises
    ------
    LookupError
        If the sample has no such metric.
    ValueError
        If the sample is of other effects.
    """
    names = tuple(effect.name for effect in effects)
    kinds = 2 + sum(len(effect.levels) for effect in effects)
    draws, rest = divmod(len(sample), kinds)
    if rest or not draws or sample.factors[: len(names)] != names:
        raise ValueError(
            f"`computer_margins(sample, effects)` needs the sample of `computer_sweep` for the effects "
            f"{', '.join(names)}; got '{sample.name}' of {', '.join(sample.factors)}."
        )
    numbers = [one.number for one in sample.measurement.columns if one.metric == metric] or [0]
    values = np.stack([sample.score(metric, number).value for number in numbers], axis=-1)
    values = np.where(np.isnan(values), np.inf, values).reshape(kinds, draws, len(numbers))
    ratios, margins, first = worst_ratio(values, values[0]), [], 1
    for effect in effects:
        own = slice(first, first + len(effect.levels))
        margins.append(ComputerMargin(effect, values[own], ratios[own]))
        first = own.stop
    sources = tuple(sample.source(metric, number) for number in numbers)
    return ComputerMargins(tuple(margins), values[0], values[-1], sources)


@check_arguments
def worst_ratio(values: Array, base: Array) -> Array:
    """The largest ratio over the numbers of a metric, the last axis: infinite where a run diverged, 1 for 0 over 0.

    Examples
    --------
    >>> wb.evidence.worst_ratio(np.array([[2.0, 3.0]]), np.array([[1.0, 2.0]]))
    array([2.])
    """
    if not values.size or not base.ndim or base.shape != values.shape[-base.ndim :]:
        raise refusal("worst_ratio(base=...)", "of the shape of the last axes of the values", base.shape)
    with np.errstate(all="ignore"):
        ratios = np.where((values == 0) & (base == 0), 1.0, values / base)
    return np.asarray(np.max(np.where(np.isnan(ratios), np.inf, ratios), axis=-1))


@check_arguments
def computer_table(name: str, caption: str, margins: Sequence[tuple[str, ComputerMargins]]) -> ReportTable:
    """A table of the margins of several loops by name, with a row for each loop and effect, and a note per loop."""
    rows: list[tuple[Cell, ...]] = []
    for loop, own in margins:
        for one in own.each:
            effect, ends = one.effect, (_end(one, most) for most in (KEEPS_RATIO, STANDS_RATIO))
            loss: Cell = 100 * one.loss if np.isfinite(one.loss) else "lost"
            shown: tuple[Cell, Cell] = (_level(effect, effect.declared_level), loss)
            declared = shown if effect.declared_level > effect.least else (None, None)
            rows.append((loop, effect.name, *declared, *ends))
    columns = (
        TableColumn("loop"),
        TableColumn("effect"),
        TableColumn("declared", align="right"),
        TableColumn("mean growth", "%", "right", digits=2),
        *(TableColumn(f"error within {most:g} times up to") for most in (KEEPS_RATIO, STANDS_RATIO)),
    )
    said = {loop: "; ".join(dict.fromkeys(note for one in own.sources for note in one.notes)) for loop, own in margins}
    notes = tuple(f"{loop}: {note}." for loop, note in said.items() if note)
    return ReportTable(name, caption, columns, tuple(rows), notes)


def _level(effect: ComputerEffect, level: float) -> str:
    if effect.unit == "s":
        return f"{1e3 * level:.3g} ms" if level >= 1e-3 else f"{1e6 * level:.3g} µs"
    return f"{100 * level:.3g} %" if effect.unit == "1" else f"{level:g} {effect.unit}".strip()


def _end(one: ComputerMargin, most: float) -> str:
    """The largest level within the limit, with a sign if all levels are; or 'less than' the smallest level tried."""
    level = one.largest(most)
    if level == one.effect.least:
        return f"less than {_level(one.effect, one.effect.levels[0])}"
    return ("\N{GREATER-THAN OR EQUAL TO} " if one.is_unbounded(most) else "") + _level(one.effect, level)
