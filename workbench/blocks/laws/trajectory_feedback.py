"""Feedback of the state about a trajectory, with a gain that varies over time."""

from __future__ import annotations

import casadi as ca

from workbench.blocks.loop.contracts import AbstractController, Follows, Parts, Reads
from workbench.blocks.signals.piecewise import MOST_PIECES, piecewise_motion
from workbench.core import Layout, Signals, block
from workbench.core.block import Number
from workbench.core.motion_record import GainRecord


@block
class TrajectoryFeedback(AbstractController):
    """State feedback about a trajectory, with the inputs of the trajectory fed forward:

        u = u_ref(t) - K(t) (x - x_ref(t)),

    where a `PlannedReference` gives x_ref and u_ref, and K is linear in time between its rows and constant behind them.

    Parameters
    ----------
    states, inputs
        The layouts of x and u.
    gains
        The gains, as `wb.planning.trajectory_lqr(...).gains`. They are constants of the equations.

    Raises
    ------
    ValueError
        If the gains have another shape, or more than 2000 rows.

    References
    ----------
    Anderson and Moore (1990), Optimal Control: Linear Quadratic Methods, chapter 2.

    Examples
    --------
    >>> motor = wb.DCMotor()
    >>> gains = wb.core.GainRecord(t=[0.0, 1.0], K=[[[0.2, 0.1]], [[0.0, 0.0]]])
    >>> law = wb.TrajectoryFeedback(motor.states, motor.inputs, gains)
    >>> law.follows.names, law.drives.names
    (('omega', 'i', 'v'), ('v',))
    """

    states: Layout
    inputs: Layout
    gains: GainRecord
    hint_on_follows = "`StateFeedback`"

    def __post_init__(self) -> None:
        want = (len(self.gains.t), self.inputs.size, self.states.size)
        if self.gains.K.shape != want or want[0] > MOST_PIECES:
            raise ValueError(
                f"`TrajectoryFeedback(gains=...)` must have gains of shape (m, {want[1]}, {want[2]}), a row for each "
                f"input and a column for each state, at most {MOST_PIECES} times; got {self.gains.K.shape}."
            )

    @property
    def mixed_units(self) -> str:
        """The units of the gains are those of each input over each state, which a table of constants does not say."""
        return "the gains over time are constants of a table"

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
        value, _, _ = piecewise_motion(ca.SX(t), self.gains.pieces)
        K = ca.reshape(value, self.states.size, self.inputs.size).T
        x, x_ref, u_ref = (
            port.flatten({name: of[name] for name in port.names})
            for port, of in ((self.states, est), (self.states, ref), (self.inputs, ref))
        )
        return Signals(self.inputs.view(u_ref - K @ (x - x_ref)))
