"""A sinusoidal disturbance torque."""

import casadi as ca

from workbench.blocks.loop.environment import AbstractDisturbance
from workbench.core import block, parameter
from workbench.core.block import Number, Vector


@block
class SineTorque(AbstractDisturbance):
    """A sinusoidal disturbance torque with n components:  D_i(t) = amplitude_i sin(frequency_i t + phase_i).

    It is the `disturbance` of a `Manipulator`, and takes one number for each of its n torques.

    Parameters
    ----------
    amplitude
        The peak value of each torque.
    frequency
        The angular frequency of each torque, in rad/s and not in Hz.
    phase
        The phase of each torque at t = 0.

    Examples
    --------
    >>> wb.SineTorque([0.5], [3.0]).at(0.0)
    SX(0)
    """

    amplitude: Vector = parameter(unit="N m", shape=("n",), symbol="delta")
    frequency: Vector = parameter(unit="rad/s", shape=("n",), symbol="omega_d")
    phase: Vector = parameter(default=0.0, unit="rad", shape=("n",), symbol="theta_d")

    @property
    def dof(self) -> int:
        """The number n of components."""
        return int(self.amplitude.shape[0])

    def at(self, t: Number) -> ca.SX:
        torque: ca.SX = self.amplitude * ca.sin(self.frequency * t + self.phase)
        return torque
