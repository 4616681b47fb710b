"""Numbers as they are printed: to how many digits two are told apart, and what the last digit leaves open."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from workbench.notation.build import parts, rebuilt
from workbench.notation.formula import Formula, Number, Power, children
from workbench.printed.slips import LONGEST, Editor
from workbench.validation.refusals import Array

SHORT, FULL = 6, 17  # significant digits: what one reads at a glance, and what tells any two doubles apart
MOST_DECIMALS = 15
ROUNDING = 1e-12  # of the room that the digits leave, for that of doubles


def told_apart(one: float, other: float) -> tuple[str, str]:
    """Two numbers with as many digits as it takes to see that they differ, six at least."""
    for digits in range(SHORT, FULL + 1):
        said = f"{one:.{digits}g}", f"{other:.{digits}g}"
        if said[0] != said[1]:
            return said
    return said


def agrees_to_its_digits(printed: Formula, right: Array, editor: Editor) -> bool:
    """Whether a formula is right (K,) once each of its decimal numbers may be off by half a unit of its last digit.

    Whole numbers, fractions that are no decimals, and numbers of one digit are taken to be exact.
    """
    if sum(1 for _ in parts(printed)) > LONGEST:
        return False
    value = editor.value(printed)
    room = sum((np.abs(editor.value(moved) - value) for moved in _moved(printed)), np.zeros_like(value))
    return bool(np.all(np.isfinite(value) & (room > 0) & (np.abs(value - right) <= room * (1 + ROUNDING))))


def _moved(formula: Formula) -> Iterator[Formula]:
    """The formula with one of its decimal numbers half a unit of the last digit larger, for each of them."""
    match formula:
        case Number(Fraction() as value):
            if (half := _half_a_unit(value)) is not None:
                yield Number(value + half)
        case Power(base, exponent):
            for moved in _moved(base):
                yield rebuilt(formula, [moved, exponent])
        case _:
            among = list(children(formula))
            for i, part in enumerate(among):
                for moved in _moved(part):
                    yield rebuilt(formula, [*among[:i], moved, *among[i + 1 :]])


def _half_a_unit(value: Fraction) -> Fraction | None:
    """Half a unit of the last decimal of a number of two digits or more; None where it is taken to be exact."""
    for decimals in range(1, MOST_DECIMALS + 1):
        scaled = value * 10**decimals
        if scaled.denominator == 1:
            return Fraction(1, 2 * 10**decimals) if value.denominator > 1 and abs(scaled) >= 10 else None
    return None
