"""Sobol bars: what part of an output's variance each factor makes up, alone and together with others."""

from __future__ import annotations

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.document import Bars, Figure, Panel
from workbench.study.pictures.parts import BEYOND, Labels, captioned, each, number, refusals, scale_of_shares, written
from workbench.study.uncertainty.indices import SobolIndices
from workbench.validation.refusals import Integers
from workbench.validation.signatures import door

UNKNOWN = "Where a bar has no interval, it is not known."
BAR = 0.36  # of a row: the thickness of the bar of one index


@door
def sobol_bars(name: str, caption: Phrase, indices: SobolIndices, note: Phrase, *, labels: Labels = None) -> Figure:
    """S1 and ST of every factor with their intervals, the largest ST first; several outputs side by side.

    All panels have the factors in one order, that of the largest ST in any of them, and one scale. An interval that
    goes on beyond the scale ends in an arrow.

    Parameters
    ----------
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.
    labels
        How factors and outputs are written, by their names; as they stand where it does not say.

    Raises
    ------
    ValueError
        If the note is empty.

    Examples
    --------
    >>> design = wb.SobolDesign(dimensions=2, base=256)
    >>> u = design.points(0, design.size)
    >>> wb.sobol_bars("bars", "Who decides", wb.sobol(design, u[:, 0] + 2 * u[:, 1]), "256 points").name
    'bars'
    """
    single = each(indices)
    total = np.max([one.ST.value for one in single], axis=0)
    order = np.argsort(-total, kind="stable")
    scale = scale_of_shares([part for one in single for part in (one.S1, one.ST)])
    return Figure(
        name,
        captioned("sobol_bars", caption, note, *refusals(indices), *_intervals(single, scale)),
        tuple(_panel(one, order, scale, labels, titled=len(indices.names) > 1) for one in single),
        columns=2 if len(single) == 4 else min(len(single), 3),
        numbers=_numbers(name, caption, single, order),
    )


def _panel(one: SobolIndices, order: Integers, scale: tuple[float, float], labels: Labels, titled: bool) -> Panel:
    rows = np.arange(len(order), dtype=float)
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
        title=written(one.names[0], labels) if titled else "",
        vlines=(0.0,),
        ynames=tuple(written(one.factors[i], labels) for i in order),
    )


def _intervals(single: list[SobolIndices], scale: tuple[float, float]) -> tuple[str, ...]:
    """What must be said of intervals that are not drawn whole."""
    low, high = (np.stack([getattr(p, end) for one in single for p in (one.S1, one.ST)]) for end in ("low", "high"))
    beyond = bool((low < scale[0]).any() or (high > scale[1]).any())
    return (*([BEYOND] * beyond), *([UNKNOWN] * bool(np.isnan([low, high]).any())))


def _numbers(name: str, caption: Phrase, single: list[SobolIndices], order: Integers) -> Table:
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
