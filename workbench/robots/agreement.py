"""Roads to the torque of an arm, at a few states: the recursion of Newton and Euler, Lagrange's equation, and M."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import casadi as ca
import numpy as np

from workbench.robots import composite, lagrange, newton_euler, poses
from workbench.robots.newton_euler import Body
from workbench.validation.refusals import Array

STATES, SEED = 3, 2021
AGREED = 1e-10  # of the largest torque; the roads differ by some hundred roundings, a wrong term by far more
TINY = np.finfo(float).tiny
REGULAR = 1e-13  # the smallest eigenvalue of M scaled to a unit diagonal: below it, M cannot be solved with in doubles


class Arm(Protocol):
    """What is compared."""

    @property
    def links(self) -> tuple[Any, ...]: ...  # noqa: D102
    @property
    def gravity(self) -> Any: ...  # noqa: D102
    @property
    def dof(self) -> int: ...  # noqa: D102
    def bodies(self, q: ca.SX) -> Sequence[Body]: ...  # noqa: D102
    def drive_inertias(self) -> ca.SX: ...  # noqa: D102


def roads(arm: Arm) -> ca.Function:
    """(q, qd, qdd) -> the torque of links by the recursion and by the energies, and M of the links."""
    q, qd, qdd = (ca.SX.sym(letter, arm.dof) for letter in ("q", "qd", "qdd"))
    bodies = arm.bodies(q)
    recursion = newton_euler.torque(bodies, ca.SX(arm.gravity), qd, qdd)
    kinetic, potential = poses.kinetic_energy(arm.links, q, qd), poses.potential_energy(arm.links, arm.gravity, q)
    energies = lagrange.torque(kinetic, potential, q, qd, qdd)
    return ca.Function("roads", [q, qd, qdd], [recursion, energies, composite.mass_matrix(bodies)])


def difference(held: ca.Function, states: Array) -> Array:
    """How far apart the roads are at states (N, 3, n) of q, qd and qdd, over the largest torque there, (N,).

    The energies know positions alone, and the recursion knows no energy. M of composite bodies is a third road to
    the part of qdd.
    """
    gaps = []
    for q, qd, qdd in states:
        recursion, energies, M = map(np.array, held(q, qd, qdd))
        steady = np.array(held(q, qd, np.zeros_like(qdd))[0])
        with np.errstate(over="ignore", invalid="ignore"):  # numbers that overflow leave a difference of nan
            gap = np.hstack([recursion - energies, recursion - steady - M @ qdd[:, np.newaxis]])
            gaps.append(np.abs(gap).max() / max(np.abs(recursion).max(), np.abs(steady).max(), TINY))
    return np.array(gaps)


def check(arm: Arm) -> None:
    """Refuse an arm for which the roads differ, or whose M cannot be inverted.

    Raises
    ------
    ValueError
        With the difference, or with the joint that moves least.
    """
    states = np.random.default_rng(SEED).uniform(-1.0, 1.0, (STATES, 3, arm.dof))
    held = roads(arm)
    worst = float(np.max(difference(held, states)))
    if not worst <= AGREED:
        raise ValueError(
            f"`SpatialArm(...)`: Newton and Euler's recursion and Lagrange's equation must give one torque; they "
            f"differ by {worst:.2g} of it, above {AGREED:g}: its numbers are too far apart in size."
        )
    rotors = np.array(ca.evalf(ca.densify(arm.drive_inertias()))).ravel()
    for state in states:
        M = np.array(held(*state)[2]) + np.diag(rotors)
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
