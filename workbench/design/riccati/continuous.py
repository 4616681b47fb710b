"""The continuous algebraic Riccati equation."""

from __future__ import annotations

from typing import Any

from workbench.design.riccati.answers import Riccati
from workbench.design.riccati.candidates import continuous
from workbench.design.riccati.equation import Continuous
from workbench.design.riccati.given import data
from workbench.design.riccati.synthesis import stabilising
from workbench.validation.signatures import door


@door
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
    call = "care(A, B, Q, R)"
    return stabilising(call, data(call, A, B, Q, R, S, E), Continuous, continuous)
