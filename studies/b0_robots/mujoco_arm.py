"""Our arms in MuJoCo, an independent engine, where it is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.robots import PlanarArm, SpatialArm
from workbench.robots.planar_arm import DIRECTIONS
from workbench.validation.refusals import Array

INSTALLED = importlib.util.find_spec("mujoco") is not None
# MuJoCo asks for positive moments: those of a point mass are raised to this, far below rounding.
LEAST = 2e-15


def engine(arm: PlanarArm | SpatialArm) -> Callable[[Array, Array], tuple[Array, Array]]:
    """What gives M (n, n) and the bias C qd + G (n,) at a state (q, qd), by MuJoCo."""
    import mujoco

    model: Any = mujoco.MjModel.from_xml_string(mjcf(arm))
    data = mujoco.MjData(model)

    def at(q: Array, qd: Array) -> tuple[Array, Array]:
        data.qpos[:], data.qvel[:] = q, qd
        mujoco.mj_forward(model, data)
        M = np.zeros((arm.dof, arm.dof))
        mujoco.mj_fullM(model, data, M)
        return M, np.array(data.qfrc_bias)

    return at


def mjcf(arm: PlanarArm | SpatialArm) -> str:
    """The arm in MuJoCo's language."""
    bodies = _planar(arm) if isinstance(arm, PlanarArm) else _spatial(arm)

    def opened(parent: int) -> str:
        return "".join(f"{body}{opened(i)}</body>" for i, (carrier, body) in enumerate(bodies) if carrier == parent)

    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-arm.gravity!r}"/>'
        f"<worldbody>{opened(-1)}</worldbody></mujoco>"
    )


def _planar(arm: PlanarArm) -> list[tuple[int, str]]:
    """The plane is x to the right, z upward; hinges turn from x to z."""
    right, up = DIRECTIONS[arm.zero]
    along, left = np.array([right, 0.0, up]), np.array([-up, 0.0, right])
    bodies, place = [], np.zeros(3)
    for i, link in enumerate(arm.links):
        com, inertia = link.com * along + link.offset * left, [max(link.inertia, LEAST)] * 3
        bodies.append((i - 1, _body(place, np.eye(3), "hinge", [0, -1, 0], link.mass, com, [*inertia, 0, 0, 0])))
        place = link.length * along
    return bodies


def _spatial(arm: SpatialArm) -> list[tuple[int, str]]:
    bodies = []
    for link in arm.links:
        xx, xy, xz, yy, yz, zz = link.inertia
        moments = [max(xx, LEAST), max(yy, LEAST), max(zz, LEAST), xy, xz, yz]
        joint = "slide" if link.joint == "prismatic" else "hinge"
        body = _body(link.position, link.rotation, joint, link.axis, link.mass, link.com, moments)
        bodies.append((link.parent, body))
    return bodies


def _body(place: Any, rotation: Any, joint: str, axis: Any, mass: float, com: Any, moments: Any) -> str:
    x, y = np.asarray(rotation)[:, 0], np.asarray(rotation)[:, 1]
    # what is diagonal already is not diagonalised, which for a point mass would be refused
    inertia = f'fullinertia="{_row(moments)}"' if any(moments[3:]) else f'diaginertia="{_row(moments[:3])}"'
    return (
        f'<body pos="{_row(place)}" xyaxes="{_row([*x, *y])}"><joint type="{joint}" axis="{_row(axis)}"/>'
        f'<inertial pos="{_row(com)}" mass="{mass!r}" {inertia}/>'
    )


def _row(vector: Any) -> str:
    return " ".join(repr(float(x)) for x in vector)
