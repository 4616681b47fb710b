"""P(t) for constant coefficients: Moebius maps of symmetric matrices over pieces of time, doubled to long ones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array

BISECTIONS = 60
LARGEST = 1e150  # of an entry of P, whose square is in the equation
SHORT = 1.0  # |H| h of the shortest piece, whose exponential loses nothing
LOSS = 1e4  # a long piece that magnifies its own rounding by more is gone through in halves
STEPS = 20_000  # pieces beyond which halving is given up, and what is lost counts as error


@dataclass(frozen=True, eq=False)
class Moebius:
    """P -> Pi + Phi' P (I + Gamma P)^-1 Phi, of (n, n) matrices with symmetric Gamma and Pi.

    The flow of P' = A'P + PA - PGP + Q over a piece of time is such a map: Pi is where P = 0 comes to, Gamma the
    Gramian of G, and Phi the transition matrix that the poles of both leave. All three stay bounded where exp(tH)
    grows.
    """

    Phi: Array
    Gamma: Array
    Pi: Array

    @cached_property
    def root(self) -> Array:
        """F (n, n) with Gamma = F' F; a negative eigenvalue can only be rounding, and counts as zero."""
        w, V = np.linalg.eigh(self.Gamma)
        root: Array = np.sqrt(np.maximum(w, 0))[:, None] * V.T
        return root


def hamiltonian(A: Array, G: Array, Q: Array) -> Array:
    """H (2n, 2n) of [U; V]' = H [U; V], whose quotient P = V U^-1 obeys P' = A'P + PA - PGP + Q."""
    return np.block([[-A, G], [Q, A.T]])


def transition_map(E: Array) -> Moebius:
    """The map of a transition matrix E (2n, 2n) of [U; V] over a piece so short that its U, from U = I, is regular."""
    n = len(E) // 2
    Phi: Array = np.array(np.linalg.inv(E[:n, :n]))
    return Moebius(Phi, _symmetric(Phi @ E[:n, n:]), _symmetric(E[n:, :n] @ Phi))


def image(piece: Moebius, P: Array) -> tuple[Array, float] | None:
    """The image of a symmetric P (n, n), for a positive semidefinite Gamma; None if P escapes to infinity on the way.

    With it comes the factor by which rounding of the map is magnified in it, relative to its size.

    With P = L S L', S a diagonal of signs, P (I + Gamma P)^-1 = L X^-1 L' where X = S + L' Gamma L is symmetric. Gamma
    grows with the length of the piece, so the eigenvalues of X only rise: P has had a pole within the piece if and only
    if X has fewer negative eigenvalues than S.

    References
    ----------
    Reid (1972), Riccati Differential Equations, chapter II (comparison, conjugate points).
    """
    w, V = np.linalg.eigh(P)
    w, L = w[w != 0], (V * np.sqrt(np.abs(w)))[:, w != 0]
    M = piece.root @ L
    if (w > 0).all():  # X = I + M'M by its root, which rounding leaves regular
        root = np.linalg.qr(np.vstack([np.eye(w.size), M]), mode="r")
        half = scipy.linalg.solve_triangular(root, L.T, trans="T", check_finite=False)
        inner = half.T @ half
    else:
        mu, Y = np.linalg.eigh(np.diag(np.sign(w)) + M.T @ M)
        if (mu < 0).sum() != (w < 0).sum() or not mu.all():
            return None
        inner = (L @ Y / mu) @ (L @ Y).T
    P = _symmetric(piece.Pi + piece.Phi.T @ inner @ piece.Phi)
    reach = _norm(inner @ piece.Phi)
    terms = reach * reach * _norm(piece.Gamma) + 2 * reach * _norm(piece.Phi) + _norm(piece.Pi)
    size = _norm(P)
    return P, terms / size if size else 1.0


def composition(first: Moebius, then: Moebius) -> Moebius | None:
    """One map for two pieces of time in succession; None if P escapes between from P = 0."""
    through = image(then, first.Pi)
    if through is None:
        return None
    n = len(first.Phi)
    W = np.linalg.solve(np.eye(n) + then.Gamma @ first.Pi, np.hstack([then.Phi, then.Gamma @ first.Phi.T]))
    return Moebius(first.Phi @ W[:, :n], _symmetric(first.Gamma + first.Phi @ W[:, n:]), through[0])


def _symmetric(X: Array) -> Array:
    half: Array = (X + X.T) / 2
    return half


def _norm(X: Array) -> float:
    return float(np.linalg.norm(X))


@dataclass(frozen=True)
@show
class Escape:
    """The times in s between which P has a pole: it is finite at `after`; `before` is infinite if no end is known."""

    after: float
    before: float


def bracket(H: Array, P: Array, start: float, length: float) -> Escape:
    """The escape between `start` and `start + length`, by bisection."""
    low, high = 0.0, length
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        if image(transition_map(scipy.linalg.expm(middle * H)), P) is None:
            high = middle
        else:
            low = middle
    return Escape(start + low, start + high)


@dataclass(frozen=True, eq=False)
class Ladder:
    """Maps over h, 2h, 4h, ... s, shortest first, and how many of the longest make up the whole length."""

    h: float
    rungs: tuple[Moebius, ...]
    count: int


def ladder(H: Array, length: float, finer: int) -> Ladder:
    """The maps for a length of time in s, halved until its pieces are short and `finer` times more."""
    pieces = float(np.abs(H).sum(axis=0).max()) * length / SHORT
    halvings = finer + max(0, int(np.ceil(np.log2(max(pieces, 1.0)))))
    h = length / 2.0**halvings
    rungs = [transition_map(scipy.linalg.expm(h * H))]
    while len(rungs) <= halvings:
        doubled = composition(rungs[-1], rungs[-1])
        if doubled is None or not np.isfinite([doubled.Phi, doubled.Gamma, doubled.Pi]).all():
            break
        rungs.append(doubled)
    return Ladder(h, tuple(rungs), 2 ** (halvings + 1 - len(rungs)))


def climb(P: Array, steps: Ladder, H: Array) -> Array | Escape:
    """P at the end of a ladder's length from P at its start, or the escape on the way; its times count from there.

    A piece that magnifies its rounding in P, or on which P escapes, is gone through in halves, down to the shortest.
    """
    ahead, done, taken = [len(steps.rungs) - 1] * min(steps.count, STEPS + 1), 0, 0
    while ahead and taken <= STEPS:
        rung = ahead.pop()
        gone = image(steps.rungs[rung], P)
        taken += 1
        if rung and (gone is None or (not gone[1] <= LOSS and taken + 2**rung < STEPS)):
            ahead += [rung - 1, rung - 1]
            continue
        if gone is None:
            return bracket(H, P, done * steps.h, steps.h)
        if not np.abs(gone[0]).max() < LARGEST:
            return Escape(done * steps.h, np.inf)
        P = gone[0]
        done += 2**rung
    return Escape(done * steps.h, np.inf) if ahead else P


def constant_flow(A: Array, G: Array, Q: Array, P: Array, lengths: Array, finer: int) -> list[Array] | Escape:
    """P after each of successive lengths of time in s; or the escape, its times counted from the start."""
    H, found, start = hamiltonian(A, G, Q), [], 0.0
    known: dict[float, Ladder] = {}
    for length in map(float, lengths):
        if length > 0:
            if length not in known:
                known[length] = ladder(H, length, finer)
            after = climb(P, known[length], H)
            if isinstance(after, Escape):
                return Escape(start + after.after, start + after.before)
            P, start = after, start + length
        found.append(P)
    return found
