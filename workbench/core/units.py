"""The algebra of units: a text such as 'N m/(rad s)' is read once, at the door, and multiplied, divided and printed.

A unit is a product of words with powers. Its text has factors with a space or '*' between them, at most one stroke, and
one factor or a bracket below it: 'kg m^2/s^2', 'V s/rad', 'm^(1/2)', 'V/sqrt(Hz)'. 'a/b/c' is a/(b c). Refused is a
text in which a factor, a bracket or a power is missing, as in 'm//s', and one that can be read in two ways, as 'a/b c'.

A word that nobody knows is a unit of its own, equal to itself alone: 'counts', 'veh', '%', and a word to a power in
letters, 'rad^(1-rho)'. '' and '1' are the unit of a pure number. '?' is the unit of a signal whose block was told none:
it fits any other, and what is made of it is unknown, too. Nothing is converted.

A text is printed as it was written if it has spaces and at most one stroke, else as the algebra prints it: 'N*m' is
'N m'. A text may name units one by one, 'm, rad', or leave them open, 'm/s or rad/s'.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, reduce

from workbench.core.validation.refusals import refusal

ANY = "?"  # the unit of a signal whose block was told none, as a system of python-control is
BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
DERIVED_UNITS: Mapping[str, tuple[Fraction, str]] = {  # each with its factor and its text in base units
    "N": (Fraction(1), "kg m/s^2"),
    "J": (Fraction(1), "kg m^2/s^2"),
    "W": (Fraction(1), "kg m^2/s^3"),
    "Pa": (Fraction(1), "kg/(m s^2)"),
    "V": (Fraction(1), "kg m^2/(s^3 A)"),
    "ohm": (Fraction(1), "kg m^2/(s^3 A^2)"),
    "C": (Fraction(1), "A s"),
    "F": (Fraction(1), "A^2 s^4/(kg m^2)"),
    "H": (Fraction(1), "kg m^2/(s^2 A^2)"),
    "T": (Fraction(1), "kg/(s^2 A)"),
    "Hz": (Fraction(1), "1/s"),
    "g": (Fraction(1, 1000), "kg"),
    "l": (Fraction(1, 1000), "m^3"),
    "cm": (Fraction(1, 100), "m"),
    "mm": (Fraction(1, 1000), "m"),
    "ms": (Fraction(1, 1000), "s"),
    "min": (Fraction(60), "s"),
    "h": (Fraction(3600), "s"),
}
LONGEST = 120  # characters of one unit
LARGEST = 99  # power in a text
TIMES = "*\N{MIDDLE DOT}\N{DOT OPERATOR}"
NUMBER = re.compile(r"\(?(-?\d{1,9}(?:\.\d{1,9})?)\)?|\((-?\d{1,9}/\d{1,9})\)")
SYMBOL = re.compile(r"\w+|\(.*\w.*\)", re.DOTALL)
HALF = Fraction(1, 2)


class UnitError(ValueError):
    """The error of a text that is no unit, with the reason as a clause."""


@dataclass(frozen=True, eq=False)
class Unit:
    """A product of words with powers, in the order in which they are printed."""

    powers: tuple[tuple[str, Fraction], ...] = ()

    def __mul__(self, other: Unit) -> Unit:
        return _collect_powers(self.powers + other.powers)

    def __truediv__(self, other: Unit) -> Unit:
        return self * other**-1

    def __pow__(self, power: Fraction | int) -> Unit:
        return _collect_powers((word, n * power) for word, n in self.powers)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Unit) and dict(self.powers) == dict(other.powers)

    def __hash__(self) -> int:
        return hash(frozenset(self.powers))

    def __str__(self) -> str:
        above = [_power(word, n) for word, n in self.powers if n > 0]
        below = [_power(word, -n) for word, n in self.powers if n < 0]
        over, under = " ".join(above), " ".join(below)
        if not below:
            return over
        return f"{over or '1'}/{under if len(below) == 1 else f'({under})'}"

    def fits(self, other: Unit) -> bool:
        """True if the two are equal, or one of them is unknown."""
        return self == other or UNKNOWN_UNIT in (self, other)


ONE, SECOND = Unit(), Unit((("s", Fraction(1)),))
UNKNOWN_UNIT = Unit(((ANY, Fraction(1)),))


def _collect_powers(factors: Iterable[tuple[str, Fraction]]) -> Unit:
    """The product of words with powers, in which a word that cancels is left out."""
    powers: dict[str, Fraction] = {}
    for word, n in factors:
        powers[word] = powers.get(word, Fraction(0)) + n
    return UNKNOWN_UNIT if ANY in powers else Unit(tuple((word, n) for word, n in powers.items() if n))


def _power(word: str, n: Fraction) -> str:
    base = f"({word})" if "^" in word and n != 1 else word
    return base if n == 1 else f"{base}^{n}" if n.denominator == 1 else f"{base}^({n})"


@lru_cache(maxsize=4096)
def read(text: str) -> Unit:
    """The unit of a text, or a `UnitError` with the reason why it is none."""
    if len(text) > LONGEST:
        raise UnitError(f"it has {len(text)} characters, more than {LONGEST}")
    text = re.sub(r"\s*(?:\^|\*\*)\s*", "^", text.strip())
    unit = _quotient(text) if text else ONE
    if any(max(abs(n.numerator), n.denominator) > LARGEST for _, n in unit.powers):
        raise UnitError(f"a power in it is beyond {LARGEST}")
    return unit


def _quotient(text: str) -> Unit:
    above, *below = _split(text, "/")
    if not all(part.strip() for part in (above, *below)):
        raise UnitError("a factor is missing before or after '/'")
    divisors = [_factors(part) for part in below]
    if several := next((part for part in divisors if len(part) > 1), None):
        raise UnitError(f"it can be read in two ways: put '{' '.join(several)}' in brackets, or before '/'")
    return _product(_factors(above)) / _product(factor for part in divisors for factor in part)


def _factors(text: str) -> list[str]:
    parts = _split(text, TIMES)
    if not all(part.strip() for part in parts):
        raise UnitError("a factor is missing before or after '*'")
    return [factor for part in parts for factor in _split(part, " \t\n\r\f\v") if factor]


def _product(factors: Iterable[str]) -> Unit:
    return reduce(Unit.__mul__, map(_factor, factors), ONE)


def _factor(text: str) -> Unit:
    """A word, a bracket or a square root, to a power."""
    base, *powers = _split(text, "^")
    if not base or not all(powers) or len(powers) > 1:
        raise UnitError("'^' must stand between one factor and one power")
    unit = _base(base)
    if not powers:
        return unit
    if (number := NUMBER.fullmatch(powers[0])) is None:
        if not SYMBOL.fullmatch(powers[0]):
            raise UnitError(f"'{powers[0]}' is no power")
        alone = (str(unit), Fraction(1)) in unit.powers and "^" not in str(unit)
        word = f"{unit if alone else f'({unit})'}^{powers[0]}"
        return unit if unit in (ONE, UNKNOWN_UNIT) else Unit(((word, Fraction(1)),))
    try:
        return unit ** Fraction(number[1] or number[2])
    except ZeroDivisionError:
        raise UnitError(f"'{powers[0]}' is no power") from None


def _base(text: str) -> Unit:
    root, inner = text.startswith("sqrt("), text.removeprefix("sqrt")
    if not inner.startswith("("):
        return ONE if text == "1" else _collect_powers([(text, Fraction(1))])
    if not inner.endswith(")") or not _split(inner[1:-1], "/", must_close=False):
        raise UnitError(f"'{text}' lacks a space between two factors")
    if not inner[1:-1].strip():
        raise UnitError("a pair of brackets is empty")
    return _quotient(inner[1:-1].strip()) ** (HALF if root else 1)


def _split(text: str, at: str, must_close: bool = True) -> list[str]:
    """The parts of a text between characters outside of brackets; none if brackets do not match and need not."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter == "(") - (letter == ")")
        if depth < 0:
            break
        if letter in at and not depth:
            parts.append("")
        else:
            parts[-1] += letter
    if depth and must_close:
        raise UnitError("its brackets do not match")
    return [] if depth else parts


