"""Laws side by side as curves: quantiles of many runs over time, fronts of two measures, and searches by their cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import Array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.report.pictures.captions import (
    Note,
    number,
    picture,
    scale_of,
    sources_of,
    stretches,
    times_of,
)
from workbench.study.document.figure import STYLES, Band, Figure, Label, Panel, Series
from workbench.study.document.phrases_and_tables import Phrase, TableColumn
from workbench.study.document.source import Source
from workbench.study.uncertainty.quantiles import Quantiles

TOGETHER = 3  # laws whose bands still can be told apart in one panel
ACROSS = 3  # panels side by side, one a law
BEYOND = 4.0  # times the least cost of all laws: the end of the scale of panels with a law each
MAX_MARKS = 15  # points of a front, at most, so that marks do not cover one another
SOME = f"At most {MAX_MARKS} points of each front are marked."


@check_arguments
def quantile_bands(
    name: str, caption: Phrase, t: Array, bands: Mapping[str, Quantiles], note: Note, ylabel: Label
) -> Figure:
    """The bands between quantiles of an output of many runs over time, for one law or several.

    `bands` has by law the quantiles of an output at each of the times t (T,) in s, all at the same levels. A band lies
    between the lowest and the highest level; if the number of levels is odd, a line marks the middle one. With more
    than three laws each has its own panel, on one scale, which is logarithmic if all quantiles are positive and far
    apart. After the time at which a run failed there are no quantiles; the caption says how many failed.

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
    sources = sources_of("quantile_bands", tuple(held), note)
    marks = {law: _band(law, times, one, k % STYLES, sources.get(law)) for k, (law, one) in enumerate(held.items())}
    scale, limits = _scale(np.concatenate([one.value.ravel() for one in held.values()]))
    if len(held) <= TOGETHER:
        panels = [Panel(ylabel, tuple(mark for law in marks.values() for mark in law), yscale=scale)]
    else:
        panels = [Panel(ylabel, tuple(found), title=law, ylim=limits, yscale=scale) for law, found in marks.items()]
    said = (_levels(levels), *(line for law, one in held.items() for line in _failures(law, times, one)))
    rows = (
        (
            law,
            float(t[k]),
            level,
            *(number(part[k, j]) for part in (one.value, one.low, one.high)),
            int(one.failures[k]),
        )
        for law, one in held.items()
        for k in range(len(t))
        for j, level in enumerate(one.levels)
    )
    heads = ("law", TableColumn("time", "s"), "level", "quantile", "from", "to", "failed runs")
    columns = 1 if len(panels) == 1 else 2
    return picture("quantile_bands", name, caption, note, panels, heads, rows, said, columns, names=tuple(held))


def _band(law: str, t: Array, one: Quantiles, style: int, source: Source | None) -> list[Series | Band]:
    low, high = one.value[:, np.argmin(one.levels)], one.value[:, np.argmax(one.levels)]
    finite = np.where(np.isfinite(low + high), low + high, np.nan)
    drawn: list[Series | Band] = [Band("", t[k], low[k], high[k], style) for k in stretches(finite)]
    if len(one.levels) % 2 and np.isfinite(middle := one.value[:, _middle(one.levels)]).any():
        over = None if source is None else replace(source, kind="time", name="time", label="", unit="s")
        pair = None if source is None or over is None else (over, source)
        drawn.insert(0, Series(law, t, np.where(np.isfinite(middle), middle, np.nan), style, sources=pair))
    elif drawn:
        drawn[0] = replace(drawn[0], label=law)
    return drawn or [Series(law, t, np.full(len(t), np.nan), style)]


