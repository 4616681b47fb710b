"""An algebraic Riccati equation: its residual at an X, the derivative there with its inverse, and its Hamiltonian."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, Complex
from workbench.design.riccati.double_double import Twice, twice

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
class RiccatiPoint:
    """An equation at an X (n, n): its gain K (m, n), the loop A - B K, and its residual.

    `beside_A` and `beside_E` (n, n) stand beside a change of A and of E in the change of the equation; `terms` is the
    norm of what the `residual` is summed from; W (m, m) is what an input costs in the end: R, or R + B'XB.
    """

    X: Array
    K: Array
    closed_loop: Array
    beside_A: Array
    beside_E: Array
    residual: Array
    terms: float
    W: Array

    @property
    def relative(self) -> float:
        """The residual over the size of its terms."""
        return norm(self.residual) / self.terms if self.terms > 0 else 0.0


@dataclass(frozen=True)
class Operator:
    """The map X -> F'XE + E'XF of a flow, or X -> F'XF - E'XE of a recursion, by the Schur form U T U* of F E^-1.

    References
    ----------
    Bartels, Stewart (1972), Solution of the matrix equation AX + XB = C, Comm. ACM 15. Kitagawa (1977), An algorithm
    for solving the matrix equation X = F X F' + S, Int. J. Control 25.
    """

    T: Array | Complex
    U: Array | Complex
    E: Array | None
    discrete: bool

    @staticmethod
    def of(F: Array, E: Array | None, discrete: bool) -> Operator:
        """The operator of the pencil F - lambda E."""
        quotient = F if E is None else np.asarray(np.linalg.solve(E.T, F.T).T)
        T, U = linalg.schur(quotient.astype(complex) if discrete else quotient)
        return Operator(T, U, E, discrete)

    @property
    def poles(self) -> Complex:
        """The eigenvalues (n,) of the pencil."""
        return np.array(np.diag(self.T)) if self.discrete else np.asarray(linalg.eigvals(self.T), dtype=complex)

    @property
    def margins(self) -> Array:
        """The distance of each pole (n,) from instability."""
        return distances(self.poles, self.discrete)

    @property
    def margin(self) -> float:
        """The distance of the slowest pole from instability."""
        return float(self.margins.min())

    def sure_margin(self) -> float:
        """The margin that is left when rounding moves every pole as far as it may (Golub, Van Loan 2013, 7.2.2)."""
        # a list, as SciPy's stub forgets one of the three
        poles, left, right = list(linalg.eig(self.T, left=True, right=True))
        along = np.abs((left.conj() * right).sum(axis=0))
        rounding = EPS * np.linalg.norm(self.T, 2) * (1.0 if self.E is None else np.linalg.cond(self.E))
        return float((distances(np.asarray(poles), self.discrete) - rounding / np.maximum(along, EPS)).min())

    def solve(self, W: Array) -> Array:
        """The symmetric X (n, n) that is mapped to a symmetric W (n, n); `LinAlgError` if there is none."""
        W = W if self.E is None else np.asarray(np.linalg.solve(self.E.T, np.linalg.solve(self.E.T, W).T))
        right = self.U.conj().T @ W @ self.U
        Y = self._by_columns(right) if self.discrete else self._by_lapack(right)
        X = (self.U @ Y @ self.U.conj().T).real
        if not np.isfinite(X).all():
            raise np.linalg.LinAlgError("the operator is singular")
        return np.asarray((X + X.T) / 2)

    def _by_lapack(self, right: Array | Complex) -> Array | Complex:
        Y, scale, perturbed = linalg.lapack.dtrsyl(self.T, self.T, right, trana="T")
        if perturbed:
            raise np.linalg.LinAlgError("two poles add up to zero")
        return np.asarray(Y / scale)

    def _by_columns(self, right: Array | Complex) -> Array | Complex:
        T, n = self.T, len(self.T)
        Y = np.zeros_like(right)
        for k in range(n):
            known = T.conj().T @ (Y[:, :k] @ T[:k, k])
            Y[:, k] = linalg.solve_triangular((T[k, k] * T.conj().T) - np.eye(n), right[:, k] - known, lower=True)
        return Y


@dataclass(frozen=True)
class RiccatiEquation:
    """A'XE + E'XA - (E'XB + S) R^-1 (B'XE + S') + Q = 0, or if it is discrete

    A'XA - E'XE - (A'XB + S) (R + B'XB)^-1 (B'XA + S') + Q = 0.
    """

    data: Data
    discrete: bool

    def at(self, X: Array | Twice) -> RiccatiPoint:
        """The equation at a symmetric X (n, n); `LinAlgError` if there is no gain."""
        d, x = self.data, twice(X)
        V = x if d.E is None else x @ d.E
        if self.discrete:
            XB = x @ d.B
            W = twice(d.B.T) @ XB + d.R
            K = _gain(W, twice(d.A.T) @ XB + d.S)
        else:
            W = twice(d.R)
            K = _gain(W, V.T @ d.B + d.S)
        closed = twice(d.A) - twice(d.B) @ K
        cost = twice(K.T) @ (twice(d.R) @ K) + d.Q
        terms = norm(d.Q) + 2 * norm(d.S) * norm(K) + norm(d.R) * norm(K) ** 2
        largest = norm(d.A) + norm(d.B) * norm(K)
        if self.discrete:
            ahead, now = x @ closed, V if d.E is None else twice(d.E.T) @ V
            half = twice(d.S) @ K
            left = (closed.T @ ahead - now - half - half.T + cost).high
            terms += norm(x.high) * largest**2 + norm(now.high)
            beside = ahead.high, V.high
        else:
            half = V.T @ closed - twice(d.S) @ K
            left = (half + half.T + cost).high
            terms += 2 * norm(V.high) * largest
            beside = V.high, x.high @ closed.high
        return RiccatiPoint(x.high, K, closed.high, *beside, (left + left.T) / 2, terms, W.high)

    def operator(self, point: RiccatiPoint) -> Operator:
        """The derivative of the residual, with F = A - B K."""
        return Operator.of(point.closed_loop, self.data.E, self.discrete)

    def gain_change(self, point: RiccatiPoint, D: Array) -> Array:
        """The first-order change W^-1 B'D E, or W^-1 B'D F, of K (m, n) when X changes by D."""
        return np.asarray(np.linalg.solve(point.W, self._inputs(point, D)))

    def curvature(self, point: RiccatiPoint, H: Array) -> Array:
        """The residual at X + H, for a small H, beyond its linear part, with its sign turned."""
        inputs = self._inputs(point, H)
        return np.asarray(inputs.T @ np.linalg.solve(point.W, inputs))

    def _inputs(self, point: RiccatiPoint, D: Array) -> Array:
        E = point.closed_loop if self.discrete else self.data.E
        return np.asarray(self.data.B.T @ (D if E is None else D @ E))


def distances(poles: Complex, discrete: bool) -> Array:
    """The distance of each pole (n,) to the left of the imaginary axis, or inside the unit circle."""
    return np.asarray(1 - np.abs(poles) if discrete else -poles.real)


def norm(matrix: Array) -> float:
    """The norm of Frobenius, whose squares neither overflow nor vanish."""
    return float(linalg.norm(matrix.ravel(), check_finite=False))


def size(matrix: Array) -> float:
    """The 2-norm; infinite where an entry is not finite, for which LAPACK would print a warning."""
    return float(np.linalg.norm(matrix, 2)) if np.isfinite(matrix).all() else np.inf


def _gain(W: Twice, right: Twice) -> Array:
    """The K with W K = right'."""
    factor = linalg.lu_factor(W.high)
    K = linalg.lu_solve(factor, right.T.high)
    for _ in range(REFINEMENTS):
        K = K + linalg.lu_solve(factor, (right.T - W @ K).high)
    if not np.isfinite(K).all():
        raise np.linalg.LinAlgError("there is no gain")
    return np.asarray(K)


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
