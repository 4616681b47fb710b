"""Mechanisms: pendulums on a cart and on a rotary arm, and two masses with a spring."""

import math

import casadi as ca
import numpy as np

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States
from workbench.core.shapes import Circle, Line, Shape, Word, project

TURN = math.pi / 12  # between the corners of a ring


@block
class CartPole(AbstractPlant):
    """A cart that a force F pushes along x, with a pole on a hinge at the angle phi.

        (M + m) x'' + b x' - m l phi'' cos(phi) + m l phi'^2 sin(phi) = F
        (I + m l^2) phi'' - m g l sin(phi) = m l x'' cos(phi)

    These are the equations of the tutorial before linearisation, with the tutorial's theta = pi + phi.

    Parameters
    ----------
    M, m
        Mass of the cart (M) and of the pole (m).
    b
        Coefficient of viscous friction of the cart.
    l
        Distance from the hinge to the centre of mass of the pole.
    I
        Moment of inertia of the pole about its centre of mass.
    g
        Gravitational acceleration.
    x
        Position of the cart. F acts toward positive x.
    xd
        Velocity of the cart.
    phi
        Angle of the pole, which is upright at 0 and hangs at pi. For a positive phi it leans toward negative x.
    phid
        Angular velocity of the pole.

    References
    ----------
    Messner and Tilbury, Control Tutorials for Matlab and Simulink, "Inverted Pendulum: System Modeling".

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

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The cart on its track, and the pole as a uniform rod of length 2 l."""
        l, at = self.l, x["x"]
        tip = (at - 2 * l * ca.sin(x["phi"]), 2 * l * ca.cos(x["phi"]))
        floor, box = -0.42 * l, [(-0.5, -0.25), (0.5, -0.25), (0.5, 0.12), (-0.5, 0.12)]
        return (
            Line([(-1e3 * l, floor), (1e3 * l, floor)], "ground"),
            Line([(at + a * l, b * l) for a, b in box], "body", is_closed=True),
            *(Circle((at + side * 0.3 * l, floor + 0.1 * l), 0.1 * l, "link") for side in (-1, 1)),
            Line([(at, 0.0), tip], "link", 0.07 * l),
            Circle((at, 0.0), 0.06 * l),
            Circle(tip, 0.04 * l, "path"),
        )

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


