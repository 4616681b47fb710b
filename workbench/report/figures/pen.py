"""A pen for SVG: lines, areas, marks and words, in points from the lower left corner of a sheet."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.backend_bases import GraphicsContextBase
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.colors import to_rgba
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path
from matplotlib.textpath import text_to_path
from matplotlib.transforms import Affine2D, Bbox, IdentityTransform

from workbench.report.figures.labels import letters, readable
from workbench.validation.refusals import Array

INK = "#000000"


@dataclass(frozen=True)
class Box:
    """A rectangle in points."""

    left: float
    bottom: float
    width: float
    height: float


class Pen:
    """Draws on one sheet, whose text `finished` gives."""

    def __init__(self, width: float, height: float) -> None:
        self.height = height
        self.out = io.StringIO()
        renderer: Any = RendererSVG  # without types
        self.renderer = renderer(width, height, self.out, metadata={"Date": None, "Creator": None})
        self.renderer._text2path = text_to_path  # one for all sheets, as it remembers the formulas that it has set

    def line(self, x: Array, y: Array, look: Mapping[str, Any], within: Box | None = None) -> None:
        """Draw a line through points, with gaps at NaN."""
        self.renderer.draw_path(_context(look, within), Path(np.column_stack([x, y])), IdentityTransform())

    def area(self, x: Array, y: Array, color: str, alpha: float, within: Box | None = None) -> None:
        """Draw a polygon filled with a colour, without an edge."""
        context = _context({"color": color, "linewidth": 0.0}, within)
        context.set_alpha(alpha)
        closed = Path(np.column_stack([x, y]), closed=False)
        self.renderer.draw_path(context, closed, IdentityTransform(), to_rgba(color, alpha))

    def marks(self, x: Array, y: Array, look: Mapping[str, Any], within: Box | None = None) -> None:
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
            text, formula = readable(label)
            angle = 90.0 if upwards else 0.0
            context = GraphicsContextBase()
            context.set_foreground(color)
            self.renderer.draw_text(context, x, self.height - y, text, letters(size), angle, formula)

    def finished(self, name: str) -> str:
        """The SVG, its ids below `name`."""
        self.renderer.finalize()
        return _tidied(self.out.getvalue(), name)


def _context(look: Mapping[str, Any], within: Box | None) -> Any:
    context = GraphicsContextBase()
    context.set_foreground(look["color"])
    context.set_linewidth(look["linewidth"])
    context.set_joinstyle("round")
    if look.get("linestyle", "-") != "-":
        start, dashes = look["linestyle"]
        context.set_dashes(start, [look["linewidth"] * dash for dash in dashes])
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
    rounded = [_rounded(path) for path in paths]
    return head + "".join(rounded)


def _rounded(path: str) -> str:
    data, quote, rest = path[3:].partition('"')
    data = re.sub(r"(\.\d\d)\d+", r"\1", data)
    data = re.sub(r"\.00?(?!\d)|(\.\d)0(?!\d)", r"\1", data)
    return f'd="{" ".join(data.split())}{quote}{rest}'
