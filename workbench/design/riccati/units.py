"""Units in which a Riccati equation can be solved: a change of units by powers of two makes no rounding error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.layout import Array
from workbench.design.riccati.equation import Data, norm

UNDER = 1e-6  # so that a half is rounded down in the units of every caller


@dataclass(frozen=True)
class Units:
    """Powers of two that states (n,) and inputs (m,) are measured by: x = states z, u = inputs v."""

    states: Array
    inputs: Array

    def into(self, d: Data) -> Data:
        """The data in these units."""
        x, u = self.states, self.inputs
        E = None if d.E is None else d.E / x[:, None] * x
        return Data(
            A=d.A / x[:, None] * x,
            B=d.B / x[:, None] * u,
            Q=d.Q * x[:, None] * x,
            R=d.R * u[:, None] * u,
            S=d.S * x[:, None] * u,
            E=E,
        )

    def out_of(self, X: Array) -> Array:
        """X (n, n) in the units of the caller."""
        return X / self.states[:, None] / self.states

    def gain(self, K: Array) -> Array:
        """K (m, n) in the units of the caller."""
        return K * self.inputs[:, None] / self.states

    def __mul__(self, other: Units) -> Units:
        """These units, measured by others."""
        return Units(self.states * other.states, self.inputs * other.inputs)


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
    units = _level(d)
    # the inputs' units come next: they change R by a congruence, which balancing, a similarity, cannot undo
    weight = np.diag(units.into(d).R)
    units *= Units(np.ones(n), np.exp2(-np.round(np.log2(np.where(weight > 0, weight, 1.0)) / 2)))
    units *= Units(balance(_pencil(units.into(d)), n), np.ones(m))
    alike = units.into(d)
    sizes = norm(alike.Q), norm(alike.B) ** 2
    whole = np.exp2(np.round(np.log2(sizes[1] / sizes[0]) / 4)) if min(sizes) > 0 else 1.0
    return Units(whole * units.states, units.inputs)


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
    exponent = np.linalg.lstsq(normal, -right)[0][:-1]
    return Units(*np.split(np.exp2(np.round(exponent - UNDER)), [n]))


def balance(pencil: Array, n: int) -> Array:
    """The powers of two (n,) of states that balance a pencil, whose first n rows are theirs and the next n dual."""
    np.fill_diagonal(pencil, 0)
    _, (scale, _) = linalg.matrix_balance(pencil, permute=False, separate=True)
    exponent = np.log2(scale)
    return np.asarray(np.exp2(np.round((exponent[:n] - exponent[n : 2 * n]) / 2)))
