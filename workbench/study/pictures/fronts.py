"""Pareto fronts: what of two measures can be had at once, law by law."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.study.document.cells import Column, Phrase, Table
from workbench.study.document.curves import STYLES, Array
from workbench.study.document.document import Figure, Label, Panel, Series
from workbench.study.pictures.parts import by_law, captioned, require_array, scale_of
from workbench.validation.refusals import Integers
from workbench.validation.signatures import door

MARKED = 15  # points of a front, at most, so that marks do not cover one another
SOME = f"Of a front of more points {MARKED} are marked."


@door
def pareto_fronts(
    name: str,
    caption: Phrase,
    fronts: Mapping[str, Array],
    note: Phrase,
    xlabel: Label,
    ylabel: Label,
) -> Figure:
    """Fronts of two measures that should be small: what is up and right of the steps is worse than a point of them.

    Of the points given only those that no other of the same law dominates are drawn. An axis whose numbers are
    positive and far apart is logarithmic.

    Parameters
    ----------
    fronts
        By law, points (B, 2); one with a NaN or an infinite number is left out, and counted in the caption.
    note
        Evaluations, failed ones, seeds and step error.

    Raises
    ------
    ValueError
        If the note is empty, or a front is no such table.
    """
    held = by_law("pareto_fronts", "fronts", fronts)
    found, said = {}, []
    for law, given in held.items():
        points = require_array(f"pareto_fronts(fronts={{'{law}': ...}})", given, columns=2)
        known = points[np.isfinite(points).all(axis=1)]
        found[law] = _front(known)
        if lost := len(points) - len(known):
            said.append(f"{law}: {lost:,} of {len(points):,} points have no numbers and are not drawn.")
    marks: list[Series] = []
    for k, (law, front) in enumerate(found.items()):
        if len(front) > 1:
            marks.append(Series(law, front[:, 0], front[:, 1], k % STYLES, "steps"))
        if len(front):
            x, y = front[_some(len(front))].T
            marks.append(Series("" if len(front) > 1 else law, x, y, k % STYLES, "marks"))
    if not marks:
        raise ValueError(f"`pareto_fronts('{name}')` needs a point with two finite numbers; got none.")
    scales = [scale_of(np.concatenate([front[:, axis] for front in found.values()])) for axis in (0, 1)]
    said += [SOME] * any(len(front) > MARKED for front in found.values())
    panel = Panel(ylabel, tuple(marks), xlabel=xlabel, xscale=scales[0], yscale=scales[1])
    rows = tuple((law, float(x), float(y)) for law, front in found.items() for x, y in front)
    table = Table(name, caption, (Column("law"), Column(xlabel), Column(ylabel)), rows)
    return Figure(name, captioned("pareto_fronts", caption, note, *said), (panel,), numbers=table)


def _some(points: int) -> Integers:
    """The places of the points that are marked: all of them, or some evenly among them."""
    return np.unique(np.linspace(0, points - 1, min(points, MARKED)).round().astype(int))


def _front(points: Array) -> Array:
    """The points that no other dominates, in rising order of the first measure."""
    ordered = points[np.lexsort(points.T[::-1])]
    least = np.minimum.accumulate(np.concatenate([[np.inf], ordered[:, 1]]))[:-1]
    return np.asarray(ordered[ordered[:, 1] < least])
