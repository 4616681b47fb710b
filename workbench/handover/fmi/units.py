"""Units of FMI: a unit as the workbench writes it, in powers of the SI's base units."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
# Each with its factor and its powers of base units.
DERIVED: Mapping[str, tuple[Fraction, str]] = {
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
TOKEN = re.compile(r"\s*([A-Za-z]+(?:\^-?\d+)?|1|/|\(|\))")


class Unit(NamedTuple):
    """A factor and the powers of base units."""

    factor: float
    powers: Mapping[str, int]


def unit_of(text: str) -> Unit | None:
    """The unit of a text such as 'N m/(rad s)'; None if it is none of the SI, as 'rad^(1-rho)/s^2' is none."""
    tokens, place = [], 0
    while place < len(text.rstrip()):
        token = TOKEN.match(text, place)
        if token is None:
            return None
        tokens.append(token[1])
        place = token.end()
    powers: Counter[str] = Counter()
    if not _plain(tokens):
        return None
    factor = float(_factor(tokens, powers))
    return Unit(factor, {name: n for name, n in powers.items() if n})


def _plain(tokens: list[str]) -> bool:
    """True for factors and at most one stroke, below which there is one factor or a bracket of them."""
    above, _, below = "|".join(tokens).partition("|/|")
    wrapped = below.startswith("(|") and below.endswith("|)")
    parts = [above, *([below[2:-2] if wrapped else below] if below else [])]
    names = [token.partition("^")[0] for part in parts for token in part.split("|")]
    return all(name in (*BASE, *DERIVED, "1") for name in names) and (wrapped or "|" not in below)


def _factor(tokens: list[str], powers: Counter[str], power: int = 1) -> Fraction:
    """The factor of some tokens, whose powers are counted."""
    factor = Fraction(1)
    for token in tokens:
        if token == "/":
            power = -power
        name, _, exponent = token.partition("^")
        n = power * int(exponent or 1)
        if name in BASE:
            powers[name] += n
        elif name in DERIVED:
            own, text = DERIVED[name]
            factor *= own**n * _factor(TOKEN.findall(text), powers, n)
    return factor
