"""Figures in one style, readable in black and white: the only door to matplotlib."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure as Canvas
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from matplotlib.mathtext import MathTextParser
from matplotlib.patches import Patch

from workbench.notation import latex, text
from workbench.report.cleaning import cleaned
from workbench.report.thinning import thinned, windowed
from workbench.study.curves import Array, Band, Label, Panel, Series, Style
from workbench.study.document import Figure

WIDTH = 6.3  # inches: the text width of an A4 page with margins of 25 mm
POINTS = 600  # drawn of one series; all series of a figure share BUDGET points
BUDGET = 5400

RULES: Any = {
    "font.family": "STIXGeneral",
    "font.size": 9,
    "mathtext.fontset": "stix",
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "axes.linewidth": 0.5,
    "axes.titlepad": 4,
    "axes.labelpad": 3,
    "axes.xmargin": 0,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    "axes.unicode_minus": True,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.4,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "legend.handletextpad": 0.5,
    "legend.columnspacing": 1.3,
    "legend.borderaxespad": 0.2,
    "lines.dash_capstyle": "butt",
    "path.simplify": True,
    "svg.fonttype": "path",
    "svg.hashsalt": "control-workbench",
    "text.usetex": False,
}

# Okabe and Ito's colours without their yellow, which no paper shows; each with a dash and a width of
# its own, so that a photocopy still tells the laws apart.
_LINES: dict[Style, dict[str, Any]] = {
    0: {"color": "#0072B2", "linestyle": "-", "linewidth": 1.5, "marker": "o"},
    1: {"color": "#D55E00", "linestyle": (0, (5, 1.6)), "linewidth": 1.2, "marker": "s"},
    2: {"color": "#009E73", "linestyle": (0, (6, 1.5, 1.2, 1.5)), "linewidth": 1.2, "marker": "^"},
    3: {"color": "#CC79A7", "linestyle": (0, (1.2, 1.2)), "linewidth": 1.6, "marker": "D"},
    4: {"color": "#E69F00", "linestyle": (0, (9, 2)), "linewidth": 1.0, "marker": "v"},
    5: {"color": "#56B4E9", "linestyle": (0, (2.6, 1.3)), "linewidth": 1.2, "marker": "P"},
    6: {"color": "#000000", "linestyle": "-", "linewidth": 0.7, "marker": "x"},
    7: {"color": "#777777", "linestyle": (0, (6, 1.4, 1.2, 1.4, 1.2, 1.4)), "linewidth": 1.1, "marker": "*"},
    "reference": {"color": "#b4b4b4", "linestyle": "-", "linewidth": 3.0, "marker": "o"},
    "bound": {"color": "#000000", "linestyle": (0, (1, 2)), "linewidth": 0.9, "marker": "_"},
}


_MARKS: dict[str, Any] = {
    "linestyle": "none",
    "markersize": 3.8,
    "markerfacecolor": "none",
    "markeredgewidth": 0.8,
}


def draw(figure: Figure) -> str:
    """A figure as the text of an SVG: the same figure, the same bytes.

    Its letters are outlines, so it looks the same on every machine; its ids begin with the figure's
    name, so many such figures can stand in one page.
    """
    figure = cleaned(figure)
    with _house_style():
        out = io.StringIO()
        canvas = FigureCanvasSVG(_plot_alone(figure))
        canvas.print_figure(out, format="svg", metadata={"Date": None, "Creator": None})
    return _tidied(out.getvalue(), figure.name)


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
            _draw_panel(panel, ax, _points(figure))
        return _canvas_of(given[0])
    with _house_style():
        return _plot_alone(figure)


@contextmanager
def _house_style() -> Iterator[None]:
    """Our rules and nobody else's: what a machine's own settings of matplotlib say is put aside."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(RULES)
        yield


