"""A transfer matrix as polynomials with whole coefficients, and its minors.

A state space has doubles as entries, which are rationals; over common powers of two they are whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

from workbench.core.validation.refusals import Array
from workbench.design.frequency.half_planes import is_hurwitz
from workbench.design.frequency.integer_polynomials import Polynomial, add, bilinear, multiply, quotient, scale, stretch
from workbench.design.frequency.rational_matrices import integer_characteristic_polynomial, markov_parameters, whole

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

    def combine_channels(self, weight: int) -> TransferPolynomials:
        """The square system in which the last channel stands for all further ones too, by powers of a weight."""
        rows, columns = len(self.numerators), len(self.numerators[0])
        size = min(rows, columns)
        numerators = [row[: size - 1] + [_weighted_sum(row[size - 1 :], weight)] for row in self.numerators]
        last = [_weighted_sum([row[j] for row in numerators[size - 1 :]], weight) for j in range(size)]
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
        return quotient(total, self.denominator)


def _weighted_sum(polynomials: list[Polynomial], weight: int) -> Polynomial:
    total: Polynomial = []
    for k, polynomial in enumerate(polynomials):
        total = add(total, scale(polynomial, weight**k))
    return total
