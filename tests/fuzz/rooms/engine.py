from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from workbench.core import rk4
from workbench.engine import arithmetic
from workbench.engine.divergence import Divergence
from workbench.engine.job import Job
from workbench.engine.step_check import StepCheck
from workbench.engine.step_size import Accuracy, Check

from ..parts import ODE

room = import_module("workbench.engine")  # `workbench.engine` is the function
MODULES = ("workbench.engine",)

STEP, HALF = rk4(ODE, 2e-5), rk4(ODE, 1e-5)  # so short that a run to 2^31 s is refused for its length
P, X0 = np.full((2, 1), 2.0), np.ones((2, 1))


def calls() -> dict[str, Any]:
    job = Job(STEP, P, 1, 0, np.arange(2))
    lost = Divergence(np.array([np.nan, 0.1]), np.array([-1, 0]))
    limit = room.StepLimit(0.1, 1.0, 0.0, complex(-2.0), 3)
    found = Accuracy("end", 1e-3, 1e-6, 1e-5, 1.0, 2, 0)
    times = {"until": 1e-3, "every": 5e-4}
    how = {"seed": 1, "progress": lambda share: None, "arithmetic": None, "tolerance": 1e-2}
    return {
        "StepLimit": partial(room.StepLimit, 0.1, 1.0, 0.0, complex(-2.0), 3),
        "Accuracy": partial(Accuracy, "end", 1e-3, 1e-6, 1e-5, 1.0, 2, 0),
        "Check": partial(Check, (found,), limit, 2, 4),
        "StepCheck": partial(StepCheck, limit, 1e-3, "x", 0, 1, 1.0, 1e-2, False),
        "Trajectories": partial(room.Trajectories, job, np.array([0.0, 0.1]), np.ones((2, 2, 1)), lost),
        "simulate": partial(room.simulate, STEP, P, X0, **times, **how, runs=[3, 4], engine=None),
        "step_limit": partial(room.step_limit, room.simulate(STEP, P, X0, **times), 0, 10),
        "check": partial(arithmetic.check, "fused"),
        "signature": partial(arithmetic.signature, "portable"),
        "default_for": partial(arithmetic.default_for, STEP),
        "is_compiled": partial(arithmetic.is_compiled, STEP, "portable"),
        # where nothing is compiled, to raise an ImportError is what it is for
        "native": partial(arithmetic.native, "portable") if arithmetic.is_compiled(STEP, "portable") else None,
    }


def arguments() -> dict[str, Any]:
    return {}
