"""What a rigid body may weigh, as one matrix; and several bodies as one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from workbench.robots.motion import skew, sparse
from workbench.validation.refusals import Array

ROUNDED = 1e-6  # of the sum of the other two: how far printed digits may take a flat body beyond the triangle
ORDER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # of the six moments: xx, xy, xz, yy, yz, zz


class Lump(NamedTuple):
    """A rigid body by its numbers: mass in kg, centre of mass (3,) in m, moments (3, 3) about it in kg m^2."""

    mass: float
    com: Array
    inertia: Array


def tensor(moments: Any) -> Any:
    """The symmetric matrix (3, 3) of six moments in the order xx, xy, xz, yy, yz, zz: of numbers or of symbols."""
    xx, xy, xz, yy, yz, zz = (moments[i] for i in range(6))
    rows = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return ca.blockcat(rows) if isinstance(moments, ca.SX) else np.array(rows)


def moments(matrix: Array) -> Array:
    """The six moments (6,) of a symmetric matrix (3, 3)."""
    return np.array([matrix[place] for place in ORDER])


def about_origin(mass: Any, com: Any, moments: Any) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Mass, first moment m c (3, 1) and moments (3, 3) about the link's origin: the numbers tau is linear in."""
    c = sparse(com)
    lever = skew(c)
    return ca.SX(mass), mass * c, sparse(tensor(moments)) - mass * (lever @ lever)


def spatial(mass: ca.SX, first: ca.SX, second: ca.SX) -> ca.SX:
    """The spatial inertia (6, 6) from mass, first moment and moments about the link's origin."""
    return ca.blockcat([[second, skew(first)], [-skew(first), mass * ca.SX.eye(3)]])


def merged(lumps: Sequence[Lump]) -> Lump:
    """Bodies fixed to each other, all seen from one frame, as one body."""
    mass = float(sum(lump.mass for lump in lumps))
    if mass == 0:
        return Lump(0.0, np.zeros(3), np.zeros((3, 3)))
    com = sum((lump.mass * lump.com for lump in lumps), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for lump in lumps:
        d = lump.com - com
        inertia = inertia + lump.inertia + lump.mass * (d @ d * np.eye(3) - np.outer(d, d))
    return Lump(mass, com, inertia)


def refuse_impossible(of: str, mass: float, inertia: Array) -> None:
    """Refuse moments (3, 3) about the centre of mass that no body of that mass has.

    A mass has moments that are integrals of squares, so none is negative and none is above the sum of the other
    two; a point mass (all zero) and a thin rod (one zero) are limits that are let pass.

    Raises
    ------
    ValueError
        If the mass is negative, or the matrix has a negative eigenvalue, violates the triangle inequality, or belongs
        to no mass.
    """
    if not 0 <= mass < np.inf:
        raise ValueError(f"The mass of {of} must be finite and not negative; got {mass:g} kg.")
    if not np.isfinite(inertia).all():
        raise ValueError(f"The inertia of {of} must be finite; got {inertia.tolist()} kg m^2.")
    if mass == 0 and inertia.any():
        raise ValueError(f"The inertia of {of} belongs to no mass: its mass is 0; give it one, or no inertia.")
    low, middle, high = np.linalg.eigvalsh(inertia)
    if low < -ROUNDED * high or high < 0:
        raise ValueError(
            f"The inertia of {of} must be positive definite, as a moment is a sum of masses times squares; "
            f"its principal moments are {low:.6g}, {middle:.6g} and {high:.6g} kg m^2."
        )
    if high > (low + middle) * (1 + ROUNDED):
        raise ValueError(
            f"The inertia of {of} belongs to no body: the largest principal moment, {high:.6g} kg m^2, is above the "
            f"sum of the other two, {low:.6g} + {middle:.6g}; check the six moments and the frame they are given in."
        )
