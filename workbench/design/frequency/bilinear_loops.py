"""A discrete state space on the imaginary axis, by v = (z - 1) / (z + 1), with whole periods of delay."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

SINGULAR = 1e12  # the condition of I + A beyond which a pole lies at z = -1


def on_axis(A: Array, B: Array, C: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """Discrete matrices, or stacks (..., n, n) of them, in v = (z - 1) / (z + 1), with a root of two in B and in C."""
    one, root = np.eye(A.shape[-1]), math.sqrt(2.0)
    plus = np.linalg.inv(A + one)
    return plus @ (A - one), root * plus @ B, root * C @ plus, D - C @ plus @ B


def delayed_loop(A: Array, B: Array, C: Array, D: Array, periods: int) -> control.StateSpace:
    """The loop with so many periods of delay, each a state that holds the input."""
    import control

    for _ in range(periods):
        A, B = np.block([[A, B], [np.zeros((1, len(A) + 1))]]), np.eye(len(A) + 1)[:, -1:]
        C, D = np.hstack([C, D]), 0 * D
    return control.ss(A, B, C, D)


def loop_on_axis(loop: control.StateSpace) -> control.StateSpace:
    """A discrete loop in v = (z - 1) / (z + 1)."""
    import control

    A, B, C, D = loop.A, loop.B, loop.C, loop.D
    plus = np.eye(len(A)) + A
    if not np.linalg.cond(plus) < SINGULAR:
        raise DesignError(
            "`stability_margins(loop=...)` of a discrete loop with many states must have no pole at z = -1; this one "
            "has. Leave out the mode at Nyquist's frequency."
        )
    inverse = np.linalg.inv(plus)
    return control.ss(inverse @ (A - np.eye(len(A))), inverse @ B, 2 * C @ inverse, D - C @ inverse @ B)
