from __future__ import annotations

from functools import partial
from typing import Any

import control
import numpy as np

from workbench.arms import observer_gains
from workbench.arms.dynamics import Dynamics
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import FirstOrderLag, Manipulator
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant
from workbench.core import Ode
from workbench.design import chattering

from ..parts import signals

LAG = control.ss([[0.0, 1.0, 0.0], [0.0, -9.0, 1.0], [0.0, 0.0, -9.0]], [[0.0], [0.0], [1.0]], [[81.0, 0.0, 0.0]], 0)
SWING = Dynamics.of(PlanarArm((PointMass(2.0, 0.5),), 9.81))
MISMATCH = observer_gains.Mismatch.of(SWING)
GAINS = observer_gains.Gains(np.array([[80.0]]), np.array([[1600.0]]))
REGION = observer_gains.Region(np.array([3.0]), np.array([7.0]))


def layer() -> tuple[Ode, np.ndarray]:
    """A loop with a boundary layer on its first joint alone, and its parameters."""
    arm, folded = PlanarArm((PointMass(1.0, 1.0), PointMass(1.0, 1.0)), 0.0), [0.0, np.pi]
    law = SlidingMode(arm, Lambda=[6.0] * 2, K=[5.0] * 2, phi=0.01, saturation="clip")
    plant = Manipulator(arm, q=folded, actuator=FirstOrderLag(0.01))
    loop = ClosedLoop(plant, ArmFullState(2), law, Constant("q", "rad", folded)).ode()
    p = loop.parameters.default.copy()
    p[loop.parameters.labels.index("controller.K[1]")] = 0.0
    return loop, p


def calls() -> dict[str, Any]:
    q, (loop, p) = np.zeros((3, 1)), layer()
    return {
        "cut": partial(chattering.linear_part_of, loop, loop.states.default, p),
        "Mismatch": partial(observer_gains.Mismatch.of, SWING),
        "Frozen": partial(observer_gains.frozen_poles_along, MISMATCH, GAINS, REGION, q, q, q),
    }


def arguments() -> dict[str, Any]:
    column = [[0.1]]
    return {
        **signals(),
        **dict.fromkeys(("q", "qd", "tau", "squares"), lambda thing: np.array(column)),
        "a": lambda thing: 0.5,
        "g": lambda thing: 0.1,
        "w": lambda thing: 3.0,
        "share": lambda thing: 0.5,
        "gain": lambda thing: 1.0,
        "period": lambda thing: 0.01,
        "region": lambda thing: REGION,
        "arm": lambda thing: REGION,
        "dynamics": lambda thing: SWING,
        "system": lambda thing: LAG,
        "times": lambda thing: [0.1, 0.2],
        "frequencies": lambda thing: np.array([1.0, 2.0]),
        "c": lambda thing: np.array(column),
        "r": lambda thing: np.array(column),
    }
