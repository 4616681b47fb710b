"""The planar chains of hinges among the exam's robots, as the arms that are derived from their energies."""

from __future__ import annotations

import numpy as np

from workbench.arms.mechanics import Link, PlanarArm

from .graders import Loaded
from .rigid import GRAVITY, Answers, Bodies, answers

EXACT = 1e-15  # how far off its plane a number may be that was printed in full


def planar_arm(bodies: Bodies) -> PlanarArm | None:
    """The exam's chain as ours, or None: hinges about one horizontal axis, links along the vertical at q = 0.

    A turn about the axis u moves a body along u x r; 'left' of a link's line is that direction at q = 0,
    as seen in the plane, for any of the zeros.
    """
    axis = np.array(bodies[0]["axis"])
    # a point-mass link of no successor is as long as its centre of mass is far: the tip does not enter M, C, G
    lines = [*(np.array(body["placement_p"]) for body in bodies[1:]), np.array(bodies[-1]["com"])]
    up = 1.0 if lines[0][2] > 0 else -1.0
    along = np.array([0.0, 0.0, up])
    left = np.cross(axis, along)
    links = []
    for i, (body, line) in enumerate(zip(bodies, lines, strict=True)):
        hinge = body["type"] == "R" and np.array_equal(body["axis"], axis) and axis[2] == 0
        chain = body["parent"] == (i - 1 if i else None)
        straight = np.array_equal(body["placement_R"], np.eye(3)) and abs(line @ left) < EXACT and line @ along > 0
        if not (hinge and chain and straight):
            return None
        com, inertia = np.array(body["com"]), np.array(body["inertia_com"])
        links.append(Link(body["mass"], line @ along, com @ along, com @ left, axis @ inertia @ axis))
    return PlanarArm(tuple(links), GRAVITY, "up" if up > 0 else "down")


def planar(exam: Loaded) -> dict[str, Answers]:
    """The robots of an exam that are planar."""
    arms = {name: planar_arm(robot["bodies"]) for name, robot in exam.module.robots().items()}
    return {name: answers(arm, range(arm.dof)) for name, arm in arms.items() if arm is not None}
