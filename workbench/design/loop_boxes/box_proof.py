"""Proofs that a condition on a loop holds for all parameters of a box: one quadratic form for each part of it.

The box is halved until on each part a form P exists with which S(M) > 0 for all matrices M of the loop there; see
`quadratic_conditions.py` for S, `loop_family.py` for M, and `workbench.proofs.branch_and_bound` for definiteness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.switching_functions import Mask
from workbench.design.loop_boxes.loop_family import LEAST, ROOM, LoopFamily, Matrices
from workbench.design.loop_boxes.parameter_box import ParameterBox
from workbench.design.loop_boxes.quadratic_conditions import AbstractCondition, form
from workbench.design.loop_boxes.rest_tubes import RestBranch
from workbench.proofs.branch_and_bound import Boxes, corners_definite, definite, halve, whole
from workbench.proofs.enclosures import UNIT
from workbench.proofs.interval import NoBound

MOST_BOXES = 1000  # some seconds for a loop of a few states
SLACK = 1e-6  # by which the rest of a draw, as computed, may miss the states that are enclosed


@dataclass(frozen=True)
class BoxProof:
    """The outcome of a proof on the number of `boxes`: whether it `is_proved`, or the reason `why` not."""

    is_proved: bool
    boxes: int
    why: str = ""


def prove_over_box(
    family: LoopFamily, condition: AbstractCondition, box: ParameterBox, draws: tuple[Array, Array], most: int
) -> BoxProof:
    """Prove a condition for all draws of a box with at most so many parts.

    `draws` are parameters (N, d) and the states (N, nx) at which the loop was found to rest; a proof holds of the rests
    that continue these.

    Examples
    --------
    >>> from workbench.design.loop_boxes import GainBelow, LoopFamily, ParameterBox, prove_over_box
    >>> from workbench.design.loop_boxes import DampingAbove, DecayAbove
    >>> law = wb.PID(wb.DCMotor().outputs, wb.DCMotor().inputs, Kp=100.0, Ki=200.0)
    >>> linear = wb.linear_loop(wb.ClosedLoop(wb.DCMotor(), controller=law, reference=wb.Step("omega", "rad/s", 1.0)))
    >>> box = ParameterBox.of("box", linear.parameters, {"plant.J": (0.0099, 0.0101)})
    >>> family, theta = LoopFamily.of(linear, box.labels, ("v_load",), ("v",)), np.array([[0.01]])
    >>> conditions = GainBelow(3.0, ("v_load",), ("v",), 1.0), DampingAbove(0.1), DecayAbove(0.1)
    >>> draws = theta, linear.rows({"plant.J": theta[:, 0]}).x
    >>> [prove_over_box(family, condition, box, draws, 100).is_proved for condition in conditions]
    [True, True, True]
    """
    start = whole(box.low, box.high)
    try:
        with np.errstate(all="ignore"):
            branch = RestBranch.over(family.tube, start.c[0], start.r[0], ROOM, LEAST)
            if branch is None:
                return BoxProof(False, 0, "its rest is not proved to be one that moves evenly over the box")
            theta, x = draws
            rests = x[:, list(family.moving_states)]
            if not branch.holds(theta, rests, -SLACK * (1 + np.abs(rests))).all():
                return BoxProof(False, 0, "some draws rest at another state than the one that is enclosed")
            return _prove(family, condition, start, branch, most)
    except NoBound as none:
        return BoxProof(False, 0, str(none).rstrip("."))


def _prove(family: LoopFamily, condition: AbstractCondition, todo: Boxes, branch: RestBranch, most: int) -> BoxProof:
    count = 0
    while len(todo.c):
        if count + len(todo.c) > most:
            return BoxProof(False, count, f"the budget of {most} boxes was used up")
        count += len(todo.c)
        found = family.enclose(todo.c, todo.r)
        holds, possible = _proved_parts(family, condition, found, todo)
        if not possible.all():
            place = todo.c[int(np.argmin(possible))]
            words = ", ".join(f"{name} = {v:.6g}" for name, v in zip(family.labels, place, strict=True))
            return BoxProof(False, count, f"no quadratic form proves it at {words}")
        holds &= branch.holds(todo.c, found.x, found.doubt)
        failed = np.logical_not(holds)
        todo = halve(todo.c[failed], todo.r[failed], _shares(found, todo.r)[failed])
    return BoxProof(True, count)


def _proved_parts(
    family: LoopFamily, condition: AbstractCondition, matrices: Matrices, todo: Boxes
) -> tuple[Mask, Mask]:
    """True (b,) for the parts that some form proves, and for those whose middle has a form."""
    M = family.matrices(matrices.x, todo.c)
    holds, possible = np.zeros(len(M), dtype=bool), np.zeros(len(M), dtype=bool)
    for P in condition.candidates(family, M):
        open_ = np.flatnonzero(~holds & np.isfinite(P).all(axis=(1, 2)))
        if not open_.size:
            continue
        S = form(condition, family, P[open_], M[open_])
        good = np.isfinite(S).all(axis=(1, 2)) & (np.linalg.eigvalsh(np.nan_to_num(S))[:, 0] > 0)
        open_ = open_[good]
        possible[open_] = True
        own = Matrices(*(part[open_] for part in matrices))
        holds[open_] = _holds(family, condition, own, P[open_], todo.r[open_])
        if holds.all():
            break
    return holds, possible


def _holds(family: LoopFamily, condition: AbstractCondition, matrices: Matrices, P: Array, r: Array) -> Mask:
    """True (b,) where P > 0 and S(M) > 0 are proved for all matrices of a box."""
    constant, doubt = condition.constant(family, P)
    start = constant + condition.linear(family, P, matrices.middle)
    slopes = np.stack([condition.linear(family, P, matrices.slopes[:, k]) for k in range(r.shape[1])], axis=1)
    steps = slopes * r[:, :, np.newaxis, np.newaxis]
    with np.errstate(invalid="ignore"):
        size = np.abs(matrices.middle) + (np.abs(matrices.slopes) * r[:, :, np.newaxis, np.newaxis]).sum(axis=1)
        n = 8 * (P.shape[-1] + r.shape[1] + 4)
        rest = condition.linear_bound(family, P, matrices.rest + n * UNIT * size) * (1 + n * UNIT)
        rest = np.where(np.isnan(rest), np.inf, rest) + doubt + n * UNIT * (np.abs(constant) + np.abs(start))
    _, U = np.linalg.eigh(start)
    values = np.linalg.eigvalsh(start)
    U = U / np.sqrt(np.maximum(values, 1e-9 * np.abs(values).max(axis=1, keepdims=True)))[:, np.newaxis]
    V, W, m = U.swapaxes(1, 2), np.abs(U), start.shape[-1]
    turned, moved = V @ start @ U, V[:, np.newaxis] @ steps @ U[:, np.newaxis]
    with np.errstate(invalid="ignore"):
        left = W.swapaxes(1, 2) @ rest @ W
        whole_size = W.swapaxes(1, 2) @ (np.abs(start) + np.abs(steps).sum(axis=1)) @ W
        left = left * (1 + 8 * m * UNIT) + 8 * m * m * UNIT * whole_size
    left = np.where(np.isnan(left), np.inf, left)
    formed = corners_definite((turned + turned.swapaxes(1, 2)) / 2, moved, left)
    return np.asarray(formed.astype(bool) & definite(P).astype(bool))


def _shares(matrices: Matrices, r: Array) -> Array:
    """The distance by which each number moves the matrices over a box (b, d), as a share of their size."""
    moved = np.abs(matrices.slopes).sum(axis=(2, 3)) * r
    return np.asarray(moved / (np.abs(matrices.middle).max(axis=(1, 2))[:, np.newaxis] + 1e-300))
