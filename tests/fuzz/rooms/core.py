from __future__ import annotations

from functools import partial
from typing import Any

import casadi as ca
import control
import numpy as np

from workbench import core
from workbench.core import Entry, Layout
from workbench.core.block import initial, option, parameter
from workbench.core.expressions import rows
from workbench.core.numbers import Bounds

from ..parts import ARM, LAW, LOOP, ODE, PLANT, signals

MODULES = ("workbench.core",)
T, X, P, W, H, K = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p"), ca.SX(0, 1), ca.SX.sym("h"), ca.SX.sym("k")
ROLES = LOOP.roles
LINEAR = control.ss([[-1.0]], [[1.0]], [[2.0]], 0)
STATES, PARAMETERS = Layout((Entry("x", 1.0),)), Layout((Entry("k", 2.0),))
READINGS, COMMANDS, Y = Layout((Entry("y", 1.0),)), Layout((Entry("u", 1.0),)), ca.SX.sym("y")


def plain() -> type:
    """A new class, of which `block` makes a block, once."""

    class Plain:
        """A size, a kind and a start."""

        size: Any = parameter(1.0, unit="m", low=0)
        kind: str = option({"a": "one", "b": "other"}, default="a")
        start: Any = initial(default=0.0, unit="m", shape=("3",))
        __annotations__ = {"size": Any, "kind": str, "start": Any}

    return Plain


def decay(**more: Any) -> dict[str, Any]:
    """The parts of x' = -p x."""
    parts = {"states": STATES, "parameters": PARAMETERS, "outputs": Layout((Entry("y", 1.0),))}
    return {"name": "decay", **parts, "t": T, "x": X, "p": P, "rate": -P * X, "output": X, **more}


def calls() -> dict[str, Any]:
    ode, rule = core.Ode(**decay()), core.rk4(ODE, 0.1).rule
    flow = core.rk4(ODE, 0.1)
    return {
        "Claim": partial(core.Claim, "it holds", "x stays.", "a book", (core.Claim("a", "b", "c"),), lambda s: s["x"]),
        "Declared": partial(core.Declared, core.Claim("a", "b", "c"), "controller.", "PID"),
        "Circle": partial(core.Circle, (X, 1.0), 0.1, "link"),
        "Drawing": partial(core.Drawing, X, ({"kind": "word", "tone": "body", "letters": "a", "points": [0, 0]},)),
        "Entry": partial(core.Entry, "x", [1.0, 2.0], "m", Bounds(low=0), "x"),
        "Bounds": partial(Bounds, 0.0, 1.0, True, False, ""),
        "Layout": partial(core.Layout, (Entry("q", [1.0, 2.0]), Entry("K", np.eye(2), bounds=Bounds(symmetric=True)))),
        "LinearSystem": partial(core.LinearSystem, STATES, STATES, STATES, *[np.ones((1, 1))] * 4, 0.1),
        "LinearSystem.of": partial(core.LinearSystem.of, LINEAR, inputs="v", outputs="y", units={"v": "V"}, dt=None),
        "Line": partial(core.Line, [(0.0, 0.0), (X, 1.0)], "link", 0.1, True),
        "Lifted": partial(core.Lifted, ARM, STATES, X),
        "Ode": partial(core.Ode, **decay(inputs=("k",), notes=("a note",))),
        "Ode.of": partial(core.Ode.of, "decay", STATES, PARAMETERS, (T, X, P), {"x": -P * X}, {"y": X}, {"y": "m"}),
        "Signals": partial(core.Signals, {"x": X}, y=T),
        "layout": partial(core.layout, x="m", v=("V", 1.0)),
        "Roles": partial(core.Roles, **vars(ROLES)),
        "grouped": partial(core.grouped, {"a": ROLES, "b": ROLES}),
        "Rule": partial(core.Rule, rule.h, rule.k, rule.t, rule.x, rule.p, rule.w, rule.rate, rule.update, rule.output),
        "Sampled": partial(core.Sampled, ode, 0.1, K, W, 0.5 * X),
        "SampledLaw": partial(
            core.SampledLaw, "law", 0.1, STATES, READINGS, core.Layout(), COMMANDS, PARAMETERS, K, X, Y, W, P,
            -P * Y, X + Y, (core.Stage("Law", {"u": -P * Y}),), {"u": (-1.0, 1.0)}, {"u": 1}, ("a note",),
        ),
        "Stage": partial(core.Stage, "Law", {"u": X}, "u = x"),
        "Step": partial(
            core.Step, 0.1, flow.states, flow.parameters, flow.outputs, flow.rule, flow.flow, flow.amplification, 1
        ),
        "Word": partial(core.Word, (0.0, X), "A"),
        "block": partial(core.block, plain()),
        "initial": partial(core.initial, 1.0, unit="m", shape=("n",), symbol="x"),
        "lift": partial(core.lift, LAW, "law."),
        "lift of a loop": partial(core.lift, LOOP),
        "option": partial(core.option, {"a": "one", "b": "other"}, default="a"),
        "parameter": partial(
            core.parameter, 1.0, unit="m", low=0.0, high=2.0, strict=True, symmetric=False, definite="", shape=("n",),
            symbol="x",
        ),
        "rk4": partial(core.rk4, ODE, 0.1),
        "runge_kutta_step": partial(core.runge_kutta_step, ODE, 0.1, "stabilised"),
        "with_quadrature": partial(core.with_quadrature, ODE, {"z": ODE.x**2}, {"z": "m"}),
        "with_sensitivity": partial(core.with_sensitivity, ODE, ["k", "x"]),
        "rows": partial(rows, ODE.f, np.zeros((3, 1)), np.ones((3, 1)), np.ones((1, 1))),
        "a plant": partial(core.lift, PLANT),
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
        "Rule.extended.symbols": lambda rule: ca.SX.sym("z"),
        "update": lambda rule: ca.SX.sym("z"),
        "Step.extended.extra": lambda step: Layout((Entry("z", 0.0),)),
        "Step.extended.symbols": lambda step: ca.SX.sym("z"),
        "Signals.only.names": lambda signals: Layout((Entry("x", 0.0),)),
        "h": lambda sampled: 0.05,
        "substeps": lambda sampled: 2,
    }  # fmt: skip
