"""What a caller gives: the matrices of an equation, or a python-control `StateSpace`."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.design.matrices import definite, invertible, matrix, square, symmetric
from workbench.design.riccati.equation import Data
from workbench.validation.refusals import Array


def data(call: str, A: Any, B: Any, Q: Any, R: Any, S: Any, E: Any, positive: bool = True) -> Data:
    """The matrices of a Riccati equation, checked; R need not be positive definite if `positive` is False.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q or R not symmetric, R not positive definite, or E
        singular.
    """
    a = square(call, "A", A)
    n = len(a)
    b = matrix(call, "B", B, rows=n)
    m = b.shape[1]
    weight = definite if positive else symmetric
    return Data(
        A=a,
        B=b,
        Q=symmetric(call, "Q", Q, n),
        R=weight(call, "R", R, m),
        S=np.zeros((n, m)) if S is None else matrix(call, "S", S, n, m),
        E=None if E is None else invertible(call, "E", E, n),
    )


def is_system(value: Any) -> bool:
    """Whether a value is a linear system by its matrices, as python-control's `StateSpace`."""
    return all(hasattr(value, name) for name in ("A", "B", "C", "D", "dt"))


def is_discrete(system: Any) -> bool:
    """Whether a system is sampled: python-control writes 0 or None for one that is not."""
    return system.dt not in (0, None)


def joint(call: str, names: str, Q: Array, N: Array, R: Array) -> None:
    """Check that [Q N; N' R] is positive semidefinite.

    Raises
    ------
    ValueError
        If it has a negative eigenvalue beyond rounding.
    """
    # measured by the roots of the diagonals, in which the rounding of eigenvalues means something
    whole = np.block([[Q, N], [N.T, R]])
    root = np.sqrt(np.maximum(np.diag(whole), np.finfo(float).tiny))
    values = np.linalg.eigvalsh(whole / root[:, None] / root)
    if values[0] < -8 * len(whole) * np.finfo(float).eps * max(1.0, np.abs(values).max()):
        raise ValueError(
            f"`{call}`: {names} must be positive semidefinite, or the cost has no minimum; its least eigenvalue, with "
            f"its diagonal scaled to one, is {values[0]:.3g}. Weigh less across, or more on the diagonal."
        )
