"""The scaling of a Riccati equation, and the sensitivity of its solution to small changes of the data.

The inverse of the derivative of Res at a stabilising solution, with its sign turned, maps semidefinite matrices to
such. So a change of the equation between -M and M moves X by no more than H(M), the image of M. A change dZ of a
matrix enters as P' dZ + dZ' P, which lies between both signs of c r^2 Z'Z + P'P / c for every c > 0, with r = |d|.

That linear picture ends where the curvature of Res along H(M) reaches M / 4 (for one state Kantorovich's condition,
for more an estimate), or, for a continuous equation, at the least singular value of H - i omega over the frequencies
of the slow poles, with the Hamiltonian matrix H. Both are pessimistic, so the larger one counts.

References
----------
Kenney, Hewer (1990), The sensitivity of the algebraic and differential Riccati equations, SIAM J. Control
Optim. 28. Kantorovich, Akilov (1964), Functional Analysis in Normed Spaces, XVIII.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, DesignError
from workbench.design.riccati.algebraic_equation import Data, RiccatiEquation, hamiltonian, norm, size
from workbench.design.riccati.newton import NewtonResult

Exponents = NDArray[np.int64]
LEAST = float(np.finfo(float).tiny / np.finfo(float).eps)  # below it the digits of a sum get lost
UNDER = 1e-6  # so that a half is rounded down in the units of every caller
ENOUGH = 0.25  # x = h + x^2 has a real solution up to h = 1/4
MOST_POLES = 12  # whose frequencies are looked at: each asks for singular values


@dataclass(frozen=True)
class BinaryUnits:
    """The exponents of two in the units of states (n,) and inputs (m,): x = 2^states z, u = 2^inputs v."""

    states: Exponents
    inputs: Exponents

    def into(self, d: Data) -> Data:
        """The data in these units."""
        x, u = self.states, self.inputs
        return Data(
            A=times(d.A, -x, x),
            B=times(d.B, -x, u),
            Q=times(d.Q, x, x),
            R=times(d.R, u, u),
            S=times(d.S, x, u),
            E=None if d.E is None else times(d.E, -x, x),
        )

    def out_of(self, X: Array) -> Array:
        """X (n, n) in the units of the caller."""
        return times(X, -self.states, -self.states)

    def gain(self, K: Array) -> Array:
        """K (m, n) in the units of the caller."""
        return times(K, self.inputs, -self.states)

    def __add__(self, other: BinaryUnits) -> BinaryUnits:
        """The composition of two changes of units: the exponents add."""
        return BinaryUnits(self.states + other.states, self.inputs + other.inputs)


def times(matrix: Array, rows: Exponents, columns: Exponents) -> Array:
    """The matrix with its rows and columns times powers of two; entries too small for a float become zero."""
    return np.asarray(np.ldexp(matrix, rows[:, None] + columns))


def in_range(call: str, name: str, full: Array, within: Array) -> Array:
    """A matrix in the units of the caller, refused if its largest entry overflows or has lost digits."""
    largest = float(np.abs(full).max())
    if not (np.isfinite(largest) and (largest >= LEAST or not within.any())):
        raise DesignError(
            f"`{call}`: the largest entry of {name} lies beyond the range of floating-point numbers, being "
            f"{largest:.3g} in their arithmetic. Choose other units."
        )
    return full


def good_units(d: Data) -> BinaryUnits:
    """Units in which the extended Hamiltonian pencil has rows and columns alike, and stays Hamiltonian.

    References
    ----------
    Benner (2001), Symplectic balancing of Hamiltonian matrices, SIAM J. Sci. Comput. 22. Kenney, Laub, Wette (1989),
    Systems Control Lett. 12 (the size of X).
    """
    n, m = d.B.shape
    none = BinaryUnits(np.zeros(n, dtype=int), np.zeros(m, dtype=int))
    units = _level(d)
    # the inputs' units come next: they change R by a congruence, which balancing, a similarity, cannot undo
    weight = np.diag(units.into(d).R)
    units += BinaryUnits(none.states, -nearest(np.where(weight > 0, weight, 1.0), 2))
    units += BinaryUnits(balance(_pencil(units.into(d)), n), none.inputs)
    alike = units.into(d)
    return units + BinaryUnits(none.states + nearest(norm(alike.B), 2) - nearest(norm(alike.Q), 4), none.inputs)


@overload
def nearest(sizes: float, root: int) -> np.int64: ...
@overload
def nearest(sizes: Array, root: int) -> Exponents: ...
def nearest(sizes: float | Array, root: int) -> np.int64 | Exponents:
    """The whole numbers nearest to the binary logarithms of the roots of sizes; zero for a size that is zero."""
    logarithms = np.log2(np.where(np.asarray(sizes) > 0, sizes, 1.0))
    exponents: np.int64 | Exponents = np.round(logarithms / root - UNDER).astype(int)
    return exponents


def _pencil(d: Data) -> Array:
    A, B, Q, R, S = (np.abs(matrix) for matrix in (d.A, d.B, d.Q, d.R, d.S))
    A = A if d.E is None else A + np.abs(d.E)
    return np.block([[A, np.zeros((d.n, d.n)), B], [Q, A.T, S], [S.T, B.T, R]])


def _level(d: Data) -> BinaryUnits:
    """Units that bring the logarithms of the pencil's entries nearest to one number (Curtis and Reid 1972)."""
    n, m = d.B.shape
    pencil = _pencil(d)
    seen = (pencil != 0).astype(float)
    logarithm = np.log2(np.where(pencil != 0, pencil, 1.0))
    states, inputs, one = *np.split(np.eye(n + m + 1)[:-1], [n]), np.eye(n + m + 1)[[-1] * len(pencil)]
    # what a power of each unit, and of the one size, does to the exponents of rows and columns
    rows, columns = np.vstack([-states, states, inputs]) - one, np.vstack([states, -states, inputs])
    across = rows.T @ seen @ columns
    normal = across + across.T + rows.T * seen.sum(axis=1) @ rows + columns.T * seen.sum(axis=0) @ columns
    right = rows.T @ logarithm.sum(axis=1) + columns.T @ logarithm.sum(axis=0)
    exponent = np.round(np.linalg.lstsq(normal, -right)[0][:-1] - UNDER).astype(int)
    return BinaryUnits(*np.split(exponent, [n]))


