"""The door to linear matrix inequalities: CVXPY writes them as the book prints them, Clarabel solves them.

What comes back is a proposal in floating point. Whoever uses it proves it, and refuses it if the proof fails.
The extra `lmi` installs both packages.

References
----------
Boyd, El Ghaoui, Feron and Balakrishnan (1994), Linear Matrix Inequalities in System and Control Theory, chapters 5, 7.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from workbench.design.certificates import Refused
from workbench.validation.refusals import Array


def common_lyapunov(A: Array, rate: float) -> Array:
    """P (m, m) of least condition with A_i' P + P A_i + 2 rate P < 0 for all of N matrices: V = z' P z falls for each.

    P lies between I and its condition times I, and each inequality keeps 1e-6 |A_i| of room.

    Parameters
    ----------
    A
        (N, m, m), in 1/s, in coordinates in which its states are of like size.
    rate
        In 1/s: V falls at least as exp(-2 rate t).

    Raises
    ------
    Refused
        If there is no such P, the solver finds none, or the extra `lmi` is not installed.
    """
    cp, m = _cvxpy("common_lyapunov"), A.shape[-1]
    P, condition = cp.Variable((m, m), symmetric=True), cp.Variable()
    falls = [P @ Ai + Ai.T @ P + 2 * rate * P << -_room(Ai) for Ai in A]
    _solve(cp, condition, [P >> np.eye(m), P << condition * np.eye(m), *falls], "common_lyapunov")
    return _symmetric(P.value)


def least_noise_observer(A: Array, nominal: Array, C: Array, rate: float, weight: Array) -> tuple[Array, Array]:
    """P (m, m) and L (m, k) of z' = (A_i - L C) z - L v with a rate for N matrices, and little noise for a nominal one.

    Of all gains with a common P > 0 such that

        (A_i - L C)' P + P (A_i - L C) + 2 rate P < 0,    (A - L C)' P + P (A - L C) + weight' weight < 0

    these have the least trace of L' P L, whose root bounds the H2 norm from v to weight z of the nominal A.

    Parameters
    ----------
    A, nominal, C
        (N, m, m) and (m, m), in 1/s, and (k, m).
    weight
        (j, m).

    Raises
    ------
    Refused
        As `common_lyapunov`.
    """
    cp, (k, m) = _cvxpy("least_noise_observer"), C.shape
    P, Y, W = cp.Variable((m, m), symmetric=True), cp.Variable((m, k)), cp.Variable((k, k), symmetric=True)

    def falls(Ai: Array) -> Any:
        return P @ Ai + Ai.T @ P - Y @ C - C.T @ Y.T

    quiet = [cp.bmat([[W, Y.T], [Y, P]]) >> 0, falls(nominal) + weight.T @ weight << 0]
    _solve(cp, cp.trace(W), [*quiet, *(falls(Ai) + 2 * rate * P << 0 for Ai in A)], "least_noise_observer")
    solved = _symmetric(P.value)
    return solved, np.linalg.solve(solved, np.asarray(Y.value, dtype=float))


def require(call: str) -> None:
    """Refuse a call that needs the extra `lmi` where it is not installed."""
    if find_spec("cvxpy") is None or find_spec("clarabel") is None:
        raise Refused(
            f"`{call}(...)` needs CVXPY and Clarabel, which are not here: pip install control-workbench[lmi]."
        )


def _cvxpy(call: str) -> Any:
    require(call)
    import cvxpy

    return cvxpy


def _room(A: Array) -> Array:
    return np.asarray(1e-6 * np.linalg.norm(A, 2) * np.eye(len(A)))


def _solve(cp: Any, objective: Any, constraints: Sequence[Any], call: str) -> None:
    problem = cp.Problem(cp.Minimize(objective), list(constraints))
    try:
        with warnings.catch_warnings():  # an inaccurate answer is a proposal like any other: it is proved or refused
            warnings.simplefilter("ignore")
            problem.solve(solver=cp.CLARABEL)
    except cp.error.SolverError as failure:
        raise Refused(f"`{call}(...)` found no answer: {str(failure).splitlines()[0]}") from None
    if problem.status not in ("optimal", "optimal_inaccurate"):
        raise Refused(f"`{call}(...)` found no answer: these inequalities are {problem.status.replace('_', ', ')}.")


def _symmetric(P: Any) -> Array:
    P = np.asarray(P, dtype=float)
    return np.asarray((P + P.T) / 2)
