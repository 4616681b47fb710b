"""A motion on record as the reference of a loop: all states and inputs of a plan over time."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from workbench.blocks.loop.environment import AbstractReference
from workbench.blocks.signals.piecewise import MOST_PIECES, piecewise_motion
from workbench.core import Layout, Signals, block
from workbench.core.block import Number
from workbench.core.motion_record import MotionRecord
from workbench.core.validation.refusals import Array, vector


@block
class PlannedReference(AbstractReference):
    """The states and inputs of a plan as a reference: cubic states between nodes, and constant or linear inputs.

    `TrajectoryFeedback` follows it with its inputs fed forward. The numbers are constants of the equations.

    Parameters
    ----------
    motion
        The motion, as `wb.plan(...).motion`.
    rest_inputs
        Inputs (nu,) with which the last state is held behind the end; None if a run must end with the plan.

    Raises
    ------
    ValueError
        If the motion has more than 2000 intervals, or `rest_inputs` has another shape.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> turn = wb.plan(wb.open_loop(motor), 1.0, cost="energy", end={"omega": 1.0, "i": 0.5})
    >>> wb.PlannedReference(turn.motion).gives.names
    ('omega', 'i', 'v')
    """

    motion: MotionRecord
    rest_inputs: Array | None = None

    def __post_init__(self) -> None:
        pieces, nu = len(self.motion.t) - 1, self.motion.inputs.size
        if pieces > MOST_PIECES:
            raise ValueError(
                f"`PlannedReference(motion=...)` must have at most {MOST_PIECES} intervals, each of which costs at "
                f"every step; got {pieces}: plan with a larger tolerance."
            )
        if self.rest_inputs is not None:
            rest = vector("PlannedReference(rest_inputs=...)", self.rest_inputs, nu, "inputs")
            rest.flags.writeable = False
            object.__setattr__(self, "rest_inputs", rest)

    @property
    def gives(self) -> Layout:
        """The states and the inputs, with their units."""
        return self.motion.states + self.motion.inputs

    @property
    def primary(self) -> tuple[str, ...]:
        """The names of the states: the inputs are fed forward, and no output follows them."""
        return self.motion.states.names

    @property
    def ends(self) -> float:
        """The end of the plan in s, or infinity where its last state is held."""
        return float(self.motion.t[-1]) if self.rest_inputs is None else math.inf

    @property
    def pieces(self) -> Array:
        """The pieces of the motion, (m, 1 + 4 (nx + nu)) as `MotionRecord.pieces`, with that of the rest behind it."""
        pieces = self.motion.pieces
        if self.rest_inputs is None:
            return pieces
        end = np.concatenate([self.motion.t[-1:], self.motion.x_ends[-1], self.rest_inputs])
        return np.vstack([pieces, np.pad(end, (0, pieces.shape[1] - len(end)))])

    def at(self, t: Number) -> Signals:
        """The states and inputs at time t [s]."""
        value, _, _ = piecewise_motion(ca.SX(t), self.pieces)
        return Signals(self.gives.view(value))