def balance(pencil: Array, n: int) -> Exponents:
    """The exponents (n,) of units that balance a pencil, whose first n rows are of states and the next n dual."""
    np.fill_diagonal(pencil, 0)
    _, _, _, scale, _ = linalg.lapack.dgebal(pencil, scale=1)
    exponent = np.log2(scale)
    return np.asarray(np.round((exponent[:n] - exponent[n : 2 * n]) / 2).astype(int))


@dataclass(frozen=True)
class Conditioning:
    """The effect of small changes of the data.

    `condition` and `in_good_units` bound the relative change of X, in the 2-norm, over that of every matrix in good
    units: as the caller measures X, and in good units. Up to a relative change of every matrix by about `reach` there
    is a stabilising solution. `response` is how far X moves when the equation is changed by a matrix of norm one.
    """

    condition: float
    in_good_units: float
    reach: float
    response: float


def conditioning(equation: RiccatiEquation, solution: NewtonResult, units: BinaryUnits) -> Conditioning:
    """The effect of relative changes of A, B, Q, R, S and E in their 2-norms."""
    d, point = equation.data, solution.point
    one = np.eye(d.n)
    changes = [
        (size(d.A), point.beside_A, one),
        (size(d.B), point.beside_A, point.K),
        (size(d.Q) / 2, one, one),
        (size(d.R) / 2, point.K, point.K),
        (size(d.S), one, point.K),
        (0.0 if d.E is None else size(d.E), point.beside_E, one),
    ]
    moved: dict[int, Array] = {}

    def most(P: Array) -> Array:
        """H(P'P)."""
        if id(P) not in moved:
            moved[id(P)] = solution.operator.solve(-P.T @ P)
        return moved[id(P)]

    whole, X = size(units.out_of(point.X)), size(point.X)
    total, inside, M = 0.0, 0.0, np.zeros((d.n, d.n))
    for r, P, Z in changes:
        by_P, by_Z = size(most(P)), size(most(Z))
        if not r * by_P * by_Z > 0:
            continue
        total += 2 * r * np.sqrt(size(units.out_of(most(P)))) * np.sqrt(size(units.out_of(most(Z))))
        inside += 2 * r * np.sqrt(by_P) * np.sqrt(by_Z)
        c = np.sqrt(by_P / by_Z) / r
        M += c * r**2 * Z.T @ Z + P.T @ P / c
    reach = _reach(equation, solution, M)
    if reach <= EPS**0.75 and not equation.discrete:
        reach = max(reach, _distance(d, solution))
    response = size(units.out_of(most(one)))
    return Conditioning(total / whole if whole > 0 else 0.0, inside / X if X > 0 else 0.0, reach, response)


def _reach(equation: RiccatiEquation, solution: NewtonResult, M: Array) -> float:
    """The largest t with curvature(H(t M)) <= t M / 4."""
    if not M.any():
        return 1.0
    bent = equation.curvature(solution.point, solution.operator.solve(-M))
    values, vectors = np.linalg.eigh(M)
    root = vectors / np.sqrt(np.maximum(values, EPS * values[-1]))
    most = float(linalg.eigvalsh(root.T @ bent @ root)[-1])
    return min(1.0, ENOUGH / most) if most > 0 else 1.0


def _distance(d: Data, solution: NewtonResult) -> float:
    """The least singular value of H - i omega at the frequencies of the slowest poles, over the norm of H."""
    H, one = hamiltonian(d), np.eye(2 * d.n)
    slow = solution.operator.poles[np.argsort(solution.operator.margins)[:MOST_POLES]]
    least = [np.linalg.svd(H - 1j * omega * one, compute_uv=False)[-1] for omega in np.unique(np.abs(slow.imag))]
    return float(min(least)) / size(H)
