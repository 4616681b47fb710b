"""Numbers as text: the digits that the error supports, in pieces that a column can align."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal

MOST_DIGITS = 5  # of a measured value, however small its error
LEAST, GREATEST = 1e-3, 1e5  # outside of these a number has a power of ten

# The units that stand behind numbers in sentences, longest first where one begins with another.
_PRODUCTS = ("kg m", "kN m", "N m", "N s", "V s", "rad s")
_NAMED = ("[kMG]?Hz", "[mµ]?rad", "[mµn]?s", "[mµck]?m", "[kM]?W", "k?N", "k?J", "m?V", "m?A", "kg", "min", "bytes")
_SINGLE = rf"(?:{'|'.join((*_PRODUCTS, *_NAMED))})(?:\^?-?\d|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
_UNIT = rf"%|(?:1|{_SINGLE})/(?:{_SINGLE}|\((?:{_SINGLE}|[ ·])+\))|{_SINGLE}"
_NUMBER_AND_UNIT = re.compile(rf"(?<=[\d)]) ({_UNIT}|±(?= \d))(?!\w)|(?<=\d ±) ")
_NO_BREAK = "\u00a0"


@dataclass(frozen=True)
class NumberText:
    """A number in text: a sign, digits, a tail from the point on, as '.3532(2)', and a power of ten or none."""

    sign: str
    whole: str
    tail: str = ""
    power: str = ""

    def __str__(self) -> str:
        """The number on one line, as plain text."""
        return f"{self.sign}{self.whole}{self.tail}" + (f"e{self.power}".replace("−", "-") if self.power else "")


@dataclass(frozen=True)
class Padding:
    """Invisible text before and behind a number, which makes it as wide as the widest of its column."""

    before: str = ""
    behind: str = ""
    power: str = ""


def number_text(value: float, digits: int | None = None) -> NumberText:
    """A number without an error: `digits` significant digits; by default four, or fewer if they are exact."""
    if math.isinf(value):
        return NumberText("−" if value < 0 else "", "∞")
    if isinstance(value, int):
        return NumberText("−" if value < 0 else "", _grouped(str(abs(value))))
    if digits is None:
        digits = next((k for k in range(1, 4) if float(f"{value:.{k - 1}e}") == value), 4)
    mantissa, exponent = f"{abs(value):.{digits - 1}e}".split("e")
    if value == 0 or LEAST <= abs(float(f"{mantissa}e{exponent}")) < GREATEST:
        return _fixed(value, max(0, digits - 1 - int(exponent)))
    whole, point, fraction = mantissa.partition(".")
    return NumberText("−" if value < 0 else "", whole, point + fraction, _minus(int(exponent)))


def number_text_with_error(value: float, error: float) -> NumberText:
    """A value with its error in brackets: 0.3532(2) is 0.3532 with an error of 0.0002, 480(30) one of 30.

    The error has one digit that counts, or two if the first is 1. No more than five digits of the value are printed; an
    error below them has no brackets.
    """
    size = max(abs(value), error)
    if size == 0:
        return NumberText("", "0")
    top = math.floor(math.log10(size))
    last = max(_last_place(error), top - MOST_DIGITS + 1) if error else top - MOST_DIGITS + 1
    shift = 0 if LEAST <= size < GREATEST else top
    place = Decimal(1).scaleb(last)
    body = _fixed((round(Decimal(value) / place) * place).scaleb(-shift), max(0, shift - last))
    digits = round(Decimal(error) / place) * (10**last if last > 0 and not shift else 1)
    tail = body.tail + (f"({digits})" if digits else "")
    return NumberText(body.sign, body.whole, tail, _minus(shift) if shift else "")


def join_units(text: str) -> str:
    r"""The text with no-break spaces between a number and its unit or percent sign, within a unit, and around '±'.

    Examples
    --------
    >>> from workbench.report.number_text import join_units
    >>> join_units("by 1.8 % at 5 N m")
    'by 1.8\xa0% at 5\xa0N\xa0m'
    """
    return _NUMBER_AND_UNIT.sub(lambda found: found[0].replace(" ", _NO_BREAK), text)


def paddings(column: Iterable[NumberText]) -> list[Padding]:
    """For each number of a column, the characters that it lacks to the common frame, one class of glyphs at a time.

    So all decimal points stand in one place in any font with digits of one width.
    """
    numbers = list(column)
    signs = max((n.sign for n in numbers), key=len, default="")
    whole = max((n.whole for n in numbers), key=len, default="")
    tails = [Counter("0" if c.isdigit() else c for c in n.tail) for n in numbers]
    frame: Counter[str] = Counter()
    for tail in tails:
        frame |= tail
    power = max((n.power for n in numbers), key=len, default="")
    return [
        Padding(
            before=("" if n.sign else signs) + whole[: len(whole) - len(n.whole)],
            behind="".join(sorted((frame - tail).elements())),
            power=power[: len(power) - len(n.power)] if n.power else power,
        )
        for n, tail in zip(numbers, tails, strict=True)
    ]


def _last_place(error: float) -> int:
    """The decimal place of the last digit that an error leaves: -4 for 0.0002."""
    mantissa, exponent = f"{error:.1e}".split("e")
    return int(exponent) - (1 if mantissa.startswith("1") else 0)


def _fixed(value: float | Decimal, decimals: int) -> NumberText:
    whole, point, fraction = f"{abs(value):.{decimals}f}".partition(".")
    negative = value < 0 and any(c in "123456789" for c in whole + fraction)
    return NumberText("−" if negative else "", whole, point + fraction)


def _grouped(digits: str) -> str:
    """The digits in groups of three from 10 000 on."""
    return f"{int(digits):,}".replace(",", "\u2009") if len(digits) > 4 else digits


def _minus(exponent: int) -> str:
    return str(exponent).replace("-", "−")
