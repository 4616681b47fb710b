"""P(t) for coefficients that vary: Gauss collocation of the Hamiltonian system, with steps that hold a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.design.riccati_flow.escape import LARGEST, Escape
from workbench.design.riccati_flow.moebius import Moebius, applied, of_transition
from workbench.validation.refusals import Array

STAGES = 4
ORDER = 2 * STAGES
LEAST = 1e-9  # of the time gone and to go: a step below this meets a pole of P, or a jump
STEPS = 20_000
LONGEST = 2.0  # |H| h of a step, whose [U; V] would lose too much
TINY = float(np.finfo(float).tiny)
SAFETY, SLOWEST, FASTEST = 0.9, 0.2, 3.0

Hamiltonian = Callable[[float], Array]


def _gauss(stages: int) -> tuple[Array, Array, Array]:
    """Nodes (s,), weights (s,) and matrix (s, s) of Gauss collocation on [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(stages)
    c: Array = (x + 1) / 2
    powers = np.arange(1, stages + 1)
    V = c[:, None] ** (powers - 1)
    a = np.linalg.solve(V.T, (c[:, None] ** powers / powers).T).T
    return c, w / 2, np.array(a, dtype=float)


def _extrapolation(nodes: Array) -> Array:
    """Weights (2, s) that give the polynomial through values at the nodes (s,) at 0 and at 1."""
    powers = np.arange(len(nodes))
    ends = np.array([[0.0, 1.0]]) ** powers[:, None]
    return np.array(np.linalg.solve((nodes[:, None] ** powers).T, ends).T, dtype=float)


NODES, WEIGHTS, MATRIX = _gauss(STAGES)
OF_HALVES = np.concatenate([NODES, 1 + NODES]) / 2
ENDS = _extrapolation(OF_HALVES)


@dataclass(frozen=True, eq=False)
class Track:
    """P by the steps taken and, to see their error, by steps twice as long."""

    fine: Array
    coarse: Array


def steps(at: Array, h: Array) -> list[Moebius]:
    """The maps over steps of lengths h (k,) by Gauss collocation of order 8, from H (k, 4, 2n, 2n) at their nodes.

    The method is symplectic, so P stays symmetric; and it is the discretised optimal control problem with
    positive weights, so P stays semidefinite, however long the step.

    References
    ----------
    Hairer, Lubich and Wanner (2006), Geometric Numerical Integration, II.1.3 and VI.4.
    """
    k, _, size, _ = at.shape
    coupled = h[:, None, None, None, None] * MATRIX[:, None, :, None] * at[:, :, :, None, :]
    lhs = np.eye(STAGES * size) - coupled.reshape(k, STAGES * size, STAGES * size)
    slopes = np.linalg.solve(lhs, at.reshape(k, STAGES * size, size)).reshape(at.shape)
    E = np.eye(size) + h[:, None, None] * np.einsum("s,ksij->kij", WEIGHTS, slopes)
    return [of_transition(one) for one in E]


def flow(H: Hamiltonian, P: Array, times: Array, rtol: float) -> list[Track] | Escape:
    """P at each of the times (N,), from P at the first of them; or the escape.

    A step is two steps of half its length; it is kept where they differ from one of the whole length by less
    than rtol. P by the long steps alone goes along, so the difference at the end is the error that the long
    ones have gathered: an upper bound, in practice, of that of the short ones, which is 2^8 times smaller.
    """
    t, track, found, h, taken = float(times[0]), Track(P, P), [Track(P, P)], np.inf, 0
    span = float(times[-1] - times[0])
    for until in map(float, times[1:]):
        while t < until:
            wanted = min(h, LONGEST / max(float(np.abs(H(t)).sum(axis=0).max()), TINY))
            pieces = np.ceil((until - t) / wanted)
            h = (until - t) / max(1.0, float(pieces))
            after, ratio = _tried(H, t, h, track, rtol)
            taken += 1
            if after is not None and not np.abs(after.fine).max() < LARGEST:
                return Escape(t, np.inf)
            if after is not None and ratio <= 1:
                t, track = (until, after) if pieces <= 1 else (t + h, after)
                h *= min(FASTEST, SAFETY * ratio ** (-1 / (ORDER + 1)) if ratio > 0 else FASTEST)
                continue
            if h < LEAST * (abs(t) + span) or taken > STEPS:
                return Escape(t, t + h if after is None else np.inf)
            h *= max(SLOWEST, SAFETY * ratio ** (-1 / (ORDER + 1)))
        found.append(track)
    return found


def _tried(H: Hamiltonian, t: float, h: float, track: Track, rtol: float) -> tuple[Track | None, float]:
    """The track after a step, None where P escapes, and the difference of one step from two over its tolerance."""
    fine = np.array([H(t + h * c) for c in OF_HALVES])
    at = np.array([[H(t + h * c) for c in NODES], fine[:STAGES], fine[STAGES:]])
    try:
        whole, first, second = steps(at, h * np.array([1.0, 0.5, 0.5]))
    except np.linalg.LinAlgError:  # far too long a step
        return track, np.inf
    once, half, coarse = applied(whole, track.fine), applied(first, track.fine), applied(whole, track.coarse)
    twice = applied(second, half.P)
    if once.escaped or half.escaped or twice.escaped:
        return None, np.inf
    if coarse.escaped:  # by its own error only
        return track, np.inf
    difference, size = np.linalg.norm(once.P - twice.P), np.linalg.norm(twice.P)
    relative = float(difference / size) if size else 0.0
    return Track(twice.P, coarse.P), max(relative, _unseen(H, t, h, fine)) / rtol


def _unseen(H: Hamiltonian, t: float, h: float, fine: Array) -> float:
    """What a jump between the outermost nodes and the ends of a step would do, which no node can see."""
    off = np.tensordot(ENDS, fine, axes=1) - np.array([H(t), H(t + h)])
    return float(np.abs(off).max() * OF_HALVES[0] * h)
