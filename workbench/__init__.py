"""control-workbench: equations in, verdicts, numbers and a running controller out.

`import workbench as wb` loads nothing by itself; each of the names of `wb` comes from its room when it is first asked
for. `dir(wb)` lists them, and `help(wb.X)` tells of one, with its shapes, units and an example.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

# Each public name and the room that it comes from; `Name: room.Other` where it is called otherwise there.
ROOMS = {
    "core": ("Layout", "Ode", "Sampled", "Signals", "block", "initial", "layout", "lift", "option", "parameter", "rk4"),
    "loop": ("ClosedLoop", "Instruments", "open_loop", "roles"),
    "plants": (
        "BuckConverter",
        "CartPole",
        "DCMotor",
        "FurutaPendulum",
        "Manipulator",
        "OdePlant",
        "PlanarQuadrotor",
        "Quadrotor",
        "QuadrupleTank",
        "SingleTrackVehicle",
        "StirredTank",
        "TwoMasses",
    ),
}
