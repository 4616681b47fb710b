"""The inverted pendulum on a cart of the Michigan tutorials."""

from __future__ import annotations

import casadi as ca

from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.loop.contracts import AbstractPlant, Inputs, Parts


@block
class CartPole(AbstractPlant):
    """A cart at x, pushed by F, with a pole on a hinge; phi is its angle from upright, positive away from +x.

        (M + m) x'' + b x' - m l phi'' cos(phi) + m l phi'^2 sin(phi) = F
        (I + m l^2) phi'' - m g l sin(phi) = m l x'' cos(phi)

    These are the equations of the tutorial with its theta = pi + phi, before they are made linear: a pole that hangs
    has phi = pi. l is the distance from the hinge to the centre of mass, I the inertia about that.

    References
    ----------
    Messner and Tilbury, Control Tutorials for Matlab and Simulink, "Inverted Pendulum: System Modeling"; g = 9.8 is
    theirs.

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    >>> wb.lqr(linear, Q=np.diag([5000.0, 0.0, 100.0, 0.0]), R=[[1.0]]).K.round(4)
    array([[-70.7107, -37.8345, 105.5298,  20.9238]])
    """

    M: Scalar = parameter(default=0.5, unit="kg", low=0, strict=True)
    m: Scalar = parameter(default=0.2, unit="kg", low=0, strict=True)
    b: Scalar = parameter(default=0.1, unit="N s/m", low=0)
    l: Scalar = parameter(default=0.3, unit="m", low=0, strict=True)
    I: Scalar = parameter(default=0.006, unit="kg m^2", low=0)
    g: Scalar = parameter(default=9.8, unit="m/s^2")
    x: Scalar = initial(default=0.0, unit="m")
    xd: Scalar = initial(default=0.0, unit="m/s")
    phi: Scalar = initial(default=0.0, unit="rad")
    phid: Scalar = initial(default=0.0, unit="rad/s")

    inputs = layout(F="N")
    outputs = layout(x="m", phi="rad")

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        sin, cos, phid = ca.sin(x["phi"]), ca.cos(x["phi"]), x["phid"]
        ml, inertia = self.m * self.l, self.I + self.m * self.l**2
        push = u["F"] - self.b * x["xd"] - ml * phid**2 * sin
        fall = ml * self.g * sin
        determinant = (self.M + self.m) * inertia - (ml * cos) ** 2
        return {
            "x": x["xd"],
            "xd": (inertia * push + ml * cos * fall) / determinant,
            "phi": phid,
            "phid": ((self.M + self.m) * fall + ml * cos * push) / determinant,
        }