def _plot_alone(figure: Figure) -> Canvas:
    rows = -(-len(figure.panels) // figure.columns)
    height = {1: 2.4, 2: 2.0, 3: 1.8}[figure.columns] * (1 if rows == 1 else 0.86)
    engine = ConstrainedLayoutEngine(w_pad=0.05, h_pad=0.04, wspace=0.02, hspace=0.02)
    canvas = Canvas(figsize=(WIDTH, rows * height + 0.35), layout=engine)
    for i, panel in enumerate(figure.panels):
        ax = canvas.add_subplot(rows, figure.columns, i + 1)
        _draw_panel(panel, ax, _points(figure))
        if len(figure.panels) > 1:
            ax.set_title(f"({'abcdefghijklmnopqrstuvwxyz'[i % 26]}) {_label(panel.title)}".rstrip(), loc="left")
        if i + figure.columns < len(figure.panels) and _same_abscissa(figure):
            ax.set_xlabel("")
    _add_legend(canvas, figure)
    return canvas


def _same_abscissa(figure: Figure) -> bool:
    return len({(str(panel.xlabel), panel.xlim, panel.xscale) for panel in figure.panels}) == 1


def _points(figure: Figure) -> int:
    series = sum(len(panel.series) for panel in figure.panels)
    return max(120, min(POINTS, BUDGET // series))


def _draw_panel(panel: Panel, ax: Axes, points: int) -> None:
    ax.set_xscale(panel.xscale)
    ax.set_yscale(panel.yscale)
    for at in panel.hlines:
        ax.axhline(at, color="#555555", linewidth=0.6, zorder=1.5)
    for at in panel.vlines:
        ax.axvline(at, color="#555555", linewidth=0.6, zorder=1.5)
    for i, series in enumerate(panel.series):
        below = {"reference": 2.0, "bound": 3.5}.get(str(series.style), 3.0 - i / len(panel.series))
        curves = thinned(windowed(series.curves, panel.xlim), points)
        if isinstance(series, Band):
            _draw_band(series, ax, curves, below)
        else:
            _draw_series(series, ax, curves, below)
    if panel.xlim:
        ax.set_xlim(*panel.xlim)
    if panel.ylim:
        ax.set_ylim(*panel.ylim)
    ax.set_xlabel(_label(panel.xlabel))
    ax.set_ylabel(_label(panel.ylabel))
    if panel.title:
        ax.set_title(_label(panel.title), loc="left")


def _draw_series(series: Series, ax: Axes, curves: tuple[Array, ...], zorder: float) -> None:
    x, y = curves
    look = dict(_LINES[series.style])
    if series.look == "marks":
        look |= _MARKS
        ax.margins(x=0.05)
    else:
        look |= {"marker": "none", "drawstyle": "steps-post" if series.look == "steps" else "default"}
        if _chatters(y):  # dashes would only make patterns, and a thick line would hide the band
            look |= {"linestyle": "-", "linewidth": 0.5}
    ax.plot(x, y, label=_label(series.label) or "_", zorder=zorder, **look)


def _chatters(y: Array) -> bool:
    """Whether a thinned curve covers its own range many times over."""
    numbers = y[np.isfinite(y)]
    return len(numbers) > 100 and bool(np.abs(np.diff(numbers)).sum() > 20 * np.ptp(numbers))


def _draw_band(band: Band, ax: Axes, curves: tuple[Array, ...], zorder: float) -> None:
    x, low, high = curves
    look = _LINES[band.style]
    ax.fill_between(x, low, high, color=look["color"], alpha=0.22, linewidth=0, zorder=zorder - 0.9)
    edge = {"color": look["color"], "linestyle": look["linestyle"], "linewidth": 0.5, "zorder": zorder - 0.85}
    ax.plot(x, low, label="_", **edge)
    ax.plot(x, high, label="_", **edge)


def _add_legend(canvas: Canvas, figure: Figure) -> None:
    """One legend for all panels, above them, so that it never covers a curve.

    What is named by the title of its panel needs no line in it.
    """
    handles: dict[str, Any] = {}
    for panel in figure.panels:
        for series in panel.series:
            if series.label and series.label != panel.title:
                handles.setdefault(_label(series.label), _handle(series))
    if not handles:
        return
    letters = [len(re.sub(r"[\\${}]", "", label)) for label in handles]
    rows = -(-sum(0.065 * n + 0.5 for n in letters) // WIDTH)
    across = -(-len(handles) // int(rows))
    # Matplotlib fills a legend column by column; one reads it row by row.
    order = [label for i in range(across) for label in list(handles)[i::across]]
    canvas.legend([handles[label] for label in order], order, loc="outside upper center", ncols=across)


def _handle(series: Series | Band) -> Any:
    look = dict(_LINES[series.style])
    if isinstance(series, Band):
        return Patch(facecolor=look["color"], alpha=0.3, linewidth=0)
    marks = series.look == "marks"
    return Line2D([], [], **(look | _MARKS if marks else look | {"marker": "none"}))


def _label(label: Label) -> str:
    """A label in the words of matplotlib: what is text stays text, dollars and all."""
    pieces = label if isinstance(label, tuple) else (label,)
    return "".join(p.replace("$", r"\$") if isinstance(p, str) else _mathtext(p) for p in pieces)


def _mathtext(formula: Any) -> str:
    """A formula between dollars; as plain text if matplotlib cannot set it, as with a matrix."""
    written = f"${latex.emit(formula, width=math.inf)}$"
    try:
        MathTextParser("path").parse(written)
    except ValueError:
        return text.emit(formula).replace("$", r"\$")
    return written


def _canvas_of(ax: Axes) -> Canvas:
    canvas = ax.figure
    while not isinstance(canvas, Canvas):
        canvas = canvas.figure
    return canvas


def _tidied(svg: str, name: str) -> str:
    """The SVG element alone, its ids below `name`, its coordinates to a hundredth of a point."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r"\n\s+", "\n", svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # nothing points to a group
    svg = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", svg)
    head, *paths = re.split(r'(?=\bd=")', svg)
    rounded = [_rounded(path) for path in paths]
    return head + "".join(rounded)


def _rounded(path: str) -> str:
    data, quote, rest = path[3:].partition('"')
    data = re.sub(r"-?\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), data)
    return f'd="{" ".join(data.split())}{quote}{rest}'
