"""Indices over time: which factors matter when."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.curves import Array
from workbench.study.document.document import Band, Figure, Panel, Series
from workbench.study.pictures.parts import Labels, captioned, number, scale_of_shares, stretches, times_of, written
from workbench.study.uncertainty.indices import SobolIndices
from workbench.study.uncertainty.outputs import Estimate
from workbench.validation.signatures import door

BEYOND = "An interval that reaches the edge goes on beyond the axes."
FEW_BANDS = "Intervals are drawn of the three factors with the largest ST alone, so that they can be told apart."
BANDED = 3  # of them with a band
MOST = 7  # curves in a panel that an eye still tells apart


@door
def indices_over_time(
    name: str, caption: Phrase, t: Array, indices: SobolIndices, note: Phrase, *, labels: Labels = None
) -> Figure:
    """S1 and ST of the factors over time; the indices have an output for each time.

    At most seven factors are drawn, those whose ST is largest at any time, three of them with their intervals; the
    caption bounds the others, and the figure's numbers hold all. A time whose output is refused is a gap, with its
    reason in the caption.

    Parameters
    ----------
    t
        (T,), in s.
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.
    labels
        How factors are written, by their names; as they stand where it does not say.

    Raises
    ------
    ValueError
        If the note is empty, or there is not one time for each output.
    """
    times = times_of("indices_over_time", t, len(indices.names))
    largest = np.fmax.reduce(indices.ST.value, axis=0)
    order = np.argsort(-largest, kind="stable")
    drawn, left = order[:MOST].tolist(), order[MOST:]
    banded, panels, beyond = drawn[:BANDED], [], False
    for title, part in (("S1, alone", indices.S1), ("ST, alone and together with others", indices.ST)):
        shown = Estimate(part.value, np.where(np.isin(np.arange(len(largest)), banded), part.half, 0.0))
        limits = scale_of_shares([shown])
        curves: list[Series | Band] = []
        for k, i in enumerate(drawn):
            curves.append(Series(written(indices.factors[i], labels), times, part.value[:, i], k))
            curves += _bands(times, part, i, k, limits) if k < BANDED else []
        beyond |= bool((shown.low < limits[0]).any() or (shown.high > limits[1]).any())
        panels.append(Panel("part of the variance", tuple(curves), title=title, hlines=(0.0,), ylim=limits))
    said = (
        *([FEW_BANDS] * (len(drawn) > BANDED)),
        *([BEYOND] * beyond),
        *_gaps(times, indices.names, indices.refused),
        *_rest(largest[left]),
    )
    return Figure(
        name,
        captioned("indices_over_time", caption, note, *said),
        tuple(panels),
        numbers=_numbers(name, caption, times, indices),
    )


def _rest(largest: Array) -> tuple[str, ...]:
    """What bounds the factors that are not drawn: two digits, rounded upwards."""
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


def _numbers(name: str, caption: Phrase, t: Array, indices: SobolIndices) -> Table:
    rows = tuple(
        (float(t[k]), factor, *(number(part[k, i]) for e in (indices.S1, indices.ST) for part in (e.value, e.half)))
        for k in range(len(t))
        for i, factor in enumerate(indices.factors)
    )
    heads = (Column("time", "s"), *map(Column, ("factor", "S1", "S1 (half-interval)", "ST", "ST (half-interval)")))
    return Table(name, caption, heads, rows)
