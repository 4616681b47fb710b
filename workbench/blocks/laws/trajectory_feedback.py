"""Feedback of the state about a trajectory, with a gain that varies over time."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractController, Follows, Parts, Reads
from workbench.blocks.signals.piecewise import MOST_PIECES, linear_pieces, piecewise_motion
from workbench.blocks.signals.profiles import refuse_times
from workbench.core import Layout, Signals, block
from workbench.core.block import Number
from workbench.core.validation.refusals import Array, matrix


@block
class TrajectoryFeedback(AbstractController):
    """State feedback about a trajectory, with the inputs of the trajectory fed forward:

        u = u_ref(t) - K(t) (x - x_ref(t)),

    where a `PlannedReference` gives x_ref and u_ref, and K is linear in time between its rows and constant behind them.

    Parameters
    ----------
    states, inputs
        The layouts of x and u.
    times
        The m times of the gains in s, in increasing order, the first 0 or negative.
    K
        The gains, (m, nu nx): those of a time row by row. For one input and m times this is (m, nx).

    Raises
    ------
    ValueError
        If the times do not increase, or a shape does not fit.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 2.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> law = wb.TrajectoryFeedback(motor.states, motor.inputs, times=[0.0, 1.0], K=[[0.2, 0.1], [0.0, 0.0]])
    >>> law.follows.names, law.drives.names
    (('omega', 'i', 'v'), ('v',))
    """

    states: Layout
    inputs: Layout
    times: Array
    K: Array
    hint_on_follows = "`StateFeedback`"

    def __post_init__(self) -> None:
        refuse_times("TrajectoryFeedback(times=...)", self.times)
        if self.times[0] > 0 or len(self.times) > MOST_PIECES:
            raise ValueError(
                f"`TrajectoryFeedback(times=...)` must begin at 0 s or before and have at most {MOST_PIECES} rows; got "
                f"{len(self.times)} from {self.times[0]:g} s on."
            )
        size = self.inputs.size * self.states.size
        gains = matrix("TrajectoryFeedback(K=...)", self.K, len(self.times), size)
        for name, numbers in (("times", np.array(self.times)), ("K", gains)):
            numbers.flags.writeable = False
            object.__setattr__(self, name, numbers)

    @property
    def reads(self) -> Layout:
        return self.states

    @property
    def follows(self) -> Layout:
        return self.states + self.inputs

    @property
    def drives(self) -> Layout:
        return self.inputs

    def command(self, t: Number, z: Parts, est: Reads, ref: Follows) -> Signals:
        value, _, _ = piecewise_motion(ca.SX(t), linear_pieces(self.times, self.K))
        K = ca.reshape(value, self.states.size, self.inputs.size).T
        x, x_ref, u_ref = (
            port.flatten({name: of[name] for name in port.names})
            for port, of in ((self.states, est), (self.states, ref), (self.inputs, ref))
        )
        return Signals(self.inputs.view(u_ref - K @ (x - x_ref)))
