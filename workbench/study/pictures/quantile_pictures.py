"""Quantiles as pictures: the bands between which the runs of laws lie over time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from workbench.study.document.figure import STYLES, Band, Figure, Label, Panel, Series
from workbench.study.document.phrases import Column, Phrase
from workbench.study.pictures.captions import number, picture, scale_of, stretches, times_of
from workbench.study.uncertainty.quantiles import Quantiles
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

TOGETHER = 3  # laws whose bands still can be told apart in one panel


@door
def quantile_bands(
    name: str,
    caption: Phrase,
    t: Array,
    bands: Mapping[str, Quantiles],
    note: Phrase,
    ylabel: Label,
) -> Figure:
    """The bands between quantiles of an output of many runs over time, for one law or several.

    By law, `bands` are the quantiles of an output for each of the times t (T,) in s, all at the same levels. A band
    lies between the lowest and the highest, the line at the middle one, if their number is odd. More than three laws
    have a panel each, on one scale, which is logarithmic if all quantiles are positive and far apart. From the time on
    at which a run failed there are no quantiles; the caption says how many failed.

    Raises
    ------
    ValueError
        If the note is empty, there is not one time for each output, or the levels differ.
    """
    if len({(one.levels, len(one.names)) for one in bands.values()}) != 1:
        raise ValueError(
            "`quantile_bands(bands=...)` needs a law or more, all with the same levels and times, to compare them."
        )
    held = dict(bands)
    first = next(iter(held.values()))
    times, levels = times_of("quantile_bands", t, len(first.names)), first.levels
    marks = {law: _band(law, times, one, k % STYLES) for k, (law, one) in enumerate(held.items())}
    scale, limits = _scale(list(held.values()))
    if len(held) <= TOGETHER:
        panels = [Panel(ylabel, tuple(mark for law in marks.values() for mark in law), yscale=scale)]
    else:
        panels = [Panel(ylabel, tuple(found), title=law, ylim=limits, yscale=scale) for law, found in marks.items()]
    said = (_levels(levels), *(line for law, one in held.items() for line in _failures(law, times, one)))
    rows = (
        (law, float(t[k]), level, *(number(part[k, j]) for part in (one.value, one.low, one.high)), int(one.failed[k]))
        for law, one in held.items()
        for k in range(len(t))
        for j, level in enumerate(one.levels)
    )
    heads = ("law", Column("time", "s"), "level", "quantile", "from", "to", "failed runs")
    columns = 1 if len(panels) == 1 else 2
    return picture("quantile_bands", name, caption, note, panels, heads, rows, said, columns)


def _band(law: str, t: Array, one: Quantiles, style: int) -> list[Series | Band]:
    low, high = one.value[:, np.argmin(one.levels)], one.value[:, np.argmax(one.levels)]
    finite = np.where(np.isfinite(low + high), low + high, np.nan)
    drawn: list[Series | Band] = [Band("", t[k], low[k], high[k], style) for k in stretches(finite)]
    if len(one.levels) % 2 and np.isfinite(middle := one.value[:, _middle(one.levels)]).any():
        drawn.insert(0, Series(law, t, np.where(np.isfinite(middle), middle, np.nan), style))
    elif drawn:
        drawn[0] = replace(drawn[0], label=law)
    return drawn or [Series(law, t, np.full(len(t), np.nan), style)]


def _middle(levels: tuple[float, ...]) -> int:
    return int(np.argsort(levels)[len(levels) // 2])


def _scale(held: list[Quantiles]) -> tuple[Literal["linear", "log"], tuple[float, float] | None]:
    """The scale and the ends of an axis around all quantiles; no ends where there is nothing to measure."""
    values = np.concatenate([one.value.ravel() for one in held])
    values = values[np.isfinite(values)]
    if not values.size or np.ptp(values) == 0:
        return "linear", None
    low, high = float(values.min()), float(values.max())
    if scale_of(values) == "log":
        return "log", (low * (low / high) ** 0.05, high * (high / low) ** 0.05)
    return "linear", (low - 0.05 * (high - low), high + 0.05 * (high - low))


def _levels(levels: tuple[float, ...]) -> str:
    band = f"Between the {100 * min(levels):g} % and the {100 * max(levels):g} % quantile of the runs"
    middle = levels[_middle(levels)]
    line = "the median" if middle == 0.5 else f"the {100 * middle:g} % quantile"
    return f"{band}; the line is {line}." if len(levels) % 2 else f"{band}."


def _failures(law: str, t: Array, one: Quantiles) -> tuple[str, ...]:
    lost = np.flatnonzero(one.failed)
    if not lost.size:
        return ()
    return (f"{law} has no quantiles from {t[lost[0]]:g} s on (failed runs: {int(one.failed.max()):,}).",)
