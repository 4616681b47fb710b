"""Margins of a loop for its computer: how far an effect may go by itself, and what a declared one costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core import Sampled
from workbench.study.contract import Run, Sweep
from workbench.study.document.phrases import Cell, Column, Table
from workbench.study.sample import Sample
from workbench.study.uncertainty.designs import Listed
from workbench.study.uncertainty.distributions import Uniform
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Array, known, refusal, whole
from workbench.validation.signatures import door

KEPT, STANDS = 1.1, 2.0  # times the metric without the effect: kept, and still standing
MOST_QUANTUM = 64.0  # times the declared steps of the readings
MOST_MISSED = 0.5
LEVELS = (1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 1.0)  # of the largest value of an effect


@dataclass(frozen=True)
@door
class ComputerEffect:
    """A thing that computers do, from `least`, where a loop has none of it, by `levels` to the last of them.

    `declared` is the level at which its cost is asked for; with `share`, levels are shares of the loop's own numbers.

    Raises
    ------
    ValueError
        If the levels do not rise from above `least`, or the declared one is none of them, nor the least.
    """

    name: str
    paths: tuple[str, ...]
    levels: tuple[float, ...]
    declared: float
    unit: str = ""
    least: float = 0.0
    share: bool = False

    def __post_init__(self) -> None:
        rises = bool(self.levels) and bool((np.diff((self.least, *self.levels)) > 0).all())
        if not rises or self.declared not in (self.least, *self.levels):
            raise refusal(
                f"ComputerEffect({self.name!r}, levels=...)",
                "levels that rise from `least`, with the declared one among them",
                (self.least, self.levels, self.declared),
            )

    @property
    def factor(self) -> Factor:
        """The effect as a number that a sweep varies."""
        return Factor(self.name, self.paths, Uniform(self.least, self.levels[-1]), share=self.share)

    def coordinate(self, level: float) -> float:
        """The coordinate of a level in the unit cube."""
        return (level - self.least) / (self.levels[-1] - self.least)


@door
def computer_effects(sampled: Sampled, jitter: float, missed: float) -> tuple[ComputerEffect, ...]:
    """Coarser readings, jitter and missed periods of a loop that `Sampled.disturbed` gave.

    Readings have the declared steps at the least, and those of no step stay exact; jitter goes to half of the period.

    Parameters
    ----------
    jitter
        The largest delay of an instant that is declared, in s.
    missed
        The share of missed periods that is declared.

    Raises
    ------
    LookupError
        If the loop is not disturbed.
    ValueError
        If a declared level is beyond half of the period, or of all periods.
    """
    half = sampled.period / 2
    rows = sampled.parameters
    known("computer.jitter", rows.names, "parameters of the loop")
    coarse = tuple(name for name in rows.names if name.endswith(".quantum") and rows[name].default.all())
    ladders = (
        ("jitter", "computer.jitter", half, jitter, "s"),
        ("missed periods", "computer.missed", MOST_MISSED, missed, "1"),
    )
    effects = tuple(
        ComputerEffect(name, (path,), tuple(sorted({declared, *(most * level for level in LEVELS)})), declared, unit)
        for name, path, most, declared, unit in ladders
    )
    shares = tuple(MOST_QUANTUM * level for level in LEVELS[1:])
    own = ComputerEffect("coarser readings", coarse, shares, 1.0, "times the declared steps", 1.0, share=True)
    return (own, *effects) if coarse else effects


@door
def computer_sweep(name: str, run: Run, effects: Sequence[ComputerEffect], draws: int = 8) -> Sweep:
    """Runs without effect, with each at each of its levels by itself, and with all at what is declared.

    Parameters
    ----------
    run
        Of a loop that `Sampled.disturbed` gave, with at least one metric.
    draws
        Runs of each kind, each with its own noise.

    Raises
    ------
    ValueError
        If there is no effect, or no draw.
    """
    whole("computer_sweep(draws=...)", draws)
    if not effects:
        raise refusal("computer_sweep(effects=...)", "at least one effect", tuple(effects))
    points = [np.zeros(len(effects))]
    for i, effect in enumerate(effects):
        for level in effect.levels:
            points.append(np.zeros(len(effects)))
            points[-1][i] = effect.coordinate(level)
    points.append(np.array([effect.coordinate(effect.declared) for effect in effects]))
    design = Listed(np.repeat(points, draws, axis=0))
    return Sweep(name, replace(run, every=None), tuple(effect.factor for effect in effects), design)


@dataclass(frozen=True, eq=False)
@door
class ComputerMargin:
    """What an effect does to a metric: `ratios` (levels, draws) are the worst over its numbers, over those without it.

    A run that diverged has an infinite ratio.
    """

    effect: ComputerEffect
    ratios: Array

    def largest(self, most: float) -> float:
        """The largest level up to which every run has at most `most` times the metric; the least if no level has."""
        good = np.asarray((self.ratios <= most).all(axis=1))
        count = good.size if good.all() else int(np.argmin(good))
        return (self.effect.least, *self.effect.levels)[count]

    def open_end(self, most: float) -> bool:
        """True if no level is beyond `most`."""
        return bool((self.ratios <= most).all())

    @property
    def loss(self) -> float:
        """The mean ratio at the declared level, less 1."""
        if self.effect.declared == self.effect.least:
            return 0.0
        return float(self.ratios[self.effect.levels.index(self.effect.declared)].mean() - 1)


@door
def computer_margins(
    sample: Sample, effects: Sequence[ComputerEffect], metric: str
) -> tuple[tuple[ComputerMargin, ...], Array]:
    """The margins of each effect by a metric, and the ratios (draws,) with all of them at what is declared.

    Parameters
    ----------
    sample
        Of a sweep that `computer_sweep` made of the same effects.

    Raises
    ------
    LookupError
        If the sample has no such metric.
    ValueError
        If the sample is of other effects.
    """
    kinds = 2 + sum(len(effect.levels) for effect in effects)
    draws, rest = divmod(len(sample), kinds)
    if rest or not draws or sample.factors != tuple(effect.name for effect in effects):
        raise ValueError(
            f"`computer_margins(sample, effects)` needs the sample of `computer_sweep` for the effects "
            f"{', '.join(effect.name for effect in effects)}; got '{sample.name}' of {', '.join(sample.factors)}."
        )
    numbers = [number for name, number, _ in sample.columns if name == metric] or [0]
    values = np.stack([sample.outputs(metric, number) for number in numbers], axis=-1)
    ends = values.reshape(kinds, draws, len(numbers))
    ratios = np.max(ends / ends[0].mean(axis=0), axis=-1)
    ratios = np.where(np.isnan(ratios), np.inf, ratios)
    margins, first = [], 1
    for effect in effects:
        margins.append(ComputerMargin(effect, ratios[first : first + len(effect.levels)]))
        first += len(effect.levels)
    return tuple(margins), ratios[-1]


@door
def computer_table(name: str, caption: str, margins: Sequence[tuple[str, Sequence[ComputerMargin]]]) -> Table:
    """The margins of several loops, a row for each loop and effect."""
    rows: list[tuple[Cell, ...]] = []
    for loop, own in margins:
        for one in own:
            ends = (_end(one, most) for most in (KEPT, STANDS))
            loss: Cell = 100 * one.loss if np.isfinite(one.loss) else "lost"
            rows.append((loop, one.effect.name, _level(one.effect, one.effect.declared), loss, *ends))
    columns = (
        Column("loop"),
        Column("effect"),
        Column("declared"),
        Column("loss", "%", "right", digits=2),
        Column(f"within {100 * (KEPT - 1):.0f} % up to"),
        Column(f"within {STANDS:g} times up to"),
    )
    return Table(name, caption, columns, tuple(rows))


def _level(effect: ComputerEffect, level: float) -> str:
    if effect.unit == "s":
        return f"{1e6 * level:.3g} µs"
    return f"{100 * level:.3g} %" if effect.unit == "1" else f"{level:g} {effect.unit}"


def _end(one: ComputerMargin, most: float) -> str:
    """The largest level that is kept, and that no longer one was tried where that is so."""
    level = one.largest(most)
    if level == one.effect.least:
        return f"none: {_level(one.effect, one.effect.levels[0])} is too much"
    return _level(one.effect, level) + (" or more" if one.open_end(most) else "")
