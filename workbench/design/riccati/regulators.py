"""The algebraic Riccati equations, and the linear-quadratic regulator and estimator that they give."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from workbench.design.matrices import definite, invertible, matrix, semidefinite, square, symmetric
from workbench.design.riccati.algebraic_equation import Continuous, Data, Discrete
from workbench.design.riccati.stabilisation import ESTIMATOR, Riccati, stabilising
from workbench.validation.refusals import Array
from workbench.validation.signatures import door


def is_system(value: Any) -> bool:
    """True if a value is a linear system by its matrices, as python-control's `StateSpace`."""
    return all(hasattr(value, name) for name in ("A", "B", "C", "D", "dt"))


def is_discrete(system: Any) -> bool:
    """True if a system is sampled: python-control writes 0 or None for one that is not."""
    return system.dt not in (0, None)


def _check_joint(call: str, Q: Array, N: Array, R: Array) -> None:
    """Refuse a matrix [Q N; N' R] that is not positive semidefinite, but for rounding."""
    # measured by the roots of the diagonals, in which the rounding of eigenvalues means something
    whole = np.block([[Q, N], [N.T, R]])
    root = np.sqrt(np.maximum(np.diag(whole), np.finfo(float).tiny))
    values = np.linalg.eigvalsh(whole / root[:, None] / root)
    if values[0] < -8 * len(whole) * np.finfo(float).eps * max(1.0, np.abs(values).max()):
        raise ValueError(
            f"`{call}`: [Q N; N' R] must be positive semidefinite, or the cost has no minimum; its least eigenvalue, "
            f"with its diagonal scaled to one, is {values[0]:.3g}. Weigh less across, or more on the diagonal."
        )


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
    return stabilising(call, _data(call, A, B, Q, R, S, E), Continuous)


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
    return stabilising(call, _data(call, A, B, Q, R, S, E, positive=False), Discrete)


@door
def lqr(A: Any, B: Any = None, Q: Any = None, R: Any = None, N: Any = None, discrete: bool = False) -> Riccati:
    """The gain K of u = -K x that makes the integral, or sum, of x'Qx + 2 x'Nu + u'Ru smallest.

    The system is x' = A x + B u, or x+ = A x + B u if it is discrete. A python-control `StateSpace` takes
    the place of A and B, as in `lqr(system, Q, R)` and `lqr(system, Q, R, N)`, and says itself whether it is
    sampled.

    Parameters
    ----------
    A, B
        (n, n) and (n, m).
    Q, R
        The weights of states (n, n), positive semidefinite, and inputs (m, m), positive definite.
    N
        The weight between states and inputs (n, m), such that [Q N; N' R] is positive semidefinite.
    discrete
        True if A and B are those of a sampled system.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, of its shape, or not as definite as it must be.
    Refused
        If no gain stabilises, as a mode is not moved by any input, or stays on the boundary as it costs
        nothing; or if none can be trusted.

    References
    ----------
    Anderson, Moore (1990), Optimal Control: Linear Quadratic Methods, chapters 2 and 3.

    Examples
    --------
    >>> answer = wb.lqr([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], Q=np.diag([1.0, 0.0]), R=[[1.0]])
    >>> answer.K.round(4), answer.certificate.residual < 1e-15
    (array([[1.    , 1.4142]]), True)
    """
    call = "lqr(A, B, Q, R)"
    if is_system(A):
        call, discrete = "lqr(system, Q, R)", is_discrete(A)
        if B is not None:  # weights in the places of matrices, the rest of them by name
            Q, R, N = (B, R, N) if Q is None else (B, Q, R if N is None else N)
        A, B = A.A, A.B
    d = _data(call, A, B, Q, R, N)
    semidefinite(call, "Q", d.Q)
    _check_joint(call, d.Q, d.S, d.R)
    return stabilising(call, d, Discrete if discrete else Continuous)


@door
def lqe(A: Any, G: Any, C: Any, Qn: Any, Rn: Any, discrete: bool = False) -> Riccati:
    """The gain K of the stationary Kalman filter of x' = A x + G w, y = C x + v, and X = P, its covariance.

    The estimate follows x_hat' = A x_hat + K (y - C x_hat), or x_hat+ if the system is discrete: then K is that of
    the predictor, with P before a measurement.

    Parameters
    ----------
    A
        (n, n).
    G, C
        (n, nw), where the noise w enters, and (ny, n).
    Qn, Rn
        The intensities of w (nw, nw), positive semidefinite, and v (ny, ny), positive definite.
    discrete
        True if the system is sampled.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, of its shape, or not as definite as it must be.
    Refused
        If no gain stabilises, as no output sees a mode, or a mode on the boundary is not driven by noise;
        or if none can be trusted.

    References
    ----------
    Kalman, Bucy (1961), New results in linear filtering and prediction theory, J. Basic Eng. 83.
    """
    call = "lqe(A, G, C, Qn, Rn)"
    a = square(call, "A", A)
    g = matrix(call, "G", G, rows=len(a))
    c = matrix(call, "C", C, columns=len(a))
    q, r = semidefinite(call, "Qn", Qn, g.shape[1]), definite(call, "Rn", Rn, len(c))
    driven = g @ q @ g.T
    d = _data(call, a.T, c.T, (driven + driven.T) / 2, r)  # the equation of the transposed system
    dual = stabilising(call, d, Discrete if discrete else Continuous, ESTIMATOR)
    return replace(dual, K=dual.K.T)


def _data(call: str, A: Any, B: Any, Q: Any, R: Any, S: Any = None, E: Any = None, positive: bool = True) -> Data:
    """The matrices of a Riccati equation, checked; R need not be positive definite if `positive` is False."""
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
