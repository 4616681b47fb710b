from __future__ import annotations

from functools import partial
from typing import Any

import casadi as ca
import control
import numpy as np

from workbench import core
from workbench.core import Entry, Layout
from workbench.core.expressions import rows
from workbench.core.numbers import Bounds

from ..parts import ARM, ODE, signals

T, X, P, W, H, K = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p"), ca.SX(0, 1), ca.SX.sym("h"), ca.SX.sym("k")
LINEAR = control.ss([[-1.0]], [[1.0]], [[2.0]], 0)
STATES, PARAMETERS = Layout((Entry("x", 1.0),)), Layout((Entry("k", 2.0),))


def calls() -> dict[str, Any]:
    return {
        "Bounds": partial(Bounds, 0.0, 1.0, True, False, ""),
        "LinearSystem.of": partial(core.LinearSystem.of, LINEAR, inputs="v", outputs="y", units={"v": "V"}, dt=None),
        "Ode.of": partial(core.Ode.of, "decay", STATES, PARAMETERS, (T, X, P), {"x": -P * X}, {"y": X}, {"y": "m"}),
        "rows": partial(rows, ODE.f, np.zeros((3, 1)), np.ones((3, 1)), np.ones((1, 1))),
    }  # fmt: skip


def arguments() -> dict[str, Any]:
    return {
        **signals(),
        "Ode.rate_at.t": lambda ode: 0.0,
        "Ode.outputs_at.t": lambda ode: 0.0,
        "Ode.rate_at.x": lambda ode: [1.0],
        "Ode.outputs_at.x": lambda ode: [1.0],
        "Dynamics.of.arm": lambda dynamics: ARM,
        **{f"Dynamics.{m}.{n}": lambda dynamics: [0.1, 0.2] for m in ("matrices", "torque", "acceleration")
           for n in ("q", "qd", "qdd", "tau")},
        "Ode.of.name": lambda ode: "decay",
        "states": lambda ode: STATES,
        "parameters": lambda ode: PARAMETERS,
        "symbols": lambda ode: (T, X, P),
        "rates": lambda ode: {"x": -P * X},
        "outputs": lambda ode: {"y": X},
        "Layout.slice.name": lambda layout: "q",
        "Layout.indices.name": lambda layout: "K[0,1]",
        "prefix": lambda layout: "plant.",
        "Layout.pack.values": lambda layout: {"q": [1.0, 2.0]},
        "Layout.check.rows": lambda layout: np.ones((3, layout.size)),
        "Layout.unpack.rows": lambda layout: np.ones((3, layout.size)),
        "Layout.view.vector": lambda layout: layout.symbols(),
        "Layout.flatten.parts": lambda layout: layout.view(layout.symbols()),
        "Bounds.allow.value": lambda bounds: np.ones(3),
        "StepRule.with_memory.symbols": lambda rule: ca.SX.sym("z"),
        "update": lambda rule: ca.SX.sym("z"),
        "StepMap.with_memory.extra": lambda step: Layout((Entry("z", 0.0),)),
        "StepMap.with_memory.symbols": lambda step: ca.SX.sym("z"),
        "Signals.only.names": lambda signals: Layout((Entry("x", 0.0),)),
        "h": lambda sampled: 0.05,
        "substeps": lambda sampled: 2,
    }  # fmt: skip
