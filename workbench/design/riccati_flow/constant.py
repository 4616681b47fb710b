"""P(t) for constant coefficients: exponentials of the Hamiltonian over equal pieces, doubled to long ones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.linalg

from workbench.design.riccati_flow.escape import LARGEST, Escape, bracketed
from workbench.design.riccati_flow.moebius import Moebius, applied, composed, hamiltonian, of_transition
from workbench.validation.refusals import Array

SHORT = 1.0  # |H| h of the shortest piece, whose exponential loses nothing
LOSS = 1e4  # a long piece that magnifies its own rounding by more is gone through in halves
STEPS = 20_000  # pieces beyond which halving is given up, and what is lost counts as error


@dataclass(frozen=True, eq=False)
class Ladder:
    """Maps over h, 2h, 4h, ... as far as they exist, and how many of the longest make up the whole length.

    Parameters
    ----------
    h
        The length of the shortest piece, in s.
    rungs
        The maps, shortest first.
    count
        How many of the last one.
    """

    h: float
    rungs: tuple[Moebius, ...]
    count: int


def ladder(H: Array, length: float, finer: int) -> Ladder:
    """The maps for a length of time in s, halved until its pieces are short and `finer` times more."""
    pieces = float(np.abs(H).sum(axis=0).max()) * length / SHORT
    halvings = finer + max(0, int(np.ceil(np.log2(max(pieces, 1.0)))))
    h = length / 2.0**halvings
    rungs = [of_transition(scipy.linalg.expm(h * H))]
    while len(rungs) <= halvings:
        doubled = composed(rungs[-1], rungs[-1])
        if doubled is None or not doubled.finite:
            break
        rungs.append(doubled)
    return Ladder(h, tuple(rungs), 2 ** (halvings + 1 - len(rungs)))


def climbed(P: Array, steps: Ladder, H: Array) -> Array | Escape:
    """P at the end of a ladder's length from P at its start, or the escape on the way; its times count from there.

    Every piece is one of the ladder's longest, unless that magnifies its rounding in P or P escapes on it: then
    it is gone through in halves, down to the shortest.
    """
    ahead, done, taken = [len(steps.rungs) - 1] * min(steps.count, STEPS + 1), 0, 0
    while ahead and taken <= STEPS:
        rung = ahead.pop()
        image = applied(steps.rungs[rung], P)
        taken += 1
        if rung and (image.escaped or (not image.loss <= LOSS and taken + 2**rung < STEPS)):
            ahead += [rung - 1, rung - 1]
            continue
        if image.escaped:
            return bracketed(partial(_escapes, H, P), done * steps.h, steps.h)
        if not np.abs(image.P).max() < LARGEST:
            return Escape(done * steps.h, np.inf)
        P = image.P
        done += 2**rung
    return Escape(done * steps.h, np.inf) if ahead else P


def _escapes(H: Array, P: Array, length: float) -> bool:
    """Whether P has a pole within a short length of time."""
    return applied(of_transition(scipy.linalg.expm(length * H)), P).escaped


def flow(A: Array, G: Array, Q: Array, P: Array, lengths: Array, finer: int) -> list[Array] | Escape:
    """P after each of successive lengths of time in s; or the escape, its times counted from the start."""
    H, found, start = hamiltonian(A, G, Q), [], 0.0
    known: dict[float, Ladder] = {}
    for length in map(float, lengths):
        if length > 0:
            if length not in known:
                known[length] = ladder(H, length, finer)
            after = climbed(P, known[length], H)
            if isinstance(after, Escape):
                return after.later(start)
            P, start = after, start + length
        found.append(P)
    return found
