"""Bars, tiles with texts, and maps of cells with numbers, drawn by the pen.

The scale of tiles is of even lightness, which colour-blind eyes and grey prints keep.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.colors import to_hex, to_rgb

from workbench.core.validation.refusals import Array
from workbench.report.figures.pen import DIGIT, INK, Pen, Rectangle, edges, extent
from workbench.report.figures.rulers import Ruler
from workbench.report.figures.style import GREY, LINES, SMALL_LETTERS, LineStyle
from workbench.study.document.figure import Bars, Style, Tiles

CAP = 2.0  # points: half of the mark at the end of an interval
ARROW = 3.5  # points: the arrow of an interval that goes on beyond the panel
WHISKER: LineStyle = {"color": "#000000", "linewidth": 0.7}
EDGE = 0.6  # points: the outline of a bar
WHITE, DARKEST = np.array([100.0, 0.0, 0.0]), np.array([30.0, 2.0, -38.0])  # the ends of the scale, CIELAB
TURN = 50.0  # the lightness below which white letters are read better than black ones
SMALL = 0.9  # of the size of the first line of a text: that of the others
LEAD = 0.36  # of the size of a line: the gap above it
FRAME, THIN = 1.5, 0.09  # points, and of the lesser side of a small tile: the line around it
CORNER, LEAST = 0.3, 3.0  # of the lesser side of a tile, and points: the marked corner's side
STRIPE = 3.6  # points between the lines of a hatch
OUTLINE: LineStyle = {"color": GREY, "linewidth": 0.4}
HATCH = "#8c8c8c"


def tint(style: Style, shade: float) -> str:
    """A colour thinned with white: none of it at 0, all of it at 1."""
    red, green, blue = (1 - shade * (1 - part) for part in to_rgb(LINES[style]["color"]))
    return to_hex((red, green, blue))


def ink_on(style: Style, shade: float) -> str:
    """Black or white, whichever is read better on a tint."""
    red, green, blue = to_rgb(tint(style, shade))
    return "#ffffff" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.5 else INK


def draw_bars(pen: Pen, box: Rectangle, bars: Bars, x: Ruler, y: Ruler) -> None:
    """Bars with their texts, then their intervals."""
    starts, ends = (np.clip(x.share(part), 0, 1) for part in (bars.starts, bars.ends))
    thick = abs(float(y.share(bars.thick) - y.share(0.0))) * box.height
    left, middle = box.at(starts, y.share(bars.places))
    right, _ = box.at(ends, np.zeros_like(ends))
    there = np.flatnonzero(np.isfinite(ends)).tolist()
    for k in there:
        bar = edges(left[k], middle[k] - thick / 2, right[k], middle[k] + thick / 2)
        with pen.piece("mark", k):
            fill_box(pen, *bar, bars.style, bars.shade, box)
        text = bars.texts[k] if bars.texts else ""
        width = extent(text, SMALL_LETTERS).width if text else 0.0
        if text and width + 3 < abs(right[k] - left[k]):
            foot = middle[k] - DIGIT * SMALL_LETTERS / 2
            start = (left[k] + right[k] - width) / 2
            with pen.piece("words", k):
                pen.words(text, start, foot, SMALL_LETTERS, color=ink_on(bars.style, bars.shade))
    for k in there:
        with pen.piece("mark", k):
            draw_interval(pen, box, x, (bars.low, bars.high), k, middle[k])


def fill_box(pen: Pen, x: Array, y: Array, style: Style, shade: float, within: Rectangle | None = None) -> None:
    """A filled polygon with its outline."""
    pen.area(x, y, tint(style, shade), within=within)
    pen.line(x, y, {"color": LINES[style]["color"], "linewidth": EDGE}, within)


def draw_interval(
    pen: Pen,
    box: Rectangle,
    ruler: Ruler,
    ends: tuple[Array | None, Array | None],
    k: int,
    beside: float,
    upwards: bool = False,
) -> list[float]:
    """An interval along a ruler, capped where it ends and with an arrow where it goes on; returns its segment."""
    low, high = (float(np.asarray(end)[k]) for end in ends)
    if np.isnan(low) or np.isnan(high):
        return []
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = [end if np.isinf(end) else float(ruler.share(end)) for end in (low, high)]
    within = np.clip(shares, 0, 1)
    at = box.at(within, within)[upwards]

    def stroke(along: list[float], aside: list[float]) -> None:
        lengthwise, crosswise = np.array(along), beside + np.array(aside)
        x, y = (crosswise, lengthwise) if upwards else (lengthwise, crosswise)
        pen.line(x, y, WHISKER)

    stroke([at[0], at[1]], [0, 0])
    for end, share, inwards in zip(at, shares, (1, -1), strict=True):
        if -1e-9 <= share <= 1 + 1e-9:
            stroke([end, end], [-CAP, CAP])
        else:
            stroke([end + inwards * ARROW, end, end + inwards * ARROW], [-CAP, 0, CAP])
    return [beside, at[0], beside, at[1]] if upwards else [at[0], beside, at[1], beside]


def tone(shade: float) -> str:
    """The colour of a shade from 0, white, to 1, a dark blue: equal steps look equal, as they are so in CIELAB."""
    lightness, a, b = WHITE + shade * (DARKEST - WHITE)
    f = (lightness + 16) / 116 + np.array([a / 500, 0.0, -b / 200])
    xyz = np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29)) * (0.95047, 1.0, 1.08883)
    linear = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) @ xyz
    linear = np.clip(linear, 0, 1)
    return to_hex(np.where(linear > 0.0031308, 1.055 * linear ** (1 / 2.4) - 0.055, 12.92 * linear))


def ink_over(shade: float) -> str:
    """Black or white, whichever is read better on a tone."""
    return "#ffffff" if WHITE[0] + shade * (DARKEST[0] - WHITE[0]) < TURN else INK


def draw_tiles(pen: Pen, box: Rectangle, tiles: Tiles, x: Ruler, y: Ruler) -> None:
    """Tiles with their texts, all as large as the smallest room allows, and their frames, corners and stripes."""
    width, height = box.width / abs(x.high - x.low), box.height / abs(y.high - y.low)
    shades = np.asarray(tiles.shades)
    size = _size(tiles, width, height)
    framed, marked, hatched = map(np.asarray, (tiles.has_frame, tiles.has_mark, tiles.has_hatch))
    for (i, j), shade in np.ndenumerate(shades):
        lines = tiles.texts[i][j]
        if not lines and np.isnan(shade):
            continue
        across, up = box.at(float(x.share(j)), float(y.share(i)))
        tile = Rectangle(across - width / 2, up - height / 2, width, height)
        dark = float(np.nan_to_num(shade))
        pen.area(*tile.corners, tone(dark))
        if hatched[i, j]:
            _hatch(pen, tile)
        pen.line(*tile.edges, OUTLINE)
        _write(pen, tile, lines, size, dark, plain=bool(hatched[i, j]))
        if marked[i, j]:
            top, right, side = tile.bottom + height, tile.left + width, max(LEAST, CORNER * min(width, height))
            pen.area(np.array([right - side, right, right]), np.array([top, top, top - side]), ink_over(dark))
        if framed[i, j]:
            line = min(FRAME, THIN * min(width, height))
            inner = Rectangle(tile.left + line / 2, tile.bottom + line / 2, width - line, height - line)
            pen.line(*inner.edges, {"color": INK, "linewidth": line})


def _size(tiles: Tiles, width: float, height: float) -> float:
    """The size of the first lines in points, so that every text fits its tile."""
    texts = [text for row in tiles.texts for text in row if text]
    widest = max((_width(text, 10.0) / 10 for text in texts), default=1.0)
    return min(
        SMALL_LETTERS, 0.84 * width / widest, 0.74 * height / max((_height(text) for text in texts), default=1.0)
    )


def _width(text: Sequence[str], size: float) -> float:
    return max(extent(line, size * (SMALL if k else 1)).width for k, line in enumerate(text))


def _height(text: Sequence[str]) -> float:
    """The height of the digits of a text, in sizes of its first line."""
    return DIGIT + (len(text) - 1) * SMALL * (DIGIT + LEAD)


def _write(pen: Pen, tile: Rectangle, text: Sequence[str], size: float, shade: float, plain: bool) -> None:
    """The lines of a text in the middle of their tile, on `plain` ground where stripes would cross them."""
    middle = tile.left + tile.width / 2
    top = tile.bottom + (tile.height + (_height(text) if text else 0.0) * size) / 2
    for k, line in enumerate(text):
        letters = size * (SMALL if k else 1)
        wide = extent(line, letters).width
        foot = top - DIGIT * letters
        if plain:
            pen.area(*Rectangle(middle - wide / 2 - 1, foot - 1, wide + 2, DIGIT * letters + 2).corners, tone(shade))
        pen.words(line, middle - wide / 2, foot, letters, color=ink_over(shade))
        top = foot - LEAD * SMALL * size


def _hatch(pen: Pen, tile: Rectangle) -> None:
    """Lines of 45 degrees across a tile."""
    starts = np.arange(-tile.height, tile.width, STRIPE)
    low, high = np.maximum(starts, 0), np.minimum(starts + tile.height, tile.width)
    gaps = np.full_like(starts, np.nan)
    x = np.column_stack([tile.left + low, tile.left + high, gaps]).ravel()
    y = np.column_stack([tile.bottom + low - starts, tile.bottom + high - starts, gaps]).ravel()
    pen.line(x, y, {"color": HATCH, "linewidth": 0.5}, tile)
