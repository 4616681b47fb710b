"""An algebraic Riccati equation: what is left of it at an X, and its linear part there."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.design.riccati.double_double import Twice, twice
from workbench.design.riccati.operators import AbstractOperator, lyapunov_operator, stein_operator
from workbench.validation.refusals import Array

REFINEMENTS = 3  # of a gain: each gains as many digits as the condition of R + B'XB leaves


@dataclass(frozen=True)
class Data:
    """The matrices of E x' = A x + B u, or E x+ = A x + B u, and of the cost x'Qx + 2 x'Su + u'Ru; E None is I."""

    A: Array
    B: Array
    Q: Array
    R: Array
    S: Array
    E: Array | None

    @property
    def n(self) -> int:
        """The number of states."""
        return len(self.A)


@dataclass(frozen=True)
class Point:
    """An equation at an X.

    Parameters
    ----------
    X, K
        The matrix (n, n) and its gain (m, n).
    closed
        A - B K, (n, n).
    beside_A, beside_E
        The matrices (n, n) that stand beside a change of A and of E in the change of the equation.
    left, terms
        The residual (n, n), and the norm of the terms that it is summed from.
    W
        What an input costs in the end, (m, m): R, or R + B'XB.
    """

    X: Array
    K: Array
    closed: Array
    beside_A: Array
    beside_E: Array
    left: Array
    terms: float
    W: Array

    @property
    def relative(self) -> float:
        """The residual over the size of its terms."""
        return norm(self.left) / self.terms if self.terms > 0 else 0.0


class AbstractEquation(ABC):
    """0 = Res(X), whose stabilising solution is looked for."""

    data: Data

    @abstractmethod
    def at(self, X: Array | Twice) -> Point:
        """The equation at a symmetric X (n, n).

        Raises
        ------
        LinAlgError
            If there is no gain at X.
        """

    @abstractmethod
    def operator(self, point: Point) -> AbstractOperator:
        """The derivative of Res at a point, as a map of symmetric matrices."""

    @abstractmethod
    def steering(self, point: Point, D: Array) -> Array:
        """By how much K (m, n) changes, to first order, when X changes by D."""

    @abstractmethod
    def curvature(self, point: Point, H: Array) -> Array:
        """What Res at X + H has beyond its linear part, with its sign turned: (n, n), positive semidefinite."""


@dataclass(frozen=True)
class Continuous(AbstractEquation):
    """A'XE + E'XA - (E'XB + S) R^-1 (B'XE + S') + Q = 0."""

    data: Data

    def at(self, X: Array | Twice) -> Point:
        """The equation at a symmetric X (n, n)."""
        d, x = self.data, twice(X)
        V = x if d.E is None else x @ d.E
        K = _gain(twice(d.R), V.T @ d.B + d.S)
        closed = twice(d.A) - twice(d.B) @ K
        half = V.T @ closed - twice(d.S) @ K
        left = (half + half.T + twice(K.T) @ (twice(d.R) @ K) + d.Q).high
        terms = 2 * norm(V.high) * (norm(d.A) + norm(d.B) * norm(K)) + _cost(d, K)
        return Point(x.high, K, closed.high, V.high, x.high @ closed.high, _even(left), terms, d.R)

    def operator(self, point: Point) -> AbstractOperator:
        """X -> F'XE + E'XF, F = A - B K."""
        return lyapunov_operator(point.closed, self.data.E)

    def steering(self, point: Point, D: Array) -> Array:
        """R^-1 B'D E."""
        DE = D if self.data.E is None else D @ self.data.E
        return np.asarray(np.linalg.solve(point.W, self.data.B.T @ DE))

    def curvature(self, point: Point, H: Array) -> Array:
        """E'H B R^-1 B'H E."""
        HE = H if self.data.E is None else H @ self.data.E
        inputs = self.data.B.T @ HE
        return np.asarray(inputs.T @ np.linalg.solve(point.W, inputs))


@dataclass(frozen=True)
class Discrete(AbstractEquation):
    """A'XA - E'XE - (A'XB + S) (R + B'XB)^-1 (B'XA + S') + Q = 0."""

    data: Data

    def at(self, X: Array | Twice) -> Point:
        """The equation at a symmetric X (n, n)."""
        d, x = self.data, twice(X)
        V = x if d.E is None else x @ d.E
        XB = x @ d.B
        W = twice(d.B.T) @ XB + d.R
        K = _gain(W, twice(d.A.T) @ XB + d.S)
        closed = twice(d.A) - twice(d.B) @ K
        ahead, now = x @ closed, V if d.E is None else twice(d.E.T) @ V
        half = twice(d.S) @ K
        left = (closed.T @ ahead - now - half - half.T + twice(K.T) @ (twice(d.R) @ K) + d.Q).high
        terms = norm(x.high) * (norm(d.A) + norm(d.B) * norm(K)) ** 2 + norm(now.high) + _cost(d, K)
        return Point(x.high, K, closed.high, ahead.high, V.high, _even(left), terms, W.high)

    def operator(self, point: Point) -> AbstractOperator:
        """X -> F'XF - E'XE, F = A - B K."""
        return stein_operator(point.closed, self.data.E)

    def steering(self, point: Point, D: Array) -> Array:
        """W^-1 B'D F."""
        return np.asarray(np.linalg.solve(point.W, self.data.B.T @ D @ point.closed))

    def curvature(self, point: Point, H: Array) -> Array:
        """F'H B W^-1 B'H F, for a small H."""
        inputs = self.data.B.T @ H @ point.closed
        return np.asarray(inputs.T @ np.linalg.solve(point.W, inputs))


def norm(matrix: Array) -> float:
    """The norm of Frobenius, whose squares neither overflow nor vanish."""
    return float(linalg.norm(matrix.ravel(), check_finite=False))


def size(matrix: Array) -> float:
    """The 2-norm, infinite where an entry is not finite: LAPACK would print what it thinks of that."""
    return float(np.linalg.norm(matrix, 2)) if np.isfinite(matrix).all() else np.inf


def _gain(W: Twice, right: Twice) -> Array:
    """K with W K = right', refined: an ill-conditioned W leaves digits to gain after the first time."""
    factor = linalg.lu_factor(W.high)
    K = linalg.lu_solve(factor, right.T.high)
    for _ in range(REFINEMENTS):
        K = K + linalg.lu_solve(factor, (right.T - W @ K).high)
    if not np.isfinite(K).all():
        raise np.linalg.LinAlgError("there is no gain")
    return np.asarray(K)


def _cost(d: Data, K: Array) -> float:
    return norm(d.Q) + 2 * norm(d.S) * norm(K) + norm(d.R) * norm(K) ** 2


def _even(matrix: Array) -> Array:
    return (matrix + matrix.T) / 2
