"""What a spatial arm is: bodies on hinges and slides, each carried by one before it, on a base that stands still."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from workbench.core import AbstractArm, block, option, parameter
from workbench.core.block import Scalar, Vector
from workbench.robots import agreement, composite, newton_euler, poses
from workbench.robots.frames import Frame, frame_named, refuse_skewed
from workbench.robots.inertia import about_origin, refuse_impossible, spatial, tensor
from workbench.robots.motion import sparse, transform
from workbench.robots.newton_euler import Body
from workbench.validation.shapes import Column, Number
from workbench.validation.words import Array, described, matrix, vector

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
    viscous, coulomb
        F = viscous qd + coulomb sign(qd), in N m, or in N for a slide.
    rotor, gear
        The drive adds gear^2 rotor to the joint's inertia. Its gyroscopic torque is left out.

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
    viscous: Scalar = parameter(default=None, unit="N m s/rad or N s/m", low=0, symbol="b")
    coulomb: Scalar = parameter(default=None, unit="N m or N", low=0, symbol="f_c")
    rotor: Scalar = parameter(default=None, unit="kg m^2 or kg", low=0, symbol="J_r")
    gear: Scalar = parameter(default=None, unit="", symbol="k_r")

    def __post_init__(self) -> None:
        me = f"SpatialLink({described(self.name)}"
        object.__setattr__(self, "axis", _frozen(vector(f"{me}, axis=...)", self.axis, 3, "coordinates")))
        object.__setattr__(self, "rotation", _frozen(matrix(f"{me}, rotation=...)", self.rotation, 3, 3)))
        length = float(np.linalg.norm(self.axis))
        if not abs(length - 1) <= UNIT:
            raise ValueError(
                f"`{me}, axis=...)` must be a unit vector, as q counts angle or length along "
                f"it; got length {length:g}: divide it by that."
            )
        refuse_skewed(f"{me}, rotation=...)", self.rotation)
        if self.gear is not None and self.rotor is None:
            raise ValueError(f"`{me}, gear=...)` has no effect without a `rotor`: give both.")
        refuse_impossible(f"link '{self.name}'", self.mass, tensor(self.inertia))

    def body(self, q: Number) -> Body:
        """What the recursions see of it at the position q of its joint."""
        pose, slides = poses.across_joint(self, q), self.joint == "prismatic"
        S = ca.vertcat(ca.SX(3, 1), sparse(self.axis)) if slides else ca.vertcat(sparse(self.axis), ca.SX(3, 1))
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
        return viscous if self.coulomb is None else viscous + self.coulomb * ca.sign(qd)


def _frozen(value: Array) -> Array:
    value.flags.writeable = False
    return value


@block
class SpatialArm(AbstractArm):
    """A tree of rigid bodies on hinges and slides; gravity pulls along -z of the base.

    C is the matrix of the Christoffel symbols; `torque` and `acceleration` come from recursions and never form it.
    When an arm is made, the recursion of Newton and Euler is held against Lagrange's equation of its energies, and
    M against both.

    Parameters
    ----------
    links
        The carrying body before the carried one.
    frames
        Named places on bodies, such as the tool; each link's own frame is one by the name of its joint.

    Raises
    ------
    ValueError
        If a name comes twice, a link is carried by none before it, a frame lies on no link, the two roads disagree,
        or M is not positive definite.
    """

    links: tuple[SpatialLink, ...]
    gravity: Scalar = parameter(default=9.81, unit="m/s^2", low=0, symbol="g")
    frames: tuple[Frame, ...] = ()

    def __post_init__(self) -> None:
        if not self.links:
            raise ValueError("`SpatialArm(links=...)` must be a tuple of at least one `SpatialLink`; got none.")
        names = [link.name for link in self.links]
        if twice := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"`SpatialArm(links=...)` needs unique names; {sorted(twice)} came more than once.")
        for i, link in enumerate(self.links):
            if not -1 <= link.parent < i:
                raise ValueError(
                    f"`SpatialArm(links=...)` takes the carrying link before the carried one, -1 for the base, so that "
                    f"there is no loop; '{link.name}' at [{i}] has parent {link.parent}."
                )
        for frame in self.frames:
            if not -1 <= frame.link < len(self.links):
                raise ValueError(
                    "`SpatialArm(frames=...)` lie on links by number, -1 for the base; "
                    f"'{frame.name}' is on {frame.link} of {len(self.links)}."
                )
        agreement.check(self)

    @property
    def dof(self) -> int:
        """The number of joints."""
        return len(self.links)

    def bodies(self, q: Column) -> list[Body]:
        """What the recursions see at q."""
        return [link.body(q[i]) for i, link in enumerate(self.links)]

    def mass_matrix(self, q: Column) -> ca.SX:
        """M(q), (n, n): of composite bodies, with the drives' rotors on its diagonal."""
        return composite.mass_matrix(self.bodies(q)) + ca.diag(self.drive_inertias())

    def coriolis_matrix(self, q: Column, qd: Column) -> ca.SX:
        """C(q, qd), (n, n): the one of the Christoffel symbols, for which M' - 2C is skew."""
        return composite.coriolis_matrix(self.bodies(q), qd)

    def coriolis_force(self, q: Column, qd: Column) -> ca.SX:
        """C(q, qd) qd, (n, 1), without C."""
        return newton_euler.torque(self.bodies(q), ca.SX(1, 1), qd, ca.SX(self.dof, 1))

    def gravity_vector(self, q: Column) -> ca.SX:
        """G(q), (n, 1)."""
        rest = ca.SX(self.dof, 1)
        return newton_euler.torque(self.bodies(q), ca.SX(self.gravity), rest, rest)

    def friction(self, qd: Column) -> ca.SX:
        """F(qd), (n, 1), with no entry for a joint without friction."""
        return ca.vertcat(*[link.friction(qd[i]) for i, link in enumerate(self.links)])

    def drive_inertias(self) -> ca.SX:
        """gear^2 rotor of each joint, (n, 1)."""
        return ca.vertcat(*[sparse(link.drive_inertia()) for link in self.links])

    def recursion(self, q: Column, qd: Column, qdd: Column) -> ca.SX:
        """tau = M qdd + C qd + G + F, (n, 1), by Newton and Euler."""
        tau = newton_euler.torque(self.bodies(q), ca.SX(self.gravity), qd, qdd)
        return ca.densify(tau + self.drive_inertias() * qdd + self.friction(qd))

    def kinetic_energy(self, q: Column, qd: Column) -> ca.SX:
        """T(q, qd) in J, of links and rotors."""
        rotors = ca.dot(self.drive_inertias(), qd**2) / 2
        return ca.densify(newton_euler.kinetic_energy(self.bodies(q), qd) + rotors)

    def potential_energy(self, q: Column) -> ca.SX:
        """U(q) in J, zero with all masses at the height of the base."""
        return poses.potential_energy(self.links, self.gravity, q)

    def pose(self, q: Column, frame: str = "") -> poses.Pose:
        """Rotation (3, 3) and origin (3, 1) of a frame seen from the base; of the last link without a name.

        Raises
        ------
        LookupError
            If there is no frame of that name; the message names the nearest.
        """
        place = frame_named(frame, self.links, self.frames)
        fixed = poses.Pose(sparse(place.rotation), sparse(place.position))
        return fixed if place.link < 0 else poses.from_base(self.links, q)[place.link].then(fixed)

    def jacobian(self, q: Column, frame: str = "") -> ca.SX:
        """J(q), (6, n): J qd is the velocity of a frame's origin above its angular velocity, in the base's axes.

        Raises
        ------
        LookupError
            If there is no frame of that name; the message names the nearest.
        """
        place = frame_named(frame, self.links, self.frames)
        held, origin = poses.from_base(self.links, q), self.pose(q, frame).position
        J, i = ca.SX(6, self.dof), place.link
        while i >= 0:
            axis = held[i].rotation @ sparse(self.links[i].axis)
            slides = self.links[i].joint == "prismatic"
            arm = origin - held[i].position
            J[:3, i] = axis if slides else ca.cross(axis, arm)
            J[3:, i] = ca.SX(3, 1) if slides else axis
            i = self.links[i].parent
        return ca.densify(J)
