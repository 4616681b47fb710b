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
from workbench.report.figures.labels import written
from workbench.report.figures.legend import across, entries
from workbench.report.figures.looks import (
    LINES,
    MARKS,
    house_style,
    layer_of,
    letter_of,
    line_of,
    points_of,
    shares_abscissa,
    size_of,
)
from workbench.report.thinning import thinned, windowed
from workbench.study.curves import Array, Band, Panel, Series
from workbench.study.document import Figure


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
        for panel, ax in zip(figure.panels, given, strict=True):
            _draw_panel(panel, ax, points_of(figure))
        return _canvas_of(given[0])
    with house_style():
        return _plot_alone(figure)


def _plot_alone(figure: Figure) -> Canvas:
    rows = -(-len(figure.panels) // figure.columns)
    engine = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.04, wspace=0.02, hspace=0.02)
    canvas = Canvas(figsize=size_of(figure), layout=engine)
    for i, panel in enumerate(figure.panels):
        ax = canvas.add_subplot(rows, figure.columns, i + 1)
        _draw_panel(panel, ax, points_of(figure))
        if len(figure.panels) > 1:
            ax.set_title(f"{letter_of(figure, i)} {written(panel.title)}".rstrip(), loc="left")
        if i + figure.columns < len(figure.panels) and shares_abscissa(figure):
            ax.set_xlabel("")
    _add_legend(canvas, figure)
    return canvas


def _draw_panel(panel: Panel, ax: Axes, points: int) -> None:
    ax.set_xscale(panel.xscale)
    ax.set_yscale(panel.yscale)
    for at in panel.hlines:
        ax.axhline(at, color="#555555", linewidth=0.6, zorder=1.5)
    for at in panel.vlines:
        ax.axvline(at, color="#555555", linewidth=0.6, zorder=1.5)
    for i, series in enumerate(panel.series):
        layer = layer_of(i, panel)
        curves = thinned(windowed(series.curves, panel.xlim), points)
        if isinstance(series, Band):
            _draw_band(series, ax, curves, layer)
        else:
            _draw_series(series, ax, curves, layer)
    if panel.xlim:
        ax.set_xlim(*panel.xlim)
    if panel.ylim:
        ax.set_ylim(*panel.ylim)
    ax.set_xlabel(written(panel.xlabel))
    ax.set_ylabel(written(panel.ylabel))
    if panel.title:
        ax.set_title(written(panel.title), loc="left")


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
    ax.fill_between(x, low, high, color=look["color"], alpha=0.22, linewidth=0, zorder=zorder - 0.9)
    edge = {"color": look["color"], "linestyle": look["linestyle"], "linewidth": 0.5, "zorder": zorder - 0.85}
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


def _handle(series: Series | Band) -> Any:
    look = dict(LINES[series.style])
    if isinstance(series, Band):
        return Patch(facecolor=look["color"], alpha=0.3, linewidth=0)
    marks = series.look == "marks"
    return Line2D([], [], **(look | MARKS if marks else look | {"marker": "none"}))


def _canvas_of(ax: Axes) -> Canvas:
    canvas = ax.figure
    while not isinstance(canvas, Canvas):
        canvas = canvas.figure
    return canvas
