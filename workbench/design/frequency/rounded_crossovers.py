"""Crossovers that rest on the last digits of a loop's matrices: the matrices as written have them, others need not.

If C A^i B is zero by cancellation, as for a force on one mass and the place of another, rounding leaves a number near
1e-17 in its place. It decides the sign of Im L at very high frequencies, so that L goes through the real axis once
more, with a gain margin of 1e13 or more. Changes of each entry of A, B, C and D by at most u = 2^-53 of itself, which
is how far a double may be from the number that it stands for, change L by at most

    u (2 |C| |F| |B| + |C| |F| |A| |F| |B| + |D|),      F = (j omega I - A)^-1,

with absolute values entry by entry, to first order (Higham 2002, Accuracy and Stability of Numerical Algorithms,
section 7.2). A crossover is kept if on both of its sides, before the next one, |Im L| is larger at some frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from workbench.design.control_system import System
from workbench.design.frequency.axis_loop import AxisLoop
from workbench.design.frequency.certified_values import CertifiedValue
from workbench.design.frequency.margin_records import Crossover
from workbench.design.frequency.positive_roots import at

UNIT = 2.0**-53
SAFETY = 2.0  # for the second order, and for the rounding of the bound itself
OUTWARD = (2.0, 4.0, 16.0, 256.0, 65536.0)  # times the last crossover, and its inverse below the first one
INWARD = (0.5, 0.25, 0.75, 0.1, 0.9)  # of the way between two crossovers, on a scale of logarithms


def doubtful_crossovers(system: System, loop: AxisLoop, rows: Sequence[Crossover]) -> list[Crossover]:
    """The phase crossovers of a state-space system in continuous time that changes of its last digits may undo."""
    inner = sorted((row for row in rows if 0 < row.frequency.value < np.inf), key=lambda row: row.frequency.value)
    places = [row.frequency.value for row in inner]
    gaps = [_points(low, high) for low, high in zip([0.0, *places], [*places, np.inf], strict=True)] if inner else []
    known = [any(_is_decided(system, loop, omega) for omega in gap) for gap in gaps]
    return [row for i, row in enumerate(inner) if not (known[i] and known[i + 1])]


def _points(low: float, high: float) -> list[float]:
    """Frequencies between two neighbours, or beyond the last one."""
    if low == 0:
        return [high / factor for factor in OUTWARD]
    if high == np.inf:
        return [low * factor for factor in OUTWARD]
    return [float(low ** (1 - share) * high**share) for share in INWARD]


def _is_decided(system: System, loop: AxisLoop, omega: float) -> bool:
    """True if Im L, which is exact, is larger than changes of the last digits of the matrices move it."""
    x = Fraction(omega) ** 2
    below = at(loop.B, x)
    if below == 0:
        return True
    A, B, C, D = (np.asarray(part, dtype=float) for part in (system.A, system.B, system.C, system.D))
    with np.errstate(all="ignore"):
        try:
            F = np.abs(np.linalg.inv(1j * omega * np.eye(len(A)) - A))
        except np.linalg.LinAlgError:
            return True
        seen, driven = np.abs(C) @ F, F @ np.abs(B)
        change = UNIT * (2 * np.abs(C) @ driven + seen @ np.abs(A) @ driven + np.abs(D))
    size = abs(Fraction(omega) * at(loop.Q, x) / below)
    bound = SAFETY * float(change[0, 0])
    return not np.isfinite(bound) or size > Fraction(bound)


def with_doubt(low: CertifiedValue, high: CertifiedValue, rows: Sequence[Crossover]) -> tuple[CertifiedValue, ...]:
    """The factors of gain below and above one, whose bounds hold with and without the crossovers of `rows`."""
    below = max((row.margin.high for row in rows if row.margin.value < 1), default=0.0)
    above = min((row.margin.low for row in rows if row.margin.value > 1), default=np.inf)
    return (
        CertifiedValue(low.value, low.low, max(low.high, below)),
        CertifiedValue(high.value, min(high.low, above), high.high),
    )


def doubt_words(rows: Sequence[Crossover]) -> str:
    """The sentence on crossovers that are left out."""
    places = ", ".join(f"{row.frequency.value:.4g} rad/s (a factor of {row.margin.value:.3g})" for row in rows)
    return (
        f"L is real and negative at {places} for its matrices as written, but not for all that differ from them in the "
        "last digit: not listed, and the bounds of the gain margins hold with and without it."
    )
