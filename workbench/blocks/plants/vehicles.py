"""Vehicles: a car as a single track, and quadrotors in a vertical plane and in space."""

import math

import casadi as ca

from workbench.blocks.loop.contracts import AbstractPlant, Inputs, Parts
from workbench.core import block, initial, layout, parameter
from workbench.core.block import Number, Scalar, States, Vector
from workbench.core.shapes import Circle, Line, Shape, project

STRIPE = 12.0  # m, from one mark of a road to the next
CORNERS = [math.pi / 4 * corner for corner in range(8)]  # of a rotor's disc, in rad


@block
class SingleTrackVehicle(AbstractPlant):
    """The bicycle model of a car at a constant speed V_x, steered by the angle delta of its front wheels.

        m (v_y' + V_x r) = F_f + F_r,     F_f = 2 C_f (delta - (v_y + l_f r) / V_x)
        I_z r' = l_f F_f - l_r F_r,       F_r = -2 C_r (v_y - l_r r) / V_x
        psi' = r,                         Y' = V_x sin(psi) + v_y cos(psi)

    Slip angles are small, and the tyres do not saturate.

    Parameters
    ----------
    m
        Mass.
    I_z
        Yaw moment of inertia.
    l_f, l_r
        Distance from the centre of mass to the front axle (l_f) and to the rear axle (l_r).
    C_f, C_r
        Cornering stiffness of one front tyre (C_f) and of one rear tyre (C_r).
    V_x
        Forward speed.
    Y
        Lateral position on the ground.
    psi
        Heading.
    v_y
        Lateral velocity of the body, positive to the left.
    r
        Yaw rate.

    References
    ----------
    Rajamani (2012), Vehicle Dynamics and Control, 2nd edition, sections 2.3 and 3.3; the numbers of a passenger car
    were read from programs that implement it, and the speed is an assumption.

    Examples
    --------
    >>> car = wb.SingleTrackVehicle()
    >>> car.states.names, car.inputs.names, car.outputs.names
    (('Y', 'psi', 'v_y', 'r'), ('delta',), ('Y', 'psi', 'r'))
    """

    m: Scalar = parameter(default=1573.0, unit="kg", low=0, strict=True)
    I_z: Scalar = parameter(default=2873.0, unit="kg m^2", low=0, strict=True)
    l_f: Scalar = parameter(default=1.1, unit="m", low=0, strict=True)
    l_r: Scalar = parameter(default=1.58, unit="m", low=0, strict=True)
    C_f: Scalar = parameter(default=80_000.0, unit="N/rad", low=0, strict=True)
    C_r: Scalar = parameter(default=80_000.0, unit="N/rad", low=0, strict=True)
    V_x: Scalar = parameter(default=30.0, unit="m/s", low=0, strict=True)
    Y: Scalar = initial(default=0.0, unit="m")
    psi: Scalar = initial(default=0.0, unit="rad")
    v_y: Scalar = initial(default=0.0, unit="m/s")
    r: Scalar = initial(default=0.0, unit="rad/s")

    inputs = layout(delta="rad")
    outputs = layout(Y="m", psi="rad", r="rad/s")

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The car from above, on a road of lanes of 3.5 m that passes below it at V_x."""
        cos, sin = ca.cos(x["psi"]), ca.sin(x["psi"])
        passed = ca.fmod(self.V_x * t, STRIPE)
        front, rear = self.l_f + 0.9, -self.l_r - 0.8

        def outline(corners: list[tuple[Scalar, float]]) -> list[tuple[ca.SX, ca.SX]]:
            return [(a * cos - b * sin, x["Y"] + a * sin + b * cos) for a, b in corners]

        edges = [Line([(-1e3, side), (1e3, side)], "ground") for side in (-1.75, 5.25)]
        marks = [
            Line([(STRIPE * i - passed, 1.75), (STRIPE * i - passed + 3.0, 1.75)], "ground", 0.12) for i in range(-3, 5)
        ]
        wheels = [
            Line(outline([(axle - 0.33, side), (axle + 0.33, side)]), "link", 0.22)
            for axle in (self.l_f, -self.l_r)
            for side in (-0.78, 0.78)
        ]
        body = [(front, 0.55), (front - 0.35, 0.88), (rear + 0.2, 0.88), (rear, 0.7)]
        roof = [(self.l_f - 0.6, 0.66), (0.0, 0.6), (-self.l_r + 0.3, 0.6), (-self.l_r - 0.2, 0.66)]
        halves = [half + [(a, -b) for a, b in reversed(half)] for half in (body, roof)]
        return *edges, *marks, *(Line(outline(half), "body", is_closed=True) for half in halves), *wheels

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        v_y, r = x["v_y"], x["r"]
        F_f = 2 * self.C_f * (u["delta"] - (v_y + self.l_f * r) / self.V_x)
        F_r = -2 * self.C_r * (v_y - self.l_r * r) / self.V_x
        return {
            "Y": self.V_x * ca.sin(x["psi"]) + v_y * ca.cos(x["psi"]),
            "psi": r,
            "v_y": (F_f + F_r) / self.m - self.V_x * r,
            "r": (self.l_f * F_f - self.l_r * F_r) / self.I_z,
        }


@block
class PlanarQuadrotor(AbstractPlant):
    """A quadrotor in a vertical plane: two propellers whose thrusts u_1 and u_2 [N] act along the axis of the body.

        m x''     = -(u_1 + u_2) sin(theta)
        m y''     =  (u_1 + u_2) cos(theta) - m g
        I theta'' =  r (u_1 - u_2)

    It hovers with u_1 = u_2 = m g / 2.

    Parameters
    ----------
    m
        Mass.
    I
        Moment of inertia.
    r
        Distance of each propeller from the centre of mass.
    g
        Gravitational acceleration.
    x, y
        Horizontal position, height.
    xd, yd
        Their velocities.
    theta, thetad
        Angle of the body, its angular velocity.

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

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The body with its two propellers, and the track of its centre."""
        cos, sin, r = ca.cos(x["theta"]), ca.sin(x["theta"]), self.r

        def at(along: Scalar, up: Scalar) -> tuple[ca.SX, ca.SX]:
            return x["x"] + along * cos - up * sin, x["y"] + along * sin + up * cos

        return (
            Circle(at(0.0, 0.0), 0.03 * r, "path"),
            Line([at(-r, 0.0), at(r, 0.0)], "link", 0.08 * r),
            *(Line([at(side * r, 0.0), at(side * r, 0.22 * r)], "link", 0.05 * r) for side in (-1, 1)),
            *(Line([at((side - 0.4) * r, 0.22 * r), at((side + 0.4) * r, 0.22 * r)], "body") for side in (-1, 1)),
            Circle(at(0.0, 0.0), 0.16 * r),
        )

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


@block
class Quadrotor(AbstractPlant):
    """A quadrotor: a rigid body with rotors 1 and 3 on its x axis, and rotors 2 and 4 on its y axis.

        m xi''  = -m g e_3 + R(eta) e_3 T - A xi',        T = k (w_1^2 + w_2^2 + w_3^2 + w_4^2)
        I nu'   = -nu x (I nu) - I_r nu x e_3 w_G + tau,  w_G = w_1 - w_2 + w_3 - w_4
        eta'    = W(eta)^-1 nu
        tau     = (l k (w_4^2 - w_2^2), l k (w_3^2 - w_1^2), b (-w_1^2 + w_2^2 - w_3^2 + w_4^2))

    The input w (4,) has the speeds of the rotors; rotors 1 and 3 turn in one sense, 2 and 4 in the other. The rotation
    matrix is R = R_z(psi) R_y(theta) R_x(phi). W is singular at a pitch of +-90 degrees. The term I_M w' of the paper,
    for a changing speed of the rotors, is left out. The quadrotor hovers at w_i = sqrt(m g / (4 k)), 620.6 rad/s.

    Parameters
    ----------
    m
        Mass.
    I
        Principal moments of inertia of the body.
    I_r
        Moment of inertia of one rotor.
    l
        Distance of each rotor from the centre of mass.
    k, b
        Lift constant (k) or drag constant (b) of a rotor.
    A
        Coefficients of air resistance along the three axes of the world.
    g
        Gravitational acceleration.
    xi, xid
        Position (xi) or velocity (xid) in the world. The third component is vertical.
    eta
        Roll, pitch and yaw, eta = (phi, theta, psi).
    nu
        Angular velocity in the axes of the body.

    References
    ----------
    Luukkonen (2011), Modelling and control of quadcopter, Aalto University, equations (2) to (20) and table 1, whose
    numbers were read from programs that cite it.

    Examples
    --------
    >>> plant = wb.Quadrotor()
    >>> plant.inputs["w"].shape, plant.inputs["w"].unit, plant.outputs.names
    ((4,), 'rad/s', ('xi', 'eta'))
    """

    m: Scalar = parameter(default=0.468, unit="kg", low=0, strict=True)
    l: Scalar = parameter(default=0.225, unit="m", low=0, strict=True)
    k: Scalar = parameter(default=2.980e-6, unit="N s^2/rad^2", low=0, strict=True)
    b: Scalar = parameter(default=1.140e-7, unit="N m s^2/rad^2", low=0)
    I_r: Scalar = parameter(default=3.357e-5, unit="kg m^2", low=0)
    I: Vector = parameter(default=(4.856e-3, 4.856e-3, 8.801e-3), unit="kg m^2", low=0, strict=True, shape=("3",))
    A: Vector = parameter(default=(0.25, 0.25, 0.25), unit="kg/s", low=0, shape=("3",))
    g: Scalar = parameter(default=9.81, unit="m/s^2")
    xi: Vector = initial(default=(0.0, 0.0, 0.0), unit="m", shape=("3",))
    eta: Vector = initial(default=(0.0, 0.0, 0.0), unit="rad", shape=("3",))
    xid: Vector = initial(default=(0.0, 0.0, 0.0), unit="m/s", shape=("3",))
    nu: Vector = initial(default=(0.0, 0.0, 0.0), unit="rad/s", shape=("3",))

    inputs = layout(w=("rad/s", [620.0, 620.0, 620.0, 620.0]))  # near hovering, where trimming starts
    outputs = layout(xi=("m", [0.0, 0.0, 0.0]), eta=("rad", [0.0, 0.0, 0.0]))

    def drawing(self, t: Number, x: States) -> tuple[Shape, ...]:
        """The two beams with their rotors, seen from the side and above. The beam of rotor 1 is the thickest."""
        (s_x, s_y, s_z), (c_x, c_y, c_z) = ca.vertsplit(ca.sin(x["eta"])), ca.vertsplit(ca.cos(x["eta"]))
        ahead = ca.vertcat(c_z * c_y, s_z * c_y, -s_y)  # the first column of R(eta), then the others
        left = ca.vertcat(c_z * s_y * s_x - s_z * c_x, s_z * s_y * s_x + c_z * c_x, c_y * s_x)
        up = ca.vertcat(c_z * s_y * c_x + s_z * s_x, s_z * s_y * c_x - c_z * s_x, c_y * c_x)
        hub, l, beam = project(x["xi"]), self.l, [project(part) for part in (ahead, left)]

        def at(along: float, across: float) -> ca.SX:
            place: ca.SX = hub + l * (along * beam[0] + across * beam[1])
            return place

        def disc(along: float, across: float) -> Line:
            corners = [(along + 0.4 * math.cos(a), across + 0.4 * math.sin(a)) for a in CORNERS]
            return Line([at(*corner) + 0.12 * l * project(up) for corner in corners], "body", 0.0, is_closed=True)

        return (
            Line([at(-1.0, 0.0), at(1.0, 0.0)], "link", 0.07 * l),
            Line([at(0.0, -1.0), at(0.0, 1.0)], "link", 0.07 * l),
            Line([hub, at(1.0, 0.0)], "link", 0.14 * l),
            *(disc(*end) for end in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))),
            Circle(hub, 0.14 * l),
            Circle(hub, 0.03 * l, "path"),
        )

    def rate(self, t: Number, x: States, u: Inputs) -> Parts:
        nu, w, lift = x["nu"], u["w"], self.k * u["w"] ** 2
        sin, cos = ca.vertsplit(ca.sin(x["eta"])), ca.vertsplit(ca.cos(x["eta"]))
        up = ca.vertcat(  # the third column of R(eta)
            cos[2] * sin[1] * cos[0] + sin[2] * sin[0], sin[2] * sin[1] * cos[0] - cos[2] * sin[0], cos[1] * cos[0]
        )
        turn = w[0] - w[1] + w[2] - w[3]
        tau = ca.vertcat(
            self.l * (lift[3] - lift[1]),
            self.l * (lift[2] - lift[0]),
            self.b / self.k * (lift[1] + lift[3] - lift[0] - lift[2]),
        )
        spin = ca.cross(nu, self.I * nu + ca.vertcat(0, 0, self.I_r * turn))
        level = sin[0] * nu[1] + cos[0] * nu[2]
        return {
            "xi": x["xid"],
            "eta": ca.vertcat(nu[0] + sin[1] / cos[1] * level, cos[0] * nu[1] - sin[0] * nu[2], level / cos[1]),
            "xid": (ca.sum1(lift) * up - self.A * x["xid"]) / self.m - ca.vertcat(0, 0, self.g),
            "nu": (tau - spin) / self.I,
        }
