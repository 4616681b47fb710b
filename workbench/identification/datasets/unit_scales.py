"""Units of signals beside those that a system expects: equal, scaled, or of another kind."""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction

from workbench.core.units import ONE, UNKNOWN_UNIT, Unit, in_base_units, read

# Words that logs use and that the algebra of units holds for units of their own: factor and text in base units.
WORDS: Mapping[str, tuple[float, str]] = {
    "deg": (math.pi / 180, "rad"),
    "mrad": (1e-3, "rad"),
    "rev": (2 * math.pi, "rad"),
    "rpm": (2 * math.pi / 60, "rad/s"),
    "mV": (1e-3, "V"),
    "kV": (1e3, "V"),
    "mA": (1e-3, "A"),
    "kN": (1e3, "N"),
    "mN": (1e-3, "N"),
    "kW": (1e3, "W"),
    "kPa": (1e3, "Pa"),
    "bar": (1e5, "Pa"),
    "kHz": (1e3, "Hz"),
    "km": (1e3, "m"),
    "um": (1e-6, "m"),
    "us": (1e-6, "s"),
    "ml": (1e-6, "m^3"),
}


def scale(unit: str, other: str) -> float | None:
    """The factor that turns numbers in `unit` into numbers in `other`, or None if they are of another kind.

    A rad is a pure number here, as 1/s and rad/s are often written for each other.
    """
    one, two = read(unit), read(other)
    if one == two or UNKNOWN_UNIT in (one, two):
        return 1.0
    parts = [_in_base_units(text) for text in (one, two)]
    if parts[0] is None or parts[1] is None or parts[0][1] != parts[1][1]:
        return None
    return parts[0][0] / parts[1][0]


def _in_base_units(unit: Unit) -> tuple[float, Unit] | None:
    factor, rest = 1.0, ONE
    for word, power in unit.powers:
        own, text = WORDS.get(word, (1.0, word))
        factor *= own ** float(power)
        rest *= read(text) ** Fraction(power)
    base = in_base_units(rest, angles=False)
    return base and (factor * float(base[0]), base[1])
