"""Where the bodies of a tree are, seen from the base: by turns and shifts, without spatial vectors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import casadi as ca

from workbench.robots import motion
from workbench.robots.inertia import tensor
from workbench.validation.refusals import Array


class Jointed(Protocol):
    """What a body tells of the joint that carries it, and of its mass."""

    @property
    def parent(self) -> int: ...  # noqa: D102
    @property
    def joint(self) -> str: ...  # noqa: D102
    @property
    def axis(self) -> Array: ...  # noqa: D102
    @property
    def rotation(self) -> Array: ...  # noqa: D102
    @property
    def position(self) -> Any: ...  # noqa: D102
    @property
    def mass(self) -> Any: ...  # noqa: D102
    @property
    def com(self) -> Any: ...  # noqa: D102
    @property
    def inertia(self) -> Any: ...  # noqa: D102


class Pose(NamedTuple):
    """A frame seen from another one: its axes as the columns of a rotation (3, 3), its origin (3, 1) in m."""

    rotation: ca.SX
    position: ca.SX

    def then(self, other: Pose) -> Pose:
        """The pose of a frame that lies at `other` within this one."""
        return Pose(self.rotation @ other.rotation, self.position + self.rotation @ other.position)


def across_joint(link: Jointed, q: ca.SX) -> Pose:
    """A body's frame seen from the body that carries it, at the position q of its joint."""
    rotation, position = motion.sparse(link.rotation), motion.sparse(link.position)
    if link.joint == "prismatic":
        return Pose(rotation, position + rotation @ (motion.sparse(link.axis) * q))
    return Pose(rotation @ motion.turn(link.axis, q), position)


def from_base(links: Sequence[Jointed], q: ca.SX) -> list[Pose]:
    """Each body's frame seen from the base."""
    poses: list[Pose] = []
    for i, link in enumerate(links):
        step = across_joint(link, q[i])
        poses.append(step if link.parent < 0 else poses[link.parent].then(step))
    return poses


def potential_energy(links: Sequence[Jointed], gravity: Any, q: ca.SX) -> ca.SX:
    """U(q) = sum of m g z, in J, zero with all masses at the height of the base."""
    energy = ca.SX(1, 1)
    for link, pose in zip(links, from_base(links, q), strict=True):
        energy += link.mass * gravity * (pose.position[2] + pose.rotation[2, :] @ motion.sparse(link.com))
    return ca.densify(energy)


def kinetic_energy(links: Sequence[Jointed], q: ca.SX, qd: ca.SX) -> ca.SX:
    """T(q, qd) in J, from nothing but the poses: velocities are their derivatives along qd; q and qd are symbols."""
    poses = from_base(links, q)
    coms = [p.position + p.rotation @ motion.sparse(link.com) for link, p in zip(links, poses, strict=True)]
    rates = ca.jtimes(ca.densify(ca.horzcat(*coms, *(p.rotation for p in poses))), q, qd)
    energy = ca.SX(1, 1)
    for i, (link, pose) in enumerate(zip(links, poses, strict=True)):
        turning = len(links) + 3 * i
        spin = pose.rotation.T @ rates[:, turning : turning + 3]
        omega = ca.vertcat(spin[2, 1], spin[0, 2], spin[1, 0])
        energy += link.mass * ca.sumsqr(rates[:, i]) / 2 + omega.T @ motion.sparse(tensor(link.inertia)) @ omega / 2
    return ca.densify(energy)
