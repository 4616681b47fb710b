from __future__ import annotations

from functools import partial
from typing import Any

import control

from workbench.arms import manipulator
from workbench.blocks import plants
from workbench.blocks.loop import open_loop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import Entry, layout

from ..parts import ARM, PLANT, signals

MODULES = ("workbench.blocks.plants",)
LINEAR = control.ss([[-1.0]], [[1.0]], [[2.0]], 0, inputs="v", outputs="omega")


def _f(t: Any, x: Any, u: Any, p: Any, m: Any) -> Any:
    return [x[1], u[0] - p.k * m.sin(x[0])]


def _h(t: Any, x: Any, p: Any) -> Any:
    return [x[0]]


def calls() -> dict[str, Any]:
    friction = manipulator.Friction([1.0, 1.0], [0.1, 0.1])
    disturbance = SineTorque([1.0, 1.0], [1.0, 1.0])
    x0 = [0.0, 0.0, 0.0]
    return {
        "Backlash": partial(plants.Backlash, "v", 0.1, 0.01, 0.0),
        "BuckConverter": partial(plants.BuckConverter, 28.0, 50e-6, 500e-6, 3.0, 1.0, 2.0),
        "CartPole": partial(plants.CartPole, 0.5, 0.2, 0.1, 0.3, 0.006, 9.8, 0.1, 0.2, 0.3, 0.4),
        "DCMotor": partial(plants.DCMotor, 0.01, 0.1, 0.01, 1.0, 0.5, 0.1, 0.2, 0.3, "position"),
        "FurutaPendulum": partial(plants.FurutaPendulum, 0.3, 0.075, 0.278, 0.15, 0.148, 0.0248, 0.0039),
        "OdePlant": partial(plants.OdePlant, open_loop(plants.DCMotor())),
        "OdePlant.of": partial(
            plants.OdePlant.of, _f, ("a:m", "b"), ("u:N",), ("y:m",), _h, p=layout(k="N/m"), x0=[1.0, 2.0], u0=[0.5]
        ),
        "PlanarQuadrotor": partial(plants.PlanarQuadrotor, 0.486, 0.00383, 0.25, 9.81, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
        "Quadrotor": partial(
            plants.Quadrotor, 0.468, 0.225, 3e-6, 1e-7, 3e-5, [1.0, 1.0, 1.0], x0, 9.81, x0, x0, x0, x0
        ),
        "QuadrupleTank": partial(plants.QuadrupleTank, 28.0, 32.0, 0.071, 0.057, 3.33, 3.35, 0.7, 0.6, 981.0, 1.0, 1.0),
        "SingleTrackVehicle": partial(plants.SingleTrackVehicle, 1573.0, 2873.0, 1.1, 1.58, 8e4, 8e4, 30.0, 0.1, 0.2),
        "StirredTank": partial(plants.StirredTank, 100.0, 100.0, 1000.0, 0.239, 5e4, 8750.0, 7.2e10, 5e4, 350.0, 1.0),
        "TwoMasses": partial(plants.TwoMasses, 1.0, 1.0, 1.0, 0.1, 0.2, 0.3, 0.4),
        "AbstractActuator": manipulator.DirectDrive(),
        "AbstractElement": plants.Saturation("v", -1.0, 1.0),
        "DeadZone": partial(plants.DeadZone, "v", -1.0, [1.0, 2.0]),
        "Equipped": partial(
            plants.Equipped, plants.DCMotor(), (plants.Saturation("v", -1.0, 1.0),), (plants.FirstOrder("omega", 0.1),)
        ),
        "FirstOrder": partial(plants.FirstOrder, "v", 0.1, 0.0),
        "PadeDelay": partial(plants.PadeDelay, "v", 0.1, 2, 0.0),
        "Quantiser": partial(plants.Quantiser, "v", 0.1, "down"),
        "RateLimit": partial(plants.RateLimit, "v", -1.0, 1.0, 0.01, 0.0),
        "Saturation": partial(plants.Saturation, "v", [-1.0, -2.0], 1.0),
        "DirectDrive": partial(manipulator.DirectDrive, [1.0, 2.0]),
        "Disturbed": partial(plants.Disturbed, PLANT, Sines([1.0, 1.0], 1.0, signal="tau", unit="N m")),
        "FirstOrderLag": partial(manipulator.FirstOrderLag, 0.1, [1.0, 2.0]),
        "Friction": partial(manipulator.Friction, [1.0, 1.0], [0.1, 0.1], 0.01),
        "LinearPlant": partial(plants.LinearPlant, LINEAR, [1.0]),
        "Manipulator": partial(
            manipulator.Manipulator, ARM, [0.1, 0.2], [0.0, 0.0], disturbance, friction, manipulator.FirstOrderLag(0.1)
        ),
    }


def arguments() -> dict[str, Any]:
    return {**signals(), "entry": lambda element: Entry("v", [0.0, 0.0])}
