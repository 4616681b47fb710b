"""Labels in the words of matplotlib, and the room that they take."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any, NamedTuple

from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from workbench.notation import latex, text
from workbench.report.figures.style import RULES, SMALL_LETTERS
from workbench.study.document.figure import Label

FAMILY = RULES["font.family"]
ASCENT, DESCENT = 0.76, 0.24  # of the size of the letters: a line of text takes as much even if it has no such letter


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
def _formula(formula: Any) -> str:
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
def folded(label: str, size: float, width: float) -> str:
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


def unmarked(number: str) -> str:
    r"""The number at an axis as plain text, '0.5' for r'$\mathdefault{0.5}$', if it needs no formula: much faster."""
    plain = re.fullmatch(r"\$\\mathdefault\{([^\\^{}]*)\}\$", number)
    return plain[1] if plain else number
