"""The motion of least time of the arm of the paper within its torques."""

from __future__ import annotations

from functools import cache

import workbench as wb

TORQUES = (100.0, 50.0)  # N m
GOAL = 1.0  # rad, of both joints, from 0 at rest to rest


@cache
def arm() -> wb.Ode:
    """The arm of the paper at rest, whose torques are inputs."""
    return wb.open_loop(wb.Manipulator(wb.paper_arm(), q=[0.0, 0.0]))


def least_time_plan() -> wb.planning.Plan:
    """The motion of least time within the torques."""
    low, high = [-torque for torque in TORQUES], list(TORQUES)
    return wb.plan(arm(), (0.1, 10.0), end={"q": [GOAL, GOAL], "qd": 0.0}, limits={"tau": (low, high)})
