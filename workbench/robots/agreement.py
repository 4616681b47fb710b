"""Two roads to the torque of an arm, Newton and Euler's recursion and Lagrange's equation, at a few states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import casadi as ca
import numpy as np

from workbench.core.layout import Array
from workbench.robots import composite, lagrange, newton_euler, poses
from workbench.robots.newton_euler import Body

STATES, SEED = 3, 2021
AGREED = 1e-10  # of the largest torque; the roads differ by some hundred roundings, a wrong term by far more
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


def difference(arm: Arm, states: Array) -> Array:
    """The difference of the two roads at states (N, 3, n) of q, qd and qdd, over the largest torque there, (N,).

    The energies know positions alone; the recursion knows no energy.
    """
    q, qd, qdd = (ca.SX.sym(letter, arm.dof) for letter in ("q", "qd", "qdd"))
    recursion = newton_euler.torque(arm.bodies(q), ca.SX(arm.gravity), qd, qdd)
    energy = poses.kinetic_energy(arm.links, q, qd)
    torque = lagrange.torque(energy, poses.potential_energy(arm.links, arm.gravity, q), q, qd, qdd)
    both = ca.Function("both", [q, qd, qdd], [recursion, torque])
    found = [np.hstack([np.array(road) for road in both(*state)]) for state in states]
    return np.array([np.abs(f[:, 0] - f[:, 1]).max() / max(np.abs(f).max(), np.finfo(float).tiny) for f in found])


def check(arm: Arm) -> None:
    """Refuse an arm for which the two roads differ, or whose M cannot be inverted.

    Raises
    ------
    ValueError
        With the difference, or with the joint that moves no mass.
    """
    states = np.random.default_rng(SEED).uniform(-1.0, 1.0, (STATES, 3, arm.dof))
    worst = float(np.max(difference(arm, states)))
    if not worst <= AGREED:
        raise ValueError(
            f"`SpatialArm(...)`: Newton and Euler's recursion and Lagrange's equation must give one torque; they "
            f"differ by {worst:.2g} of it, above {AGREED:g}: its numbers are too far apart in size."
        )
    q = ca.SX.sym("q", arm.dof)
    M = ca.Function("M", [q], [composite.mass_matrix(arm.bodies(q)) + ca.diag(arm.drive_inertias())])
    for state in states:
        found = np.array(M(state[0]))
        diagonal = np.diag(found)
        if diagonal.min() > 0:
            size = np.sqrt(diagonal)
            if np.linalg.eigvalsh(found / size / size[:, np.newaxis]).min() > REGULAR:
                continue
        name = arm.links[int(np.argmin(diagonal))].name
        raise ValueError(
            "`SpatialArm(...)`: M must be positive definite, as a motion of mass has energy; there is a motion that "
            f"moves none, and joint '{name}' moves least: give its link a moment of inertia or a centre of mass off "
            "the axis."
        )
