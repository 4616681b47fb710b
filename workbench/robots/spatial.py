"""A spatial arm: bodies on hinges and slides, each carried by one before it, on a base that stands still."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.core import AbstractArm, block, parameter
from workbench.core.block import Column, Scalar
from workbench.robots import agreement, composite, newton_euler, poses
from workbench.robots.frames import Frame, frame_named
from workbench.robots.limits import Limits
from workbench.robots.link import SpatialLink
from workbench.robots.motion import sparse
from workbench.robots.newton_euler import Body
from workbench.validation.refusals import Array, known


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
    passive
        The names of the joints without a motor.

    Raises
    ------
    ValueError
        If a name comes twice, a link is carried by none before it, a frame lies on no link, the two roads disagree,
        or M is not positive definite; or no joint has a motor.
    LookupError
        If a passive joint is none of the arm's; the message names the nearest.
    """

    links: tuple[SpatialLink, ...]
    gravity: Scalar = parameter(default=9.81, unit="m/s^2", low=0, symbol="g")
    frames: tuple[Frame, ...] = ()
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
        for frame in self.frames:
            if not -1 <= frame.link < len(self.links):
                raise ValueError(
                    "`SpatialArm(frames=...)` lie on links by number, -1 for the base; "
                    f"'{frame.name}' is on {frame.link} of {len(self.links)}."
                )
        for joint in self.passive:
            known(joint, names, "joints of this arm")
        if not self.motors:
            raise ValueError("`SpatialArm(passive=...)` must leave a joint with a motor; got all joints.")
        agreement.check(self)

    @property
    def dof(self) -> int:
        """The number of joints."""
        return len(self.links)

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each joint's position: rad where it turns, m where it slides."""
        return tuple(link.length for link in self.links)

    @property
    def motors(self) -> tuple[int, ...]:
        """The joints that have a motor, by number: all but the passive ones."""
        return tuple(i for i, link in enumerate(self.links) if link.name not in self.passive)

    @property
    def limits(self) -> Limits:
        """The limits of the joints: those of effort for the actuator, the others to be checked."""
        return Limits.of([link.limits for link in self.links])

    def motor_limits(self) -> Array:
        """The most that each motor can give either way, (motors,) in N m or N: `DirectDrive(limit=...)` takes it.

        Raises
        ------
        ValueError
            If a joint with a motor has no limit of effort, or that of nothing at all.
        """
        for i in self.motors:
            if not self.links[i].limits.effort:
                raise ValueError(
                    "`motor_limits()` must find an effort above zero for each joint with a motor; that of "
                    f"'{self.links[i].name}' is {self.links[i].limits.effort}: write the limits yourself."
                )
        return np.array([self.links[i].limits.effort for i in self.motors])

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
            slides = self.links[i].slides
            arm = origin - held[i].position
            J[:3, i] = axis if slides else ca.cross(axis, arm)
            J[3:, i] = ca.SX(3, 1) if slides else axis
            i = self.links[i].parent
        return ca.densify(J)
