"""Spatial arms: rigid bodies on hinges and slides, each carried by one before it, on a base that stands still."""

import math

import casadi as ca

from workbench.arms.dynamics import AbstractArm
from workbench.arms.mechanics import energies, recursions
from workbench.arms.mechanics.recursions import Body
from workbench.arms.mechanics.spatial_vectors import (
    refuse_impossible,
    refuse_skewed,
    sparse,
    spatial_inertia,
    tensor,
    transform,
)
from workbench.core import block, option, parameter
from workbench.core.block import Column, Matrix, Number, Scalar, Vector
from workbench.core.shapes import Circle, Line, Shape, project
from workbench.core.validation.refusals import Array, describe, known_name, matrix, name, vector

UNIT = 1e-12  # what rounding leaves of a unit axis


@block
class SpatialLink:
    """A rigid body and the joint `name` that carries it; `parent` is the number of the link before, -1 the base.

    The joint's frame lies at `position` with the axes `rotation` in the frame of the body that carries it; the body's
    own frame is the joint's, turned by q about `axis` or shifted by q along it. Both are shape, not numbers to vary.
    `inertia` holds the moments xx, xy, xz, yy, yz, zz about `com`, round the axes of the body's frame. The mass may be
    0 of a link that carries others, if M stays positive definite.

    F = viscous qd + coulomb sign(qd); where a `speed` is given the jump is spread over it, coulomb tanh(qd / speed).
    The drive adds gear^2 rotor to the joint's inertia; its gyroscopic torque is left out. Where a number is None, the
    equations have no such term.

    References
    ----------
    Siciliano, Sciavicco, Villani and Oriolo (2009), Robotics: Modelling, Planning and Control, section 7.1.
    """

    name: str
    mass: Scalar = parameter(unit="kg", low=0, symbol="m")
    com: Vector = parameter(unit="m", shape=("3",), symbol="c")
    inertia: Vector = parameter(unit="kg m^2", shape=("6",), symbol="I")
    position: Vector = parameter(default=(0.0, 0.0, 0.0), unit="m", shape=("3",), symbol="r")
    axis: Vector = (0.0, 0.0, 1.0)
    rotation: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
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

    def __post_init__(self) -> None:
        me = f"SpatialLink({describe(name('SpatialLink(name=...)', self.name))}"
        object.__setattr__(self, "axis", _freeze(vector(f"{me}, axis=...)", self.axis, 3, "coordinates")))
        object.__setattr__(self, "rotation", _freeze(matrix(f"{me}, rotation=...)", self.rotation, 3, 3)))
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
        return self.joint == "prismatic"

    @property
    def length(self) -> str:
        """The unit of its position."""
        return "m" if self.slides else "rad"

    @property
    def force(self) -> str:
        """The unit of the force that drives it."""
        return "N" if self.slides else "N m"

    @property
    def rotor_unit(self) -> str:
        """The unit of its drive's inertia, seen from the joint."""
        return "kg" if self.slides else "kg m^2"

    def body(self, q: Number) -> Body:
        """The link as a body of the recursions, at the position q of its joint."""
        pose = energies.across_joint(self, q)
        S = ca.vertcat(ca.SX(3, 1), sparse(self.axis)) if self.slides else ca.vertcat(sparse(self.axis), ca.SX(3, 1))
        inertia = spatial_inertia(self.mass, self.com, self.inertia)
        return Body(self.parent, transform(*pose), S, inertia)

    def drive_inertia(self) -> Scalar:
        """The inertia that the rotor adds to the diagonal of M, reflected to the joint: gear^2 rotor."""
        if self.rotor is None:
            return 0.0
        return self.rotor if self.gear is None else self.gear**2 * self.rotor

    def friction(self, qd: Number) -> ca.SX:
        """F(qd) of its joint."""
        viscous = ca.SX(1, 1) if self.viscous is None else self.viscous * qd
        if self.coulomb is None:
            return viscous
        friction: ca.SX = viscous + self.coulomb * self.direction(qd)
        return friction

    def direction(self, qd: Number) -> ca.SX:
        """The sign of qd, spread over the `speed` where there is one."""
        return ca.sign(qd) if self.speed is None else ca.tanh(qd / self.speed)


def _freeze(value: Array) -> Array:
    value.flags.writeable = False
    return value


