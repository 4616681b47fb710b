"""First approximations to the solution of a Riccati equation, and their refinement by Newton's method.

References
----------
Laub (1979), IEEE Trans. Autom. Control 24 (Schur form). Chu, Fan, Lin, Wang (2004), Int. J. Control 77 (doubling).
Kleinman (1968), IEEE Trans. Autom. Control 13, and Hewer (1971), the same, 16 (Newton's method).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS
from workbench.design.riccati.algebraic_equation import (
    Data,
    Operator,
    RiccatiEquation,
    RiccatiPoint,
    hamiltonian,
    norm,
    plain,
    quadratic,
)

MOST_ROUNDS = 60  # of an iteration that squares or doubles
MOST_STEPS = 30  # near a solution a step doubles the digits, far from it or at the edge of stability it halves the way


def _zero(d: Data) -> Array:
    """The solution X = 0 of an equation without cost, to which Newton's method would converge slowly."""
    if d.Q.any() or d.S.any():
        raise np.linalg.LinAlgError("there is a cost")
    return np.zeros((d.n, d.n))


def _schur(d: Data) -> Array:
    """X = U2 U1^-1 from an orthogonal basis [U1; U2] of the stable subspace of the Hamiltonian."""
    n = d.n
    _, U, stable = linalg.schur(hamiltonian(d), output="real", sort="lhp")
    if stable != n:
        raise np.linalg.LinAlgError("the Hamiltonian has eigenvalues on the imaginary axis")
    return np.asarray(np.linalg.solve(U[:n, :n].T, U[n:, :n].T).T)


def _doubling_solution(d: Data) -> Array:
    """X by doubling the horizon again and again; quadratic as long as R has an inverse."""
    p = plain(d)
    A, G, X = p.A, quadratic(p), p.Q
    for _ in range(MOST_ROUNDS):
        inside = np.eye(d.n) + G @ X
        grown = X + A.T @ X @ np.linalg.solve(inside, A)
        A, G = A @ np.linalg.solve(inside, A), G + A @ np.linalg.solve(inside, G) @ A.T
        change, X = np.linalg.norm(grown - X), grown
        if change <= 1e-16 * np.linalg.norm(X):
            break
    return X


@dataclass(frozen=True)
class NewtonResult:
    """The end of Newton's method: the equation at the last X kept, its derivative there, and the steps kept.

    `correction` (n, n) is the next step: to first order, what X still lacks.
    """

    point: RiccatiPoint
    operator: Operator
    steps: int
    correction: Array


def refine(equation: RiccatiEquation, X: Array) -> NewtonResult:
    """Newton's method from X, as long as each step makes the residual smaller; `LinAlgError` if a step fails.

    Where the residual is below the working precision, the next step must be shorter by half.
    """
    now = _looked_at(equation, X, 0)
    while now.steps < MOST_STEPS:
        if norm(now.correction) <= EPS * norm(now.point.X):
            return now
        blind = now.point.relative <= EPS
        following = equation.at(now.point.X + now.correction)
        if following.relative > EPS and not following.relative < now.point.relative:
            return now
        then = _looked_at(equation, following.X, now.steps + 1)
        if blind and not 2 * norm(then.correction) < norm(now.correction):
            return now
        now = then
    return now  # what is left is judged as any other answer


def _looked_at(equation: RiccatiEquation, X: Array, steps: int) -> NewtonResult:
    point = equation.at(X)
    operator = equation.operator(point)
    return NewtonResult(point, operator, steps, operator.solve(-point.residual))


def candidates(equation: RiccatiEquation) -> Iterator[Array]:
    """Symmetric first answers X (n, n) to an equation; a method that fails gives none."""
    d = equation.data

    def scipys(d: Data) -> Array:
        solver = linalg.solve_discrete_are if equation.discrete else linalg.solve_continuous_are
        return np.asarray(solver(d.A, d.B, d.Q, d.R, e=d.E, s=d.S))

    for method in (_zero, _doubling_solution, scipys) if equation.discrete else (_zero, _schur, scipys):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # an inaccurate candidate is judged by what Newton makes of it
                X = method(d)
        except (np.linalg.LinAlgError, ValueError):
            continue
        if np.isfinite(X).all():
            yield (X + X.T) / 2
