"""Proposals of a certificate and of gains, by linear matrix inequalities at a growing set of Jacobians."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from workbench.design.certificates import Refused
from workbench.design.lmi import common_lyapunov, least_noise_observer
from workbench.design.observer_gains.gains import Gains
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.region import Region
from workbench.validation.refusals import Array

# Positions of a grid a joint, rounds of adding Jacobians and how many at a time, and the room, as a share of the
# observer's speed, that the rate of a proposal keeps for what lies between the samples.
POINTS, ROUNDS, ADDED, ROOM = 17, 20, 10, 0.04


def sampled(mismatch: Mismatch, region: Region, points: int = POINTS) -> Array:
    """Jacobians J (N, n, 2n) at a grid of positions and at all vertices of speeds and torques."""
    low, high = region.box
    axes = [np.linspace(a, b, points) for a, b in zip(low, high, strict=True)]
    q = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, mismatch.joints)
    A = mismatch.expand(q, np.zeros_like(q))[0]
    J = np.einsum("vk,bkij->bvij", mismatch.vertices(region), A)
    return np.asarray(J.reshape(-1, *J.shape[2:]))


def lyapunov_matrix(mismatch: Mismatch, gains: Gains, region: Region, rate: float) -> Array:
    """P (2n, 2n) of a V = x~' P x~ that falls at a rate in 1/s, at all sampled Jacobians of a region.

    Raises
    ------
    Refused
        If there is none, or the extra `lmi` is not installed.
    """
    J = sampled(mismatch, region)
    speed = float(np.sqrt(np.linalg.norm(gains.L2, 2)))
    room = min(ROOM * speed, rate)
    T = _scales(gains.joints, speed)
    A = T[:, None] * gains.error_matrix(J) / T

    def proposed(chosen: Array) -> tuple[Array, Array]:
        P = common_lyapunov(A[chosen], rate + room)
        return P, _symmetric_sum(P @ A) + (2 * rate + room) * P

    return np.asarray(T[:, None] * _grown(proposed, _extremes(J)) * T)


def least_noise(mismatch: Mismatch, region: Region, rate: float) -> tuple[Gains, Array]:
    """The gains with the least bound of noise of those that decay at a rate in a region, and their P (2n, 2n).

    Noise is that of (rate q~, qd~) where the model adds nothing: the trace of L' P L bounds its H2 norm squared.

    Raises
    ------
    Refused
        If there are none, or the extra `lmi` is not installed.
    """
    n, J = mismatch.joints, sampled(mismatch, region)
    model = np.concatenate([np.broadcast_to(np.eye(n, 2 * n, n), J.shape), J], axis=-2)
    speed = float(np.sqrt(np.linalg.norm(J[..., :n], 2, axis=(1, 2)).max()) + rate)
    T, C, room = _scales(n, speed), np.eye(n, 2 * n), ROOM * speed
    A, nominal = (T[:, None] * part / T for part in (model, np.eye(2 * n, k=n)))
    weight = np.diag(np.repeat([rate / speed, 1.0], n))
    found: list[Array] = []

    def proposed(chosen: Array) -> tuple[Array, Array]:
        P, L = least_noise_observer(A[chosen], nominal, C, rate + room, weight)
        found[:] = [L]
        return P, _symmetric_sum(P @ (A - L @ C)) + (2 * rate + room) * P

    P = _grown(proposed, _extremes(J))
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


def _grown(proposed: Callable[[Array], tuple[Array, Array]], chosen: Array) -> Array:
    """P for all samples: those at which its inequality N < 0 fails worst are added to those that it was made for."""
    for _ in range(ROUNDS):
        P, N = proposed(chosen)
        most = np.linalg.eigvalsh(N)[:, -1]
        if most.max() < 0:
            return P
        order = np.argsort(most)[::-1]
        worst = order[: 4 * ADDED : 4]
        chosen = np.union1d(chosen, worst[most[worst] >= 0])
    raise Refused(f"No common P was found in {ROUNDS} rounds: a smaller region or rate may have one.")
