"""Certificates and gains proposed by linear matrix inequalities, which CVXPY writes and Clarabel solves (extra `lmi`).

The result is a proposal in floating point, which the caller must prove, and refuse if the proof fails.

References
----------
Boyd, El Ghaoui, Feron and Balakrishnan (1994), Linear Matrix Inequalities in System and Control Theory, chapters 5, 7.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from workbench.arms.observer_gains.gains import Gains, Region
from workbench.arms.observer_gains.mismatch import Mismatch
from workbench.core.validation.refusals import Array
from workbench.design.matrices import DesignError

# Positions of a grid a joint, rounds of adding Jacobians and how many at a time, and the room, as a share of the
# observer's speed, that the rate of a proposal keeps for what lies between the samples.
POINTS, ROUNDS, MOST_ADDED, ROOM = 17, 20, 10, 0.04


def common_lyapunov(A: Array, rate: float) -> Array:
    """P (m, m) of least condition with A_i' P + P A_i + 2 rate P < 0 for all of N matrices: V = z' P z falls for each.

    P lies between I and its condition times I. A (N, m, m), in 1/s, is in coordinates in which its states are of like
    size.
    """
    cp, m = solvers("common_lyapunov"), A.shape[-1]
    P, condition = cp.Variable((m, m), symmetric=True), cp.Variable()
    falls = [P @ Ai + Ai.T @ P + 2 * rate * P << -1e-6 * np.linalg.norm(Ai, 2) * np.eye(m) for Ai in A]
    _solve(cp, condition, [P >> np.eye(m), P << condition * np.eye(m), *falls], "common_lyapunov")
    return _symmetric(P.value)


def least_noise_observer(A: Array, nominal: Array, C: Array, rate: float, weight: Array) -> tuple[Array, Array]:
    """P (m, m) and L (m, k) of z' = (A_i - L C) z - L v with a rate for N matrices, and little noise for a nominal one.

    Of all gains with a common P > 0 such that

        (A_i - L C)' P + P (A_i - L C) + 2 rate P < 0,    (A - L C)' P + P (A - L C) + weight' weight < 0

    these have the least trace of L' P L, whose root bounds the H2 norm from v to weight z of the nominal A (m, m).
    """
    cp, (k, m) = solvers("least_noise_observer"), C.shape
    P, Y, W = cp.Variable((m, m), symmetric=True), cp.Variable((m, k)), cp.Variable((k, k), symmetric=True)

    def falls(Ai: Array) -> Any:
        return P @ Ai + Ai.T @ P - Y @ C - C.T @ Y.T

    quiet = [cp.bmat([[W, Y.T], [Y, P]]) >> 0, falls(nominal) + weight.T @ weight << 0]
    _solve(cp, cp.trace(W), [*quiet, *(falls(Ai) + 2 * rate * P << 0 for Ai in A)], "least_noise_observer")
    solved = _symmetric(P.value)
    return solved, np.linalg.solve(solved, np.asarray(Y.value, dtype=float))


def solvers(call: str) -> Any:
    """CVXPY, or a refusal of a call that needs the extra `lmi` where it is not installed."""
    if find_spec("cvxpy") is None or find_spec("clarabel") is None:
        raise DesignError(
            f"`{call}(...)` needs CVXPY and Clarabel, which are not here: pip install control-workbench[lmi]."
        )
    import cvxpy

    return cvxpy


def _solve(cp: Any, objective: Any, constraints: Sequence[Any], call: str) -> None:
    problem = cp.Problem(cp.Minimize(objective), list(constraints))
    try:
        with warnings.catch_warnings():  # an inaccurate answer is a proposal like any other: it is proved or refused
            warnings.simplefilter("ignore")
            problem.solve(solver=cp.CLARABEL)
    except cp.error.SolverError as failure:
        raise DesignError(f"`{call}(...)` found no answer: {str(failure).splitlines()[0]}") from None
    if problem.status not in ("optimal", "optimal_inaccurate"):
        raise DesignError(f"`{call}(...)` found no answer: these inequalities are {problem.status.replace('_', ', ')}.")


def _symmetric(P: Any) -> Array:
    P = np.asarray(P, dtype=float)
    return np.asarray((P + P.T) / 2)


def jacobian_samples(mismatch: Mismatch, region: Region, points: int = POINTS) -> Array:
    """Jacobians J (N, n, 2n) at a grid of positions and at all vertices of speeds and torques."""
    low, high = region.box
    axes = [np.linspace(a, b, points) for a, b in zip(low, high, strict=True)]
    q = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, mismatch.joints)
    A = mismatch.expand(q, np.zeros_like(q))[0]
    J = np.einsum("vk,bkij->bvij", mismatch.vertices(region), A)
    return np.asarray(J.reshape(-1, *J.shape[2:]))


def lyapunov_matrix(mismatch: Mismatch, gains: Gains, region: Region, rate: float) -> Array:
    """P (2n, 2n) of a V = x~' P x~ that falls at a rate in 1/s, at all sampled Jacobians of a region."""
    J = jacobian_samples(mismatch, region)
    speed = float(np.sqrt(np.linalg.norm(gains.L2, 2)))
    room = min(ROOM * speed, rate)
    T = _scales(gains.joints, speed)
    A = T[:, None] * gains.error_matrix(J) / T

    def propose(places: Array) -> tuple[Array, Array]:
        P = common_lyapunov(A[places], rate + room)
        return P, _symmetric_sum(P @ A) + (2 * rate + room) * P

    return np.asarray(T[:, None] * _grow_samples(propose, _extremes(J)) * T)


