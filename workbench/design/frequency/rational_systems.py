"""The system of a state space that holds its finite zeros, and its minimal realisation, without rounding."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array
from workbench.design.frequency.integer_polynomials import PRIME, Polynomial
from workbench.design.frequency.rational_matrices import (
    Matrix,
    echelon,
    product,
    rational,
    rational_characteristic_polynomial,
    transpose,
)


@dataclass(frozen=True, eq=False)
class RationalSystem:
    """x' = A x + B u, y = C x + D u with `nu` inputs and fractions for numbers."""

    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    nu: int

    @staticmethod
    def of(A: Array, B: Array, C: Array, D: Array) -> RationalSystem:
        """The system of matrices of doubles, exactly as written."""
        return RationalSystem(rational(A), rational(B), rational(C), rational(D), D.shape[1])

    @property
    def order(self) -> int:
        """The number of states."""
        return len(self.A)

    def dual(self) -> RationalSystem:
        """The system of the transposed transfer matrix."""
        n, ny = self.order, len(self.D)
        return RationalSystem(
            transpose(self.A, n), transpose(self.C, n), transpose(self.B, self.nu), transpose(self.D, self.nu), ny
        )

    def controllable_part(self) -> RationalSystem:
        """The system on the states that its inputs reach.

        The reachable subspace gets a basis that is the identity in some of the states, the pivots: these states are the
        coordinates, and what the others are in them stands in the rows of the basis.
        """
        n = self.order
        if _reaches_all_modulo(self.A, self.B):
            return self
        basis, pivots = _reachable(self.A, self.B, self.nu)
        if len(pivots) == n:
            return self
        spanned = transpose(basis, n)  # V, (n, rank)
        A = product([self.A[i] for i in pivots], spanned, len(pivots))
        return RationalSystem(A, [self.B[i] for i in pivots], product(self.C, spanned, len(pivots)), self.D, self.nu)

    def minimal(self) -> RationalSystem:
        """The part that its inputs reach and its outputs show."""
        return self.controllable_part().dual().controllable_part().dual()

    def zero_dynamics(self) -> RationalSystem:
        """The system with an invertible D and the same finite zeros and normal rank.

        References
        ----------
        Emami-Naeini and Van Dooren (1982), Computation of zeros of linear multivariable systems, Automatica 18.
        """
        return _independent_outputs(_independent_outputs(self).dual()).dual()

    def zeros_polynomial(self) -> Polynomial:
        """The polynomial with whole coefficients of which a system with invertible D has the roots as zeros."""
        n = self.order
        rows = [d + c for d, c in zip(self.D, self.C, strict=True)]
        solved, _ = echelon(rows, self.nu)
        gain = [row[self.nu :] for row in solved]  # D^-1 C
        moved = product(self.B, gain, n)
        A = [[a - b for a, b in zip(*both, strict=True)] for both in zip(self.A, moved, strict=True)]
        return rational_characteristic_polynomial(A)


def _reachable(A: Matrix, B: Matrix, nu: int) -> tuple[Matrix, list[int]]:
    """A basis of the states that the inputs reach, as rows in reduced echelon form, and its pivots."""
    n = len(A)
    basis: Matrix = []
    transposed, news = transpose(A, n), transpose(B, nu)
    pivots: list[int] = []
    while news:
        before = len(pivots)
        rows, pivots = echelon(basis + news, n)
        basis = rows[: len(pivots)]
        if len(pivots) in (before, n):
            break
        news = product(basis, transposed, n)
    return basis, pivots


def _reaches_all_modulo(A: Matrix, B: Matrix) -> bool:
    """True if the inputs reach all states modulo a prime, and so exactly too; False proves nothing."""
    if any(x.denominator % PRIME == 0 for row in (*A, *B) for x in row):
        return False
    n = len(A)
    moves = np.array([[_residue(x) for x in row] for row in A], dtype=object).reshape(n, n)
    news = [np.array([_residue(row[j]) for row in B], dtype=object) for j in range(len(B[0]) if B else 0)]
    basis: dict[int, NDArray[np.object_]] = {}  # by the place of the first entry, which is 1
    while news:
        vector = news.pop()
        for place in range(n):
            if vector[place] and place in basis:
                vector = (vector - vector[place] * basis[place]) % PRIME
        first = next((i for i in range(n) if vector[i]), None)
        if first is not None:
            basis[first] = vector * pow(int(vector[first]), -1, PRIME) % PRIME
            news.append(moves @ basis[first] % PRIME)
    return len(basis) == n


def _residue(x: Fraction) -> int:
    return x.numerator * pow(x.denominator, -1, PRIME) % PRIME


def _independent_outputs(system: RationalSystem) -> RationalSystem:
    """The system with the same finite zeros and normal rank whose D has independent rows.

    An output without a direct term that is held at zero binds a state: the bound states leave, and their rates, which
    must be zero too, take the place of the outputs.
    """
    while True:
        n, nu = system.order, system.nu
        rows, pivots = echelon([d + c for d, c in zip(system.D, system.C, strict=True)], nu)
        direct, rest = rows[: len(pivots)], [row[nu:] for row in rows[len(pivots) :]]
        D, C = [row[:nu] for row in direct], [row[nu:] for row in direct]
        binding, bound = echelon(rest, n)
        if not bound:
            return RationalSystem(system.A, system.B, C, D, nu)
        binding = binding[: len(bound)]
        free = [j for j in range(n) if j not in bound]
        E = [[Fraction(0)] * len(free) for _ in range(n)]  # x = E (free states), where the bound outputs are zero
        for place, j in enumerate(free):
            E[j][place] = Fraction(1)
            for row, i in zip(binding, bound, strict=True):
                E[i][place] = -row[j]
        AE = product(system.A, E, len(free))
        system = RationalSystem(
            [AE[j] for j in free],
            [system.B[j] for j in free],
            product(binding, AE, len(free)) + product(C, E, len(free)),
            product(binding, system.B, nu) + D,
            nu,
        )
