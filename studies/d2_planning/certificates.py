"""Infeasible states with their proofs, and a published law beside the exact one and that of few sweeps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.d2_planning.posed_problems import INFEASIBLE, published_law

# Table 1 of the paper: the state at which a piece is looked at, its printed gain, and its offset.
PIECES = {
    "no limit": ((-0.01, 0.0), (-5.9220, -6.8883), 0.0),
    "second move at its limit": ((0.25, -0.5), (-6.4159, -4.6953), 0.6423),
    "first move at its limit": ((1.0, 1.0), (0.0, 0.0), -2.0),
}
STEP = 1e-4  # of a difference, which has no error of its own on a straight piece


@dataclass(frozen=True)
class Conflict:
    """Limits that conflict, their margin and whether it is proved, and how many are needed for the conflict."""

    limits: tuple[str, ...]
    margin: float
    is_proved: bool
    needed_count: int


@dataclass(frozen=True)
class Piece:
    """A piece of the published law: the largest difference of its printed numbers from both settings of ours."""

    exact: float
    few: float


def prove_conflict(name: str) -> Conflict:
    """The proof for an infeasible state, and how many of its limits are needed: the others can be kept without it."""
    one = INFEASIBLE[name]()
    try:
        wb.planning.exact_mpc(one.problem).solve(one.x)
    except wb.planning.MpcConflictError as conflict:
        proof = conflict.proof
        left = [set(proof.limits) - {limit} for limit in proof.limits]
        needed = sum(can_keep(one.problem, names, one.x) for names in left)
        return Conflict(proof.limits, proof.margin, proof.is_proved, needed)
    return Conflict((), 0.0, False, 0)


def can_keep(problem: wb.planning.LinearMpc, names: set[str], x: wb.Array) -> bool:
    """True if the limits of some names can be kept, without all others."""
    rows = problem.rows
    is_free = np.array([name not in names for name in rows.names])
    wide = replace(rows, low=np.where(is_free, -np.inf, rows.low), high=np.where(is_free, np.inf, rows.high))
    try:
        answer = wb.planning.exact_mpc(replace(problem, rows=wide)).solve(x)
    except ValueError:
        return False
    return answer.certificate.is_passed


def published_piece(name: str) -> Piece:
    """The largest difference from the printed numbers of a piece, for both settings."""
    x, gain, offset = PIECES[name]
    posed, printed = published_law(), np.array([*gain, offset])
    cold = wb.planning.no_memory(posed.numbers)

    def few(at: wb.Array) -> wb.Array:
        return wb.planning.solve_period(posed.numbers, cold, at).u

    exact, own = (np.abs(affine_piece(law, x) - printed).max() for law in (posed.exact.first_move, few))
    return Piece(float(exact), float(own))


def affine_piece(law: Callable[[wb.Array], wb.Array], x: tuple[float, float]) -> wb.Array:
    """The gain and the offset, (3,), of a law of straight pieces at a state within a piece."""
    at = np.array(x)
    u = float(law(at)[0])
    gain = np.array([(float(law(at + STEP * v)[0]) - u) / STEP for v in np.eye(2)])
    return np.append(gain, u - gain @ at)
