"""What stands between an arm and its computer: instruments with noise and steps, a torque with limits."""

from __future__ import annotations

from typing import Annotated

import casadi as ca

from workbench.core import block, parameter
from workbench.core.block import Vector
from workbench.loop.ports import Measurement
from workbench.validation.shapes import Column


@block
class Instruments:
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
    def entries(self) -> int:
        """How many standard normal numbers one reading takes: for each joint one of q, then one of qd."""
        return 2 * self.dof

    def read(self, y: Measurement, w: Annotated[ca.SX, "2n"]) -> Measurement:
        """What the computer reads where y is true, with w (2n, 1); the disturbance is no reading and stays as it is."""
        q = quantised(y.q + self.noise_q * w[: self.dof], self.quantum_q)
        qd = quantised(y.qd + self.noise_qd * w[self.dof :], self.quantum_qd)
        return Measurement(q, qd, y.d)

    def limited(self, tau: Column) -> ca.SX:
        """The torque that is asked for where the law commands `tau`, (n, 1), in N m."""
        return tau if self.limit is None else ca.fmin(ca.fmax(tau, -self.limit), self.limit)


def quantised(x: ca.SX, quantum: ca.SX) -> ca.SX:
    """The multiple of the quantum that is nearest to x, the upper one of two; x itself where the quantum is 0."""
    some = quantum > 0
    b = ca.if_else(some, quantum, 1)  # nothing is ever divided by 0
    return ca.if_else(some, ca.floor(x / b + 0.5) * b, x)