@block
class SpatialArm(AbstractArm):
    """A tree of rigid bodies on hinges and slides, the carrying before the carried; gravity pulls along -z of the base.

    Joints whose names are `passive` have no motor. C is the matrix of the Christoffel symbols; `torque` and
    `acceleration` come from recursions and never form it. When an arm is made, the recursion of Newton and Euler is
    held against Lagrange's equation of its energies, and M against both.

    Raises
    ------
    ValueError
        If a name comes twice, a link is carried by none before it, the two roads disagree, M is not positive definite,
        or no joint has a motor.
    LookupError
        If a passive joint is none of the arm's.

    References
    ----------
    Featherstone (2008), Rigid Body Dynamics Algorithms, section 5.3 (the torque) and section 6.2 (M).
    Echeandia and Wensing (2021), Numerical methods to compute the Coriolis matrix and Christoffel symbols for
    rigid-body systems, J. Comput. Nonlinear Dynamics 16(9), algorithm 1 (C).
    """

    links: tuple[SpatialLink, ...]
    gravity: Scalar = parameter(default=9.81, unit="m/s^2", low=0, symbol="g")
    passive: tuple[str, ...] = ()

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
        for joint in self.passive:
            known_name(joint, names, "joints of this arm")
        if not self.motors:
            raise ValueError("`SpatialArm(passive=...)` must leave a joint with a motor; got all joints.")
        energies.check(self)

    @property
    def dof(self) -> int:
        return len(self.links)

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(link.length for link in self.links)

    @property
    def motors(self) -> tuple[int, ...]:
        return tuple(i for i, link in enumerate(self.links) if link.name not in self.passive)

    def bodies(self, q: Column) -> list[Body]:
        return [link.body(q[i]) for i, link in enumerate(self.links)]

    def drawing(self, q: Column) -> tuple[Shape, ...]:
        """The joints and the lines between them, seen by `projected`; the last line leads to the centre of mass."""
        poses = energies.from_base(self.links, q)
        size = sum((ca.norm_2(ca.SX(each)) for link in self.links for each in (link.position, link.com)), ca.SX(0))
        base = ca.SX.zeros(3)
        floor = Line([(-0.12 * size, 0.0), (0.12 * size, 0.0)], "ground", 0.01 * size)
        rods, hinges, tips = [], [], []
        carrying = {link.parent for link in self.links}
        for i, (link, pose) in enumerate(zip(self.links, poses, strict=True)):
            before = poses[link.parent].position if link.parent >= 0 else base
            rods.append(Line([project(before), project(pose.position)], "link", 0.03 * size))
            hinges.append(Circle(project(pose.position), 0.02 * size))
            if i not in carrying:
                end = project(pose.position + pose.rotation @ sparse(link.com))
                rods.append(Line([project(pose.position), end], "link", 0.02 * size))
                tips.append(Circle(end, 0.014 * size, "path"))
        return floor, *rods, *hinges, *tips

    def mass_matrix(self, q: Column) -> ca.SX:
        return recursions.mass_matrix(self.bodies(q)) + ca.diag(self.drive_inertias())

    def coriolis_matrix(self, q: Column, qd: Column) -> ca.SX:
        return recursions.coriolis_matrix(self.bodies(q), qd)

    def coriolis_force(self, q: Column, qd: Column) -> ca.SX:
        """C(q, qd) qd, (n, 1), without C."""
        return recursions.torque(self.bodies(q), ca.SX(1, 1), qd, ca.SX(self.dof, 1))

    def gravity_vector(self, q: Column) -> ca.SX:
        rest = ca.SX(self.dof, 1)
        return recursions.torque(self.bodies(q), ca.SX(self.gravity), rest, rest)

    def friction(self, qd: Column) -> ca.SX:
        """F(qd), (n, 1), with no entry for a joint without friction."""
        return ca.vertcat(*[link.friction(qd[i]) for i, link in enumerate(self.links)])

    def drive_inertias(self) -> ca.SX:
        """gear^2 rotor of each joint, (n, 1)."""
        return ca.vertcat(*[sparse(link.drive_inertia()) for link in self.links])

    def recursion(self, q: Column, qd: Column, qdd: Column) -> ca.SX:
        tau = recursions.torque(self.bodies(q), ca.SX(self.gravity), qd, qdd)
        return ca.densify(tau + self.drive_inertias() * qdd + self.friction(qd))

    def kinetic_energy(self, q: Column, qd: Column) -> ca.SX:
        """T(q, qd) in J, of links and rotors."""
        rotors = ca.dot(self.drive_inertias(), qd**2) / 2
        return ca.densify(recursions.kinetic_energy(self.bodies(q), qd) + rotors)

    def potential_energy(self, q: Column) -> ca.SX:
        """U(q) in J, zero with all masses at the height of the base."""
        return energies.potential_energy(self.links, self.gravity, q)
