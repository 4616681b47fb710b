"""Units of FMI: a unit as the workbench writes it, in powers of the SI's base units."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
# Each with its factor and its powers of base units.
DERIVED: Mapping[str, tuple[float, str]] = {
    **{"N": (1.0, "kg m/s^2"), "J": (1.0, "kg m^2/s^2"), "W": (1.0, "kg m^2/s^3"), "Pa": (1.0, "kg/(m s^2)")},
    **{"V": (1.0, "kg m^2/(s^3 A)"), "ohm": (1.0, "kg m^2/(s^3 A^2)"), "C": (1.0, "A s"), "Hz": (1.0, "1/s")},
    **{"F": (1.0, "A^2 s^4/(kg m^2)"), "H": (1.0, "kg m^2/(s^2 A^2)"), "T": (1.0, "kg/(s^2 A)")},
    **{"g": (1e-3, "kg"), "cm": (1e-2, "m"), "mm": (1e-3, "m"), "l": (1e-3, "m^3"), "min": (60.0, "s")},
    **{"h": (3600.0, "s"), "deg": (math.pi / 180, "rad"), "ms": (1e-3, "s")},
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
    return Unit(_factor(tokens, powers), {name: n for name, n in powers.items() if n}) if _plain(tokens) else None


def _plain(tokens: list[str]) -> bool:
    """True for factors, at most one stroke, and brackets around all that is below it."""
    above, _, below = "|".join(tokens).partition("|/|")
    wrapped = below.startswith("(|") and below.endswith("|)")
    parts = [above, *([below[2:-2] if wrapped else below] if below else [])]
    names = [token.partition("^")[0] for part in parts for token in part.split("|")]
    return all(name in (*BASE, *DERIVED, "1") for name in names)


def _factor(tokens: list[str], powers: Counter[str], power: int = 1) -> float:
    """The factor of some tokens, whose powers are counted."""
    factor, sign = Fraction(1), 1
    scale = 1.0
    for token in tokens:
        if token == "/":
            sign = -1
        name, _, exponent = token.partition("^")
        n = power * sign * int(exponent or 1)
        if name in BASE:
            powers[name] += n
        elif name in DERIVED:
            own, text = DERIVED[name]
            exact = Fraction(str(own)) if own != DERIVED["deg"][0] else None
            factor, scale = (factor * exact**n, scale) if exact is not None else (factor, scale * own**n)
            _factor([match[1] for match in TOKEN.finditer(text)], powers, n)
    return float(factor) * scale
