"""First answers to a Riccati equation, by several roads: none is trusted, each may start Newton's method.

References
----------
Laub (1979), A Schur method for solving algebraic Riccati equations, IEEE Trans. Autom. Control 24.
Byers (1987), Solving the algebraic Riccati equation with the matrix sign function, Linear Algebra Appl. 85.
Chu, Fan, Lin, Wang (2004), Structure-preserving algorithms for periodic discrete-time algebraic Riccati
equations, Int. J. Control 77 (doubling).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator

import numpy as np
from scipy import linalg

from workbench.design.riccati.equation import Data
from workbench.design.riccati.hamiltonian import hamiltonian, plain, quadratic
from workbench.validation.refusals import Array

MOST_ROUNDS = 60  # of an iteration that squares or doubles


def continuous(d: Data) -> Iterator[Array]:
    """Symmetric candidates X (n, n) for the continuous equation; a road that fails gives none."""
    yield from _by(d, _zero, _schur, _scipy_continuous, _sign)


def discrete(d: Data) -> Iterator[Array]:
    """Symmetric candidates X (n, n) for the discrete equation; a road that fails gives none."""
    yield from _by(d, _zero, _doubling, _scipy_discrete)


def _by(d: Data, *roads: Callable[[Data], Array]) -> Iterator[Array]:
    for road in roads:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # an inaccurate candidate is judged by what Newton makes of it
                X = road(d)
        except (np.linalg.LinAlgError, ValueError):
            continue
        if np.isfinite(X).all():
            yield (X + X.T) / 2


def _zero(d: Data) -> Array:
    """The solution where nothing costs and all is stable: Newton's method would only come ever nearer to it."""
    if d.Q.any() or d.S.any():
        raise np.linalg.LinAlgError("there is a cost")
    return np.zeros((d.n, d.n))


def _schur(d: Data) -> Array:
    """By an orthogonal basis [U1; U2] of the stable subspace of the Hamiltonian: X = U2 U1^-1."""
    n = d.n
    _, U, stable = linalg.schur(hamiltonian(d), output="real", sort="lhp")
    if stable != n:
        raise np.linalg.LinAlgError("the Hamiltonian has eigenvalues on the imaginary axis")
    return np.asarray(np.linalg.solve(U[:n, :n].T, U[n:, :n].T).T)


def _scipy_continuous(d: Data) -> Array:
    return np.asarray(linalg.solve_continuous_are(d.A, d.B, d.Q, d.R, e=d.E, s=d.S))


def _scipy_discrete(d: Data) -> Array:
    return np.asarray(linalg.solve_discrete_are(d.A, d.B, d.Q, d.R, e=d.E, s=d.S))


def _sign(d: Data) -> Array:
    """By Newton's iteration for the sign of the Hamiltonian, scaled by its determinant: (sign + I) [I; X] = 0."""
    Z, n = hamiltonian(d), d.n
    for _ in range(MOST_ROUNDS):
        scale = np.exp(-np.linalg.slogdet(Z)[1] / (2 * n))
        following = (scale * Z + np.linalg.inv(Z) / scale) / 2
        change, Z = np.linalg.norm(following - Z), following
        if change <= 1e-14 * np.linalg.norm(Z):
            break
    kernel = Z + np.eye(2 * n)
    return np.asarray(np.linalg.lstsq(kernel[:, n:], -kernel[:, :n])[0])


def _doubling(d: Data) -> Array:
    """By doubling the horizon again and again; quadratic as long as R has an inverse."""
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
