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
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

import numpy as np

from workbench.design.frequency.integer_polynomials import (
    Polynomial,
    add,
    bilinear,
    is_hurwitz,
    multiply,
    quotient_by_monic,
    scale,
    shift,
    squared_modulus,
    stretch,
)
from workbench.design.frequency.rational_matrices import integer_characteristic_polynomial, markov_parameters, whole
from workbench.design.matrices import Refused
from workbench.validation.refusals import Array

BITS = 64  # of the largest singular value at one frequency, beyond those of a double
LARGEST_EXPONENT = 1020  # of a norm that is a double
Minors = dict[tuple[tuple[int, ...], tuple[int, ...]], Polynomial]


@dataclass(frozen=True, eq=False)
class TransferPolynomials:
    """G = N / (K d) with whole coefficients: N (ny, nu) and the monic d, in S = rate s (or z), and a constant K."""

    numerators: list[list[Polynomial]]
    denominator: Polynomial
    constant: int
    rate: int
    discrete: bool

    @staticmethod
    def of(A: Array, B: Array, C: Array, D: Array, discrete: bool) -> TransferPolynomials:
        """The polynomials of a state space with the doubles as they are, hidden modes in numerator and denominator."""
        (a, rate), (b, beta), (c, gamma), (e, delta) = whole(A), whole(B), whole(C), whole(D)
        n = len(A)
        d = integer_characteristic_polynomial(a)
        parameters = markov_parameters(a, b, c, n)
        numerators = [[scale(d, gamma * beta * e[i, j]) for j in range(D.shape[1])] for i in range(D.shape[0])]
        for i, row in enumerate(numerators):
            for j, polynomial in enumerate(row):
                for k in range(n):
                    entry = sum(d[n - m] * parameters[k - m][i, j] for m in range(k + 1))
                    polynomial[n - 1 - k] += rate * delta * entry
        return TransferPolynomials(numerators, d, gamma * beta * delta, rate, discrete)

    def in_variable(self, p: Polynomial) -> Polynomial:
        """A polynomial in S as one in s or z, with n + 1 coefficients."""
        return stretch(p + [0] * (len(self.denominator) - len(p)), self.rate)

    def on_axis(self, p: Polynomial) -> Polynomial:
        """A polynomial in S as one in s, or in v for a discrete system, with n + 1 coefficients."""
        return bilinear(self.in_variable(p)) if self.discrete else self.in_variable(p)

    @property
    def stable(self) -> bool:
        """True if every root of d, hidden modes included, lies inside the region of stability: decided exactly."""
        return is_hurwitz(self.on_axis(self.denominator))

    def combined(self, weight: int) -> TransferPolynomials:
        """The square system in which the last channel stands for all further ones too, by powers of a weight."""
        rows, columns = len(self.numerators), len(self.numerators[0])
        size = min(rows, columns)
        numerators = [row[: size - 1] + [_weighted(row[size - 1 :], weight)] for row in self.numerators]
        last = [_weighted([row[j] for row in numerators[size - 1 :]], weight) for j in range(size)]
        return replace(self, numerators=[*numerators[: size - 1], last])

    def minors(self) -> list[Minors]:
        """The k x k minors of G times d, for k = 1 to min(ny, nu), each times K^k."""
        rows, columns = len(self.numerators), len(self.numerators[0])
        first: Minors = {((i,), (j,)): self.numerators[i][j] for i in range(rows) for j in range(columns)}
        orders = [first]
        for k in range(2, min(rows, columns) + 1):
            orders.append(
                {
                    (below, across): self._minor(orders[-1], below, across)
                    for below in combinations(range(rows), k)
                    for across in combinations(range(columns), k)
                }
            )
        return orders

    def _minor(self, smaller: Minors, below: tuple[int, ...], across: tuple[int, ...]) -> Polynomial:
        total: Polynomial = []
        for place, j in enumerate(across):
            rest = across[:place] + across[place + 1 :]
            part = multiply(self.numerators[below[0]][j], smaller[below[1:], rest])
            total = add(total, scale(part, -1 if place % 2 else 1))
        return quotient_by_monic(total, self.denominator)


def _weighted(polynomials: list[Polynomial], weight: int) -> Polynomial:
    total: Polynomial = []
    for k, polynomial in enumerate(polynomials):
        total = add(total, scale(polynomial, weight**k))
    return total


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


def float_root(square: Fraction, up: bool) -> float:
    """The square root as a double that is not larger, or, `up`, not smaller.

    Raises
    ------
    Refused
        If it is larger than any double.
    """
    if square == 0:
        return 0.0
    exponent = 2 * ((160 - square.numerator.bit_length() + square.denominator.bit_length()) // 2)
    root = Fraction(math.isqrt(math.floor(square * Fraction(2) ** exponent)) + up) / Fraction(2) ** (exponent // 2)
    if root.numerator.bit_length() - root.denominator.bit_length() > LARGEST_EXPONENT:
        raise Refused("the norm is beyond 1e307, which is more than a double holds; choose other units.")
    near = float(root)
    wrong = near < root if up else near > root
    return float(np.nextafter(near, np.inf if up else 0.0)) if wrong else near
