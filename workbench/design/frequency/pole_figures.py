"""The decay and the least damping of the poles of a system, certified for the doubles as written."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.core.validation.refusals import Array
from workbench.design.frequency.axis_loop import axis_loop, refuse_odd_loop
from workbench.design.frequency.certified_values import INFINITE, CertifiedValue, least
from workbench.design.frequency.complex_roots import complex_roots
from workbench.design.frequency.exact_systems import MOST_STATES
from workbench.design.frequency.integer_polynomials import stretch
from workbench.design.frequency.rational_matrices import integer_characteristic_polynomial, whole
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

DOUBT = 2.0**-50  # relative: a root is right to the last place of both its parts, and an elementary function to two
ONE = CertifiedValue(1.0, 1.0, 1.0)


@dataclass(frozen=True)
class PoleFigures:
    """The decay in 1/s of the slowest pole, negative where one grows, and the least damping of all poles.

    The damping of a pole s is -Re s / |s|; a pole z of a loop in a computer counts as s = log(z) / period.
    """

    decay: CertifiedValue
    damping: CertifiedValue


def pole_figures(A: Array, period: float | None = None) -> PoleFigures:
    """The figures of the eigenvalues of A (n, n), in continuous time or of the map over a period in s.

    Raises
    ------
    DesignError
        If A has more than 40 states, or poles are too near to each other to be told apart.
    """
    if len(A) > MOST_STATES:
        raise DesignError(
            f"poles are certified of up to {MOST_STATES} states, and this loop has {len(A)}; reduce its order first."
        )
    numbers, rate = whole(A)
    roots, _ = complex_roots(stretch(integer_characteristic_polynomial(numbers), rate))
    return _figures((complex(root), 0.0) for root in roots) if period is None else _in_periods(roots, period)


def closed_pole_figures(loop: control.TransferFunction | control.StateSpace) -> PoleFigures:
    """The figures of the closed loop of a loop gain L with one channel, modes that L hides included.

    Raises
    ------
    ValueError
        If L is no linear system with one channel, as `stability_margins` asks for.
    DesignError
        As `pole_figures`.
    """
    refuse_odd_loop("pole_figures", loop)
    axis = axis_loop("pole_figures", loop, 0.0)
    roots, _ = complex_roots(axis.closed_polynomial)
    if axis.period is None:
        return _figures((complex(root), 0.0) for root in roots)
    poles = []
    for v in map(complex, roots):
        spread = 2 * abs(v) / abs(1 - v * v) if v not in (1, -1) else math.inf
        poles.append(((1 + v) / (1 - v) if v != 1 else 0j, spread))
    return _figures((_logarithm(z, axis.period, spread) for z, spread in poles))


def _in_periods(roots: Iterable[complex], period: float) -> PoleFigures:
    return _figures(_logarithm(complex(z), period, 1.0) for z in roots)


def _logarithm(z: complex, period: float, spread: float) -> tuple[complex, float]:
    """The pole s = log(z) / period, and a bound of its error beyond that of its own last places."""
    if z == 0 or not math.isfinite(spread):
        return complex(-math.inf, 0.0), 0.0
    s = cmath.log(z) / period
    return s, 4 * (1 + spread) * DOUBT / period


def _figures(poles: Iterable[tuple[complex, float]]) -> PoleFigures:
    """The least decay and damping of poles s with bounds of their errors, beyond a share of their size."""
    decays, dampings = list[CertifiedValue](), list[CertifiedValue]()
    for s, error in poles:
        size = abs(s)
        doubt = DOUBT * size + error if math.isfinite(size) else 0.0
        decays.append(CertifiedValue(-s.real, -s.real - doubt, -s.real + doubt))
        if not math.isfinite(size) or (s.imag == 0 and s.real < -doubt):
            dampings.append(ONE)
        elif size <= doubt:
            dampings.append(CertifiedValue(0.0, -1.0, 1.0))
        else:
            value, spread = -s.real / size, 2 * doubt / size + DOUBT
            dampings.append(CertifiedValue(value, max(value - spread, -1.0), min(value + spread, 1.0)))
    return PoleFigures(least(decays) if decays else INFINITE, least(dampings) if dampings else ONE)
