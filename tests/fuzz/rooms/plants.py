from __future__ import annotations

from functools import partial
from typing import Any

import control

from workbench import plants
from workbench.signals import SineTorque

from ..parts import ARM, signals

MODULES = ("workbench.plants",)
LINEAR = control.ss([[-1.0]], [[1.0]], [[2.0]], 0, inputs="v", outputs="omega")


def calls() -> dict[str, Any]:
    friction = plants.Friction([1.0, 1.0], [0.1, 0.1])
    disturbance = SineTorque([1.0, 1.0], [1.0, 1.0])
    return {
        "AbstractActuator": plants.DirectDrive(),
        "DirectDrive": partial(plants.DirectDrive, [1.0, 2.0]),
        "FirstOrderLag": partial(plants.FirstOrderLag, 0.1, [1.0, 2.0]),
        "Friction": partial(plants.Friction, [1.0, 1.0], [0.1, 0.1], 0.01),
        "LinearPlant": partial(plants.LinearPlant, LINEAR, [1.0]),
        "Manipulator": partial(
            plants.Manipulator, ARM, [0.1, 0.2], [0.0, 0.0], disturbance, friction, plants.FirstOrderLag(0.1)
        ),
    }


def arguments() -> dict[str, Any]:
    return signals()
