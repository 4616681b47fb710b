"""What changes over time: which factors matter, and between which quantiles runs lie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from workbench.core.sockets import described, require
from workbench.study.cells import Column, Phrase, Table
from workbench.study.curves import STYLES, Array
from workbench.study.document import Band, Figure, Label, Panel, Series
from workbench.study.pictures.parts import Labels, captioned, named, number, require_array, stretches
from workbench.study.sensitivity import Estimate, Quantiles, SobolIndices

MOST = STYLES - 1  # curves in a panel that an eye still tells apart
TOGETHER = 3  # laws whose bands still can be told apart in one panel


def indices_over_time(
    name: str, caption: Phrase, t: npt.ArrayLike, indices: SobolIndices, note: Phrase, *, labels: Labels = None
) -> Figure:
    """S1 and ST of the factors over time, with their intervals; the indices have an output for each time.

    At most seven factors are drawn, those whose ST is largest at any time; the caption bounds the others. A time whose
    output is refused is a gap, with its reason in the caption.

    Parameters
    ----------
    t
        (T,), in s.
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.
    labels
        How factors are written, by their names; as they stand, without.

    Raises
    ------
    ValueError
        If the note is empty, or there is not one time for each output.
    LookupError
        If a label names no factor.
    """
    times = _times("indices_over_time", t, len(indices.names))
    written = named("indices_over_time", indices.factors, labels)
    largest = np.nanmax(indices.ST.value, axis=0)
    order = np.argsort(-largest, kind="stable")
    drawn, left = order[:MOST].tolist(), order[MOST:]
    rest = f"The ST of the {len(left)} factors that are not drawn stays below {1.01 * largest[left].max():.2g}."
    panels = []
    for title, part in (("S1, alone", indices.S1), ("ST, alone and together with others", indices.ST)):
        curves = [mark for k, i in enumerate(drawn) for mark in _curve(written[i], times, part, i, k)]
        panels.append(Panel("part of the variance", tuple(curves), title=title, hlines=(0.0,)))
    said = (*_gaps(times, indices.names, indices.refused), *([rest] if len(left) else []))
    return Figure(
        name,
        captioned("indices_over_time", caption, note, *said),
        tuple(panels),
        numbers=_index_numbers(name, caption, times, indices),
    )


def _curve(label: Label, t: Array, part: Estimate, i: int, style: int) -> list[Series | Band]:
    value = part.value[:, i]
    low, high = (np.where(np.isfinite(end), end, np.nan) for end in (part.low[:, i], part.high[:, i]))
    bands = [Band("", t[k], low[k], high[k], style) for k in stretches(low + high)]
    return [Series(label, t, value, style), *bands]


def _gaps(t: Array, names: tuple[str, ...], refused: Mapping[str, str]) -> tuple[str, ...]:
    """One sentence for the times without indices, with the reason for the first."""
    lost = [place for place, name in enumerate(names) if name in refused]
    if not lost:
        return ()
    return (
        f"No indices at {len(lost)} of {len(t)} times, the first of them {t[lost[0]]:g} s: {refused[names[lost[0]]]}.",
    )


def _index_numbers(name: str, caption: Phrase, t: Array, indices: SobolIndices) -> Table:
    rows = tuple(
        (float(t[k]), factor, *(number(part[k, i]) for e in (indices.S1, indices.ST) for part in (e.value, e.half)))
        for k in range(len(t))
        for i, factor in enumerate(indices.factors)
    )
    heads = (Column("time", "s"), *map(Column, ("factor", "S1", "S1 (half-interval)", "ST", "ST (half-interval)")))
    return Table(name, caption, heads, rows)


def quantile_bands(
    name: str,
    caption: Phrase,
    t: npt.ArrayLike,
    bands: Mapping[str, Quantiles],
    note: Phrase,
    ylabel: Label,
) -> Figure:
    """Between which quantiles an output of many runs lies over time, for one law or several.

    The band lies between the lowest and the highest level, the line at the middle one, if their number is odd. More
    than three laws have a panel each, on one scale. From the time on at which a run failed there are no quantiles; the
    caption says how many failed.

    Parameters
    ----------
    t
        (T,), in s.
    bands
        By law, the quantiles of T outputs, all at the same levels.
    note
        Runs, failed runs, seed and step error, as `sample.note_of(metric, joint)` says them.

    Raises
    ------
    ValueError
        If the note is empty, there is not one time for each output, or the levels differ.
    """
    held = _bands(bands)
    times = _times("quantile_bands", t, len(next(iter(held.values())).names))
    (levels,) = {one.levels for one in held.values()}
    marks = {law: _band(law, times, one, k % STYLES) for k, (law, one) in enumerate(held.items())}
    if len(held) <= TOGETHER:
        panels = [Panel(ylabel, tuple(mark for law in marks.values() for mark in law))]
    else:
        limits = _limits(list(held.values()))
        panels = [Panel(ylabel, tuple(found), title=law, ylim=limits) for law, found in marks.items()]
    said = (_levels(levels), *(line for law, one in held.items() for line in _failures(law, times, one)))
    return Figure(
        name,
        captioned("quantile_bands", caption, note, *said),
        tuple(panels),
        columns=1 if len(panels) == 1 else 2,
        numbers=_band_numbers(name, caption, times, held),
    )


def _bands(bands: Mapping[str, Quantiles]) -> dict[str, Quantiles]:
    if not isinstance(bands, Mapping) or not bands:
        raise ValueError(f"`quantile_bands(bands=...)` must map each law to its quantiles; got {described(bands)}.")
    for law, one in bands.items():
        require(f"quantile_bands(bands={{'{law}': ...}})", one, Quantiles)
    if len({(one.levels, len(one.names)) for one in bands.values()}) > 1:
        raise ValueError("`quantile_bands(bands=...)` needs the same levels and times for all laws, to compare them.")
    return dict(bands)


def _times(call: str, t: npt.ArrayLike, outputs: int) -> Array:
    times = require_array(f"{call}(t)", t)
    if times.shape != (outputs,):
        raise ValueError(f"`{call}(t)` must be the time of each of the {outputs} outputs; got the shape {times.shape}.")
    return times


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


def _limits(held: list[Quantiles]) -> tuple[float, float] | None:
    values = np.concatenate([one.value.ravel() for one in held])
    values = values[np.isfinite(values)]
    if not values.size or np.ptp(values) == 0:
        return None
    return float(values.min() - 0.05 * np.ptp(values)), float(values.max() + 0.05 * np.ptp(values))


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


def _band_numbers(name: str, caption: Phrase, t: Array, held: Mapping[str, Quantiles]) -> Table:
    rows = tuple(
        (law, float(t[k]), level, *(number(part[k, j]) for part in (one.value, one.low, one.high)), int(one.failed[k]))
        for law, one in held.items()
        for k in range(len(t))
        for j, level in enumerate(one.levels)
    )
    heads = (Column("law"), Column("time", "s"), *map(Column, ("level", "quantile", "from", "to", "failed runs")))
    return Table(name, caption, heads, rows)
