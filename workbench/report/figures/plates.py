"""A drawn figure with its plate: the geometry of its panels as plain data, from which a script draws curves again."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypedDict

from workbench.core.validation.refusals import Array
from workbench.report.figures.boxes import ink_on, tint
from workbench.report.figures.pen import Rectangle
from workbench.report.figures.rulers import Ruler, Ticks
from workbench.report.figures.style import LABEL, LINES, PAD, SMALL_LETTERS, TICK, TIME, points_of
from workbench.report.table_text import plain
from workbench.study.document.figure import Bars, Figure, Mark, Panel, Points, Series, Tiles


class PanelPlate(TypedDict):
    """A panel of a plate."""

    box: list[float]
    x: dict[str, object]
    y: dict[str, object]
    equal: bool
    series: list[dict[str, object]]


class Plate(TypedDict):
    """The geometry of a figure as plain data, which `FigureSheet` describes."""

    width: float
    height: float
    letters: dict[str, float]
    points: int
    panels: list[PanelPlate]


@dataclass(frozen=True)
class FigureSheet:
    """A figure as the text of an SVG, and its `plate`, which JSON can hold; lengths are in points.

    A plate has the `width` and the `height` of the sheet; the `letters` of the numbers at rulers: their `size`, the
    length `tick` of a mark and the `pad` from it to its number; `points`, to how many a series is thinned; `panels`.
    A panel has its `box` [left, bottom, width, height], from the lower left corner of the sheet; its `series`, each
    with `color`, `width`, `dash` (lengths, empty for a whole line), `look` ('line', 'steps', 'marks' or 'dots'; of a
    mark that is no series the name of its kind) and `label`; and two rulers, `x` and `y`, each with `scale` ('linear'
    or 'log'), `low` and `high`, `cut` (the number in the middle of an uneven one, else None), `fixed` (True if curves
    have no say in them), `steps` that its numbers should have, if any, `room` for the width of its numbers, and
    `power` (True if there is a power of ten at its end). `time` of an abscissa is True if it is the time. `equal` of a
    panel is True if a unit is as long across as upwards. Bars have their `places`, `starts`, `ends` (None without a
    bar), `thick`, `texts`, their `fill` and the `ink` of the texts; points have `x` and `y`, None for a gap, and their
    `shape`.
    """

    svg: str
    plate: Plate


def plate_of(
    figure: Figure,
    width: float,
    height: float,
    panels: Iterable[tuple[Panel, Rectangle, Ruler, Ruler, tuple[Ticks, Ticks]]],
) -> Plate:
    """The plate of a figure on a sheet of a width and height: its panels with their boxes, rulers and marks."""
    return {
        "width": width,
        "height": height,
        "letters": {"size": SMALL_LETTERS, "tick": TICK, "pad": PAD},
        "points": points_of(figure),
        "panels": [_panel(*placed) for placed in panels],
    }


def _panel(panel: Panel, box: Rectangle, x: Ruler, y: Ruler, ticks: tuple[Ticks, Ticks]) -> PanelPlate:
    still = any(isinstance(mark, Tiles) for mark in panel.series)
    linear, equal = any(map(_is_linear, panel.series)), panel.aspect == "equal"  # whose limits are those of what moves
    across = still or (panel.xlim is not None and not (linear and equal))
    return {
        "box": [float(length) for length in (box.left, box.bottom, box.width, box.height)],
        "x": _ruler(x, ticks[0], across) | {"time": plain(panel.xlabel).startswith(TIME)},
        "y": _ruler(y, ticks[1], still or (panel.ylim is not None and not linear)),
        "equal": equal,
        "series": [_series(mark) for mark in panel.series],
    }


def _is_linear(mark: Mark) -> bool:
    """True for a mark that shows a linear answer of a loop."""
    if isinstance(mark, Series):
        return mark.sources is not None and mark.sources[1].kind == "linear"
    pair = mark.sources[0] if isinstance(mark, Points) and mark.sources else (None, None)
    return pair[1] is not None and pair[1].kind == "linear"


def _ruler(ruler: Ruler, ticks: Ticks, fixed: bool) -> dict[str, object]:
    return {
        "scale": ruler.scale,
        "low": float(ruler.low),
        "high": float(ruler.high),
        "cut": ruler.cut,
        "fixed": fixed or bool(ruler.names),
        "steps": list(ruler.steps),
        "room": round(ticks.width + LABEL, 2),
        "power": bool(ticks.power),
    }


def _series(mark: Mark) -> dict[str, object]:
    look = LINES[mark.style]
    dash = look["linestyle"]
    dashes = dash[1] if isinstance(dash, tuple) else ()
    return {
        "color": look["color"],
        "width": look["linewidth"],
        "dash": [round(look["linewidth"] * length, 3) for length in dashes],
        "look": mark.look if isinstance(mark, Series) else type(mark).__name__.lower(),
        "label": plain(mark.label),
    } | _numbers(mark)


def _numbers(mark: Mark) -> dict[str, object]:
    """The numbers and the colours of bars, and the numbers of points."""
    if isinstance(mark, Bars):
        held = {"places": mark.places.tolist(), "starts": mark.starts.tolist(), "ends": _with_gaps(mark.ends)}
        look = {"fill": tint(mark.style, mark.shade), "ink": ink_on(mark.style, mark.shade)}
        return held | {"thick": mark.thick, "texts": list(mark.texts)} | look
    if isinstance(mark, Points):
        return {"x": _with_gaps(mark.x), "y": _with_gaps(mark.y), "shape": mark.shape}
    return {}


def _with_gaps(numbers: Array) -> list[float | None]:
    return [number if number == number else None for number in numbers.tolist()]
