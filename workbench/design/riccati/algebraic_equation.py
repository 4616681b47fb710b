"""An algebraic Riccati equation: its residual at an X, its linear part there, and its Hamiltonian matrix."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from workbench.design.riccati.double_double import Twice, twice
from workbench.design.riccati.operators import (
    LyapunovOperator,
    SteinOperator,
    lyapunov_operator,
    stein_operator,
)
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
    """An equation at an X (n, n): its gain K (m, n), the loop A - B K, and its residual.

    `beside_A` and `beside_E` (n, n) stand beside a change of A and of E in the change of the equation; `terms` is the
    norm of what the residual `left` is summed from; W (m, m) is what an input costs in the end: R, or R + B'XB.
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


@dataclass(frozen=True)
class Continuous:
    """A'XE + E'XA - (E'XB + S) R^-1 (B'XE + S') + Q = 0."""

    data: Data

    def at(self, X: Array | Twice) -> Point:
        """The equation at a symmetric X (n, n); `LinAlgError` if there is no gain."""
        d, x = self.data, twice(X)
        V = x if d.E is None else x @ d.E
        K = _gain(twice(d.R), V.T @ d.B + d.S)
        closed = twice(d.A) - twice(d.B) @ K
        half = V.T @ closed - twice(d.S) @ K
        left = (half + half.T + twice(K.T) @ (twice(d.R) @ K) + d.Q).high
        terms = 2 * norm(V.high) * (norm(d.A) + norm(d.B) * norm(K)) + _cost(d, K)
        return Point(x.high, K, closed.high, V.high, x.high @ closed.high, _even(left), terms, d.R)

    def operator(self, point: Point) -> LyapunovOperator:
        """The derivative of the residual, X -> F'XE + E'XF, with F = A - B K."""
        return lyapunov_operator(point.closed, self.data.E)

    def steering(self, point: Point, D: Array) -> Array:
        """The first-order change R^-1 B'D E of K (m, n) when X changes by D."""
        DE = D if self.data.E is None else D @ self.data.E
        return np.asarray(np.linalg.solve(point.W, self.data.B.T @ DE))

    def curvature(self, point: Point, H: Array) -> Array:
        """The residual at X + H beyond its linear part, with its sign turned: E'H B R^-1 B'H E."""
        HE = H if self.data.E is None else H @ self.data.E
        inputs = self.data.B.T @ HE
        return np.asarray(inputs.T @ np.linalg.solve(point.W, inputs))


@dataclass(frozen=True)
class Discrete:
    """A'XA - E'XE - (A'XB + S) (R + B'XB)^-1 (B'XA + S') + Q = 0."""

    data: Data

    def at(self, X: Array | Twice) -> Point:
        """The equation at a symmetric X (n, n); `LinAlgError` if there is no gain."""
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

    def operator(self, point: Point) -> SteinOperator:
        """The derivative of the residual, X -> F'XF - E'XE, with F = A - B K."""
        return stein_operator(point.closed, self.data.E)

    def steering(self, point: Point, D: Array) -> Array:
        """The first-order change W^-1 B'D F of K (m, n) when X changes by D."""
        return np.asarray(np.linalg.solve(point.W, self.data.B.T @ D @ point.closed))

    def curvature(self, point: Point, H: Array) -> Array:
        """The residual at X + H beyond its linear part, with its sign turned: F'H B W^-1 B'H F for a small H."""
        inputs = self.data.B.T @ H @ point.closed
        return np.asarray(inputs.T @ np.linalg.solve(point.W, inputs))


def norm(matrix: Array) -> float:
    """The norm of Frobenius, whose squares neither overflow nor vanish."""
    return float(linalg.norm(matrix.ravel(), check_finite=False))


def size(matrix: Array) -> float:
    """The 2-norm; infinite where an entry is not finite, for which LAPACK would print a warning."""
    return float(np.linalg.norm(matrix, 2)) if np.isfinite(matrix).all() else np.inf


def _gain(W: Twice, right: Twice) -> Array:
    """The K with W K = right', after one step of iterative refinement for an ill-conditioned W."""
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


def plain(d: Data) -> Data:
    """The same equation without S and E, for methods that know neither; R must have an inverse."""
    if d.S.any():
        shift = np.linalg.solve(d.R, d.S.T)
        d = replace(d, A=d.A - d.B @ shift, Q=d.Q - d.S @ shift, S=np.zeros_like(d.S))
    if d.E is not None:  # the state of the plain equation is E x
        Q = np.linalg.solve(d.E.T, np.linalg.solve(d.E.T, d.Q).T)
        d = replace(d, A=np.asarray(np.linalg.solve(d.E.T, d.A.T).T), Q=(Q + Q.T) / 2, E=None)
    return d


def quadratic(d: Data) -> Array:
    """B R^-1 B'."""
    return d.B @ np.linalg.solve(d.R, d.B.T)


def hamiltonian(d: Data) -> Array:
    """H (2 n, 2 n), whose stable invariant subspace is spanned by [I; X] if E is the identity."""
    p = plain(d)
    return np.block([[p.A, -quadratic(p)], [-p.Q, -p.A.T]])


Equation = Continuous | Discrete
