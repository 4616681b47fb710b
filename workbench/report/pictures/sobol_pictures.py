"""Sobol indices as pictures: bars of S1 and ST, a map of S2 for pairs of factors, and indices over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments
from workbench.report.pictures.captions import (
    BEYOND,
    Labels,
    Note,
    each,
    label_of,
    number,
    picture,
    refusals,
    scale_of_shares,
    sources_of,
    stretches,
    times_of,
)
from workbench.study.document.figure import Band, Bars, Figure, Panel, Series
from workbench.study.document.phrases_and_tables import Phrase, TableColumn
from workbench.study.document.source import Source
from workbench.study.uncertainty.outputs import Estimate
from workbench.study.uncertainty.sobol_indices import SobolIndices

NO_INTERVAL_NOTE = "A bar without an interval has an unknown one."
BAR = 0.36  # of a row: the thickness of the bar of one index
EDGE = "An interval that reaches the edge goes on beyond the axes."
FEW_BANDS = "Intervals are drawn only for the three factors with the largest ST, as more would cover one another."
MAX_BANDS = 3  # curves with a band
MOST = 7  # curves in a panel that an eye still tells apart
S1, ST = "S1, alone", "ST, alone and together with others"
HEADS = ("S1", "S1 (half-interval)", "ST", "ST (half-interval)")


@check_arguments
def sobol_bars(name: str, caption: Phrase, indices: SobolIndices, note: Note, *, labels: Labels = None) -> Figure:
    """S1 and ST of every factor with their intervals, the largest ST first; several outputs side by side.

    All panels have one scale, and one order of the factors: by the largest ST in any panel. An interval that extends
    beyond the scale ends in an arrow.

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
    rows = ((one.names[0], one.factors[i], *_cells(one, (i,))) for one in single for i in order)
    sources = sources_of("sobol_bars", indices.names, note)
    panels = [_bars(one, order, scale, labels, len(indices.names) > 1, sources.get(one.names[0])) for one in single]
    remarks = (*refusals(indices), *_intervals(single, scale))
    columns = 2 if len(single) == 4 else min(len(single), 3)
    heads = ("output", "factor", *HEADS)
    return picture("sobol_bars", name, caption, note, panels, heads, rows, remarks, columns, names=indices.names)


def _bars(
    one: SobolIndices,
    order: Integers,
    scale: tuple[float, float],
    labels: Labels,
    titled: bool,
    source: Source | None,
) -> Panel:
    rows, start, sources = np.arange(len(order), dtype=float), np.zeros(len(order)), (source,) * len(order)
    bars = [
        Bars(
            label, rows + aside, part.value[order], start, 0, shade, BAR, part.low[order], part.high[order], (), sources
        )
        for label, part, aside, shade in ((S1, one.S1, -BAR / 2, 1.0), (ST, one.ST, BAR / 2, 0.25))
    ]
    return Panel(
        "",
        tuple(bars),
        xlabel="part of the variance",
        xlim=scale,
        title=label_of(one.names[0], labels) if titled else "",
        vlines=(0.0,),
        ynames=tuple(label_of(one.factors[i], labels) for i in order),
    )


def _intervals(single: list[SobolIndices], scale: tuple[float, float]) -> tuple[str, ...]:
    """Remarks on intervals that are not drawn whole."""
    low, high = (np.stack([getattr(p, end) for one in single for p in (one.S1, one.ST)]) for end in ("low", "high"))
    beyond = bool((low < scale[0]).any() or (high > scale[1]).any())
    return (*([BEYOND] * beyond), *([NO_INTERVAL_NOTE] * bool(np.isnan([low, high]).any())))


def _cells(indices: SobolIndices, place: tuple[int, ...]) -> tuple[float | None, ...]:
    """S1 and ST at a place, each with half of its interval."""
    return tuple(number(part[place]) for e in (indices.S1, indices.ST) for part in (e.value, e.half))


