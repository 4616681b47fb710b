"""A pen for SVG, in points from the lower left corner of a sheet: lines, areas, marks, words and the room of words."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, NamedTuple, overload

import numpy as np
from matplotlib.backend_bases import GraphicsContextBase
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.colors import to_rgba
from matplotlib.font_manager import FontProperties
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D, Bbox, IdentityTransform

from workbench.core.notation import latex, text
from workbench.core.notation.formula import Formula
from workbench.core.validation.refusals import Array
from workbench.report.figures.style import RULES, SMALL_LETTERS, LineStyle
from workbench.study.document.figure import Label

INK = "#000000"
FAMILY = str(RULES["font.family"])
ASCENT, DESCENT = 0.76, 0.24  # of the size of the letters: a line of text takes as much even if it has no such letter
DIGIT = 0.676  # of the size of the letters: the height of a digit


@dataclass(frozen=True)
class Rectangle:
    """A rectangle in points."""

    left: float
    bottom: float
    width: float
    height: float

    @property
    def edges(self) -> tuple[Array, Array]:
        """The corners, from the lower left one and back to it."""
        return edges(self.left, self.bottom, self.left + self.width, self.bottom + self.height)

    @property
    def corners(self) -> tuple[Array, Array]:
        """The four corners, from the lower left one."""
        return self.edges[0][:4], self.edges[1][:4]

    @overload
    def at(self, across: float, up: float) -> tuple[float, float]: ...

    @overload
    def at(self, across: Array, up: Array) -> tuple[Array, Array]: ...

    def at(self, across: float | Array, up: float | Array) -> tuple[float | Array, float | Array]:
        """The points at these shares of the width and the height."""
        return self.left + self.width * across, self.bottom + self.height * up


def edges(left: float, bottom: float, right: float, top: float) -> tuple[Array, Array]:
    """The corners of a rectangle, from the lower left one and back to it."""
    return np.array([left, right, right, left, left]), np.array([bottom, bottom, top, top, bottom])


class Pen:
    """Draws on one sheet, whose text `svg_text` gives."""

    def __init__(self, width: float, height: float) -> None:
        self.height = height
        self.out = io.StringIO()
        renderer: Any = RendererSVG  # without types
        self.renderer = renderer(width, height, self.out, metadata={"Date": None, "Creator": None})
        self.renderer._text2path = text_to_path  # one for all sheets, as it remembers the formulas that it has set

    @contextmanager
    def group(self, kind: str, panel: int, series: int | None = None) -> Iterator[None]:
        """Put what is drawn meanwhile into a group, which a script of the page finds by its class and its numbers."""
        numbers = {"data-panel": str(panel)} | ({} if series is None else {"data-series": str(series)})
        with self._group({"class": kind} | numbers):
            yield

    @contextmanager
    def piece(self, kind: Literal["mark", "words"], index: int) -> Iterator[None]:
        """Put into a group of a bar or a point: a mark stretches with the rulers, words move as they are."""
        with self._group({"class": kind, "data-index": str(index)}):
            yield

    @contextmanager
    def _group(self, attributes: dict[str, str]) -> Iterator[None]:
        self.renderer.writer.start("g", attributes)
        yield
        self.renderer.writer.end("g")

    def line(self, x: Array, y: Array, look: LineStyle, within: Rectangle | None = None) -> None:
        """Draw a line through points, with gaps at NaN."""
        self.renderer.draw_path(_context(look, within), Path(np.column_stack([x, y])), IdentityTransform())

    def area(self, x: Array, y: Array, color: str, alpha: float = 1.0, within: Rectangle | None = None) -> None:
        """Draw a polygon filled with a colour, without an edge."""
        context = _context({"color": color, "linewidth": 0.0}, within)
        context.set_alpha(alpha)
        closed = Path(np.column_stack([x, y]), closed=False)
        self.renderer.draw_path(context, closed, IdentityTransform(), to_rgba(color, alpha))

    def marks(self, x: Array, y: Array, look: LineStyle, within: Rectangle | None = None) -> None:
        """Draw the same mark at each point."""
        style = MarkerStyle(look["marker"])
        context = _context({"color": look["color"], "linewidth": look["markeredgewidth"]}, within)
        context.set_joinstyle(style.get_joinstyle())
        context.set_capstyle(style.get_capstyle())
        shape = style.get_transform() + Affine2D().scale(look["markersize"])
        places = Path(np.column_stack([x, y]))
        self.renderer.draw_markers(context, style.get_path(), shape, places, IdentityTransform())

    def words(self, label: str, x: float, y: float, size: float, upwards: bool = False, color: str = INK) -> None:
        """Draw a line of text that begins at (x, y) on its base line."""
        if label:
            words, formula = readable(label)
            angle = 90.0 if upwards else 0.0
            context = GraphicsContextBase()
            context.set_foreground(color)
            self.renderer.draw_text(context, x, self.height - y, words, letters(size), angle, formula)

    def svg_text(self, name: str) -> str:
        """The SVG, its ids below `name`."""
        self.renderer.finalize()
        return _tidied(self.out.getvalue(), name)


def _context(look: LineStyle, within: Rectangle | None) -> GraphicsContextBase:
    context = GraphicsContextBase()
    context.set_foreground(look["color"])
    context.set_linewidth(look["linewidth"])
    context.set_joinstyle("round")
    if isinstance(dash := look.get("linestyle", "-"), tuple):
        start, dashes = dash
        context.set_dashes(start, [look["linewidth"] * length for length in dashes])
    else:
        context.set_capstyle("projecting")
    if within is not None:
        context.set_clip_rectangle(Bbox.from_bounds(within.left, within.bottom, within.width, within.height))
    return context


def _tidied(svg: str, name: str) -> str:
    """The SVG element alone, its ids below `name`, its coordinates cut to a hundredth of a point."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r"\n\s+", "\n", svg)
    svg = re.sub(r'<g id="[^"]*"', "<g", svg)  # nothing points to a group
    svg = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", svg)
    head, *paths = re.split(r'(?=\bd=")', svg)
    return head + "".join(map(_rounded, paths))


