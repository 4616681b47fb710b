from __future__ import annotations

import casadi as ca

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import Layout, block, initial, layout, option, parameter
from workbench.core.block import Number, Scalar, States, initial_states
from workbench.core.shapes import Circle, Line, Shape


@block
class DCMotor(AbstractPlant):
    """A DC motor with the armature voltage v as its input.

        J omega' = K i - b omega
        L i'     = v - R i - K omega
        theta'   = omega

    The default numbers are those of the tutorial on speed. `DCMotor.position()` has those of the tutorial on position.

    Parameters
    ----------
    J
        Moment of inertia of the rotor.
    b
        Coefficient of viscous friction.
    K
        Torque constant in N m/A, which is also the back-emf constant in V s/rad.
    R
        Resistance of the armature.
    L
        Inductance of the armature.
    theta
        Angle of the rotor. It is a state only with `measurement="position"`.
    omega
        Speed of the rotor.
    i
        Armature current.
    measurement
        The output of the motor.

    References
    ----------
    Messner and Tilbury, Control Tutorials for Matlab and Simulink, "DC Motor Speed: System Modeling" and "DC Motor
    Position: System Modeling".

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    >>> np.sort(linear.poles().real).round(4), linear.dcgain().round(4)
    (array([-9.9975, -2.0025]), np.float64(0.0999))
    """

    J: Scalar = parameter(default=0.01, unit="kg m^2", low=0, strict=True)
    b: Scalar = parameter(default=0.1, unit="N m s/rad", low=0)
    K: Scalar = parameter(default=0.01, unit="N m/A")
    R: Scalar = parameter(default=1.0, unit="ohm", low=0, strict=True)
    L: Scalar = parameter(default=0.5, unit="H", low=0, strict=True)
    theta: Scalar = initial(default=0.0, unit="rad")
    omega: Scalar = initial(default=0.0, unit="rad/s")
    i: Scalar = initial(default=0.0, unit="A")
    measurement: str = option({"speed": "the speed omega", "position": "the angle theta"}, default="speed")

    @staticmethod
    def position() -> DCMotor:
        """The motor of the tutorial on position, as identified in a laboratory at Carnegie Mellon."""
        return DCMotor(3.2284e-6, 3.5077e-6, 0.0274, 4.0, 2.75e-6, measurement="position")

    @property
    def states(self) -> Layout:
        held = initial_states(self).entries
        return Layout(held if self.measurement == "position" else held[1:])

    @property
    def inputs(self) -> Layout:
        return layout(v="V")

    @property
    def outputs(self) -> Layout:
        return layout(theta="rad") if self.measurement == "position" else layout(omega="rad/s")

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...] | None:
        """The rotor with a mark that shows theta, or None if theta is not a state. Its size is not in the equations."""
        if self.measurement != "position":
            return None
        cos, sin = ca.cos(x["theta"]), ca.sin(x["theta"])
        return (
            Line([(0.0505, 0.0), (0.056, 0.0)], "ground", 0.001),
            Circle((0.0, 0.0), 0.05, "body"),
            Line([(0.0, 0.0), (0.05 * cos, 0.05 * sin)], "link", 0.005),
            Circle((0.0, 0.0), 0.008, "link"),
        )

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        omega, i = x["omega"], x["i"]
        angle = {"theta": omega} if self.measurement == "position" else {}
        return angle | {
            "omega": (self.K * i - self.b * omega) / self.J,
            "i": (u["v"] - self.R * i - self.K * omega) / self.L,
        }
