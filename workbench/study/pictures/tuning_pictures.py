"""Tunings as pictures: fronts of two measures, and the best point of a search against its cost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench.study.document.figure import STYLES, Band, Figure, Label, Panel, Series
from workbench.study.document.phrases import Column, Phrase
from workbench.study.pictures.captions import picture, scale_of, stretches
from workbench.validation.refusals import Array, Integers, refusal
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
    """Fronts of two measures that should be small: a point of a front dominates all points above and right of it.

    Of the points (B, 2) by law only those that no other of the same law dominates are drawn; one with a NaN or an
    infinite number is left out, and counted in the caption. An axis whose numbers are positive and far apart is
    logarithmic. The `note` says evaluations, failed ones, seeds and step error.

    Raises
    ------
    ValueError
        If the note is empty, or a front is no such table.
    """
    found, said = {}, []
    for law, points in fronts.items():
        if points.ndim != 2 or points.shape[1] != 2:
            raise refusal(f"pareto_fronts(fronts={{'{law}': ...}})", "an array (B, 2) of numbers", points)
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
    rows = ((law, float(x), float(y)) for law, front in found.items() for x, y in front)
    heads = ("law", Column(xlabel), Column(ylabel))
    return picture("pareto_fronts", name, caption, note, (panel,), heads, rows, said)


def _some(points: int) -> Integers:
    """The places of the points that are marked: all of them, or some evenly among them."""
    return np.unique(np.linspace(0, points - 1, min(points, MARKED)).round().astype(int))


def _front(points: Array) -> Array:
    """The points that no other dominates, in rising order of the first measure."""
    ordered = points[np.lexsort(points.T[::-1])]
    least = np.minimum.accumulate(np.concatenate([[np.inf], ordered[:, 1]]))[:-1]
    return np.asarray(ordered[ordered[:, 1] < least])


@door
def budget_curves(
    name: str,
    caption: Phrase,
    curves: Mapping[str, tuple[Array, Array]],
    note: Phrase,
    ylabel: Label,
) -> Figure:
    """The best so far against the evaluations that it cost, law by law.

    Of several searches the line is their median, and the band reaches from the best to the worst. Where a search has
    nothing admissible yet there is no band, and no line if that holds for half of them.

    By law, `curves` are evaluations (n,) and the best so far, (n,) or (searches, n), infinite or NaN while none is
    admissible. The `note` says evaluations, failed ones, seeds and step error.

    Raises
    ------
    ValueError
        If the note is empty, or a curve has no such shapes.
    """
    held = {law: _curve(law, pair) for law, pair in curves.items()}
    finite = np.concatenate([best[np.isfinite(best)] for _, best in held.values()] or [np.empty(0)])
    if not finite.size:
        raise ValueError(f"`budget_curves('{name}')` needs a law that found something admissible; got none.")
    marks: list[Series | Band] = []
    for k, (law, (spent, best)) in enumerate(held.items()):
        middle = np.median(best, axis=0)
        marks.append(Series(law, spent, np.where(np.isfinite(middle), middle, np.nan), k % STYLES, "steps"))
        low, high = best.min(axis=0), best.max(axis=0)
        spread = np.where(np.isfinite(high) & (len(best) > 1), high, np.nan)
        marks += [_band(spent[j], low[j], high[j], k % STYLES) for j in stretches(spread)]
    several = any(len(best) > 1 for _, best in held.values())
    said = ["Lines are medians of searches from different seeds; bands reach from the best to the worst."] * several
    panel = Panel(ylabel, tuple(marks), xlabel="evaluations", yscale=scale_of(finite))
    rows = (
        (law, search + 1, float(spent[k]), float(best[search, k]))
        for law, (spent, best) in held.items()
        for search in range(len(best))
        for k in range(len(spent))
    )
    heads = ("law", "search", "evaluations", Column(ylabel))
    return picture("budget_curves", name, caption, note, (panel,), heads, rows, said)


def _band(spent: Array, low: Array, high: Array, style: int) -> Band:
    """A band in steps, as its line."""
    return Band("", np.repeat(spent, 2)[1:], np.repeat(low, 2)[:-1], np.repeat(high, 2)[:-1], style)


def _curve(law: str, pair: tuple[Array, Array]) -> tuple[Array, Array]:
    call = f"budget_curves(curves={{'{law}': ...}})"
    spent, best = pair[0], np.atleast_2d(pair[1])
    if best.ndim != 2 or spent.shape != best.shape[1:]:
        raise refusal(call, "evaluations (n,) and the best so far, (n,) or (searches, n)", pair)
    return spent, np.where(np.isnan(best), np.inf, best)
