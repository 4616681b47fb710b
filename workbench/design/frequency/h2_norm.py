"""The H2 norm of a stable linear system: the square is a rational number, and the root is all that is rounded."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.frequency.gain_polynomials import TransferPolynomials, float_root
from workbench.design.frequency.hinf_norm import not_stable
from workbench.design.frequency.integer_polynomials import Polynomial, add, multiply, scale, squared_modulus
from workbench.design.frequency.rational_matrices import eliminate
from workbench.design.linear.operating_point import state_space
from workbench.validation.notebook_display import show
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, eq=False)
@show
class MeanGain:
    """The H2 norm `value` of a system within `error`: root of the power of the outputs under white noise of unit density.

    It is infinite for a system that is not stable, and for a continuous one with a direct term; `reason` says which.
    """

    value: float
    error: float
    reason: str = ""


@door
def h2_norm(system: control.StateSpace) -> MeanGain:
    """The H2 norm of a system, continuous or discrete.

    The integral of |G|^2 over frequency is solved in whole numbers: with d the characteristic polynomial and c(s) =
    sum N(s) N(-s), the u of d(s) u(-s) + d(-s) u(s) = c(s) has the highest coefficient u_(n-1) = d_n times the square.

    Raises
    ------
    ValueError
        If the system is no `StateSpace` with finite matrices.

    References
    ----------
    Astrom (1970), Introduction to Stochastic Control Theory, chapter 5, section 3.

    Examples
    --------
    >>> wb.h2_norm(control.ss(-1.0, 1.0, 1.0, 0.0)).value
    0.7071067811865476
    """
    A, B, C, D = state_space("h2_norm", system)
    discrete = bool(system.isdtime(strict=True))
    transfer = TransferPolynomials.of(A, B, C, D, discrete)
    if not transfer.stable:
        return MeanGain(np.inf, 0.0, not_stable(A, discrete))
    if not discrete and D.any():
        return MeanGain(np.inf, 0.0, "the direct term D passes white noise, whose power is infinite")
    c: Polynomial = [0]
    for row in transfer.numerators:
        for polynomial in row:
            c = add(c, squared_modulus(transfer.on_axis(polynomial)))
    d = transfer.on_axis(transfer.denominator)
    if discrete:  # d omega = 2 / (dt (1 - v^2)) dv / j
        d, c = multiply(d, [1, 1]), scale(c, 2)
    square = _integral(c, d) / transfer.constant**2
    low, high = float_root(square, up=False), float_root(square, up=True)
    near = low if square - Fraction(low) ** 2 < Fraction(high) ** 2 - square else high
    return MeanGain(near, high - low)


def _integral(c: Polynomial, d: Polynomial) -> Fraction:
    """The integral of c(omega^2) / |d(j omega)|^2 over all omega, divided by 2 pi; d is Hurwitz."""
    n = len(d) - 1
    if n == 0:
        return Fraction(0)
    c = c + [0] * (n - len(c))
    rows = [
        [2 * (-1) ** i * (d[2 * k - i] if 0 <= 2 * k - i <= n else 0) for i in range(n)] + [(-1) ** k * c[k]]
        for k in range(n)
    ]
    last = eliminate(rows)[-1]
    return Fraction(last[n], last[n - 1]) / d[n]
