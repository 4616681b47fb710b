"""P(t) for coefficients that vary: Gauss collocation of the Hamiltonian system, with steps that hold a tolerance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import answer, definite, matrix, square, symmetric
from workbench.design.riccati_flow.moebius import LARGEST, Escape, Moebius, hamiltonian, image, transition_map

Coefficient = Array | Callable[[float], Array]
STAGES = 4
ORDER = 2 * STAGES
LEAST = 1e-9  # of the time gone and to go: a step below this meets a pole of P, or a jump
STEPS = 20_000
LONGEST = 2.0  # |H| h of a step, whose [U; V] would lose too much
TINY = float(np.finfo(float).tiny)
SAFETY, SLOWEST, FASTEST = 0.9, 0.2, 3.0
Hamiltonian = Callable[[float], Array]


@dataclass(frozen=True, eq=False)
class Terms:
    """The coefficients at one time: A (n, n), B (n, m), Q (n, n), R (m, m), and G = B R^-1 B' (n, n)."""

    A: Array
    B: Array
    Q: Array
    R: Array
    G: Array

    def gain(self, P: Array) -> Array:
        """K = R^-1 B' P, (m, n)."""
        return np.array(np.linalg.solve(self.R, self.B.T @ P))

    def rest(self, P: Array) -> float:
        """The norm of A'P + PA - PGP + Q over the sum of those of its terms."""
        # over the largest entry, as squares of P G P may leave the range of numbers
        terms = (self.A.T @ P, P @ self.A, -P @ self.G @ P, self.Q)
        most = max(float(np.abs(term).max()) for term in terms)
        if not most:
            return 0.0
        over = [term / most for term in terms]
        return float(np.linalg.norm(sum(over))) / sum(float(np.linalg.norm(term)) for term in over)


@dataclass(frozen=True, eq=False)
class Coefficients:
    """A, B, Q, R as they were given to `call`."""

    call: str
    A: Coefficient
    B: Coefficient
    Q: Coefficient
    R: Coefficient

    @property
    def constant(self) -> bool:
        """True if none of them is a function of time."""
        return not any(map(callable, (self.A, self.B, self.Q, self.R)))

    def at(self, t: float) -> Terms:
        """The coefficients at time t in s, checked."""
        call = self.call if self.constant else f"{self.call} at t = {t:g} s"
        A = self._part(call, "A", t, square)
        B = self._part(call, "B", t, matrix, len(A))
        Q = self._part(call, "Q", t, symmetric, len(A))
        R = self._part(call, "R", t, definite, B.shape[1])
        first = self._known_matrices.setdefault("the first B", B).shape
        if B.shape != first:
            raise ValueError(
                f"`{call}`: B must have the same shape (n, m) at all times; got {B.shape} after {first}. Where states "
                "or inputs come or go, solve for each stretch of time by itself."
            )
        half = np.linalg.solve(np.linalg.cholesky(R), B.T)
        return Terms(A, B, Q, R, half.T @ half)

    @cached_property
    def _known_matrices(self) -> dict[str, Array]:
        return {}

    def _part(self, call: str, name: str, t: float, check: Callable[..., Array], *size: int) -> Array:
        given = getattr(self, name)
        if callable(given):
            return check(call, name, answer(call, name, given, t), *size)
        if name not in self._known_matrices:
            self._known_matrices[name] = check(call, name, given, *size)
        return self._known_matrices[name]

    def scale(self, t: float) -> float:
        """A power of two s such that P / s has terms P G P and Q of like size."""
        terms = self.at(t)
        a, g, q = (float(np.linalg.norm(X)) for X in (terms.A, terms.G, terms.Q))
        square_of = q / g if q and g else (a / g) ** 2 if g and a else (q / a) ** 2 if q and a else 1.0
        return float(2.0 ** np.round(np.log2(square_of) / 2))

    def hamiltonian(self, t: float, scale: float) -> Array:
        """H (2n, 2n) of the equation for P / scale."""
        terms = self.at(t)
        return hamiltonian(terms.A, scale * terms.G, terms.Q / scale)


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


Track = tuple[Array, Array]  # P by the steps taken and, to see their error, by steps twice as long


def step_maps(at: Array, h: Array) -> list[Moebius]:
    """The maps over steps of lengths h (k,) by Gauss collocation of order 8, from H (k, 4, 2n, 2n) at their nodes.

    The method is symplectic, so P stays symmetric, and semidefinite, however long the step.

    References
    ----------
    Hairer, Lubich and Wanner (2006), Geometric Numerical Integration, II.1.3 and VI.4.
    """
    k, _, size, _ = at.shape
    coupled = h[:, None, None, None, None] * MATRIX[:, None, :, None] * at[:, :, :, None, :]
    lhs = np.eye(STAGES * size) - coupled.reshape(k, STAGES * size, STAGES * size)
    slopes = np.linalg.solve(lhs, at.reshape(k, STAGES * size, size)).reshape(at.shape)
    E = np.eye(size) + h[:, None, None] * np.einsum("s,ksij->kij", WEIGHTS, slopes)
    return [transition_map(one) for one in E]


def varying_flow(H: Hamiltonian, P: Array, times: Array, rtol: float) -> list[Track] | Escape:
    """P at each of the times (N,), from P at the first of them; or the escape.

    A step is two steps of half its length; it is kept where they differ from one of the whole length by less than rtol.
    P by the long steps alone goes along: the difference at the end is, in practice, an upper bound of the error.
    """
    t, track, found, h, taken = float(times[0]), (P, P), [(P, P)], np.inf, 0
    span = float(times[-1] - times[0])
    for until in map(float, times[1:]):
        while t < until:
            wanted = min(h, LONGEST / max(float(np.abs(H(t)).sum(axis=0).max()), TINY))
            pieces = np.ceil((until - t) / wanted)
            h = (until - t) / max(1.0, float(pieces))
            after, ratio = _step(H, t, h, track, rtol)
            taken += 1
            if after is not None and not np.abs(after[0]).max() < LARGEST:
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


def _step(H: Hamiltonian, t: float, h: float, track: Track, rtol: float) -> tuple[Track | None, float]:
    """The track after a step, None where P escapes, and the difference of one step from two over its tolerance."""
    fine = np.array([H(t + h * c) for c in OF_HALVES])
    at = np.array([[H(t + h * c) for c in NODES], fine[:STAGES], fine[STAGES:]])
    try:
        whole, first, second = step_maps(at, h * np.array([1.0, 0.5, 0.5]))
    except np.linalg.LinAlgError:  # far too long a step
        return track, np.inf
    once, half, coarse = image(whole, track[0]), image(first, track[0]), image(whole, track[1])
    twice = None if half is None else image(second, half[0])
    if once is None or twice is None:
        return None, np.inf
    if coarse is None:  # by its own error only
        return track, np.inf
    difference, size = np.linalg.norm(once[0] - twice[0]), np.linalg.norm(twice[0])
    relative = float(difference / size) if size else 0.0
    return (twice[0], coarse[0]), max(relative, _unseen_jump(H, t, h, fine)) / rtol


def _unseen_jump(H: Hamiltonian, t: float, h: float, fine: Array) -> float:
    """The change by a jump between the outermost nodes and the ends of a step, which the nodes do not sample."""
    off = np.tensordot(ENDS, fine, axes=1) - np.array([H(t), H(t + h)])
    return float(np.abs(off).max() * OF_HALVES[0] * h)


NODES, WEIGHTS, MATRIX = _gauss(STAGES)
OF_HALVES = np.concatenate([NODES, 1 + NODES]) / 2
ENDS = _extrapolation(OF_HALVES)
