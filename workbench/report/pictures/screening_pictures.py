"""Screening of factors as pictures: the plane of Morris's effects, and tornadoes of one factor at a time."""

from __future__ import annotations

from typing import Literal

import numpy as np

from workbench.core.notation.formula import Relation, Symbol
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.report.pictures.captions import (
    BEYOND,
    DECADE,
    Labels,
    Note,
    each,
    label_of,
    number,
    picture,
    refusals,
    sources_of,
    with_unit,
)
from workbench.study.document.figure import Bars, Figure, Label, Panel, Points, Series
from workbench.study.document.phrases_and_tables import Cell, Phrase, TableColumn, parts
from workbench.study.document.source import Source
from workbench.study.uncertainty.effects import MorrisEffects, Tornado
from workbench.study.uncertainty.outputs import Estimate

MU_STAR, SIGMA = Symbol("mu", mark="*"), Symbol("sigma")
LEAST = 0.02  # of the other axis that an axis spans: below lies rounding
MOST = 1.6  # of the largest number that an axis spans: intervals that are wider are cut
NEAR = 0.03  # of both axes: factors as near to 0 are named in the caption
LETTERS = 200  # of names that the plane has room for
FLOOR = 1e-3  # of the largest number of a logarithmic axis, where it begins

LOGARITHMIC = "Both axes are logarithmic, as a few factors are more than ten times the median."
LEVEL = 0.36  # of a row: the thickness of the bar of one level


@check_arguments
def morris_plane(
    name: str, caption: Phrase, effects: MorrisEffects, note: Note, unit: str = "", *, labels: Labels = None
) -> Figure:
    """The factors in the plane of mu* and sigma with their intervals, and the line sigma = mu*; one panel per output.

    A factor far to the right matters. Below the line its effect is much the same everywhere; above the line the effect
    is nonlinear, or depends on other factors. Intervals are cut at 0, as neither number can be negative; an interval
    without a bound ends in an arrow. Both axes are logarithmic if a few factors are more than ten times the median, and
    the caption says so.

    Raises
    ------
    ValueError
        If the note is empty.

    Examples
    --------
    >>> from workbench.report.pictures import morris_plane
    >>> from workbench.study.uncertainty import MorrisDesign, morris
    >>> design = MorrisDesign(2, 8)
    >>> effects = morris(design, design.points() @ [1.0, 2.0], factors=("k", "m"))
    >>> morris_plane("morris", "Who decides", effects, "8 paths", labels={"k": "stiffness"}).name
    'morris'
    """
    single = each(effects)
    names, key = _names(single[0], labels)
    titles = [label_of(one.names[0], labels) if len(effects.names) > 1 else "" for one in single]
    log = any(map(_uneven, single))
    sources = sources_of("morris_plane", effects.names, note)
    drawn = [
        _plane(one, unit, names, title, log, sources.get(one.names[0]))
        for one, title in zip(single, titles, strict=True)
    ]
    panels, near, beyond = zip(*drawn, strict=True)
    where = f"Factors below {FLOOR:g} of the largest number" if log else "Factors near 0"
    said = (*([LOGARITHMIC] * log), *_named_near(near, names, where), *([BEYOND] * any(beyond)))
    heads = [TableColumn(head, unit) for kind in ("mu*", "sigma", "mu") for head in (kind, f"{kind} (half-interval)")]
    rows = (row for one in single for row in _moments(one))
    remarks = (*refusals(effects), *key, *said)
    named: tuple[str | TableColumn, ...] = ("output", "factor", *heads)
    return picture("morris_plane", name, caption, note, panels, named, rows, remarks, names=effects.names)


def _uneven(effects: MorrisEffects) -> bool:
    """True if a few factors are so much larger than most that they would set the scale alone."""
    largest = float(effects.mu_star.value.max())
    sizes = [part.value[part.value > LEAST * FLOOR * largest] for part in (effects.mu_star, effects.sigma)]
    return any(len(size) > 2 and float(size.max()) > DECADE * float(np.median(size)) for size in sizes)


def _names(effects: MorrisEffects, labels: Labels) -> tuple[tuple[Label, ...], tuple[Phrase, ...]]:
    """The names beside the points, or their numbers by falling mu*, with a key, where names would cover the plane."""
    names = tuple(label_of(factor, labels) for factor in effects.factors)
    letters = (len(part) if isinstance(part, str) else 3 for name in names for part in parts(name))
    if sum(letters) <= LETTERS:
        return names, ()
    order = np.argsort(-effects.mu_star.value, kind="stable").tolist()
    numbers = {i: str(place + 1) for place, i in enumerate(order)}
    key = [(*(["; "] if place else []), *parts(names[i]), f" ({numbers[i]})") for place, i in enumerate(order)]
    return tuple(numbers[i] for i in range(len(names))), (
        ("In the order of falling ", MU_STAR, ": ", *(part for pair in key for part in pair)),
    )