@check_arguments
def indices_over_time(
    name: str, caption: Phrase, t: Array, indices: SobolIndices, note: Note, *, labels: Labels = None
) -> Figure:
    """S1 and ST of the factors over time; the indices have an output for each of the times t (T,) in s.

    At most seven factors are drawn, those whose ST is largest at any time, three of them with their intervals; the
    caption bounds the others, and the figure's numbers hold all. A time whose output is refused is a gap, with its
    reason in the caption.

    Raises
    ------
    ValueError
        If the note is empty, or there is not one time for each output.

    Examples
    --------
    >>> from workbench.report.pictures import indices_over_time
    >>> t, design = np.array([1.0, 2.0]), wb.SobolDesign(2, 64)
    >>> u = design.points()
    >>> indices = wb.sobol(design, u[:, :1] + u[:, 1:] * t, ["y(1 s)", "y(2 s)"], factors=["start", "slope"])
    >>> figure = indices_over_time("course", "Who decides when.", t, indices, "256 runs, none of them failed.")
    >>> [panel.title for panel in figure.panels]
    ['S1, alone', 'ST, alone and together with others']
    """
    times = times_of("indices_over_time", t, len(indices.names))
    largest = np.fmax.reduce(indices.ST.value, axis=0)
    order = np.argsort(-largest, kind="stable")
    drawn, left = order[:MOST].tolist(), order[MOST:]
    banded, panels, beyond = drawn[:MAX_BANDS], [], False
    for title, part in ((S1, indices.S1), (ST, indices.ST)):
        shown = Estimate(part.value, np.where(np.isin(np.arange(len(largest)), banded), part.half, 0.0))
        limits = scale_of_shares([shown])
        curves: list[Series | Band] = []
        for k, i in enumerate(drawn):
            curves.append(Series(label_of(indices.factors[i], labels), times, part.value[:, i], k))
            curves += _bands(times, part, i, k, limits) if k < MAX_BANDS else []
        beyond |= bool((shown.low < limits[0]).any() or (shown.high > limits[1]).any())
        panels.append(Panel("part of the variance", tuple(curves), title=title, hlines=(0.0,), ylim=limits))
    remarks = (
        *([FEW_BANDS] * (len(drawn) > MAX_BANDS)),
        *([EDGE] * beyond),
        *_gaps(times, indices.names, indices.refusals),
        *_rest(largest[left]),
    )
    rows = (
        (float(t[k]), factor, *_cells(indices, (k, i)))
        for k in range(len(t))
        for i, factor in enumerate(indices.factors)
    )
    heads = (TableColumn("time", "s"), "factor", *HEADS)
    return picture("indices_over_time", name, caption, note, panels, heads, rows, remarks)


def _rest(largest: Array) -> tuple[str, ...]:
    """A bound of the factors that are not drawn: two digits, rounded upwards."""
    if not largest.size:
        return ()
    most = max(float(largest.max()), 1e-6)
    unit = 10.0 ** (np.floor(np.log10(most)) - 1)
    return (f"The ST of the {len(largest)} factors that are not drawn is at most {np.ceil(most / unit) * unit:.2g}.",)


def _bands(t: Array, part: Estimate, i: int, style: int, limits: tuple[float, float]) -> list[Series | Band]:
    """The intervals of a factor, as far as the panel shows them, between the times without any."""
    low, high = (np.clip(end, *limits) for end in (part.low[:, i], part.high[:, i]))
    return [Band("", t[k], low[k], high[k], style) for k in stretches(low + high)]


def _gaps(t: Array, names: tuple[str, ...], refused: Mapping[str, str]) -> tuple[str, ...]:
    """One sentence for the times without indices, with the reason for the first."""
    lost = [place for place, name in enumerate(names) if name in refused]
    if not lost:
        return ()
    return (
        f"No indices at {len(lost)} of {len(t)} times, the first of them {t[lost[0]]:g} s: {refused[names[lost[0]]]}.",
    )
