"""Figures by matplotlib's axes, for a notebook or beside drawings of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from workbench.report.cleaning import cleaned
from workbench.report.figures.axes_marks import add_bars, add_map, add_points, add_tiles
from workbench.report.figures.labels import written
from workbench.report.figures.legend import across, entries
from workbench.report.figures.looks import (
    GREY,
    LINES,
    MARKS,
    POINTS_LOOK,
    below,
    house_style,
    layer_of,
    letter_of,
    line_of,
    points_of,
    shares_abscissa,
)
from workbench.report.figures.marks import EDGE, tint
from workbench.report.figures.rulers import rulers
from workbench.report.figures.sizes import led, size_of
from workbench.report.figures.tiles import FRAME, tone
from workbench.report.thinning import thinned, windowed
from workbench.study.document.curves import Array, Band, Series
from workbench.study.document.document import Figure
from workbench.study.document.panel import Panel
from workbench.study.document.shapes import Bars, HeatMap, Mark, Points, Tiles

CROWDED = 60  # letters of names side by side below a panel


def plot(figure: Figure, axes: Axes | Sequence[Axes] | npt.NDArray[Any] | None = None) -> Canvas:
    """A figure drawn by matplotlib: on a canvas of its own, or on axes that are given.

    Parameters
    ----------
    axes
        One for each panel, in order, row by row; a single one need not be in a list. Their style is left alone, as
        is the legend's place.

    Raises
    ------
    ValueError
        If there is not one pair of axes for each panel.
    """
    figure = cleaned(figure)
    if axes is not None:
        given = np.ravel(np.asarray(axes, dtype=object)).tolist()
        if len(given) != len(figure.panels):
            raise ValueError(
                f"`plot('{figure.name}', axes)` needs one pair of axes for each of {len(figure.panels)} "
                f"panels; got {len(given)}."
            )
        for i, ax in enumerate(given):
            _draw_panel(figure, i, ax)
        return _canvas_of(given[0])
    with house_style():
        return _plot_alone(figure)


def _plot_alone(figure: Figure) -> Canvas:
    engine = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.04, wspace=0.02, hspace=0.02)
    canvas = Canvas(figsize=size_of(figure), layout=engine)
    places = _places(figure, canvas)
    for i, panel in enumerate(figure.panels):
        ax = canvas.add_subplot(places[i])
        _draw_panel(figure, i, ax)
        if len(figure.panels) > 1:
            ax.set_title(f"{letter_of(figure, i)} {written(panel.title)}".rstrip(), loc="left")
        if below(figure, i) is not None and shares_abscissa(figure):
            ax.set_xlabel("")
    _add_legend(canvas, figure)
    return canvas


def _places(figure: Figure, canvas: Canvas) -> list[Any]:
    """Where each panel stands."""
    rows = -(-(len(figure.panels) - figure.lead) // figure.columns)
    heights = [1.0] * rows
    if figure.lead:
        lead, rest = led(figure)
        heights = [lead, *[rest / max(rows, 1)] * rows]
    grid = canvas.add_gridspec(len(heights), figure.columns, height_ratios=heights)
    lower = [
        grid[figure.lead + k // figure.columns, k % figure.columns] for k in range(len(figure.panels) - figure.lead)
    ]
    return [grid[0, :], *lower] if figure.lead else lower


def _draw_panel(figure: Figure, i: int, ax: Axes) -> None:
    panel = figure.panels[i]
    ax.set_xscale(panel.xscale)
    ax.set_yscale(panel.yscale)
    for at in panel.hlines:
        ax.axhline(at, color="#555555", linewidth=0.6, zorder=1.5)
    for at in panel.vlines:
        ax.axvline(at, color="#555555", linewidth=0.6, zorder=1.5)
    if any(isinstance(mark, Bars | Points | HeatMap | Tiles) for mark in panel.series):
        _set_limits(figure, i, ax)
    for k, mark in enumerate(panel.series):
        _draw_mark(mark, ax, panel, points_of(figure), layer_of(k, panel))
    if panel.xlim:
        ax.set_xlim(*panel.xlim)
    if panel.ylim:
        ax.set_ylim(*panel.ylim)
    ax.set_xlabel(written(panel.xlabel))
    ax.set_ylabel(written(panel.ylabel))
    if panel.title:
        ax.set_title(written(panel.title), loc="left")


def _set_limits(figure: Figure, i: int, ax: Axes) -> None:
    """What a drawing spans, with its names: matplotlib would choose limits of its own around bars and cells."""
    x, y = rulers(figure, i, [() for _ in figure.panels[i].series])
    ax.set_xlim(x.low, x.high)
    ax.set_ylim(y.low, y.high)
    if x.names:
        upright = max(map(len, x.names)) * len(x.names) > CROWDED
        ax.set_xticks(range(len(x.names)), x.names, rotation=90 if upright else 0)
    if y.names:
        ax.set_yticks(range(len(y.names)), y.names, linespacing=0.9)
    for axis, ruler in ((ax.xaxis, x), (ax.yaxis, y)):
        if ruler.names:
            axis.set_tick_params(length=0)
            axis.grid(False)


def _draw_mark(mark: Mark, ax: Axes, panel: Panel, points: int, layer: float) -> None:
    match mark:
        case Band():
            _draw_band(mark, ax, thinned(windowed(mark.curves, panel.xlim), points), layer)
        case Series():
            _draw_series(mark, ax, thinned(windowed(mark.curves, panel.xlim), points), layer)
        case Bars():
            add_bars(mark, ax, layer)
        case Points():
            add_points(mark, ax, layer)
        case HeatMap():
            add_map(mark, ax, layer)
        case Tiles():
            add_tiles(mark, ax, layer)


def _draw_series(series: Series, ax: Axes, curves: tuple[Array, ...], zorder: float) -> None:
    x, y = curves
    look = dict(LINES[series.style])
    if series.look == "marks":
        look |= MARKS
        ax.margins(x=0.05)
    else:
        look = line_of(series, y) | {"marker": "none"}
        look["drawstyle"] = "steps-post" if series.look == "steps" else "default"
    ax.plot(x, y, label=written(series.label) or "_", zorder=zorder, **look)


def _draw_band(band: Band, ax: Axes, curves: tuple[Array, ...], zorder: float) -> None:
    x, low, high = curves
    look = LINES[band.style]
    ax.fill_between(x, low, high, color=look["color"], alpha=0.22, linewidth=0, zorder=zorder)
    edge = {"color": look["color"], "linestyle": look["linestyle"], "linewidth": 0.5, "zorder": zorder + 0.05}
    ax.plot(x, low, label="_", **edge)
    ax.plot(x, high, label="_", **edge)


def _add_legend(canvas: Canvas, figure: Figure) -> None:
    """One legend for all panels, above them, so that it never covers a curve."""
    names = entries(figure)
    if not names:
        return
    columns = across(names)
    # Matplotlib fills a legend column by column; one reads it row by row.
    order = [name for i in range(columns) for name in list(names)[i::columns]]
    canvas.legend([_handle(names[name]) for name in order], order, loc="outside upper center", ncols=columns)


def _handle(mark: Mark) -> Any:
    look = dict(LINES[mark.style])
    match mark:
        case Band():
            return Patch(facecolor=look["color"], alpha=0.3, linewidth=0)
        case Tiles():
            shade = float(np.nanmax(mark.shades)) if np.isfinite(mark.shades).any() else 0.0
            if np.any(mark.marked):
                return Line2D([], [], color="k", linestyle="none", marker=">")
            edge = {"edgecolor": "k", "linewidth": FRAME} if np.any(mark.framed) else {"edgecolor": GREY}
            return Patch(facecolor=tone(shade), hatch="////" if np.any(mark.hatched) else None, **edge)
        case Bars():
            return Patch(facecolor=tint(mark.style, mark.shade), edgecolor=look["color"], linewidth=EDGE)
        case Points():
            return Line2D([], [], **(look | MARKS | POINTS_LOOK))
        case Series() if mark.look == "marks":
            return Line2D([], [], **(look | MARKS))
    return Line2D([], [], **(look | {"marker": "none"}))


def _canvas_of(ax: Axes) -> Canvas:
    canvas = ax.figure
    while not isinstance(canvas, Canvas):
        canvas = canvas.figure
    return canvas
