"""A link of a spatial arm: a rigid body and the joint that carries it."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca

from workbench.core import block, option, parameter
from workbench.core.block import Number, Scalar, Vector
from workbench.robots import poses
from workbench.robots.frames import refuse_skewed
from workbench.robots.inertia import about_origin, refuse_impossible, spatial, tensor
from workbench.robots.limits import NO_LIMITS, JointLimits
from workbench.robots.motion import sparse, transform
from workbench.robots.newton_euler import Body
from workbench.validation.refusals import Array, described, matrix, name, vector

UNIT = 1e-12  # what rounding leaves of a unit axis


@block
class SpatialLink:
    """A rigid body and the joint that carries it.

    The joint's frame lies at `position` with the axes `rotation` in the frame of the body that carries it; the
    body's own frame is the joint's, turned by q about `axis` or shifted by q along it. Where a number of friction
    or of the drive is None, the equations have no such term.

    Parameters
    ----------
    name
        Of the joint.
    mass
        May be 0 of a link that carries others, as the cross of a universal joint, if M stays positive definite.
    com
        (3,): the centre of mass.
    inertia
        (6,): the moments xx, xy, xz, yy, yz, zz about the centre of mass, round the axes of the body's frame.
    parent
        The number of the link that carries this one; -1 is the base.
    axis, rotation
        (3,) and (3, 3): shape, not numbers to vary, as a unit axis would no longer be one.
    viscous, coulomb, speed
        F = viscous qd + coulomb sign(qd), in N m, or in N for a slide; where a `speed` is given the jump is spread
        over it, coulomb tanh(qd / speed).
    rotor, gear
        The drive adds gear^2 rotor to the joint's inertia. Its gyroscopic torque is left out.
    limits
        Of the joint; they are no part of the equations.

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 7.1.
    """

    name: str
    mass: Scalar = parameter(unit="kg", low=0, symbol="m")
    com: Vector = parameter(unit="m", shape=("3",), symbol="c")
    inertia: Vector = parameter(unit="kg m^2", shape=("6",), symbol="I")
    position: Vector = parameter(default=(0.0, 0.0, 0.0), unit="m", shape=("3",), symbol="r")
    axis: Any = (0.0, 0.0, 1.0)
    rotation: Any = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    parent: int = -1
    joint: str = option(
        {
            "revolute": "turns about its axis; its stops are no part of the equations",
            "continuous": "turns about its axis without end",
            "prismatic": "slides along its axis",
        },
        default="revolute",
    )
    viscous: Scalar = parameter(default=None, unit="{force} s/{length}", low=0, symbol="b")
    coulomb: Scalar = parameter(default=None, unit="{force}", low=0, symbol="f_c")
    rotor: Scalar = parameter(default=None, unit="{rotor_unit}", low=0, symbol="J_r")
    gear: Scalar = parameter(default=None, unit="", symbol="k_r")
    speed: Scalar = parameter(default=None, unit="{length}/s", low=0, strict=True, symbol="v_s")
    limits: JointLimits = NO_LIMITS

    def __post_init__(self) -> None:
        me = f"SpatialLink({described(name('SpatialLink(name=...)', self.name))}"
        object.__setattr__(self, "axis", _frozen(vector(f"{me}, axis=...)", self.axis, 3, "coordinates")))
        object.__setattr__(self, "rotation", _frozen(matrix(f"{me}, rotation=...)", self.rotation, 3, 3)))
        length = math.hypot(*self.axis)
        if not abs(length - 1) <= UNIT:
            raise ValueError(
                f"`{me}, axis=...)` must be a unit vector, as q counts angle or length along "
                f"it; got length {length:g}: divide it by that."
            )
        refuse_skewed(f"{me}, rotation=...)", self.rotation)
        for word, needed in (("gear", "rotor"), ("speed", "coulomb")):
            if getattr(self, word) is not None and getattr(self, needed) is None:
                raise ValueError(f"`{me}, {word}=...)` has no effect without a `{needed}`: give both.")
        refuse_impossible(f"link '{self.name}'", self.mass, tensor(self.inertia))

    @property
    def slides(self) -> bool:
        """Whether its joint slides; else it turns."""
        return self.joint == "prismatic"

    @property
    def length(self) -> str:
        """The unit of its position."""
        return "m" if self.slides else "rad"

    @property
    def force(self) -> str:
        """The unit of what drives it."""
        return "N" if self.slides else "N m"

    @property
    def rotor_unit(self) -> str:
        """The unit of its drive's inertia, seen from the joint."""
        return "kg" if self.slides else "kg m^2"

    def body(self, q: Number) -> Body:
        """What the recursions see of it at the position q of its joint."""
        pose = poses.across_joint(self, q)
        S = ca.vertcat(ca.SX(3, 1), sparse(self.axis)) if self.slides else ca.vertcat(sparse(self.axis), ca.SX(3, 1))
        inertia = spatial(*about_origin(self.mass, self.com, self.inertia))
        return Body(self.parent, transform(*pose), S, inertia)

    def drive_inertia(self) -> Any:
        """What the rotor adds to the diagonal of M, seen from the joint."""
        if self.rotor is None:
            return 0.0
        return self.rotor if self.gear is None else self.gear**2 * self.rotor

    def friction(self, qd: Number) -> ca.SX:
        """F(qd) of its joint."""
        viscous = ca.SX(1, 1) if self.viscous is None else self.viscous * qd
        return viscous if self.coulomb is None else viscous + self.coulomb * self.direction(qd)

    def direction(self, qd: Number) -> ca.SX:
        """sign(qd), or tanh(qd / speed) where Coulomb friction is smooth."""
        way: ca.SX = ca.sign(qd) if self.speed is None else ca.tanh(qd / self.speed)
        return way


def _frozen(value: Array) -> Array:
    value.flags.writeable = False
    return value