def least_noise(mismatch: Mismatch, region: Region, rate: float) -> tuple[Gains, Array]:
    """The gains with the least bound of noise of those that decay at a rate in a region, and their P (2n, 2n).

    Noise is that of (rate q~, qd~) where the model adds nothing: the trace of L' P L bounds its H2 norm squared.
    """
    n, J = mismatch.joints, jacobian_samples(mismatch, region)
    model = np.concatenate([np.broadcast_to(np.eye(n, 2 * n, n), J.shape), J], axis=-2)
    speed = float(np.sqrt(np.linalg.norm(J[..., :n], 2, axis=(1, 2)).max()) + rate)
    T, C, room = _scales(n, speed), np.eye(n, 2 * n), ROOM * speed
    A, nominal = (T[:, None] * part / T for part in (model, np.eye(2 * n, k=n)))
    weight = np.diag(np.repeat([rate / speed, 1.0], n))
    found: list[Array] = []

    def propose(places: Array) -> tuple[Array, Array]:
        P, L = least_noise_observer(A[places], nominal, C, rate + room, weight)
        found[:] = [L]
        return P, _symmetric_sum(P @ (A - L @ C)) + (2 * rate + room) * P

    P = _grow_samples(propose, _extremes(J))
    L = found[0] / T[:, None]
    return Gains(L[:n], L[n:]), np.asarray(speed**2 * T[:, None] * P * T)


def _symmetric_sum(part: Array) -> Array:
    return np.asarray(part + part.swapaxes(-1, -2))


def _scales(n: int, speed: float) -> Array:
    """Coordinates (x1~, x2~ / speed), in which both are of like size."""
    return np.repeat([1.0, 1 / speed], n)


def _extremes(J: Array) -> Array:
    """The samples at which an entry of J is least or greatest."""
    entries = J.reshape(len(J), -1)
    return np.unique(np.concatenate([entries.argmin(axis=0), entries.argmax(axis=0)]))


def _grow_samples(propose: Callable[[Array], tuple[Array, Array]], places: Array) -> Array:
    """P for all samples: those at which its inequality N < 0 fails worst are added to those that it was made for."""
    for _ in range(ROUNDS):
        P, N = propose(places)
        most = np.linalg.eigvalsh(N)[:, -1]
        if most.max() < 0:
            return P
        order = np.argsort(most)[::-1]
        worst = order[: 4 * MOST_ADDED : 4]
        places = np.union1d(places, worst[most[worst] >= 0])
    raise DesignError(f"No common P was found in {ROUNDS} rounds: a smaller region or rate may have one.")
