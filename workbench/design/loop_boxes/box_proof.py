"""Proofs that a condition on a loop holds for all parameters of a box: one quadratic form for each part of it.

The box is halved until on each part a form P exists with which S(M) > 0 for all matrices M of the loop there; see
`quadratic_conditions.py` for S, `loop_family.py` for M, and `workbench.proofs.branch_and_bound` for definiteness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.design.loop_boxes.loop_family import LoopFamily, Matrices, RestTube
from workbench.design.loop_boxes.parameter_box import ParameterBox
from workbench.design.loop_boxes.quadratic_conditions import AbstractCondition
from workbench.proofs.branch_and_bound import Boxes, corners_definite, definite, halved, whole
from workbench.proofs.enclosures import UNIT
from workbench.proofs.interval import NoBound
from workbench.validation.refusals import Array

MOST_BOXES = 1000  # some seconds for a loop of a few states
SLACK = 1e-6  # by which the rest of a draw, as computed, may miss the states that are enclosed


@dataclass(frozen=True)
class BoxProof:
    """The outcome of a proof on so many `boxes`: `proved`, or the reason `why` it is not."""

    proved: bool
    boxes: int
    why: str = ""


def prove_over_box(
    family: LoopFamily, condition: AbstractCondition, box: ParameterBox, draws: tuple[Array, Array], most: int
) -> BoxProof:
    """Prove a condition for all draws of a box with at most so many parts.

    `draws` are parameters (N, d) and the states (N, nx) at which the loop was found to rest; a proof holds of the rests
    that continue these.
    """
    start = whole(box.low, box.high)
    try:
        tube = family.tube(start.c[0], start.r[0])
        if tube is None:
            return BoxProof(False, 0, "its rest is not proved to be one that moves evenly over the whole box")
        theta, x = draws
        rests = x[:, list(family.moving)]
        if not tube.holds(theta, rests, -SLACK * (1 + np.abs(rests))).all():
            return BoxProof(False, 0, "some draws rest at another state than the one that is enclosed")
        return _prove(family, condition, start, tube, most)
    except NoBound as none:
        return BoxProof(False, 0, str(none).rstrip("."))


def _prove(family: LoopFamily, condition: AbstractCondition, todo: Boxes, tube: RestTube, most: int) -> BoxProof:
    count = 0
    while len(todo.c):
        if count + len(todo.c) > most:
            return BoxProof(False, count, f"the budget of {most} boxes was used up")
        count += len(todo.c)
        found = family.enclosed(todo.c, todo.r)
        forms = [condition.certificate(family, M) for M in family.matrices(found.x, todo.c)]
        lost = next((i for i, P in enumerate(forms) if P is None), None)
        if lost is not None:
            place = ", ".join(f"{name} = {v:.6g}" for name, v in zip(family.labels, todo.c[lost], strict=True))
            return BoxProof(False, count, f"at {place} no quadratic form proves it")
        P = np.array(forms)
        holds = _holds(family, condition, found, P, todo.r) & tube.holds(todo.c, found.x, found.doubt)
        failed = np.logical_not(holds)
        blame = _blame(found, todo.r)
        todo = halved(todo.c[failed], todo.r[failed], blame[failed])
    return BoxProof(True, count)


def _holds(family: LoopFamily, condition: AbstractCondition, found: Matrices, P: Array, r: Array) -> Array:
    """True (b,) where P > 0 and S(M) > 0 are proved for all matrices of a box."""
    constant, doubt = condition.constant(family, P)
    start = constant + condition.linear(family, P, found.middle)
    slopes = np.stack([condition.linear(family, P, found.slopes[:, k]) for k in range(r.shape[1])], axis=1)
    steps = slopes * r[:, :, np.newaxis, np.newaxis]
    with np.errstate(invalid="ignore"):
        size = np.abs(found.middle) + (np.abs(found.slopes) * r[:, :, np.newaxis, np.newaxis]).sum(axis=1)
        n = 8 * (P.shape[-1] + r.shape[1] + 4)
        rest = condition.spread(family, P, found.rest + n * UNIT * size) * (1 + n * UNIT)
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
    return np.asarray(corners_definite((turned + turned.swapaxes(1, 2)) / 2, moved, left) & definite(P))


def _blame(found: Matrices, r: Array) -> Array:
    """The share (b, d) of each number in the change of the matrices over a box."""
    scale = np.abs(found.middle).max(axis=(1, 2), keepdims=True) + 1e-300
    return np.asarray((np.abs(found.slopes) * r[:, :, np.newaxis, np.newaxis] / scale[:, np.newaxis]).sum(axis=(2, 3)))

