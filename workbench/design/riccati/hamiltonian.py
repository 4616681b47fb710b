"""The Hamiltonian matrix of a continuous Riccati equation.

References
----------
Lancaster, Rodman (1995), Algebraic Riccati Equations, chapter 7.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.design.riccati.equation import Data
from workbench.validation.refusals import Array


def plain(d: Data) -> Data:
    """The same equation without S and E, for roads that know neither; R must have an inverse."""
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
    """H (2 n, 2 n), whose stable invariant subspace is spanned by [I; X] if E is the identity.

    Raises
    ------
    LinAlgError
        If R or E has no inverse.
    """
    p = plain(d)
    return np.block([[p.A, -quadratic(p)], [-p.Q, -p.A.T]])
