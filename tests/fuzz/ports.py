"""Arguments of methods that no example calls: a symbol for each entry of the port that the method reads."""

from __future__ import annotations

from typing import Any

import casadi as ca

from workbench.core import Entry, Layout, Signals

PORTS = {"x": "states", "u": "inputs", "y": "reads", "est": "reads", "ref": "follows", "z": "memory"}
DOF = 2  # of a block that does not tell it
PLAIN = {"dof": DOF, "period": 0.01, "name": "x", "p": None, "entry": Entry("v", [0.0, 0.0]), "horizon": 1.0}


def guess(thing: Any, name: str) -> Any:
    """An argument of this name for a method of `thing`: of a port, of the symbols of an arm, or two numbers."""
    if name in PLAIN:
        return PLAIN[name]
    if name == "t":
        return ca.SX.sym("t")
    port = getattr(thing, PORTS.get(name, ""), None)
    if callable(port):
        port = _of_size(port, getattr(thing, "dof", DOF))
    if isinstance(port, Layout):
        return Signals(port.view(port.symbols()))
    if name in ("q", "qd", "qdd", "tau", "x", "v", "s", "K", "growth", "w"):
        return ca.SX.sym(name, 4 if name == "w" else getattr(thing, "dof", DOF))
    return [0.1, 0.2]


def _of_size(port: Any, dof: int) -> Layout | None:
    """The port of a block whose size is that of its arm, or of its signal."""
    for size in (dof, PLAIN["entry"]):
        try:
            return port(size)
        except (ValueError, LookupError, TypeError):
            continue
    return None
