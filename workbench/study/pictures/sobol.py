"""Sobol bars: what part of an output's variance each factor makes up, alone and together with others."""

from __future__ import annotations

import numpy as np

from workbench.study.cells import Column, Phrase, Table
from workbench.study.document import Bars, Figure, Panel
from workbench.study.pictures.parts import Labels, captioned, each, named, number, refusals
from workbench.study.sensitivity import SobolIndices

BEYOND = "An interval with an arrow goes on beyond the axes."
BAR = 0.36  # of a row: the thickness of the bar of one index


def sobol_bars(name: str, caption: Phrase, indices: SobolIndices, note: Phrase, *, labels: Labels = None) -> Figure:
    """S1 and ST of every factor with their intervals, the largest ST first; several outputs side by side.

    All panels have the factors in one order, that of the largest ST in any of them, and one scale. An interval that
    goes on beyond the scale ends in an arrow.

    Parameters
    ----------
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.
    labels
        How factors and outputs are written, by their names; as they stand, without.

    Raises
    ------
    ValueError
        If the note is empty.
    LookupError
        If a label names no factor or output.
    """
    named("sobol_bars", (*indices.factors, *indices.names), labels)
    single = list(each(indices))
    total = np.max([one.ST.value for one in single], axis=0)
    order = np.argsort(-total, kind="stable")
    scale = _scale(single)
    said = (*refusals(indices), *(() if _within(single, scale) else (BEYOND,)))
    return Figure(
        name,
        captioned("sobol_bars", caption, note, *said),
        tuple(_panel(one, order, scale, labels, titled=len(indices.names) > 1) for one in single),
        columns=min(len(single), 3),
        numbers=_numbers(name, caption, single, order),
    )


def _panel(one: SobolIndices, order: np.ndarray, scale: tuple[float, float], labels: Labels, titled: bool) -> Panel:
    written, rows = dict(labels or {}), np.arange(len(order))
    (output,) = one.names
    bars = [
        Bars(label, rows + aside, part.value[order], 0.0, style, shade, BAR, part.low[order], part.high[order])
        for label, part, aside, style, shade in (
            ("S1, alone", one.S1, -BAR / 2, 0, 1.0),
            ("ST, alone and together with others", one.ST, BAR / 2, 0, 0.25),
        )
    ]
    return Panel(
        "",
        tuple(bars),
        xlabel="part of the variance",
        xlim=scale,
        title=written.get(output, output) if titled else "",
        vlines=(0.0,),
        ynames=tuple(written.get(one.factors[i], one.factors[i]) for i in order),
    )


def _scale(single: list[SobolIndices]) -> tuple[float, float]:
    """From 0 as far as values reach, and intervals if they are not much wider than what can be."""
    values = np.concatenate([part.value for one in single for part in (one.S1, one.ST)])
    ends = np.concatenate([end for one in single for part in (one.S1, one.ST) for end in (part.low, part.high)])
    ends = np.clip(ends[np.isfinite(ends)], -0.25, 1.25)
    low, high = min(0.0, ends.min(initial=0.0), values.min()), max(0.1, ends.max(initial=0.1), values.max())
    return float(low - 0.02 * (high - low) * (low < 0)), float(high + 0.02 * (high - low))


def _within(single: list[SobolIndices], scale: tuple[float, float]) -> bool:
    parts = [part for one in single for part in (one.S1, one.ST)]
    return all(bool((part.low >= scale[0]).all() and (part.high <= scale[1]).all()) for part in parts)


def _numbers(name: str, caption: Phrase, single: list[SobolIndices], order: np.ndarray) -> Table:
    rows = tuple(
        (
            one.names[0],
            one.factors[i],
            *(number(value[i]) for part in (one.S1, one.ST) for value in (part.value, part.half)),
        )
        for one in single
        for i in order
    )
    heads = ("output", "factor", "S1", "S1 (half-interval)", "ST", "ST (half-interval)")
    return Table(name, caption, tuple(map(Column, heads)), rows)
