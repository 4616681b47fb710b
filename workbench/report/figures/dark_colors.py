"""The colours of figures on a dark page: each as readable on its ground as the colour by day is on white paper.

Of two colours the contrast is (Y1 + 0.05) / (Y2 + 0.05) with the greater relative luminance above (WCAG 2.2). A dark
page keeps the hue and the contrast, so that what stands back by day, as a grid, stands back by night too, and black
becomes almost white. Coloured lines that are pale by day get more contrast by night than WCAG asks of graphics.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache

import numpy as np

from workbench.core.validation.refusals import Array

GROUND = "#16181b"  # of a dark page, as in live.css
INK = 16.0  # the greatest contrast, which black gets
MIN_CHROMA = 0.1  # chroma in Oklab from which a colour is one of the lines, and no grey or tint
LEAST, MOST = 4.0, 9.0  # contrasts of the lines: above the 3 of WCAG 1.4.11, and what is bright enough
PAINT = re.compile(r"\b(fill|stroke): (#[0-9a-f]{6})\b")

# Oklab (B. Ottosson, 2020): from linear sRGB to cones, and from their cube roots to lightness, green-red, blue-yellow.
CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
OPPONENTS = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # of linear sRGB


def variable(color: str) -> str:
    """The colour `#rrggbb` as a style sheet reads it: by day itself, by night as `dark_scheme` says."""
    return f"var(--c{color[1:].lower()}, {color.lower()})"


def with_variables(svg: str) -> str:
    """An SVG whose fills and strokes are variables of its page."""
    return PAINT.sub(lambda found: f"{found[1]}: {variable(found[2])}", svg)


def colors_of(svg: str) -> set[str]:
    """The colours of the fills and strokes of an SVG."""
    return {found[2] for found in PAINT.finditer(svg)}


def dark_scheme(colors: Iterable[str]) -> str:
    """The declarations of the variables of some colours on a dark page."""
    return " ".join(f"--c{color[1:]}: {dark(color)};" for color in sorted({one.lower() for one in colors}))


@cache
def dark(color: str) -> str:
    """The colour on a dark page of a colour `#rrggbb` on white paper: white becomes the ground of the page."""
    lightness, *chroma = OPPONENTS @ np.cbrt(CONES @ _linear(color))
    wanted = min(contrast(color, "#ffffff"), INK)
    if np.hypot(*chroma) > MIN_CHROMA:
        wanted = min(max(wanted, LEAST), MOST)
    if lightness > 0.9999:
        return GROUND
    low, high = 0.0, 1.0
    while high - low > 1e-4:
        middle = (low + high) / 2
        low, high = (middle, high) if contrast(_nearest(middle, chroma), GROUND) < wanted else (low, middle)
    return _nearest(high, chroma)


def contrast(one: str, other: str) -> float:
    """The contrast of two colours `#rrggbb`, from 1 to 21."""
    less, more = sorted(float(LUMINANCE @ _linear(color)) for color in (one, other))
    return (more + 0.05) / (less + 0.05)


def _nearest(lightness: float, chroma: list[float]) -> str:
    """The colour of a lightness whose chroma is as near to the given one as a screen can show."""
    for share in np.linspace(1.0, 0.0, 41):
        cones = np.linalg.solve(OPPONENTS, np.array([lightness, *(share * np.array(chroma))])) ** 3
        color = np.linalg.solve(CONES, cones)
        if color.min() >= -1e-6 and color.max() <= 1 + 1e-6:
            break
    color = np.clip(color, 0, 1)
    parts = np.where(color > 0.0031308, 1.055 * color ** (1 / 2.4) - 0.055, 12.92 * color)
    return "#" + "".join(f"{round(255 * float(part)):02x}" for part in parts)


def _linear(color: str) -> Array:
    """The red, green and blue of a colour in linear sRGB."""
    parts = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(parts > 0.04045, ((parts + 0.055) / 1.055) ** 2.4, parts / 12.92)
