"""The units of printed entries, from those that the parameters and the joints declare."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from workbench.arms.dynamics import Dynamics
from workbench.arms.printed.arm_letters import symbols_of
from workbench.arms.printed.printed_equations import Place
from workbench.arms.printed.tokens import PI
from workbench.core.notation import text
from workbench.core.notation.build import parts
from workbench.core.notation.formula import (
    Call,
    Formula,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    children,
    letters,
)

PLAIN = 24  # the largest whole number in a fraction that is no measured value


@dataclass(frozen=True)
class Unit:
    """A unit kg^a m^b s^c; an angle has none."""

    kg: Fraction = Fraction(0)
    m: Fraction = Fraction(0)
    s: Fraction = Fraction(0)

    def __mul__(self, other: Unit) -> Unit:
        return Unit(self.kg + other.kg, self.m + other.m, self.s + other.s)

    def __pow__(self, n: Fraction | int) -> Unit:
        return Unit(self.kg * n, self.m * n, self.s * n)

    def __truediv__(self, other: Unit) -> Unit:
        return self * other**-1

    def __str__(self) -> str:
        """The unit as text: kg m^2/s."""
        powers = {"kg": self.kg, "m": self.m, "s": self.s}
        above = " ".join(name if n == 1 else f"{name}^{n}" for name, n in powers.items() if n > 0)
        below = " ".join(name if n == -1 else f"{name}^{-n}" for name, n in powers.items() if n < 0)
        return (above or "1") + (f"/({below})" if " " in below else f"/{below}" if below else "")


NONE, KG, METRE, SECOND = Unit(), Unit(kg=Fraction(1)), Unit(m=Fraction(1)), Unit(s=Fraction(1))
NEWTON = KG * METRE / SECOND**2
KNOWN = {"kg": KG, "m": METRE, "s": SECOND, "rad": NONE, "1": NONE, "N": NEWTON, "J": NEWTON * METRE}
_FACTOR = re.compile(r"([A-Za-z]+|1)(\^(-?\d+))?")


class UnitsError(ValueError):
    """The error of a formula that adds terms of different units, or takes the sine of a term with a unit."""


def unit_of(formula: Formula, units: Mapping[Symbol, Unit]) -> Unit | None:
    """The unit of a formula, None for zero, which has any; terms that do not match raise a `UnitsError`."""
    match formula:
        case Number(value):
            return None if value == 0 else NONE
        case Symbol():
            return NONE if formula == PI and formula not in units else units[formula]
        case Sum(terms):
            known = [(term, unit) for term in terms if (unit := unit_of(term, units)) is not None]
            first, wanted = known[0] if known else (formula, None)
            for term, unit in known:
                if unit != wanted:
                    raise UnitsError(f"{text.emit(first)} in {wanted} is added to {text.emit(term)} in {unit}")
            return wanted
        case Call(function, (argument,)) if function != "sqrt":
            if (unit := unit_of(argument, units)) not in (None, NONE):
                raise UnitsError(f"{function} is taken of {text.emit(argument)}, in {unit}")
            return NONE
    inner = [unit for part in children(formula) if (unit := unit_of(part, units)) is not None]
    if len(inner) < len(children(formula)):
        return None
    match formula:
        case Product():
            return reduce(Unit.__mul__, inner)
        case Quotient():
            return inner[0] / inner[1]
        case Power(_, Number(exponent)):
            return inner[0] ** Fraction(exponent)
        case Call("sqrt"):
            return inner[0] ** Fraction(1, 2)
    raise UnitsError(f"{text.emit(formula)} has no unit")


@dataclass(frozen=True)
class Units:
    """The units of an arm's symbols, and those of its joints (none where they turn, m where they slide)."""

    symbols: Mapping[Symbol, Unit]
    joints: tuple[Unit, ...]

    def of_entry(self, place: Place) -> Unit:
        """The unit of an entry of M, C or G."""
        matrix, row, column = place
        power = KG * METRE**2 / SECOND**2 / self.joints[row - 1]
        if matrix == "G":
            return power
        return power * SECOND**2 / self.joints[column - 1] / (SECOND if matrix == "C" else NONE)

    def mismatch(self, place: Place, printed: Formula) -> str:
        """The fault in the units of an entry, in words; empty if there is none, or if its numbers may have some."""
        numbers = [part for part in parts(printed) if isinstance(part, Number)]
        if not all(map(_is_plain, numbers)) or (numbers and all(letter.letter == "q" for letter in letters(printed))):
            return ""
        try:
            found = unit_of(printed, self.symbols)
        except UnitsError as error:
            return str(error)
        right = self.of_entry(place)
        return "" if found in (None, right) else f"it is in {found}, where {right} is right"


def _is_plain(number: Number) -> bool:
    """True of a number that derivations bring with them, such as 2 or 1/3, rather than a measured value."""
    return isinstance(number.value, Fraction) and max(abs(number.value.numerator), number.value.denominator) <= PLAIN


def units_of(dynamics: Dynamics) -> Units | None:
    """The units of an arm; None if one of its parameters is given as a number, or has no unit that is known here."""
    if any(entry.bounds.low == entry.bounds.high != 0 for entry in dynamics.p.entries if not entry.shape):
        return None  # numbers may then stand for it, and have its unit
    letters = {name: symbol for symbol, name in symbols_of(dynamics).items()}
    joints = tuple(METRE if unit == "m" else NONE for unit in dynamics.units)
    known: dict[Symbol, Unit] = {}
    for i, unit in enumerate(joints):
        known |= {letters[f"q[{i}]"]: unit, letters[f"qd[{i}]"]: unit / SECOND}
    for entry in dynamics.p.entries:
        if (declared := read_unit(entry.unit)) is None:
            return None
        known |= {letters[label]: declared for label in entry.labels()}
    return Units(known, joints)


def read_unit(said: str) -> Unit | None:
    """The unit that a parameter declares, such as kg m^2 or m/s^2; None if a part of it is unknown."""
    result = NONE
    for k, part in enumerate(said.split("/")):
        for factor in part.replace("*", " ").split():
            found = _FACTOR.fullmatch(factor.strip("()"))
            if found is None or found[1] not in KNOWN:
                return None
            power = KNOWN[found[1]] ** int(found[3] or 1)
            result = result / power if k else result * power
    return result
