"""The H2 norm of a stable linear system: the square is a rational number, and the root is all that is rounded."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from workbench.core.validation.notebook_display import show
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.certified_values import INFINITE, CertifiedValue, rounded_root
from workbench.design.frequency.exact_systems import exact_state_space, not_stable
from workbench.design.frequency.integer_polynomials import Polynomial, add, multiply, scale, squared_modulus
from workbench.design.frequency.transfer_polynomials import TransferPolynomials

if TYPE_CHECKING:
    import control


@dataclass(frozen=True, eq=False)
@show
class MeanGain:
    """The H2 norm `gain` of a system: the root of the power of its outputs under unit white noise.

    It is infinite for an unstable system, and for a continuous system with a direct term D; `reason` then says which.
    """

    gain: CertifiedValue
    reason: str = ""


@check_arguments
def h2_norm(system: control.StateSpace) -> MeanGain:
    """The H2 norm of a system, continuous or discrete.

    The integral of |G|^2 over frequency is computed in exact rational arithmetic. Let G = N / d, with the
    characteristic polynomial d, and let c(s) be the sum of N_ij(s) N_ij(-s) over all entries. The solution u of d(s)
    u(-s) + d(-s) u(s) = c(s) has the highest coefficient u_(n-1), which is d_n times the square of the norm.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace` with finite matrices.
    DesignError
        If the system has more than 40 states, or its norm is too large for a double.

    References
    ----------
    Astrom (1970), Introduction to Stochastic Control Theory, chapter 5, section 3.

    Examples
    --------
    >>> import control
    >>> wb.h2_norm(control.ss(-1.0, 1.0, 1.0, 0.0)).gain.value
    0.7071067811865476
    """
    A, B, C, D = exact_state_space("h2_norm", system)
    discrete = bool(system.isdtime(strict=True))
    transfer = TransferPolynomials.of(A, B, C, D, discrete)
    if not transfer.stable:
        return MeanGain(INFINITE, not_stable(A, discrete))
    if not discrete and D.any():
        return MeanGain(INFINITE, "the direct term D passes white noise, whose power is infinite")
    c: Polynomial = [0]
    for row in transfer.numerators:
        for polynomial in row:
            c = add(c, squared_modulus(transfer.on_axis(polynomial)))
    d = transfer.on_axis(transfer.denominator)
    if discrete:  # d omega = 2 / (dt (1 - v^2)) dv / j
        d, c = multiply(d, [1, 1]), scale(c, 2)
    square = _integral(c, d) / transfer.constant**2
    low, high = rounded_root(square, up=False), rounded_root(square, up=True)
    near = low if square - Fraction(low) ** 2 < Fraction(high) ** 2 - square else high
    return MeanGain(CertifiedValue(near, low, high))


def _integral(c: Polynomial, d: Polynomial) -> Fraction:
    """The integral of c(omega^2) / |d(j omega)|^2 over all omega, divided by 2 pi; d is Hurwitz.

    With y = s^2 and the even and odd parts of d, the equation for u is P(y) X(y) + Q(y) Y(y) = c(-y) / 2. Each step of
    Routh's array takes the highest coefficient off it, and is done in whole numbers with a common factor for each row.
    """
    n = len(d) - 1
    above, row = d[::-1][0::2], d[::-1][1::2]
    rest = [(-1) ** k * c[k] if k < len(c) else 0 for k in range(n)][::-1]
    of_above = of_row = Fraction(1)
    of_rest = Fraction(1, 2)
    tops, ratios = [], []
    for _ in range(n):
        lead, head, top = row[0], above[0], rest[0]
        tops.append(of_rest * top / (of_row * lead))
        ratios.append(of_above * head / (of_row * lead))
        padded = row + [0] * len(rest)
        below = [above[j + 1] * lead - head * padded[j + 1] for j in range(len(above) - 1)]
        rest = [rest[j + 1] * lead - top * padded[j + 1] for j in range(len(rest) - 1)]
        common, shared = math.gcd(*below) or 1, math.gcd(*rest) or 1
        above, row, rest = row, [b // common for b in below], [b // shared for b in rest]
        of_above, of_row, of_rest = of_row, of_above * common / lead, of_rest * shared / lead
    highest = Fraction(0)
    for top, ratio in zip(reversed(tops), reversed(ratios), strict=True):
        highest = top - ratio * highest
    return (highest if n % 2 else -highest) / d[n]