@block
class FurutaPendulum(AbstractPlant):
    """An arm that a torque tau turns about a vertical axis, with a pendulum on a hinge at the end of the arm.

        (Jh_0 + Jh_2 sin(theta_2)^2) theta_1'' + m_2 L_1 l_2 cos(theta_2) theta_2'' + b_1 theta_1'
            + Jh_2 sin(2 theta_2) theta_1' theta_2' - m_2 L_1 l_2 sin(theta_2) theta_2'^2 = tau
        m_2 L_1 l_2 cos(theta_2) theta_1'' + Jh_2 theta_2'' + b_2 theta_2'
            - Jh_2 sin(2 theta_2) theta_1'^2 / 2 + g m_2 l_2 sin(theta_2) = 0

    where Jh_0 = J_1 + m_1 l_1^2 + m_2 L_1^2 and Jh_2 = J_2 + m_2 l_2^2. The equations hold for links that are slender
    or symmetric about their axes.

    Parameters
    ----------
    m_1, m_2
        Mass of the arm (m_1) and of the pendulum (m_2).
    L_1
        Length of the arm, from its axis to the hinge.
    l_1, l_2
        Distance to the centre of mass: of the arm from its axis (l_1), of the pendulum from the hinge (l_2).
    J_1, J_2
        Moment of inertia of the arm (J_1) and of the pendulum (J_2), each about its own centre of mass.
    b_1, b_2
        Coefficient of viscous friction at the axis of the arm (b_1) and at the hinge (b_2).
    g
        Gravitational acceleration.
    theta_1
        Angle of the arm.
    theta_2
        Angle of the pendulum, which hangs at 0 and is upright at pi.
    theta_1d, theta_2d
        Angular velocities of the arm (theta_1d) and of the pendulum (theta_2d).

    References
    ----------
    Cazzolato and Prime (2011), On the dynamics of the Furuta pendulum, J. Control Sci. Eng. 2011, 528341, equations
    (33) and (34); the numbers of its rig were read from programs that cite it, and g = 9.81 is an assumption.

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.FurutaPendulum()), 0.0, np.zeros(4), at_rest=True)
    >>> linear.input_labels, linear.output_labels, linear.poles().imag.max().round(2)
    (['tau'], ['theta_1', 'theta_2'], np.float64(4.56))
    """

    m_1: Scalar = parameter(default=0.300, unit="kg", low=0)
    m_2: Scalar = parameter(default=0.075, unit="kg", low=0, strict=True)
    L_1: Scalar = parameter(default=0.278, unit="m", low=0, strict=True)
    l_1: Scalar = parameter(default=0.150, unit="m", low=0)
    l_2: Scalar = parameter(default=0.148, unit="m", low=0, strict=True)
    J_1: Scalar = parameter(default=2.48e-2, unit="kg m^2", low=0)
    J_2: Scalar = parameter(default=3.86e-3, unit="kg m^2", low=0)
    b_1: Scalar = parameter(default=1.0e-4, unit="N m s/rad", low=0)
    b_2: Scalar = parameter(default=2.8e-4, unit="N m s/rad", low=0)
    g: Scalar = parameter(default=9.81, unit="m/s^2")
    theta_1: Scalar = initial(default=0.0, unit="rad")
    theta_2: Scalar = initial(default=0.0, unit="rad")
    theta_1d: Scalar = initial(default=0.0, unit="rad/s")
    theta_2d: Scalar = initial(default=0.0, unit="rad/s")

    inputs = layout(tau="N m")
    outputs = layout(theta_1="rad", theta_2="rad")

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The arm on its post and the pendulum, a uniform rod of length 2 l_2, seen from the side and above."""
        cos, sin, size = ca.cos(x["theta_1"]), ca.sin(x["theta_1"]), self.L_1
        swing, hang = 2 * self.l_2 * ca.sin(x["theta_2"]), 2 * self.l_2 * ca.cos(x["theta_2"])
        hinge = ca.vertcat(size * cos, size * sin, 0)
        tip = project(hinge + ca.vertcat(-swing * sin, swing * cos, -hang))
        centre, foot = ca.SX.zeros(3), ca.vertcat(0, 0, -1.3 * size)
        ring = [
            project(ca.vertcat(size * math.cos(angle), size * math.sin(angle), 0)) for angle in np.arange(24) * TURN
        ]
        post = Line([project(foot), project(centre)], "ground", 0.1 * size)
        return (
            Line(ring, "ground", is_closed=True),
            post,
            Line([project(centre), project(hinge)], "link", 0.06 * size),
            Circle(project(centre), 0.07 * size),
            Line([project(hinge), tip], "link", 0.04 * size),
            Circle(project(hinge), 0.04 * size),
            Circle(tip, 0.025 * size, "path"),
        )

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        sin, cos, sin2 = ca.sin(x["theta_2"]), ca.cos(x["theta_2"]), ca.sin(2 * x["theta_2"])
        turn, swing = x["theta_1d"], x["theta_2d"]
        Jh_2 = self.J_2 + self.m_2 * self.l_2**2
        M_11 = self.J_1 + self.m_1 * self.l_1**2 + self.m_2 * self.L_1**2 + Jh_2 * sin**2
        M_12 = self.m_2 * self.L_1 * self.l_2 * cos
        arm = u["tau"] - self.b_1 * turn - Jh_2 * sin2 * turn * swing + self.m_2 * self.L_1 * self.l_2 * sin * swing**2
        pendulum = Jh_2 * sin2 * turn**2 / 2 - self.b_2 * swing - self.g * self.m_2 * self.l_2 * sin
        determinant = M_11 * Jh_2 - M_12**2
        return {
            "theta_1": turn,
            "theta_2": swing,
            "theta_1d": (Jh_2 * arm - M_12 * pendulum) / determinant,
            "theta_2d": (M_11 * pendulum - M_12 * arm) / determinant,
        }


@block
class TwoMasses(AbstractPlant):
    """Two masses on a line, joined by a spring, without friction: a force u acts on the first, the second is measured.

        m_1 x_1'' = -k (x_1 - x_2) + u
        m_2 x_2'' =  k (x_1 - x_2)

    The transfer function from u to x_2 is k / (s^2 (m_1 m_2 s^2 + k (m_1 + m_2))). The benchmark asks for a law with
    which the loop is stable for 0.5 < k < 2.

    Parameters
    ----------
    m_1, m_2
        The masses.
    k
        Stiffness of the spring.
    x_1, x_2
        Positions of the masses, measured from an equilibrium.
    x_1d, x_2d
        Velocities of the masses.

    References
    ----------
    Wie and Bernstein (1992), Benchmark problems for robust control design, J. Guid. Control Dyn. 15; without units.

    Examples
    --------
    >>> wb.linearize(wb.open_loop(wb.TwoMasses()), 0.0, np.zeros(4)).poles().imag.max().round(4)
    np.float64(1.4142)
    """

    m_1: Scalar = parameter(default=1.0, unit="kg", low=0, strict=True)
    m_2: Scalar = parameter(default=1.0, unit="kg", low=0, strict=True)
    k: Scalar = parameter(default=1.0, unit="N/m", low=0, strict=True)
    x_1: Scalar = initial(default=0.0, unit="m")
    x_2: Scalar = initial(default=0.0, unit="m")
    x_1d: Scalar = initial(default=0.0, unit="m/s")
    x_2d: Scalar = initial(default=0.0, unit="m/s")

    inputs = layout(u="N")
    outputs = layout(x_2="m")

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """Two boxes and a spring. The spring is drawn 1.4 m long at equilibrium; its length is not in the equations."""
        left, right = x["x_1"] - 1.0, x["x_2"] + 1.0
        box = [(-0.3, 0.0), (0.3, 0.0), (0.3, 0.5), (-0.3, 0.5)]
        first, length = left + 0.3, right - left - 0.6
        bends = [(0.15 + 0.7 * i / 12, 0.25 + 0.1 * (-1) ** i * (0 < i < 12)) for i in range(13)]
        return (
            Line([(-1e3, 0.0), (1e3, 0.0)], "ground"),
            Line([(first + a * length, b) for a, b in [(0, 0.25), *bends, (1, 0.25)]], "link", 0.02),
            *(Line([(middle + a, b) for a, b in box], "body", is_closed=True) for middle in (left, right)),
            *(Word((middle, 0.25), digit) for middle, digit in ((left, "1"), (right, "2"))),
        )

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        spring = self.k * (x["x_1"] - x["x_2"])
        return {
            "x_1": x["x_1d"],
            "x_2": x["x_2d"],
            "x_1d": (u["u"] - spring) / self.m_1,
            "x_2d": spring / self.m_2,
        }
