from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode
from workbench.engine import metrics as room
from workbench.engine.metrics.contract import Integral
from workbench.engine.metrics.measured_equation import common_grid
from workbench.engine.metrics.step_metrics import Overshoot, SampledRms, SettlingTime

from ..parts import ODE


@dataclass(frozen=True)
class Own(room.AbstractMetric):
    """A metric whose every method gives what it is told to."""

    watched: Any = ("y",)
    sampled: Any = None
    checked: Any = None
    integrated: Any = None
    remembered: Any = None
    updated: Any = None
    valued: Any = None

    @property
    def watches(self) -> Any:
        return self.watched

    @property
    def grid(self) -> Any:
        return self.sampled

    def check(self, ode: Ode, horizon: float) -> Any:
        return _given(self.checked, None, ode, horizon)

    def integrand(self, t: Any, y: Any) -> Any:
        return _given(self.integrated, y["y"], t, y)

    def memory(self, size: int) -> Any:
        return Layout() if self.remembered is None else self.remembered

    def update(self, k: Any, h: Any, z: Any, y: Any) -> Any:
        return _given(self.updated, {}, k, h, z, y)

    def value(self, integral: Any, z: Any, horizon: float) -> Any:
        return _given(self.valued, integral, integral, z, horizon)


def _given(told: Any, usual: Any, *arguments: Any) -> Any:
    return usual if told is None else told(*arguments) if callable(told) else told


def measure_own(**told: Any) -> room.Measurement:
    """The measurement by a metric of a user's own."""
    return room.measure(ODE, [Own("own", "m", "odd", **told)], until=0.5, h=0.1)


def measure_integral(g: Any, finish: Any, signals: Any) -> room.Measurement:
    """The measurement by an integral of a user's own."""
    return room.measure(ODE, [Integral("own", "m", "odd", g, finish, signals)], until=0.5, h=0.1)


def calls() -> dict[str, Any]:
    g, finish = (lambda t, y: y["y"]), (lambda integral, horizon: integral)
    return {
        "SampledRms": partial(SampledRms, "own", "m", "about", "y", 0.1),
        "Overshoot": partial(Overshoot, "own", "m", "about"),
        "SettlingTime": partial(SettlingTime, "own", "m", "about", 0.1),
        "measure_own": partial(measure_own, watched=("y",), sampled=None, checked=None, integrated=None,
                               remembered=Layout(), updated=None, valued=None),
        "measure_integral": partial(measure_integral, g, finish, ("y",)),
        "common_grid": partial(common_grid, [room.total_variation(0.1)], 1.0),
    }  # fmt: skip


def arguments() -> dict[str, Any]:
    one = ca.SX.sym("one")
    return {
        "ode": lambda metric: ODE,
        "horizon": lambda metric: 1.0,
        "size": lambda metric: 1,
        "integral": lambda metric: np.ones((2, 1)),
        **{name: lambda metric: one for name in ("t", "k", "h")},
        "y": lambda metric: {"y": one, "q": one, "q_ref": one},
        "z": lambda metric: {e.name: one for e in metric.memory(1).entries},
        **{f"{name}.value.z": lambda metric: {e.name: np.ones((2, 1)) for e in metric.memory(1).entries}
           for name in ("Integral", "Peak", "TotalVariation", "SampledRms", "Overshoot", "SettlingTime")},
    }  # fmt: skip
