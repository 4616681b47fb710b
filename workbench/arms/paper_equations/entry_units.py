"""The units of printed entries, from those that the parameters and the joints declare."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from workbench.arms.dynamics import Dynamics
from workbench.arms.paper_equations.arm_letters import symbols_of
from workbench.arms.paper_equations.printed_equations import Place
from workbench.arms.paper_equations.tokens import PI
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
from workbench.core.units import BASE, ONE, Unit, in_base_units, read

PLAIN = 24  # the largest whole number in a fraction that is no measured value
METRE, SECOND = read("m"), read("s")
ENERGY = read("kg m^2/s^2")


class UnitsError(ValueError):
    """The error of a formula that adds terms of different units, or takes the sine of a term with a unit."""


def unit_of_formula(formula: Formula, units: Mapping[Symbol, Unit]) -> Unit | None:
    """The unit of a formula, None for zero, which has any; terms that do not match raise a `UnitsError`."""
    match formula:
        case Number(value):
            return None if value == 0 else ONE
        case Symbol():
            return ONE if formula == PI and formula not in units else units[formula]
        case Sum(terms):
            known = [(term, unit) for term in terms if (unit := unit_of_formula(term, units)) is not None]
            if not known:
                return None
            first, wanted = known[0]
            for term, unit in known:
                if unit != wanted:
                    raise UnitsError(
                        f"{text.emit(first)} in {_text(wanted)} is added to {text.emit(term)} in {_text(unit)}"
                    )
            return wanted
        case Call(function, (argument,)) if function != "sqrt":
            if (unit := unit_of_formula(argument, units)) is not None and unit != ONE:
                raise UnitsError(f"{function} is taken of {text.emit(argument)}, in {_text(unit)}")
            return ONE
    inner = [unit for part in children(formula) if (unit := unit_of_formula(part, units)) is not None]
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
class ArmUnits:
    """The units of an arm's symbols, and those of its joints (none where they turn, m where they slide)."""

    symbols: Mapping[Symbol, Unit]
    joints: tuple[Unit, ...]

    def of_entry(self, place: Place) -> Unit:
        """The unit of an entry of M, C or G."""
        matrix, row, column = place
        power = ENERGY / self.joints[row - 1]
        if matrix == "G":
            return power
        return power * SECOND**2 / self.joints[column - 1] / (SECOND if matrix == "C" else ONE)

    def mismatch(self, place: Place, formula: Formula) -> str:
        """The fault in the units of an entry, in words; empty if there is none, or if its numbers may have some."""
        numbers = [part for part in parts(formula) if isinstance(part, Number)]
        if not all(map(_is_plain, numbers)) or (numbers and all(letter.letter == "q" for letter in letters(formula))):
            return ""
        try:
            found = unit_of_formula(formula, self.symbols)
        except UnitsError as error:
            return str(error)
        right = self.of_entry(place)
        return "" if found in (None, right) else f"it is in {_text(found)}, where {_text(right)} is right"


def _is_plain(number: Number) -> bool:
    """True of a number that derivations bring with them, such as 2 or 1/3, rather than a measured value."""
    return isinstance(number.value, Fraction) and max(abs(number.value.numerator), number.value.denominator) <= PLAIN


def units_of(dynamics: Dynamics) -> ArmUnits | None:
    """The units of an arm; None if one of its parameters is given as a number, or has no unit that is known here."""
    if any(entry.bounds.low == entry.bounds.high != 0 for entry in dynamics.p.entries if not entry.shape):
        return None  # numbers may then stand for it, and have its unit
    letters = {name: symbol for symbol, name in symbols_of(dynamics).items()}
    joints = tuple(METRE if unit == "m" else ONE for unit in dynamics.units)
    known: dict[Symbol, Unit] = {}
    for i, unit in enumerate(joints):
        known |= {letters[f"q[{i}]"]: unit, letters[f"qd[{i}]"]: unit / SECOND}
    for entry in dynamics.p.entries:
        if (declared := read_unit(entry.unit)) is None:
            return None
        known |= {letters[label]: declared for label in entry.labels()}
    return ArmUnits(known, joints)


def read_unit(text: str) -> Unit | None:
    """The unit of a text in kg, m and s, where an angle has none; None if it has other parts or a factor."""
    base = in_base_units(read(text), angles=False)
    return base[1] if base is not None and base[0] == 1 else None


def _text(unit: Unit) -> str:
    return str(Unit(tuple(sorted(unit.powers, key=lambda power: BASE.index(power[0]))))) or "1"
