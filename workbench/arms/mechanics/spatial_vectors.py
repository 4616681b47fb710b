"""Turns, shifts and masses as matrices on spatial vectors: motions (angular, linear), forces (moment, force), in R^6.

References
----------
Featherstone (2008), Rigid Body Dynamics Algorithms, chapter 2.
"""

from collections.abc import Sequence
from typing import NamedTuple, overload

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array, matrix

ORTHONORMAL = 1e-12  # what rounding leaves of a rotation
ROUNDING_MARGIN = 1e-6  # of the sum of the other two: how far printed digits may take a flat body beyond the triangle


def _made_of(blocks: Sequence[Array]) -> ca.SX:
    """The map from a vector to a matrix that is linear in it, column by column; blocks[i] is that of unit vector i."""
    return ca.SX(ca.sparsify(ca.DM(np.array([block.ravel(order="F") for block in blocks]).T)))


# One product with a constant makes such a matrix, instead of a call of CasADi for each of its entries.
_SKEW = [np.cross(axis, np.eye(3)).T for axis in np.eye(3)]
_NONE = np.zeros((3, 3))
_OF_SKEW = _made_of(_SKEW)
_OF_CROSS = _made_of(
    [np.block([[S, _NONE], [_NONE, S]]) for S in _SKEW] + [np.block([[_NONE, _NONE], [S, _NONE]]) for S in _SKEW]
)
_OF_SWAPPED = _made_of(
    [np.block([[-S, _NONE], [_NONE, _NONE]]) for S in _SKEW] + [np.block([[_NONE, -S], [-S, _NONE]]) for S in _SKEW]
)


def skew(v: ca.SX) -> ca.SX:
    """The matrix (3, 3) of the cross product v x, with the structural zeros of v."""
    return ca.reshape(_OF_SKEW @ v, 3, 3)


def turn(axis: Array, angle: ca.SX) -> ca.SX:
    """The rotation (3, 3) by an angle about a unit axis, by Rodrigues: exact zeros and ones of the axis stay such."""
    along = np.outer(axis, axis)
    across = ca.sparsify(ca.DM(np.eye(3) - along))
    return ca.sparsify(ca.DM(along)) + across * ca.cos(angle) + skew(sparse(axis)) * ca.sin(angle)


def sparse(number: Array | ca.SX) -> ca.SX:
    """An array of numbers or symbols with its exact zeros as structural ones, which cost no operation."""
    return number if isinstance(number, ca.SX) else ca.SX(ca.sparsify(ca.DM(np.asarray(number, dtype=float))))


def transform(rotation: ca.SX, position: ca.SX) -> ca.SX:
    """The matrix (6, 6) that takes motions from a frame to one that lies in it, turned and shifted."""
    return ca.blockcat([[rotation.T, ca.SX(3, 3)], [-(rotation.T @ skew(position)), rotation.T]])


def cross(v: ca.SX) -> ca.SX:
    """The matrix (6, 6) of v x on motions; minus its transpose acts on forces."""
    return ca.reshape(_OF_CROSS @ v, 6, 6)


def swapped_cross(f: ca.SX) -> ca.SX:
    """The matrix (6, 6) that maps a motion v to v x* f, the cross product of v with a force f."""
    return ca.reshape(_OF_SWAPPED @ f, 6, 6)


def from_angles(roll: float, pitch: float, yaw: float) -> Array:
    """The rotation (3, 3) of angles about the fixed axes x, then y, then z, as URDF counts them."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def refuse_skewed(call: str, R: Array) -> None:
    """Refuse a matrix that is no rotation (3, 3); `call` names it."""
    matrix(call, R, 3, 3)
    gap = float(np.abs(R @ R.T - np.eye(3)).max())
    handed = float(np.cross(R[:, 0], R[:, 1]) @ R[:, 2])
    if not (gap <= ORTHONORMAL and handed > 0):
        raise ValueError(
            f"`{call}` must be orthonormal and right-handed, as its columns are the axes of a frame; R R' is {gap:.2g} "
            f"off the identity, det R {handed:.2g}."
        )


@overload
def tensor(moments: Array | Sequence[float]) -> Array: ...
@overload
def tensor(moments: ca.SX) -> ca.SX: ...
def tensor(moments: ca.SX | Array | Sequence[float]) -> ca.SX | Array:
    """The symmetric matrix (3, 3) of six moments in the order xx, xy, xz, yy, yz, zz: of numbers or of symbols."""
    xx, xy, xz, yy, yz, zz = (moments[i] for i in range(6))
    rows = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return ca.blockcat(rows) if isinstance(moments, ca.SX) else np.array(rows)


def moments(matrix: Array) -> Array:
    """The six moments (6,) of a symmetric matrix (3, 3)."""
    return np.asarray(matrix[np.triu_indices(3)])


def spatial_inertia(mass: ca.SX | float, com: Array | ca.SX, moments: Array | ca.SX) -> ca.SX:
    """The spatial inertia (6, 6) about the frame's origin, from mass, centre of mass and moments about that."""
    c = sparse(com)
    lever = skew(c)
    return inertia_about_origin(mass, mass * c, sparse(tensor(moments)) - mass * (lever @ lever))


def inertia_about_origin(mass: ca.SX | float, first: ca.SX, second: ca.SX) -> ca.SX:
    """The spatial inertia (6, 6) from mass, first moments m c (3, 1) and moments of inertia (3, 3) about the origin."""
    return ca.blockcat([[second, skew(first)], [-skew(first), ca.SX(mass) * ca.SX.eye(3)]])


class Lump(NamedTuple):
    """A rigid body by its numbers: mass in kg, centre of mass (3,) in m, moments (3, 3) about it in kg m^2."""

    mass: float
    com: Array
    inertia: Array


def merge_lumps(lumps: Sequence[Lump]) -> Lump:
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

    None is negative and none is above the sum of the other two; a point mass (all zero) and a thin rod (one zero) pass.
    """
    if not 0 <= mass < np.inf:
        raise ValueError(f"The mass of {of} must be finite and not negative; got {mass:g} kg.")
    if not np.isfinite(inertia).all():
        raise ValueError(f"The inertia of {of} must be finite; got {inertia.tolist()} kg m^2.")
    if mass == 0 and inertia.any():
        raise ValueError(f"The inertia of {of} belongs to no mass: its mass is 0; give it one, or no inertia.")
    low, middle, high = np.linalg.eigvalsh(inertia)
    if low < -ROUNDING_MARGIN * high or high < 0:
        raise ValueError(
            f"The inertia of {of} must be positive definite, as a moment is a sum of masses times squares; "
            f"its principal moments are {low:.6g}, {middle:.6g} and {high:.6g} kg m^2."
        )
    if high > (low + middle) * (1 + ROUNDING_MARGIN):
        raise ValueError(
            f"The inertia of {of} belongs to no body: the largest principal moment, {high:.6g} kg m^2, is above the "
            f"sum of the other two, {low:.6g} + {middle:.6g}; check the six moments and the frame they are given in."
        )