def checked_unit(call: str, text: str) -> str:
    """The text of a unit, or of several, as it is printed, or a refusal that names the call."""
    try:
        return _printed_text(text)
    except UnitError as error:
        raise refusal(call, f"a unit, as 'N m/(rad s)' is, but {error}", text) from None


@lru_cache(maxsize=4096)
def _printed_text(text: str) -> str:
    for mark in (", ", " or "):
        if mark in text:
            return mark.join(map(_printed_text, text.split(mark)))
    unit = read(text)
    return str(unit) if set(text) & set(TIMES) or len(_split(text, "/")) > 2 else text


def fill_unit(template: str, texts: Mapping[str, str]) -> str:
    """A unit in which `{name}` stands for the unit of that name: '{x}/s' of 'rad/s' is 'rad/s^2'."""
    return _fill(template, tuple(texts.items()))


@lru_cache(maxsize=4096)
def _fill(template: str, texts: tuple[tuple[str, str], ...]) -> str:
    plain = whole = template
    for name, text in texts:
        plain = plain.replace(f"{{{name}}}", text)
        whole = whole.replace(f"{{{name}}}", f"({text or 1})")
    try:
        unit = read(whole)
    except UnitError:  # of alternatives, or to be refused where it is declared
        return plain
    try:
        return _printed_text(plain) if read(plain) == unit else str(unit)
    except UnitError:
        return str(unit)


