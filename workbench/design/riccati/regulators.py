"""The linear-quadratic regulator and estimator: Riccati equations with the names that control engineers know."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from workbench.design.matrices import definite, matrix, semidefinite, square
from workbench.design.riccati import candidates
from workbench.design.riccati.answers import Riccati
from workbench.design.riccati.diagnosis import ESTIMATOR, REGULATOR, Words
from workbench.design.riccati.equation import Continuous, Data, Discrete
from workbench.design.riccati.given import data, is_discrete, is_system, joint
from workbench.design.riccati.synthesis import stabilising
from workbench.validation.signatures import door


@door
def lqr(
    A: Any, B: Any = None, Q: Any = None, R: Any = None, N: Any = None, E: Any = None, discrete: bool = False
) -> Riccati:
    """The gain K of u = -K x that makes the integral, or sum, of x'Qx + 2 x'Nu + u'Ru smallest.

    The system is E x' = A x + B u, or E x+ = A x + B u if it is discrete. A python-control `StateSpace` takes
    the place of A and B, as in `lqr(system, Q, R)` and `lqr(system, Q, R, N)`, and says itself whether it is
    sampled.

    Parameters
    ----------
    A, E
        (n, n); without E, the identity.
    B
        (n, m).
    Q, R
        The weights of states (n, n), positive semidefinite, and inputs (m, m), positive definite.
    N
        The weight between states and inputs (n, m), such that [Q N; N' R] is positive semidefinite.
    discrete
        Whether A and B are those of a sampled system.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, of its shape, or not as definite as it must be, or E singular.
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
    d = data(call, A, B, Q, R, N, E)
    semidefinite(call, "Q", d.Q)
    joint(call, "[Q N; N' R]", d.Q, d.S, d.R)
    return _solved(call, d, discrete)


@door
def lqe(
    A: Any,
    G: Any = None,
    C: Any = None,
    Qn: Any = None,
    Rn: Any = None,
    N: Any = None,
    E: Any = None,
    discrete: bool = False,
) -> Riccati:
    """The gain K of the stationary Kalman filter of E x' = A x + G w, y = C x + v, and X = P, its covariance.

    The estimate follows E x_hat' = A x_hat + K (y - C x_hat), or E x_hat+ if the system is discrete: then K is that of
    the predictor, with P before a measurement. A python-control `StateSpace` takes the place of A, G and C, as in
    `lqe(system, Qn, Rn)`; w enters where its inputs do.

    Parameters
    ----------
    A, E
        (n, n); without E, the identity.
    G, C
        (n, nw), where the noise w enters, and (ny, n).
    Qn, Rn
        The intensities of w (nw, nw), positive semidefinite, and v (ny, ny), positive definite.
    N
        The intensity between w and v (nw, ny), such that [Qn N; N' Rn] is positive semidefinite.
    discrete
        Whether the system is sampled.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, of its shape, or not as definite as it must be, or E singular.
    Refused
        If no gain stabilises, as no output sees a mode, or a mode on the boundary is not driven by noise;
        or if none can be trusted.

    References
    ----------
    Kalman, Bucy (1961), New results in linear filtering and prediction theory, J. Basic Eng. 83.
    """
    call = "lqe(A, G, C, Qn, Rn)"
    if is_system(A):
        call, discrete = "lqe(system, Qn, Rn)", is_discrete(A)
        if G is not None:
            Qn, Rn, N = (G, Rn, N) if C is None else (G, C, Qn if N is None else N)
        A, G, C = A.A, A.B, A.C
    dual = _solved(call, _dual(call, A, G, C, Qn, Rn, N, E), discrete, ESTIMATOR)
    return replace(dual, K=dual.K.T)


def _dual(call: str, A: Any, G: Any, C: Any, Qn: Any, Rn: Any, N: Any, E: Any) -> Data:
    """The regulator's equation that an estimator's is when its matrices are transposed."""
    a = square(call, "A", A)
    g = matrix(call, "G", G, rows=len(a))
    c = matrix(call, "C", C, columns=len(a))
    q, r = semidefinite(call, "Qn", Qn, g.shape[1]), definite(call, "Rn", Rn, len(c))
    S = None
    if N is not None:
        across = matrix(call, "N", N, g.shape[1], len(c))
        joint(call, "[Qn N; N' Rn]", q, across, r)
        S = g @ across
    driven = g @ q @ g.T
    e = None if E is None else square(call, "E", E, len(a)).T
    return data(call, a.T, c.T, (driven + driven.T) / 2, r, S, e)


def _solved(call: str, d: Data, discrete: bool, words: Words = REGULATOR) -> Riccati:
    if discrete:
        return stabilising(call, d, Discrete, candidates.discrete, words)
    return stabilising(call, d, Continuous, candidates.continuous, words)
