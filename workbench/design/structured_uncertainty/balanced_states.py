"""A stable system in balanced states, in doubles: they spoil the eigenvalues of its Hamiltonian matrices least."""

from __future__ import annotations

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS
from workbench.design.structured_uncertainty.frequency_bands import PerturbedSystem
from workbench.design.structured_uncertainty.magnitude_fit import Matrices

CHANGE = 1e-9  # relative: the change of a gain by rounding that is accepted


def in_balanced_states(system: Matrices, omega: Array) -> Matrices | None:
    """The same system in balanced states, or None if rounding changes a gain at some frequency by more than 1e-9."""
    A, B, C, D = system
    controlled = _root(np.asarray(linalg.solve_continuous_lyapunov(A, -B @ B.T), dtype=float))
    observed = _root(np.asarray(linalg.solve_continuous_lyapunov(A.T, -C.T @ C), dtype=float))
    U, values, Vt = linalg.svd(observed.T @ controlled)
    if not values[-1] > 0:
        return None
    T = controlled @ Vt.T / np.sqrt(values)
    inverse = (U / np.sqrt(values)).T @ observed.T
    inverse = 2 * inverse - inverse @ T @ inverse  # a step of Newton's method: both factors have roundings of their own
    balanced = inverse @ A @ T, inverse @ B, C @ T, D
    for w in [0.0, *omega]:
        before, after = PerturbedSystem(*system).at(w), PerturbedSystem(*balanced).at(w)
        if not np.linalg.norm(after - before, 2) <= CHANGE * np.linalg.norm(before, 2):
            return None
    return balanced


def _root(gramian: Array) -> Array:
    """A factor R with R R' = a Gramian, whose eigenvalues below rounding count as rounding."""
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, EPS**2 * values.max())))