def _plane(
    effects: MorrisEffects, unit: str, names: tuple[Label, ...], title: Label, log: bool, source: Source | None
) -> tuple[Panel, list[int], bool]:
    """The panel, the factors that it does not name, and True if an interval reaches beyond its axes."""
    x, y = effects.mu_star, effects.sigma
    (xlow, xhigh, right), (ylow, yhigh, top) = _interval(x), _interval(y)
    right, top = max(right, LEAST * top), max(top, LEAST * right)
    left, bottom = (FLOOR * right, FLOOR * top) if log else (0.0, 0.0)
    if log:  # an interval that reaches 0 goes on beyond the axis
        xlow, ylow = np.maximum(xlow, 0.5 * left), np.maximum(ylow, 0.5 * bottom)
    shown = (x.value >= left) & (y.value >= bottom)
    numbers = (x.value, y.value, xlow, xhigh, ylow, yhigh)
    across, up, xlow, xhigh, ylow, yhigh = (np.where(shown, part, np.nan) for part in numbers)
    near = np.flatnonzero(~shown if log else np.maximum(across / right, up / top) < NEAR).tolist()
    if not log and not 2 <= len(near) < len(names):  # names hide one another where several crowd next to 0
        near = []
    beyond = (xlow < left) | (xhigh > right) | (ylow < bottom) | (yhigh > top)
    shown_names = tuple("" if i in near else name for i, name in enumerate(names))
    sources = ((source, source),) * len(names)
    points = Points("", across, up, shown_names, 0, xlow, xhigh, ylow, yhigh, sources)
    line = np.array([max(left, bottom), min(right, top)])
    scale: Literal["log", "linear"] = "log" if log else "linear"
    panel = Panel(
        with_unit(SIGMA, unit),
        (points, Series(Relation(SIGMA, "=", MU_STAR), line, line, "bound")),
        xlabel=with_unit(MU_STAR, unit),
        xlim=(left, right),
        ylim=(bottom, top),
        xscale=scale,
        yscale=scale,
        title=title,
    )
    return panel, near, bool(beyond.any())


def _interval(estimate: Estimate) -> tuple[Array, Array, float]:
    """The ends of the intervals, and the end of an axis that shows the values and most of their intervals."""
    low, high = np.maximum(estimate.low, 0.0), estimate.high
    largest = float(estimate.value.max())
    ends = high[np.isfinite(high)]
    reach = min(float(ends.max(initial=largest)), MOST * largest)
    return low, high, 1.06 * reach if reach > 0 else 1.0


def _named_near(near: tuple[list[int], ...], names: tuple[Label, ...], where: str) -> tuple[Phrase, ...]:
    """A sentence for each panel whose smallest factors are named here."""
    said: list[Phrase] = []
    for letter, places in zip("abcdefghijklmnopqrstuvwxyz", near, strict=False):
        if places:
            listed = [part for k, i in enumerate(places) for part in (*([", "] if k else []), *parts(names[i]))]
            said.append((where, f" in ({letter})" if len(near) > 1 else "", ": ", *listed, "."))
    return tuple(said)


def _moments(one: MorrisEffects) -> list[tuple[Cell, ...]]:
    rows: list[tuple[Cell, ...]] = []
    for i in np.argsort(-one.mu_star.value, kind="stable"):
        moments = [(part.value[i], part.half[i]) for part in (one.mu_star, one.sigma, one.mu)]
        rows.append((one.names[0], one.factors[i], *(number(value) for pair in moments for value in pair)))
    return rows


@check_arguments
def tornado_figure(
    name: str, caption: Phrase, tornado: Tornado, note: Note, unit: str = "", *, labels: Labels = None
) -> Figure:
    """Two bars per factor, from the output of the base point: its lowest level above, its highest level below.

    Each output has its own panel, with its own order of the factors.

    Raises
    ------
    ValueError
        If the note is empty.

    Examples
    --------
    >>> from workbench.report.pictures import tornado_figure
    >>> from workbench.study.uncertainty import OneAtATime, tornado
    >>> design = OneAtATime(2)
    >>> swings = tornado(design, design.points() @ [1.0, 2.0], factors=("k", "m"))
    >>> tornado_figure("tornado", "Who decides", swings, "4 runs", labels={"k": "stiffness"}).name
    'tornado'
    """
    single = each(tornado)
    levels = [TableColumn(_level(level), unit) for level in tornado.levels]
    heads: tuple[str | TableColumn, ...] = (
        "output",
        "factor",
        TableColumn("base", unit),
        *levels,
        TableColumn("swing", unit),
    )
    rows = (
        (
            one.names[0],
            one.factors[i],
            number(float(one.base)),
            *map(number, one.moved_outputs[i]),
            number(one.swing[i]),
        )
        for one in single
        for i in one.order
    )
    sources = sources_of("tornado_figure", tornado.names, note)
    panels = (_bars(one, unit, labels, sources.get(one.names[0])) for one in single)
    remarks = refusals(tornado)
    return picture("tornado_figure", name, caption, note, panels, heads, rows, remarks, names=tornado.names)


def _bars(tornado: Tornado, unit: str, labels: Labels, source: Source | None) -> Panel:
    order, base = tornado.order, float(tornado.base)
    lowest, highest = int(np.argmin(tornado.levels)), int(np.argmax(tornado.levels))
    rows, moved = np.arange(len(order), dtype=float), tornado.moved_outputs[order]
    start, sources = np.full(len(order), base), (source,) * len(order)
    both = ((lowest, -LEVEL / 2, 0.25), (highest, LEVEL / 2, 1.0))
    marks = tuple(
        Bars(_level(tornado.levels[k]), rows + aside, moved[:, k], start, shade=shade, thick=LEVEL, sources=sources)
        for k, aside, shade in both[lowest == highest :]  # one level alone has one bar
    )
    return Panel(
        "",
        marks,
        xlabel=with_unit(label_of(tornado.names[0], labels), unit),
        vlines=(base,),
        ynames=tuple(label_of(tornado.factors[i], labels) for i in order),
    )


def _level(level: float) -> str:
    ends = {0.0: "at the low end of its range", 1.0: "at the high end of its range"}
    return ends.get(float(level), f"at its {100 * level:g} % quantile")