def _rounded(path: str) -> str:
    data, quote, rest = path[3:].partition('"')
    data = re.sub(r"(\.\d\d)\d+", r"\1", data)
    data = re.sub(r"\.00?(?!\d)|(\.\d)0(?!\d)", r"\1", data)
    return f'd="{" ".join(data.split())}{quote}{rest}'


class Extent(NamedTuple):
    """The size of a line of text in points: its width, and its height above and below the base line."""

    width: float
    ascent: float
    descent: float

    @property
    def height(self) -> float:
        """The total height."""
        return self.ascent + self.descent


NUMBER = Extent(0.0, ASCENT * SMALL_LETTERS, DESCENT * SMALL_LETTERS)  # of the numbers at a ruler


def mathtext(label: Label) -> str:
    """A label in the mathtext of matplotlib, with the dollars of plain text escaped."""
    pieces = label if isinstance(label, tuple) else (label,)
    return "".join(p.replace("$", r"\$") if isinstance(p, str) else _formula(p) for p in pieces)


@cache
def _formula(formula: Formula) -> str:
    """A formula between dollars; as plain text if matplotlib cannot set it, as with a matrix."""
    mathtext = f"${latex.emit(formula, width=math.inf)}$"
    try:
        text_to_path.mathtext_parser.parse(mathtext, 72, letters(text_to_path.FONT_SCALE))
    except ValueError:
        return text.emit(formula).replace("$", r"\$")
    return mathtext


def letters(size: float) -> FontProperties:
    """The font of the figures in a size in points."""
    return FontProperties(family=FAMILY, size=size)


def readable(label: str) -> tuple[str, bool]:
    """A label as matplotlib's renderers expect it: its text without escapes, and True if it holds a formula."""
    formula = "$" in label.replace(r"\$", "")
    return (label if formula else label.replace(r"\$", "$")), formula


@cache
def extent(label: str, size: float) -> Extent:
    """The extent of a label of one line, in letters of a size in points."""
    width, height, descent = text_to_path.get_text_width_height_descent(
        readable(label)[0], letters(size), readable(label)[1]
    )
    return Extent(width, max(height - descent, ASCENT * size), max(descent, DESCENT * size))


def block_of(label: str, size: float) -> Extent:
    """The extent of a label of several lines: the width of the widest, and the height of all."""
    lines = [extent(line, size) for line in label.split("\n")]
    height = sum(line.height for line in lines)
    return Extent(max(line.width for line in lines), lines[0].ascent, height - lines[0].ascent)


@cache
def fold_label(label: str, size: float, width: float) -> str:
    """A label in lines of at most a width, broken at spaces, signs or within long words; a formula is not broken."""
    if extent(label, size).width <= width or readable(label)[1]:
        return label
    lines = [""]
    for word in re.findall(r".+?(?:[ .,_/\])]+|$)", label):
        if lines[-1] and extent(lines[-1] + word.rstrip(), size).width > width:
            lines.append("")
        for letter in re.findall(r"\\?.", word):
            if lines[-1] and extent(lines[-1] + letter.rstrip(), size).width > width:
                lines.append("")
            lines[-1] += letter
    return "\n".join(line.strip() for line in lines if line.strip())


def plain_number(number: str) -> str:
    r"""The number at an axis as plain text, '0.5' for r'$\mathdefault{0.5}$', if it needs no formula: much faster."""
    plain = re.fullmatch(r"\$\\mathdefault\{([^\\^{}]*)\}\$", number)
    return plain[1] if plain else number
