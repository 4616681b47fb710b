"""Poses and energies of a tree of bodies: a second derivation of the torque, against which recursions are checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import casadi as ca
import numpy as np

from workbench.arms.mechanics import lagrange, recursions
from workbench.arms.mechanics.recursions import Body
from workbench.arms.mechanics.spatial_vectors import sparse, tensor, turn
from workbench.core.block import Matrix, Scalar, Vector
from workbench.core.validation.refusals import Array

STATES, SEED = 3, 2021
AGREEMENT = 1e-10  # of the largest torque; the roads differ by some hundred roundings, a wrong term by far more
TINY = np.finfo(float).tiny
REGULAR = 1e-13  # the smallest eigenvalue of M scaled to a unit diagonal: below it, M cannot be solved with in doubles


class Pose(NamedTuple):
    """A frame seen from another one: its axes as the columns of a rotation (3, 3), its origin (3, 1) in m."""

    rotation: ca.SX
    position: ca.SX


class TreeLink(Protocol):
    """A rigid body of a tree: its numbers, its joint, and the place of that on the body that carries it."""

    @property
    def name(self) -> str: ...
    @property
    def joint(self) -> str: ...
    @property
    def parent(self) -> int: ...
    @property
    def axis(self) -> Vector: ...
    @property
    def rotation(self) -> Matrix: ...
    @property
    def position(self) -> Vector: ...
    @property
    def mass(self) -> Scalar: ...
    @property
    def com(self) -> Vector: ...
    @property
    def inertia(self) -> Vector: ...


class Tree(Protocol):
    """An arm of such bodies."""

    @property
    def dof(self) -> int: ...
    @property
    def gravity(self) -> Scalar: ...
    @property
    def links(self) -> Sequence[TreeLink]: ...
    def bodies(self, q: ca.SX) -> list[Body]: ...
    def drive_inertias(self) -> ca.SX: ...


def across_joint(link: TreeLink, q: ca.SX) -> Pose:
    """A body's frame seen from the body that carries it, at the position q of its joint."""
    rotation, position = sparse(link.rotation), sparse(link.position)
    if link.joint == "prismatic":
        return Pose(rotation, position + rotation @ (sparse(link.axis) * q))
    return Pose(rotation @ turn(link.axis, q), position)


def from_base(links: Sequence[TreeLink], q: ca.SX) -> list[Pose]:
    """Each body's frame seen from the base."""
    poses: list[Pose] = []
    for i, link in enumerate(links):
        rotation, position = across_joint(link, q[i])
        if link.parent >= 0:
            base = poses[link.parent]
            rotation, position = base.rotation @ rotation, base.position + base.rotation @ position
        poses.append(Pose(rotation, position))
    return poses


def potential_energy(links: Sequence[TreeLink], gravity: Scalar, q: ca.SX) -> ca.SX:
    """U(q) = sum of m g z, in J, zero with all masses at the height of the base."""
    energy = ca.SX(1, 1)
    for link, pose in zip(links, from_base(links, q), strict=True):
        energy += link.mass * gravity * (pose.position[2] + pose.rotation[2, :] @ sparse(link.com))
    return ca.densify(energy)


def kinetic_energy(links: Sequence[TreeLink], q: ca.SX, qd: ca.SX) -> ca.SX:
    """T(q, qd) in J, from the poses alone: velocities are their derivatives along qd; q and qd are symbols."""
    poses = from_base(links, q)
    coms = [p.position + p.rotation @ sparse(link.com) for link, p in zip(links, poses, strict=True)]
    rates = ca.jtimes(ca.densify(ca.horzcat(*coms, *(p.rotation for p in poses))), q, qd)
    energy = ca.SX(1, 1)
    for i, (link, pose) in enumerate(zip(links, poses, strict=True)):
        turning = len(links) + 3 * i
        spin = pose.rotation.T @ rates[:, turning : turning + 3]
        omega = ca.vertcat(spin[2, 1], spin[0, 2], spin[1, 0])
        energy += link.mass * ca.sumsqr(rates[:, i]) / 2 + omega.T @ sparse(tensor(link.inertia)) @ omega / 2
    return ca.densify(energy)


def torque_functions(arm: Tree) -> ca.Function:
    """(q, qd, qdd) -> the torque of links by the recursion and by the energies, and M of the links."""
    q, qd, qdd = (ca.SX.sym(letter, arm.dof) for letter in ("q", "qd", "qdd"))
    bodies = arm.bodies(q)
    recursion = recursions.torque(bodies, ca.SX(arm.gravity), qd, qdd)
    kinetic, potential = kinetic_energy(arm.links, q, qd), potential_energy(arm.links, arm.gravity, q)
    energies = lagrange.torque(kinetic, potential, q, qd, qdd)
    return ca.Function("roads", [q, qd, qdd], [recursion, energies, recursions.mass_matrix(bodies)])


def difference(torques: ca.Function, states: Array) -> Array:
    """The difference at N states of the torques by recursion, by energies and by M, over the largest torque, (N,)."""
    gaps = []
    for q, qd, qdd in states:
        recursion, energies, M = map(np.array, torques(q, qd, qdd))
        steady = np.array(torques(q, qd, np.zeros_like(qdd))[0])
        with np.errstate(over="ignore", invalid="ignore"):  # numbers that overflow leave a difference of nan
            gap = np.hstack([recursion - energies, recursion - steady - M @ qdd[:, np.newaxis]])
            gaps.append(np.abs(gap).max() / max(np.abs(recursion).max(), np.abs(steady).max(), TINY))
    return np.array(gaps)


def check(arm: Tree) -> None:
    """Refuse an arm whose recursion and energies give different torques, or whose M cannot be inverted."""
    states = np.random.default_rng(SEED).uniform(-1.0, 1.0, (STATES, 3, arm.dof))
    torques = torque_functions(arm)
    worst = float(np.max(difference(torques, states)))
    if not worst <= AGREEMENT:
        raise ValueError(
            f"`SpatialArm(...)`: Newton and Euler's recursion and Lagrange's equation must give one torque; they "
            f"differ by {worst:.2g} of it, above {AGREEMENT:g}: its numbers are too far apart in size."
        )
    rotors = np.array(ca.evalf(ca.densify(arm.drive_inertias()))).ravel()
    for state in states:
        M = np.array(torques(*state)[2]) + np.diag(rotors)
        diagonal = np.diag(M)
        if diagonal.min() > 0:
            size = np.sqrt(diagonal)
            if np.linalg.eigvalsh(M / size / size[:, np.newaxis]).min() > REGULAR:
                continue
        raise ValueError(
            "`SpatialArm(...)`: M must be positive definite, as a motion of mass has energy; there is a motion that "
            f"moves none, and joint '{arm.links[int(np.argmin(diagonal))].name}' moves least: give its link a moment "
            "of inertia or a centre of mass off the axis."
        )
