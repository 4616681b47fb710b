"""Our arms in MuJoCo, an independent engine, where it is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import workbench as wb

HAS_MUJOCO = importlib.util.find_spec("mujoco") is not None
# MuJoCo asks for positive moments: those of a point mass are raised to this, far below rounding.
LEAST = 2e-15


def engine(
    arm: wb.arms.mechanics.PlanarArm | wb.arms.mechanics.SpatialArm,
) -> Callable[[wb.Array, wb.Array], tuple[wb.Array, wb.Array]]:
    """A function to M (n, n) and the bias C qd + G (n,) at a state (q, qd), by MuJoCo."""
    import mujoco

    model: Any = mujoco.MjModel.from_xml_string(mjcf(arm))
    data = mujoco.MjData(model)

    def at(q: wb.Array, qd: wb.Array) -> tuple[wb.Array, wb.Array]:
        data.qpos[:], data.qvel[:] = q, qd
        mujoco.mj_forward(model, data)
        M = np.zeros((arm.dof, arm.dof))
        mujoco.mj_fullM(model, data, M)
        return M, np.array(data.qfrc_bias)

    return at


def mjcf(arm: wb.arms.mechanics.PlanarArm | wb.arms.mechanics.SpatialArm) -> str:
    """The arm in MuJoCo's language."""
    held = list(bodies(arm))

    def below(parent: int) -> str:
        return "".join(f"{text}{below(i)}</body>" for i, (carrier, text) in enumerate(held) if carrier == parent)

    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-arm.gravity!r}"/>'
        f"<worldbody>{below(-1)}</worldbody></mujoco>"
    )


def bodies(arm: wb.arms.mechanics.PlanarArm | wb.arms.mechanics.SpatialArm) -> Iterator[tuple[int, str]]:
    """Each body with the number of its carrier; the plane is x to the right, z upward, and hinges turn from x to z."""
    if isinstance(arm, wb.arms.mechanics.SpatialArm):
        for link in arm.links:
            xx, xy, xz, yy, yz, zz = link.inertia
            joint = "slide" if link.joint == "prismatic" else "hinge"
            pose = (link.position, np.asarray(link.rotation), joint, link.axis)
            yield link.parent, body(*pose, link.mass, link.com, (xx, yy, zz), (xy, xz, yz))
        return
    right, up = wb.arms.mechanics.DIRECTIONS[arm.zero]
    along, left, place = np.array([right, 0.0, up]), np.array([-up, 0.0, right]), np.zeros(3)
    for i, rod in enumerate(arm.links):
        com = rod.com * along + rod.offset * left
        yield i - 1, body(place, np.eye(3), "hinge", (0, -1, 0), rod.mass, com, (rod.inertia,) * 3, (0, 0, 0))
        place = rod.length * along


def body(
    place: Any, rotation: wb.Array, joint: str, axis: Any, mass: float, com: Any, moments: Any, products: Any
) -> str:
    """One body with its joint, not yet closed."""

    def row(*vectors: Any) -> str:
        return " ".join(repr(float(x)) for vector in vectors for x in vector)

    moments = [max(moment, LEAST) for moment in moments]
    # a diagonal matrix is not diagonalised, which for a point mass would be refused
    inertia = f'fullinertia="{row(moments, products)}"' if any(products) else f'diaginertia="{row(moments)}"'
    return (
        f'<body pos="{row(place)}" xyaxes="{row(*rotation.T[:2])}"><joint type="{joint}" axis="{row(axis)}"/>'
        f'<inertial pos="{row(com)}" mass="{mass!r}" {inertia}/>'
    )
