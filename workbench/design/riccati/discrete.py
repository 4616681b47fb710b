"""The discrete algebraic Riccati equation."""

from __future__ import annotations

from typing import Any

from workbench.design.riccati.answers import Riccati
from workbench.design.riccati.candidates import discrete
from workbench.design.riccati.equation import Discrete
from workbench.design.riccati.given import data
from workbench.design.riccati.synthesis import stabilising
from workbench.validation.signatures import door


@door
def dare(A: Any, B: Any, Q: Any, R: Any, S: Any = None, E: Any = None) -> Riccati:
    """The stabilising X of A'XA - E'XE - (A'XB + S) (R + B'XB)^-1 (B'XA + S') + Q = 0, and its gain K.

    With u = -K x, K = (R + B'XB)^-1 (B'XA + S'), every pole of E x+ = A x + B u lies inside the unit circle.
    R may be singular or indefinite, as long as R + B'XB has an inverse; where that is not positive definite the
    cost has no minimum, and the certificate says so.

    Parameters
    ----------
    A, E
        (n, n); without E, the identity.
    B
        (n, m).
    Q, R
        The weights of states (n, n) and inputs (m, m), both symmetric.
    S
        The weight between states and inputs (n, m); zero if it is not given.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q or R not symmetric, or E singular.
    Refused
        If there is no stabilising X, or none that can be trusted.
    """
    call = "dare(A, B, Q, R)"
    return stabilising(call, data(call, A, B, Q, R, S, E, positive=False), Discrete, discrete)
