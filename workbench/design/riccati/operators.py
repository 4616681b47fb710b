"""The linear operators of Lyapunov and Stein, inverted by way of a Schur form.

References
----------
Bartels, Stewart (1972), Solution of the matrix equation AX + XB = C, Comm. ACM 15.
Kitagawa (1977), An algorithm for solving the matrix equation X = F X F' + S, Int. J. Control 25.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import linalg

from workbench.design.matrices import EPS, Complex
from workbench.validation.refusals import Array


class AbstractOperator(ABC):
    """A linear map of symmetric matrices, and its inverse."""

    @property
    @abstractmethod
    def poles(self) -> Complex:
        """The eigenvalues (n,) of the pencil F - lambda E."""

    T: Any
    E: Array | None

    @abstractmethod
    def inside(self, poles: Complex) -> Array:
        """The distance of each of poles (n,) from instability."""

    def margins(self) -> Array:
        """The distance of each pole (n,) from instability."""
        return self.inside(self.poles)

    @property
    def margin(self) -> float:
        """The distance of the slowest pole from instability."""
        return float(self.margins().min())

    def sure_margin(self) -> float:
        """The margin that is left when rounding moves every pole as far as it may, to first order in its size.

        References
        ----------
        Golub, Van Loan (2013), Matrix Computations, section 7.2.2 (the condition of an eigenvalue).
        """
        poles, left, right = linalg.eig(self.T, left=True, right=True)
        along = np.abs((left.conj() * right).sum(axis=0))
        rounding = EPS * np.linalg.norm(self.T, 2) * (1.0 if self.E is None else np.linalg.cond(self.E))
        return float((self.inside(np.asarray(poles)) - rounding / np.maximum(along, EPS)).min())

    @property
    def slowest(self) -> complex:
        """The pole nearest to instability, or farthest beyond it."""
        return complex(self.poles[self.margins().argmin()])

    @abstractmethod
    def solve(self, W: Array) -> Array:
        """The symmetric X (n, n) that is mapped to a symmetric W (n, n); `LinAlgError` if there is none."""


@dataclass(frozen=True)
class LyapunovOperator(AbstractOperator):
    """The map X -> F' X E + E' X F, by the real Schur form U T U' of F E^-1."""

    T: Array
    U: Array
    E: Array | None

    @property
    def poles(self) -> Complex:
        """The eigenvalues of T."""
        return np.asarray(linalg.eigvals(self.T), dtype=complex)

    def inside(self, poles: Complex) -> Array:
        """The distance to the left of the imaginary axis."""
        return np.asarray(-poles.real)

    def solve(self, W: Array) -> Array:
        """The solution by LAPACK's `dtrsyl`."""
        right = self.U.T @ _divided(W, self.E) @ self.U
        Y, scale, perturbed = linalg.lapack.dtrsyl(self.T, self.T, right, trana="T")
        if perturbed:
            raise np.linalg.LinAlgError("two poles add up to zero")
        return _finite(self.U @ (Y / scale) @ self.U.T)


@dataclass(frozen=True)
class SteinOperator(AbstractOperator):
    """The map X -> F' X F - E' X E, by the complex Schur form U T U* of F E^-1."""

    T: Complex
    U: Complex
    E: Array | None

    @property
    def poles(self) -> Complex:
        """The diagonal of T."""
        return np.array(np.diag(self.T))

    def inside(self, poles: Complex) -> Array:
        """The distance inside the unit circle."""
        return np.asarray(1 - np.abs(poles))

    def solve(self, W: Array) -> Array:
        """The solution column by column, as each depends on those before it."""
        T, n = self.T, len(self.T)
        right = self.U.conj().T @ _divided(W, self.E) @ self.U
        Y = np.zeros_like(right)
        for k in range(n):
            known = T.conj().T @ (Y[:, :k] @ T[:k, k])
            Y[:, k] = linalg.solve_triangular((T[k, k] * T.conj().T) - np.eye(n), right[:, k] - known, lower=True)
        return _finite((self.U @ Y @ self.U.conj().T).real)


def lyapunov_operator(F: Array, E: Array | None) -> LyapunovOperator:
    """The operator X -> F' X E + E' X F."""
    T, U = linalg.schur(_quotient(F, E), output="real")
    return LyapunovOperator(T, U, E)


def stein_operator(F: Array, E: Array | None) -> SteinOperator:
    """The operator X -> F' X F - E' X E."""
    T, U = linalg.schur(_quotient(F, E).astype(complex), output="complex")
    return SteinOperator(T, U, E)


def _quotient(F: Array, E: Array | None) -> Array:
    """F E^-1."""
    return F if E is None else np.asarray(np.linalg.solve(E.T, F.T).T)


def _divided(W: Array, E: Array | None) -> Array:
    """E'^-1 W E^-1."""
    return W if E is None else np.asarray(np.linalg.solve(E.T, np.linalg.solve(E.T, W).T))


def _finite(X: Array) -> Array:
    if not np.isfinite(X).all():
        raise np.linalg.LinAlgError("the operator is singular")
    return (X + X.T) / 2
