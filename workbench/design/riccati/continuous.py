"""The continuous algebraic Riccati equation."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.design.matrices import definite, invertible, matrix, square, symmetric
from workbench.design.riccati.answers import Riccati
from workbench.design.riccati.candidates import continuous
from workbench.design.riccati.equation import Continuous, Data
from workbench.design.riccati.synthesis import stabilising


def care(A: Any, B: Any, Q: Any, R: Any, S: Any = None, E: Any = None) -> Riccati:
    """The stabilising X of A'XE + E'XA - (E'XB + S) R^-1 (B'XE + S') + Q = 0, and K = R^-1 (B'XE + S').

    With u = -K x every pole of E x' = A x + B u lies left of the imaginary axis. Q may be indefinite, as in
    H-infinity problems, where the certificate warns.

    Parameters
    ----------
    A, E
        (n, n); without E, the identity.
    B
        (n, m).
    Q, R
        The weights of states (n, n) and inputs (m, m), both symmetric, R positive definite.
    S
        The weight between states and inputs (n, m); zero if it is not given.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q or R not symmetric, R not positive definite, or E
        singular.
    Refused
        If there is no stabilising X, or none that can be trusted.
    """
    return stabilising("care(A, B, Q, R)", data("care(A, B, Q, R)", A, B, Q, R, S, E), Continuous, continuous)


def data(call: str, A: Any, B: Any, Q: Any, R: Any, S: Any, E: Any, positive: bool = True) -> Data:
    """The matrices of a Riccati equation, checked.

    Raises
    ------
    ValueError
        As `care`.
    """
    a = square(call, "A", A)
    n = len(a)
    b = matrix(call, "B", B, rows=n)
    m = b.shape[1]
    weight = definite if positive else symmetric
    return Data(
        a,
        b,
        symmetric(call, "Q", Q, n),
        weight(call, "R", R, m),
        np.zeros((n, m)) if S is None else matrix(call, "S", S, n, m),
        None if E is None else invertible(call, "E", E, n),
    )

