"""Equations as a book has them: the lines of a docstring above its sections, and the numbered equations among them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from workbench.core import SampledLaw
from workbench.handover.c99.c_names import letter_of

SECTIONS = frozenset(("Parameters", "Attributes", "Raises", "References", "Examples"))
NEXT = "[k+1]"  # the mark of a value at the next instant, as ' is that of a rate


class NumberedEquation(NamedTuple):
    """An equation with its number: what stands left of the equals sign, and the whole line."""

    left: str
    line: str


def opening(docstring: str) -> list[str]:
    """The lines above the first section, without blank ones at the ends."""
    lines = docstring.splitlines()
    end = next((i for i, line in enumerate(lines) if line in SECTIONS), len(lines))
    return "\n".join(lines[:end]).strip().splitlines()


def numbered_equations(docstring: str) -> Iterator[NumberedEquation]:
    """The lines of the form `s = ed + Lambda e   (12)`, each with two spaces where it has more."""
    for line in docstring.splitlines():
        words = line.split()
        if len(words) >= 3 and words[1] == "=" and _is_number(words[-1]):
            yield NumberedEquation(words[0], "  ".join(part.strip() for part in line.split("  ") if part.strip()))


def _is_number(word: str) -> bool:
    """True for '(12)' and '(12a)', also behind other letters."""
    inner = word[word.rfind("(") + 1 : -1]
    digits = inner[:-1] if inner[-1:].isalpha() and inner[-1:].islower() else inner
    return "(" in word and word.endswith(")") and digits.isdecimal()


def printed_equation(law: SampledLaw, name: str) -> str:
    """The printed equation of a value with its number; of one of the memory that of its rate or its next value."""
    letter = f"{letter_of(name, {})}{chr(39) if name in law.memory else ''}"
    socket = "Observer" if name.startswith("observer.") else "Law"
    stages = (stage for stage in law.stages if stage.title.startswith(socket))
    equations = (equation for stage in stages for equation in numbered_equations(stage.equations))
    return next((each.line for each in equations if each.left.removesuffix(NEXT) == letter), "")
