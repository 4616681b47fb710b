"""A quadrotor that moves in a vertical plane."""

from __future__ import annotations

import casadi as ca

from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.loop.contracts import AbstractPlant, Inputs, Parts


@block
class PlanarQuadrotor(AbstractPlant):
    """A body with two propellers at the distance r on either side, whose thrusts u_1 and u_2 are along its own axis.

        m x''     = -(u_1 + u_2) sin(theta)
        m y''     =  (u_1 + u_2) cos(theta) - m g
        I theta'' =  r (u_1 - u_2)

    It hovers with u_1 = u_2 = m g / 2.

    References
    ----------
    Tedrake, Underactuated Robotics, chapter 3, "Quadrotors"; the numbers are those of its planar quadrotor, which
    names Bouadi, Bouchoucha and Tadjine (2007) as their source.

    Examples
    --------
    >>> plant = wb.PlanarQuadrotor()
    >>> hover = [plant.m * plant.g / 2] * 2
    >>> linear = wb.linearize(wb.open_loop(plant), 0.0, np.zeros(6), u=hover, at_rest=True)
    >>> linear.input_labels, linear.output_labels
    (['u_1', 'u_2'], ['x', 'y', 'theta'])
    """

    m: Scalar = parameter(default=0.486, unit="kg", low=0, strict=True)
    I: Scalar = parameter(default=0.00383, unit="kg m^2", low=0, strict=True)
    r: Scalar = parameter(default=0.25, unit="m", low=0, strict=True)
    g: Scalar = parameter(default=9.81, unit="m/s^2")
    x: Scalar = initial(default=0.0, unit="m")
    y: Scalar = initial(default=0.0, unit="m")
    theta: Scalar = initial(default=0.0, unit="rad")
    xd: Scalar = initial(default=0.0, unit="m/s")
    yd: Scalar = initial(default=0.0, unit="m/s")
    thetad: Scalar = initial(default=0.0, unit="rad/s")

    inputs = layout(u_1="N", u_2="N")
    outputs = layout(x="m", y="m", theta="rad")

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        thrust = u["u_1"] + u["u_2"]
        return {
            "x": x["xd"],
            "y": x["yd"],
            "theta": x["thetad"],
            "xd": -thrust * ca.sin(x["theta"]) / self.m,
            "yd": thrust * ca.cos(x["theta"]) / self.m - self.g,
            "thetad": self.r * (u["u_1"] - u["u_2"]) / self.I,
        }