def join_units(units: Sequence[str]) -> str:
    """The units of several numbers as one text: 'm, rad', or 'm' if all are the same."""
    return units[0] if len(set(units)) == 1 else ", ".join(units)


def unit_of_each(text: str, count: int) -> tuple[str, ...]:
    """The unit of each of `count` numbers, which a text names one by one or all at once."""
    several = tuple(text.split(", "))
    return several if len(several) == count else (text,) * count


@lru_cache(maxsize=4096)
def per_second(text: str, order: int = 1) -> str:
    """The unit of a derivative: of 'rad' 'rad/s', of 'm/s' with order 2 'm/s^3', of 'm, rad' 'm/s, rad/s'."""
    return ", ".join(str(read(each) / SECOND**order) for each in text.split(", "))


@lru_cache(maxsize=4096)
def gain(out: str, of: str, seconds: int = 0) -> str:
    """The unit of a gain from signals in `of` to signals in `out`, times a power of s: 'V' of 'rad/s' is 'V s/rad'."""
    outs, ofs = out.split(", "), of.split(", ")
    pairs = ((outs[i % len(outs)], ofs[i % len(ofs)]) for i in range(max(len(outs), len(ofs))))
    return ", ".join(str(read(above) / read(below) * SECOND**seconds) for above, below in pairs)


def in_base_units(unit: Unit, angles: bool = True) -> tuple[Fraction, Unit] | None:
    """A unit as a factor and base units of the SI, or None if it has a word that is not of the SI.

    It is None, too, if a factor to a broken power is no fraction. Without `angles` a rad is a pure number.
    """
    factor, result = Fraction(1), ONE
    for word, n in unit.powers:
        own, text = DERIVED_UNITS.get(word, (Fraction(1), word))
        if (word not in DERIVED_UNITS and word not in BASE) or (own != 1 and n.denominator != 1):
            return None
        factor *= own ** int(n) if own != 1 else 1
        result *= read(text) ** n
    return factor, result if angles else Unit(tuple((word, n) for word, n in result.powers if word != "rad"))