def _middle(levels: tuple[float, ...]) -> int:
    return int(np.argsort(levels)[len(levels) // 2])


def _scale(values: Array) -> tuple[Literal["linear", "log"], tuple[float, float] | None]:
    """The scale and the ends of an axis around all numbers; no ends where there is nothing to measure."""
    values = values[np.isfinite(values)]
    if not values.size or np.ptp(values) == 0:
        return "linear", None
    low, high = float(values.min()), float(values.max())
    if scale_of(values) == "log":
        return "log", (low * (low / high) ** 0.05, high * (high / low) ** 0.05)
    return "linear", (low - 0.05 * (high - low), high + 0.05 * (high - low))


def _levels(levels: tuple[float, ...]) -> str:
    band = f"The band lies between the {100 * min(levels):g} % and the {100 * max(levels):g} % quantile of the runs"
    middle = levels[_middle(levels)]
    line = "the median" if middle == 0.5 else f"the {100 * middle:g} % quantile"
    return f"{band}; the line is {line}." if len(levels) % 2 else f"{band}."


def _failures(law: str, t: Array, one: Quantiles) -> tuple[str, ...]:
    lost = np.flatnonzero(one.failures)
    if not lost.size:
        return ()
    return (f"{law} has no quantiles from {t[lost[0]]:g} s on (failed runs: {int(one.failures.max()):,}).",)


@check_arguments
def pareto_fronts(
    name: str, caption: Phrase, fronts: Mapping[str, Array], note: Note, xlabel: Label, ylabel: Label
) -> Figure:
    """Fronts of two measures that should be small: a point of a front dominates all points above and right of it.

    `fronts` has points (B, 2) by law. Only points that no other point of the same law dominates are drawn. A point with
    a NaN or an infinite number is left out, and counted in the caption. An axis whose numbers are positive and far
    apart is logarithmic. With more than three laws each has its own panel, on one scale, with the front of all laws in
    grey. The `note` states evaluations, failures, seeds and step error.

    Raises
    ------
    ValueError
        If the note is empty, or a front does not have this shape.

    Examples
    --------
    >>> from workbench.report.pictures import pareto_fronts
    >>> fronts = {"PID": [[1.0, 2.0], [2.0, 1.0]]}
    >>> pareto_fronts("front", "A trade", fronts, "two designs, no run failed", "error", "effort").name
    'front'
    """
    found, said = {}, []
    for law, points in fronts.items():
        if points.ndim != 2 or points.shape[1] != 2:
            raise refusal(f"pareto_fronts(fronts={{'{law}': ...}})", "an array (B, 2) of numbers", points)
        known = points[np.isfinite(points).all(axis=1)]
        found[law] = _front(known)
        if lost := len(points) - len(known):
            said.append(f"{law}: {lost:,} of {len(points):,} points have no numbers and are not drawn.")
    marks = {law: _front_marks(law, front, k % STYLES) for k, (law, front) in enumerate(found.items())}
    if not any(marks.values()):
        raise ValueError(f"`pareto_fronts('{name}')` needs a point with two finite numbers; got none.")
    points = np.concatenate(list(found.values()))
    (xscale, xlim), (yscale, ylim) = _scale(points[:, 0]), _scale(points[:, 1])
    said += [SOME] * any(len(front) > MAX_MARKS for front in found.values())
    if len(found) <= TOGETHER:
        together = tuple(mark for law in marks.values() for mark in law)
        panels = [Panel(ylabel, together, xlabel=xlabel, xscale=xscale, yscale=yscale)]
    else:
        best = _front(points)
        behind = Series("front of all laws together", best[:, 0], best[:, 1], "reference", "steps")
        panels = [
            Panel("" if k % ACROSS else ylabel, (*own, behind), xlabel, xlim, ylim, xscale, yscale, law)
            for k, (law, own) in enumerate(marks.items())
        ]
    rows = ((law, float(x), float(y)) for law, front in found.items() for x, y in front)
    heads = ("law", TableColumn(xlabel), TableColumn(ylabel))
    columns = min(len(panels), ACROSS)
    return picture("pareto_fronts", name, caption, note, panels, heads, rows, said, columns, names=tuple(fronts))


def _front_marks(law: str, front: Array, style: int) -> list[Series]:
    """A front as steps, with marks at some of its points; a single point is a mark alone."""
    if not len(front):
        return []
    some = np.unique(np.linspace(0, len(front) - 1, min(len(front), MAX_MARKS)).round().astype(int))
    marks = Series("" if len(front) > 1 else law, front[some, 0], front[some, 1], style, "marks")
    return [Series(law, front[:, 0], front[:, 1], style, "steps"), marks] if len(front) > 1 else [marks]


def _front(points: Array) -> Array:
    """The points that no other dominates, in rising order of the first measure."""
    ordered = points[np.lexsort(points.T[::-1])]
    least = np.minimum.accumulate(np.concatenate([[np.inf], ordered[:, 1]]))[:-1]
    return np.asarray(ordered[ordered[:, 1] < least])


@check_arguments
def budget_curves(
    name: str, caption: Phrase, curves: Mapping[str, tuple[Array, Array]], note: Note, ylabel: Label
) -> Figure:
    """The best objective so far over the number of evaluations, law by law.

    For several searches the line is their median, and the band reaches from the best to the worst. While a search has
    no admissible point there is no band; while half of them have none there is no line. With more than three laws each
    has its own panel, on one scale. The scale begins at the least cost of all laws, a thin line, and ends at four times
    this cost.

    `curves` has by law the evaluations (n,) and the best objective so far, (n,) or (searches, n), infinite or NaN while
    no point is admissible. The `note` states evaluations, failures, seeds and step error.

    Raises
    ------
    ValueError
        If the note is empty, or a curve has no such shapes.

    Examples
    --------
    >>> from workbench.report.pictures import budget_curves
    >>> values = {"PID": ([8.0, 16.0], [[2.0, 1.0], [3.0, 1.5]])}
    >>> budget_curves("budget", "Two seeds", values, "two searches, seeds 0 and 1", "cost").name
    'budget'
    """
    held = {law: _curve(law, pair) for law, pair in curves.items()}
    finite = np.concatenate([best[np.isfinite(best)] for _, best in held.values()] or [np.empty(0)])
    if not finite.size:
        raise ValueError(f"`budget_curves('{name}')` needs a law that found something admissible; got none.")
    marks = {law: _budget_marks(law, *pair, k % STYLES) for k, (law, pair) in enumerate(held.items())}
    several = any(len(best) > 1 for _, best in held.values())
    said = ["Lines are medians of searches from different seeds; bands reach from the best to the worst."] * several
    if len(held) <= TOGETHER:
        together = tuple(mark for law in marks.values() for mark in law)
        panels = [Panel(ylabel, together, xlabel="evaluations", yscale=scale_of(finite))]
    else:
        panels, scale = _budget_panels(marks, finite, max(float(spent.max()) for spent, _ in held.values()), ylabel)
        said += [scale]
    rows = (
        (law, search + 1, float(spent[k]), float(best[search, k]))
        for law, (spent, best) in held.items()
        for search in range(len(best))
        for k in range(len(spent))
    )
    heads = ("law", "search", "evaluations", TableColumn(ylabel))
    columns = min(len(panels), ACROSS)
    return picture("budget_curves", name, caption, note, panels, heads, rows, said, columns, names=tuple(curves))


def _budget_marks(law: str, spent: Array, best: Array, style: int) -> list[Series | Band]:
    """The median of the searches of a law as steps, and the band between the best and the worst of them."""
    middle = np.median(best, axis=0)
    line = Series(law, spent, np.where(np.isfinite(middle), middle, np.nan), style, "steps")
    low, high = best.min(axis=0), best.max(axis=0)
    spread = np.where(np.isfinite(high) & (len(best) > 1), high, np.nan)
    return [line, *(_steps(spent[j], low[j], high[j], style) for j in stretches(spread))]


def _budget_panels(
    marks: Mapping[str, list[Series | Band]], costs: Array, longest: float, ylabel: Label
) -> tuple[list[Panel], str]:
    """A panel for each law, all with the same axes, and a sentence on their ordinate.

    Where the finite costs are not all positive, the ordinate has the range of all of them.
    """
    least, most = float(costs.min()), float(costs.max())
    scale, limits = _scale(costs)
    words = f"The thin line is the least value of all laws, {least:.3g}"
    if least > 0 and most > BEYOND * least:
        scale, limits = "log", (least / 1.04, BEYOND * least)
        words += f"; values above {BEYOND:g} times that are cut off"
    panels = [
        Panel(
            "" if k % ACROSS else ylabel,
            tuple(own),
            xlabel="evaluations",
            xlim=(0.0, longest),
            ylim=limits,
            yscale=scale,
            title=law,
            hlines=(least,),
        )
        for k, (law, own) in enumerate(marks.items())
    ]
    return panels, f"{words}."


def _steps(spent: Array, low: Array, high: Array, style: int) -> Band:
    """A band in steps, as its line."""
    return Band("", np.repeat(spent, 2)[1:], np.repeat(low, 2)[:-1], np.repeat(high, 2)[:-1], style)


def _curve(law: str, pair: tuple[Array, Array]) -> tuple[Array, Array]:
    call = f"budget_curves(curves={{'{law}': ...}})"
    spent, best = pair[0], np.atleast_2d(pair[1])
    if best.ndim != 2 or spent.shape != best.shape[1:]:
        raise refusal(call, "evaluations (n,) and the best so far, (n,) or (searches, n)", pair)
    return spent, np.where(np.isnan(best), np.inf, best)
