"""The look of figures: sizes, letters, and a line for each law that black and white can tell apart."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypedDict

import matplotlib as mpl
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.report.table_text import plain
from workbench.study.document.figure import Area, Band, Bars, Figure, Guides, Label, Panel, Series, Style, Tiles

TIME = "time ["  # as the label of an abscissa begins that is the time
WIDTH = 6.3  # inches: the text width of an A4 page with margins of 25 mm
LETTERS, SMALL_LETTERS, LEGEND_LETTERS = 9.0, 8.0, 8.5  # points
TICK = 3.0  # points: a mark at an axis
PAD = 3.5  # points from it to its number
LABEL = 3.0  # points from the numbers to what they measure
TITLE = 4.0  # points from a title to its panel
POINTS = 600  # drawn of one series; all series of a figure share BUDGET points
BUDGET = 5400


class LineStyle(TypedDict, total=False):
    """The look of a line or of marks: lengths in points, dashes as '-' or an offset with their lengths."""

    color: str
    linestyle: str | tuple[float, tuple[float, ...]]
    linewidth: float
    marker: str
    markersize: float
    markeredgewidth: float


# All that is asked of matplotlib, which makes letters and numbers; the rest is its default.
RULES: Any = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    "svg.hashsalt": "control-workbench",
}

# Okabe and Ito's colours without their yellow, which no paper shows, and four darker ones; each with a dash and a width
# of its own, so that a photocopy still tells the laws apart.
LINES: dict[Style, LineStyle] = {
    0: {"color": "#0072B2", "linestyle": "-", "linewidth": 1.5, "marker": "o"},
    1: {"color": "#D55E00", "linestyle": (0, (5, 1.6)), "linewidth": 1.2, "marker": "s"},
    2: {"color": "#009E73", "linestyle": (0, (6, 1.5, 1.2, 1.5)), "linewidth": 1.2, "marker": "^"},
    3: {"color": "#CC79A7", "linestyle": (0, (1.2, 1.2)), "linewidth": 1.6, "marker": "D"},
    4: {"color": "#E69F00", "linestyle": (0, (9, 2)), "linewidth": 1.0, "marker": "v"},
    5: {"color": "#56B4E9", "linestyle": (0, (2.6, 1.3)), "linewidth": 1.2, "marker": "P"},
    6: {"color": "#000000", "linestyle": "-", "linewidth": 0.7, "marker": "x"},
    7: {"color": "#777777", "linestyle": (0, (6, 1.4, 1.2, 1.4, 1.2, 1.4)), "linewidth": 1.1, "marker": "*"},
    8: {"color": "#882255", "linestyle": (0, (1.2, 2.4)), "linewidth": 1.4, "marker": "p"},
    9: {"color": "#332288", "linestyle": (0, (9, 1.4, 3, 1.4)), "linewidth": 1.1, "marker": "<"},
    10: {"color": "#7A4A00", "linestyle": (0, (3.5, *7 * (1.2,))), "linewidth": 1.1, "marker": ">"},
    11: {"color": "#6B6B00", "linestyle": (0, (4, 3)), "linewidth": 1.3, "marker": "h"},
    "reference": {"color": "#b4b4b4", "linestyle": "-", "linewidth": 3.0, "marker": "o"},
    "bound": {"color": "#000000", "linestyle": (0, (1, 2)), "linewidth": 0.9, "marker": "_"},
    "aid": {"color": "#666666", "linestyle": (0, (4, 2)), "linewidth": 0.8, "marker": "+"},
}
POINTED: dict[str, LineStyle] = {  # the looks of a series that has no line
    "marks": {"markersize": 3.8, "markeredgewidth": 0.8},
    "dots": {"marker": "o", "markersize": 1.3, "markeredgewidth": 1.3},
}
POINTS_LOOK: LineStyle = {"markersize": 4.2, "markeredgewidth": 1.2}
SHAPES: dict[str, LineStyle] = {  # of the points that have a shape of their own
    "": {},
    "pole": {"marker": "x", "markersize": 5.6},
    "zero": {"marker": "o", "markersize": 5.6},
    "critical": {"marker": "+", "markersize": 6.4, "markeredgewidth": 1.0},
}
GREY = "#aaaaaa"  # the lines between cells
MAX_NAME_WIDTH = 0.36  # of a figure's width, at most, for the names of its rows


@contextmanager
def house_style() -> Iterator[None]:
    """The settings of matplotlib for this file's style, independent of the machine's own."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(RULES)
        yield


def points_of(figure: Figure) -> int:
    """The number of points that are drawn of each series."""
    series = sum(len(panel.series) for panel in figure.panels)
    return max(120, min(POINTS, BUDGET // series))


def shares_abscissa(figure: Figure) -> bool:
    """True if all panels have the same abscissa, which is then named below the last row alone."""
    return len({(str(panel.xlabel), panel.xlim, panel.xscale, panel.xcut) for panel in figure.panels}) == 1


def said_on_axis(panel: Panel) -> Label:
    """The label of an abscissa, with the words that an uneven time axis needs."""
    label = plain(panel.xlabel)
    words = ""
    if panel.xcut is not None:
        unit = label.rpartition("[")[2].rstrip("]") if label.endswith("]") else ""
        words = f", compressed after {panel.xcut:g} {unit}".rstrip()
    elif panel.xscale == "log" and label.startswith(TIME):
        words = ", logarithmic"
    if not words:
        return panel.xlabel
    return (*(panel.xlabel if isinstance(panel.xlabel, tuple) else (panel.xlabel,)), words)


def shares_rows(figure: Figure) -> bool:
    """True if all panels name the same rows, which is then done beside the first column alone."""
    return len({str(panel.ynames) for panel in figure.panels}) == 1


def column_of(figure: Figure, i: int) -> int:
    """The column in which a panel stands."""
    return (i - figure.lead) % figure.columns if i or not figure.lead else 0


def below(figure: Figure, i: int) -> Panel | None:
    """The panel below another; none stands in the columns below the one that leads."""
    under = i + figure.columns
    return figure.panels[under] if under < len(figure.panels) and (i or not figure.lead) else None


def layer_of(i: int, panel: Panel) -> float:
    """The layer of a mark: areas below lines, references below all laws, bounds above them, the first law on top.

    Lines that help to read lie below those of the laws, and guides behind all else.
    """
    mark, below = panel.series[i], {"reference": 2.0, "bound": 3.5, "aid": 1.95}
    if isinstance(mark, Guides):
        return 0.5
    layer = below.get(str(mark.style), 3.0 - i / len(panel.series))
    return layer - 0.9 if isinstance(mark, Band | Bars | Tiles | Area) else layer


def line_of(series: Series, y: Array) -> LineStyle:
    """The line of a series with the ordinates y, thin where these cover their own range many times over."""
    numbers = y[np.isfinite(y)]
    chatters = len(numbers) > 100 and bool(np.abs(np.diff(numbers)).sum() > 20 * np.ptp(numbers))
    return LINES[series.style] | ({"linestyle": "-", "linewidth": 0.5} if chatters else {})


def letter_of(figure: Figure, i: int) -> str:
    """The letter of a panel: '(a)'; a single panel needs no letter."""
    return f"({'abcdefghijklmnopqrstuvwxyz'[i % 26]})" if len(figure.panels) > 1 else ""
