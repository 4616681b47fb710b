"""Squared singular values of a transfer matrix over frequency, as roots of a polynomial with whole coefficients:

    E_0(x) l^r - E_1(x) l^(r-1) + ... + (-1)^r E_r(x) = 0,     l = sigma^2,  x = omega^2,

where E_0 = |d(j omega)|^2 for the characteristic polynomial d, and E_k is E_0 times the sum of the squared moduli of
the k x k minors of G (Cauchy and Binet). For l = gamma^2 its left side is, up to a constant, the characteristic
polynomial of the Hamiltonian matrix of Boyd and Balakrishnan at j omega. A discrete system is taken to
v = (z - 1) / (z + 1) first, where the unit circle is the imaginary axis; then x = tan(omega dt / 2)^2, and
x = infinity is Nyquist's frequency.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from workbench.design.frequency.integer_polynomials import Polynomial, add, scale, shift, squared_modulus, stretch
from workbench.design.frequency.transfer_polynomials import TransferPolynomials

BITS = 64  # of the largest singular value at one frequency, beyond those of a double


@dataclass(frozen=True, eq=False)
class GainPolynomials:
    """The polynomials E_0, ..., E_r in x, each with n + 1 coefficients."""

    E: list[Polynomial]

    @staticmethod
    def of(transfer: TransferPolynomials) -> GainPolynomials:
        """The polynomials of a transfer matrix of which every minor is finite on the axis."""
        orders = transfer.minors()
        r, n = len(orders), len(transfer.denominator) - 1
        E = [scale(squared_modulus(transfer.on_axis(transfer.denominator)), transfer.constant ** (2 * r))]
        for k, minors in enumerate(orders, 1):
            total: Polynomial = [0] * (n + 1)
            for minor in minors.values():
                total = add(total, squared_modulus(transfer.on_axis(minor)))
            E.append(scale(total, transfer.constant ** (2 * (r - k))))
        common = math.gcd(*(c for polynomial in E for c in polynomial)) or 1
        return GainPolynomials([[c // common for c in polynomial[: n + 1]] for polynomial in E])

    def at(self, x: Fraction | None) -> list[int]:
        """The values E_k(x), times a positive constant; None stands for infinity."""
        if x is None:
            return [polynomial[-1] for polynomial in self.E]
        n = len(self.E[0]) - 1
        powers = [x.numerator**i * x.denominator ** (n - i) for i in range(n + 1)]
        return [sum(c * power for c, power in zip(polynomial, powers, strict=True)) for polynomial in self.E]

    def level(self, square: Fraction) -> Polynomial:
        """The polynomial in x whose positive roots are the frequencies with a singular value of this square."""
        r, total = len(self.E) - 1, [0] * len(self.E[0])
        for k, polynomial in enumerate(self.E):
            factor = (-1) ** k * square.numerator ** (r - k) * square.denominator**k
            total = add(total, scale(polynomial, factor))
        return total


def exceeds(square: Fraction, values: list[int]) -> bool:
    """True if a square is larger than every squared singular value at a frequency, given E_k there.

    All roots being real, none is as large as the square exactly if all coefficients about it are positive.
    """
    p = [(-1) ** k * value for k, value in enumerate(values)][::-1]
    return all(c > 0 for c in shift(stretch(p, square.numerator, square.denominator)))


def largest_square(values: list[int]) -> Fraction:
    """The largest squared singular value at a frequency, rounded down by 2^-64 of it at most, given E_k there."""
    trace, r = Fraction(values[1], values[0]), len(values) - 1
    if trace == 0:
        return trace
    unit = Fraction(2) ** (trace.numerator.bit_length() - trace.denominator.bit_length() - BITS - r.bit_length() - 2)
    low, high = math.floor(trace / r / unit), math.ceil(trace / unit) + 1
    if r == 1:
        return low * unit
    while high - low > 1:  # never above at low: the largest square is at least the mean
        middle = (low + high) // 2
        low, high = (low, middle) if exceeds(middle * unit, values) else (middle, high)
    return low * unit
