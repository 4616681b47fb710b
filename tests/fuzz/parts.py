"""The small arm, loop and equation that the valid calls of all rooms are made of."""

from __future__ import annotations

from typing import Any

import casadi as ca

from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.plants import AbstractElement
from workbench.blocks.signals import Sines
from workbench.core import Entry, Layout, Ode, Signals

ARM = paper_arm()
PLANT = Manipulator(ARM, q=[0.1, 0.2])
OBSERVER = ArmFullState(2)
LAW = ArmPID([1.0, 1.0], [0.1, 0.1], [1.0, 1.0], ARM)
REFERENCE = Sines("q", "rad", [1.0, 1.0], [1.0, 1.0])
LOOP = ClosedLoop(PLANT, OBSERVER, LAW, REFERENCE)


def decay() -> Ode:
    """x' = -k x, y = x."""
    states, parameters = Layout((Entry("x", 1.0),)), Layout((Entry("k", 2.0),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    return Ode.of("decay", states, parameters, (t, x, p), {"x": -p * x}, {"y": x})


ODE = decay()


def column(name: str, rows: int = 2) -> ca.SX:
    return ca.SX.sym(name, rows)


def signals() -> dict[str, Any]:
    """Arguments of a block's methods by the names that all rooms give them."""
    return {
        "t": lambda block: ca.SX.sym("t"),
        **{name: lambda block, name=name: column(name) for name in ("q", "qd", "qdd", "tau", "growth", "s", "K")},
        "x": lambda block: column("x"),
        "v": lambda block: column("v"),
        "z": lambda block: _memory(block),
        "y": lambda block: Signals(q=column("q"), qd=column("qd"), d=column("d")),
        "est": lambda block: Signals(q=column("q_hat"), qd=column("qd_hat"), d=column("d_hat")),
        "ref": lambda block: Signals(q=column("q_ref"), qd=column("qd_ref"), qdd=column("qdd_ref")),
        "w": lambda block: column("w", 4),
        "dof": lambda block: 2,
        "period": lambda block: 0.01,
        "name": lambda block: "x",
        "p": lambda block: None,
    }


def _memory(block: Any) -> dict[str, ca.SX]:
    memory = getattr(block, "memory", Layout())
    if callable(memory):
        memory = memory(Entry("v", [0.0, 0.0]) if isinstance(block, AbstractElement) else 2)
    return dict(memory.view(memory.symbols()))
