from __future__ import annotations

from functools import partial
from typing import Any

from workbench.arms import manipulator
from workbench.blocks import plants
from workbench.core import Entry, layout

from ..parts import signals


def _f(t: Any, x: Any, u: Any, p: Any, m: Any) -> Any:
    return [x[1], u[0] - p.k * m.sin(x[0])]


def _h(t: Any, x: Any, p: Any) -> Any:
    return [x[0]]


def calls() -> dict[str, Any]:
    return {
        "OdePlant.of": partial(
            plants.OdePlant.of, _f, ("a:m", "b"), ("u:N",), ("y:m",), _h, p=layout(k="N/m"), x0=[1.0, 2.0], u0=[0.5]
        ),
        "DirectDrive": partial(manipulator.DirectDrive, [1.0, 2.0]),
        "FirstOrderLag": partial(manipulator.FirstOrderLag, 0.1, [1.0, 2.0]),
        "Friction": partial(manipulator.Friction, [1.0, 1.0], [0.1, 0.1], 0.01),
    }


def arguments() -> dict[str, Any]:
    return {**signals(), "entry": lambda element: Entry("v", [0.0, 0.0])}
