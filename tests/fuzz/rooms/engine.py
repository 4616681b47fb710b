from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

from workbench.core import rk4
from workbench.engine import arithmetic
from workbench.engine.step_check import StepCheck
from workbench.engine.step_limits import Accuracy, Check

from ..parts import ODE

room = import_module("workbench.engine")  # `workbench.engine` is the function

STEP = rk4(ODE, 2e-5)


def calls() -> dict[str, Any]:
    limit = room.StepLimit(0.1, 1.0, 0.0, complex(-2.0), 3)
    found = Accuracy("end", 1e-3, 1e-6, 1e-5, 1.0, 2, 0)
    return {
        "Accuracy": partial(Accuracy, "end", 1e-3, 1e-6, 1e-5, 1.0, 2, 0),
        "Check": partial(Check, (found,), limit, 2, 4),
        "StepCheck": partial(StepCheck, limit, 1e-3, "x", 0, 1, 1.0, 1e-2, False),
        "check": partial(arithmetic.check, "fused"),
        "signature": partial(arithmetic.signature, "portable"),
        "default_for": partial(arithmetic.default_for, STEP),
        "is_compiled": partial(arithmetic.is_compiled, STEP, "portable"),
        # where nothing is compiled, to raise an ImportError is what it is for
        **({"native": partial(arithmetic.native, "portable")} if arithmetic.is_compiled(STEP, "portable") else {}),
    }


def arguments() -> dict[str, Any]:
    return {}
