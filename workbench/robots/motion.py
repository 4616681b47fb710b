"""Spatial vectors: a motion is (angular, linear) in R^6, a force (moment, force), both seen from a link's frame.

References
----------
Featherstone (2008), Rigid Body Dynamics Algorithms, chapter 2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from workbench.validation.refusals import Array


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
    """The matrix (3, 3) of v x; where v has no entry at all, neither has the matrix."""
    return ca.reshape(_OF_SKEW @ v, 3, 3)


def turn(axis: Array, angle: ca.SX) -> ca.SX:
    """The rotation (3, 3) by an angle about a unit axis, by Rodrigues: exact zeros and ones of the axis stay such."""
    along = np.outer(axis, axis)
    across = ca.sparsify(ca.DM(np.eye(3) - along))
    return ca.sparsify(ca.DM(along)) + across * ca.cos(angle) + skew(sparse(axis)) * ca.sin(angle)


def sparse(number: Any) -> ca.SX:
    """An array of numbers or symbols in which an exact zero takes no place, and costs no operation."""
    return number if isinstance(number, ca.SX) else ca.SX(ca.sparsify(ca.DM(np.asarray(number, dtype=float))))


def transform(rotation: ca.SX, position: ca.SX) -> ca.SX:
    """The matrix (6, 6) that takes motions from a frame to one that lies in it, turned and shifted."""
    return ca.blockcat([[rotation.T, ca.SX(3, 3)], [-(rotation.T @ skew(position)), rotation.T]])


def cross(v: ca.SX) -> ca.SX:
    """The matrix (6, 6) of v x on motions; minus its transpose acts on forces."""
    return ca.reshape(_OF_CROSS @ v, 6, 6)


def swapped_cross(f: ca.SX) -> ca.SX:
    """The matrix (6, 6) that takes a motion v to what v x makes of the force f."""
    return ca.reshape(_OF_SWAPPED @ f, 6, 6)


def from_angles(roll: float, pitch: float, yaw: float) -> Array:
    """The rotation (3, 3) of angles about the fixed axes x, then y, then z, as URDF counts them."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)
