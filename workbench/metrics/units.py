"""Units of what is made of signals: products and powers of units, printed as one writes them."""

from __future__ import annotations

import re
from collections import Counter

WORD = re.compile(r"([^\W\d_]+|%|1)(?:\^(-?\d+))?")
POWERS = ({"N": 1, "m": 1, "s": -1}, {"V": 1, "A": 1}, {"W": 1}, {"N": 1, "m": 1, "rad": 1, "s": -1})


def product(*units: tuple[str, int]) -> str:
    """The product of units, each with its power: ("rad", 2), ("s", 1) is "rad^2 s", and ("N m", 1), ("s", -1) "N m/s".

    What is no product of words, as "V/sqrt(Hz)" is none, stands in brackets; what is not known stays so.
    """
    if any(unit == "?" for unit, _ in units):
        return "?"
    powers: Counter[str] = Counter()
    for unit, power in units:
        words = _words(unit)
        for word, n in ({f"({unit})": 1} if words is None else words).items():
            powers[word] += n * power
    above = [_power(word, n) for word, n in powers.items() if n > 0]
    below = [_power(word, -n) for word, n in powers.items() if n < 0]
    if not below:
        return " ".join(above)
    divisor = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return f"{' '.join(above) or '1'}/{divisor}"


def work(effort: str, flow: str) -> str:
    """The unit of effort times flow times seconds: J where that is an energy."""
    power = product((effort, 1), (flow, 1))
    return "J" if _words(power) in POWERS else product((power, 1), ("s", 1))


def _power(word: str, n: int) -> str:
    return word if n == 1 else f"{word}^{n}"


def _words(unit: str) -> dict[str, int] | None:
    """The words of a unit with their powers; None of what is no product of words."""
    over, _, under = unit.partition("/")
    powers: Counter[str] = Counter()
    for part, sign in ((over, 1), (under.removeprefix("(").removesuffix(")"), -1)):
        for word in part.split():
            if (read := WORD.fullmatch(word)) is None:
                return None
            powers[read[1]] += sign * int(read[2] or 1)
    return {word: n for word, n in powers.items() if word != "1" and n}
