"""What stands between an arm and its computer: readings of q and qd with noise and steps, a torque with limits."""

from __future__ import annotations

from typing import Annotated

import casadi as ca

from workbench.core import Layout, Signals, block, parameter
from workbench.core.block import Vector
from workbench.core.port import ANY
from workbench.loop.arm_ports import motion, torques
from workbench.loop.instruments import quantised
from workbench.loop.surroundings import AbstractInstruments


@block
class ArmInstruments(AbstractInstruments):
    """Positions and velocities as a computer reads them, and the torque that it can ask for:

        reading = quantised(x + noise w, quantum),     quantised(x, b) = floor(x / b + 1/2) b,   or x where b = 0
        tau     = command within -limit and limit, where there is one

    for x = q and x = qd, joint by joint, with independent standard normal w, fresh ones at every reading.

    Parameters
    ----------
    joints
        How many there are; one number stands for all of them.
    noise_q, noise_qd
        (n,), standard deviations.
    quantum_q, quantum_qd
        (n,), the steps in which a reading comes; 0 for a reading without steps.
    limit
        (n,), or None.

    Raises
    ------
    ValueError
        If `joints` is not positive, a number is negative, or a limit is not positive.
    """

    joints: int
    noise_q: Vector = parameter(default=0.0, unit="rad", low=0, shape=("n",), symbol="sigma_q")
    noise_qd: Vector = parameter(default=0.0, unit="rad/s", low=0, shape=("n",), symbol="sigma_v")
    quantum_q: Vector = parameter(default=0.0, unit="rad", low=0, shape=("n",), symbol="b_q")
    quantum_qd: Vector = parameter(default=0.0, unit="rad/s", low=0, shape=("n",), symbol="b_v")
    limit: Vector | None = parameter(default=None, unit="N m", low=0, strict=True, shape=("n",), symbol="tau_max")

    @property
    def dof(self) -> int:
        """The number of joints; a negative one counts as none, which is refused."""
        return max(self.joints, 0)

    @property
    def reads(self) -> Layout:
        """Positions and velocities."""
        return motion((ANY,) * self.dof, ("q", "qd"))

    @property
    def limits(self) -> Layout:
        """The torques, where they have limits."""
        return Layout() if self.limit is None else torques("tau", (ANY,) * self.dof)

    @property
    def noises(self) -> int:
        """For each joint one of q, then one of qd."""
        return 2 * self.dof

    def read(self, y: Signals, w: Annotated[ca.SX, "2n"]) -> Signals:
        """What the computer reads where y is true, with w (2n, 1)."""
        q = quantised(y.q + self.noise_q * w[: self.dof], self.quantum_q)
        qd = quantised(y.qd + self.noise_qd * w[self.dof :], self.quantum_qd)
        return Signals(q=q, qd=qd)

    def limited(self, u: Signals) -> Signals:
        """The torque that is asked for where the law commands `u.tau`, (n, 1), in N m."""
        return Signals(tau=ca.fmin(ca.fmax(u.tau, -self.limit), self.limit)) if self.limit is not None else Signals()
