"""Units in which a Riccati equation can be solved: a change of units by powers of two makes no rounding error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.layout import Array
from workbench.design.riccati.equation import Data


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


def good_units(d: Data) -> Units:
    """Units in which the extended Hamiltonian pencil has rows and columns alike, and stays Hamiltonian.

    References
    ----------
    Benner (2001), Symplectic balancing of Hamiltonian matrices, SIAM J. Sci. Comput. 22.
    """
    n = d.n
    # the inputs' units come first: they change R by a congruence, which balancing, a similarity, cannot undo
    weight = np.diag(d.R)
    inputs = np.exp2(-np.round(np.log2(np.where(weight > 0, weight, 1.0)) / 2))
    d = Units(np.ones(n), inputs).into(d)
    A, B, Q, R, S = (np.abs(matrix) for matrix in (d.A, d.B, d.Q, d.R, d.S))
    A = A if d.E is None else A + np.abs(d.E)
    pencil = np.block([[A, np.zeros((n, n)), B], [Q, A.T, S], [S.T, B.T, R]])
    np.fill_diagonal(pencil, 0)
    _, (scale, _) = linalg.matrix_balance(pencil, permute=False, separate=True)
    exponent = np.log2(scale)
    states = np.exp2(np.round((exponent[:n] - exponent[n : 2 * n]) / 2))
    return Units(states, inputs)
