"""The coefficients of a Riccati equation in time: matrices, or functions of time that are checked at every call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from workbench.design.matrices import answer, definite, matrix, square, symmetric
from workbench.design.riccati_flow.moebius import hamiltonian
from workbench.validation.refusals import Array

Coefficient = Array | Callable[[float], Array]


@dataclass(frozen=True, eq=False)
class Terms:
    """The coefficients at one time: A (n, n), B (n, m), Q (n, n), R (m, m), and G = B R^-1 B' (n, n)."""

    A: Array
    B: Array
    Q: Array
    R: Array
    G: Array

    def gain(self, P: Array) -> Array:
        """K = R^-1 B' P, (m, n)."""
        return np.array(np.linalg.solve(self.R, self.B.T @ P))

    def rest(self, P: Array) -> float:
        """The norm of A'P + PA - PGP + Q over the sum of those of its terms."""
        # over the largest entry, as squares of P G P may leave the range of numbers
        terms = (self.A.T @ P, P @ self.A, -P @ self.G @ P, self.Q)
        most = max(float(np.abs(term).max()) for term in terms)
        if not most:
            return 0.0
        over = [term / most for term in terms]
        return float(np.linalg.norm(sum(over))) / sum(float(np.linalg.norm(term)) for term in over)


@dataclass(frozen=True, eq=False)
class Coefficients:
    """A, B, Q, R as they were given to `call`."""

    call: str
    A: Any
    B: Any
    Q: Any
    R: Any

    @property
    def constant(self) -> bool:
        """Whether none of them is a function of time."""
        return not any(map(callable, (self.A, self.B, self.Q, self.R)))

    def at(self, t: float) -> Terms:
        """The coefficients at time t in s, checked.

        Raises
        ------
        ValueError
            If A is not square, B, Q or R does not fit it, Q is not symmetric or R not positive definite, or the
            numbers of states and inputs are not those of the first time asked for.
        """
        if self.constant:
            return self._still
        terms = self._terms(f"{self.call} at t = {t:g} s", t)
        first = self._shape.setdefault("B", terms.B.shape)
        if terms.B.shape != first:
            raise ValueError(
                f"`{self.call} at t = {t:g} s`: B must have the same shape (n, m) at all times; got {terms.B.shape} "
                f"after {first}. Where states or inputs come or go, solve for each stretch of time by itself."
            )
        return terms

    @cached_property
    def _shape(self) -> dict[str, tuple[int, ...]]:
        """That of B when it was first asked for."""
        return {}

    @cached_property
    def _still(self) -> Terms:
        return self._terms(self.call, 0.0)

    @cached_property
    def _checked(self) -> dict[str, Array]:
        """What is constant among them and has been checked once."""
        return {}

    def _terms(self, call: str, t: float) -> Terms:
        A = self._part(call, "A", t, square)
        n = len(A)
        B = self._part(call, "B", t, lambda call, name, X: matrix(call, name, X, n))
        Q = self._part(call, "Q", t, lambda call, name, X: symmetric(call, name, X, n))
        R = self._part(call, "R", t, lambda call, name, X: definite(call, name, X, B.shape[1]))
        half = np.linalg.solve(np.linalg.cholesky(R), B.T)
        return Terms(A, B, Q, R, half.T @ half)

    def _part(self, call: str, name: str, t: float, check: Callable[[str, str, Any], Array]) -> Array:
        given = getattr(self, name)
        if callable(given):
            return check(call, name, answer(call, name, given, t))
        if name not in self._checked:
            self._checked[name] = check(call, name, given)
        return self._checked[name]

    def scale(self, t: float) -> float:
        """A power of two s such that P / s has terms P G P and Q of like size."""
        terms = self.at(t)
        a, g, q = (float(np.linalg.norm(X)) for X in (terms.A, terms.G, terms.Q))
        square_of = q / g if q and g else (a / g) ** 2 if g and a else (q / a) ** 2 if q and a else 1.0
        return float(2.0 ** np.round(np.log2(square_of) / 2))

    def hamiltonian(self, t: float, scale: float) -> Array:
        """H (2n, 2n) of the equation for P / scale."""
        terms = self.at(t)
        return hamiltonian(terms.A, scale * terms.G, terms.Q / scale)
