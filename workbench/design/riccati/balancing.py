"""Units in which a Riccati equation can be solved: a change of units by powers of two makes no rounding error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import linalg

from workbench.core.layout import Array
from workbench.design.certificates import Refused
from workbench.design.riccati.algebraic_equation import Data, norm

Exponents = np.ndarray[Any, np.dtype[np.int64]]
LEAST = float(np.finfo(float).tiny / np.finfo(float).eps)  # below it the digits of a sum get lost
UNDER = 1e-6  # so that a half is rounded down in the units of every caller


@dataclass(frozen=True)
class Units:
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

    def __add__(self, other: Units) -> Units:
        """These units, measured by others."""
        return Units(self.states + other.states, self.inputs + other.inputs)


def times(matrix: Array, rows: Exponents, columns: Exponents) -> Array:
    """The matrix with its rows and columns times powers of two; what is too small for a float becomes zero."""
    return np.asarray(np.ldexp(matrix, rows[:, None] + columns))


def in_range(call: str, name: str, full: Array, within: Array) -> Array:
    """A matrix in the units of the caller, refused if its largest entry overflows or has lost digits."""
    largest = float(np.abs(full).max())
    if not (np.isfinite(largest) and (largest >= LEAST or not within.any())):
        raise Refused(
            f"`{call}`: the largest entry of {name} lies beyond the range of floating-point numbers, being "
            f"{largest:.3g} in their arithmetic. Choose other units."
        )
    return full


def good_units(d: Data) -> Units:
    """Units in which the extended Hamiltonian pencil has rows and columns alike, and stays Hamiltonian.

    Balancing leaves a state alone that nothing drives or that drives nothing, so it starts where the entries are
    nearest to one size: then the answer is the same in all units of the caller.

    References
    ----------
    Benner (2001), Symplectic balancing of Hamiltonian matrices, SIAM J. Sci. Comput. 22.
    Kenney, Laub, Wette (1989), A stability-enhancing scaling procedure for Schur-Riccati solvers, Systems
    Control Lett. 12 (the size of X).
    """
    n, m = d.B.shape
    none = Units(np.zeros(n, dtype=int), np.zeros(m, dtype=int))
    units = _level(d)
    # the inputs' units come next: they change R by a congruence, which balancing, a similarity, cannot undo
    weight = np.diag(units.into(d).R)
    units += Units(none.states, -nearest(np.where(weight > 0, weight, 1.0), 2))
    units += Units(balance(_pencil(units.into(d)), n), none.inputs)
    alike = units.into(d)
    return units + Units(none.states + nearest(norm(alike.B), 2) - nearest(norm(alike.Q), 4), none.inputs)


def nearest(sizes: Any, root: int) -> Any:
    """The whole numbers nearest to the binary logarithms of the roots of sizes; zero for a size that is zero."""
    return np.round(np.log2(np.where(np.asarray(sizes) > 0, sizes, 1.0)) / root - UNDER).astype(int)


def _pencil(d: Data) -> Array:
    A, B, Q, R, S = (np.abs(matrix) for matrix in (d.A, d.B, d.Q, d.R, d.S))
    A = A if d.E is None else A + np.abs(d.E)
    return np.block([[A, np.zeros((d.n, d.n)), B], [Q, A.T, S], [S.T, B.T, R]])


def _level(d: Data) -> Units:
    """Units that bring the logarithms of the pencil's entries, but for zeros, nearest to one number by least squares.

    References
    ----------
    Curtis, Reid (1972), On the automatic scaling of matrices for Gaussian elimination, IMA J. Appl. Math. 10.
    """
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
    return Units(*np.split(exponent, [n]))


def balance(pencil: Array, n: int) -> Exponents:
    """The exponents (n,) of units that balance a pencil, whose first n rows are of states and the next n dual."""
    np.fill_diagonal(pencil, 0)
    _, _, _, scale, _ = linalg.lapack.dgebal(pencil, scale=1)
    exponent = np.log2(scale)
    return np.asarray(np.round((exponent[:n] - exponent[n : 2 * n]) / 2).astype(int))
