"""Root loci: the poles of a loop over the values of any of its parameters, as branches in the plane."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from workbench.core.validation.refusals import Array, numbers, positive, refusal, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.report.loop_pictures.pole_maps import grid_remarks, root_panel
from workbench.study.document.figure import Arrows, Figure, Label, Mark, Points, Series
from workbench.study.document.frequency_curves import Complex, Complexes, add_remarks, complexes, join_words, number
from workbench.study.document.phrases_and_tables import Cell, Phrase, ReportTable, TableColumn, superscript_powers

MAX_NAMES = 4  # crossings with a name
FAR = 6.0  # times the size of the poles at the first value: beyond it a branch is cut, unless `reach` says otherwise


@check_arguments
def root_locus_figure(
    name: str,
    caption: Phrase,
    parameter: Label,
    values: Array,
    poles: Complexes,
    unit: str = "",
    marked_values: Sequence[float] = (),
    zeros: Complexes = (),  # type: ignore[assignment]
    period: float | None = None,
    reach: float | None = None,
    grid: bool = True,
) -> Figure:
    """The poles (N, nx) of a loop at the values (N,) of one of its parameters, joined to branches.

    A cross stands at the first value, a dot at each of the `marked_values`, and a plus where a branch crosses the limit
    of stability, with the value there. Arrowheads point to higher values. `zeros`, where branches end, are rings.
    Branches are cut at the distance `reach` from zero, in 1/s.

    Raises
    ------
    ValueError
        If there are fewer than two values, they do not rise or fall, there are no poles for each of them, or the reach
        is not positive.
    """
    at = numbers("root_locus_figure(values=...)", values, 1)
    if len(at) < 2 or not np.isfinite(at).all() or not ((np.diff(at) > 0).all() or (np.diff(at) < 0).all()):
        raise refusal("root_locus_figure(values=...)", "two or more finite values in rising or falling order", values)
    held = complexes("root_locus_figure(poles=...)", poles, 2, gaps=True)
    if held.shape[0] != len(at) or not held.shape[1]:
        raise refusal("root_locus_figure(poles=...)", f"an array ({len(at)}, nx) of poles, a row for each value", poles)
    rings = complexes("root_locus_figure(zeros=...)", zeros, 1)
    if period is not None:
        period = seconds("root_locus_figure(period=...)", period)
    paths = branches(held)
    window = _window(paths, rings, period, reach)
    marks = [*_paths(paths, window), *_dots(at, paths, marked_values, parameter, unit), *_ends(paths, rings)]
    crossings = stability_crossings(at, paths, period)
    marks += _limits(crossings, unit)
    shown = paths[np.isfinite(paths) & (np.abs(paths) <= window)]
    panel = root_panel(marks, np.concatenate([shown, rings]), period, grid)
    rows: list[tuple[Cell, ...]] = [
        (float(value), k + 1, *(None if np.isnan(part) else float(part) for part in (root.real, root.imag)))
        for value, row in zip(at, paths, strict=True)
        for k, root in enumerate(row)
    ]
    heads = (TableColumn(parameter, unit), *map(TableColumn, ("branch", "real part", "imaginary part")))
    remarks = [*_remarks(at, crossings, parameter, unit), *(grid_remarks(period) if grid else [])]
    return Figure(name, add_remarks(caption, remarks), (panel,), 1, ReportTable(name, caption, heads, tuple(rows)))


def _limits(crossings: Sequence[tuple[float, complex]], unit: str) -> list[Mark]:
    """A plus where a branch crosses the limit of stability, the first ones with the value, above the real axis."""
    if not crossings:
        return []
    roots = np.array([root for _, root in crossings])
    upper = [k for k, root in enumerate(roots) if root.imag >= 0][:MAX_NAMES]
    words = tuple(f"{number(value)}{_unit(unit)}" if k in upper else "" for k, (value, _) in enumerate(crossings))
    return [Points("limit of stability", roots.real, roots.imag, words, 6, shape="critical")]


def _unit(unit: str) -> str:
    return f" {superscript_powers(unit)}" if unit not in ("", "1") else ""


def branches(poles: Complex) -> Complex:
    """The poles (N, nx) in an order in which each column is a branch: the least sum of steps from row to row.

    A step is measured from where the last two rows point to, so that branches that cross go on straight. A row with a
    NaN is a gap.
    """
    from scipy.optimize import linear_sum_assignment  # here, as it takes long to import

    found = np.array(poles)
    last, before = None, None
    for k in range(len(found)):
        if not np.isfinite(found[k]).all():
            continue
        if last is not None:
            ahead = found[last] if before is None else 2 * found[last] - found[before]
            cost = np.abs(ahead[:, np.newaxis] - found[k]) + np.abs(found[last][:, np.newaxis] - found[k])
            found[k] = found[k][linear_sum_assignment(cost)[1]]
            before = last
        last = k
    return found


def stability_crossings(values: Array, paths: Complex, period: float | None) -> list[tuple[float, complex]]:
    """The values, and the poles, at which branches cross the axis, or the unit circle: on the line between rows."""
    depth = paths.real if period is None else np.abs(paths) - 1
    found = []
    for j, own in enumerate(depth.T):
        beside = np.flatnonzero(np.isfinite(own) & (own != 0))  # a pole may lie on the limit at a value
        for k, after in pairwise(beside):
            if (own[k] < 0) == (own[after] < 0):
                continue
            if after == k + 2 and own[k + 1] == 0:
                found.append((float(values[k + 1]), complex(paths[k + 1, j])))
                continue
            share = own[k] / (own[k] - own[after])
            value = values[k] + share * (values[after] - values[k])
            found.append((float(value), complex(paths[k, j] + share * (paths[after, j] - paths[k, j]))))
    return sorted(found, key=lambda crossing: crossing[0])


def _window(paths: Complex, zeros: Complex, period: float | None, reach: float | None) -> float:
    """The distance from zero within which branches are drawn."""
    if reach is not None:
        return positive("root_locus_figure(reach=...)", reach)
    known = paths[np.isfinite(paths)]
    if period is not None:
        return max(1.5, float(np.abs(zeros).max(initial=0.0)))
    first = next(row for row in paths if np.isfinite(row).all()) if np.isfinite(paths).all(axis=1).any() else known
    size = max(float(np.abs(first).max()), float(np.abs(zeros).max(initial=0.0)))
    return float(np.abs(known).max()) if size == 0 else min(FAR * size, float(np.abs(known).max()))


def _paths(paths: Complex, window: float) -> list[Mark]:
    """A line for each branch, and an arrowhead in its middle."""
    marks: list[Mark] = []
    for j, path in enumerate(paths.T):
        inside = np.isfinite(path) & (np.abs(path) <= 4 * window)
        x = np.where(np.isfinite(path.real), path.real, 0.0)
        marks.append(Series("poles" if not j else "", x, np.where(inside, path.imag, np.nan), 0))
        seen = path[np.isfinite(path) & (np.abs(path) <= window)]
        length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(seen)))]) if len(seen) > 1 else np.zeros(1)
        if length[-1] > 0.08 * window:
            k = max(1, int(np.searchsorted(length, 0.5 * length[-1])))
            along = seen[k] - seen[k - 1]
            at, way = (np.array([part.real, part.imag]) for part in (seen[k], along))
            marks.append(Arrows("", at[:1], at[1:], way[:1], way[1:], 0))
    return marks


def _dots(at: Array, paths: Complex, marked: Sequence[float], parameter: Label, unit: str) -> list[Mark]:
    """Dots at the poles at marked values, on the straight line between rows."""
    marks: list[Mark] = []
    order = np.argsort(at)
    for k, value in enumerate(marked):
        if not at.min() <= value <= at.max():
            raise ValueError(
                f"`root_locus_figure(marked_values=...)` must lie within the values, {at.min():g} to {at.max():g}; got "
                f"{value:g}."
            )
        roots = np.array(
            [
                np.interp(value, at[order], path[order].real) + 1j * np.interp(value, at[order], path[order].imag)
                for path in paths.T
            ]
        )
        label = parameter if isinstance(parameter, tuple) else (parameter,)
        marks.append(Points((*label, f" = {number(value)}{_unit(unit)}"), roots.real, roots.imag, (), 1 + k % 11))
    return marks


def _ends(paths: Complex, zeros: Complex) -> list[Mark]:
    """Crosses at the first value, and rings at the zeros."""
    first = paths[0]
    marks: list[Mark] = []
    if np.isfinite(first).any():
        marks.append(Points("at the first value", first.real, first.imag, (), 6, shape="pole"))
    if len(zeros):
        marks.append(Points("zeros", zeros.real, zeros.imag, (), 6, shape="zero"))
    return marks


def _remarks(at: Array, crossings: Sequence[tuple[float, complex]], parameter: Label, unit: str) -> list[Phrase]:
    label = parameter if isinstance(parameter, tuple) else (parameter,)
    said: list[Phrase] = [(*label, f" goes from {number(float(at[0]))} to {number(float(at[-1]))}{_unit(unit)}.")]
    if crossings:
        values = list(dict.fromkeys(number(value) for value, root in crossings if root.imag >= 0))
        said.append(
            (
                "A pole crosses the limit of stability at ",
                *label,
                f" = {join_words(values)}{_unit(unit)}, by interpolation.",
            )
        )
    else:
        said.append("No pole crosses the limit of stability.")
    return said
