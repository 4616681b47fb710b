from __future__ import annotations

from functools import lru_cache, partial
from importlib import import_module
from typing import Any

import numpy as np
from workbench.simulate.stepping.schedule import Segment

from workbench.core import rk4, stepper
from workbench.simulate import Schedule, arithmetic
from workbench.simulate.divergence import Divergence
from workbench.simulate.job import Job
from workbench.simulate.step_size import Accuracy, Check, Choice

from ..parts import ODE

room = import_module("workbench.simulate")  # `workbench.simulate` is the function
MODULES = ("workbench.simulate", "workbench.simulate.arithmetic")

STEP, HALF = rk4(ODE, 2e-5), rk4(ODE, 1e-5)  # so short that a run to 2^31 s is refused for its length
P, X0 = np.full((2, 1), 2.0), np.ones((2, 1))


@lru_cache
def make(method: str, h: float) -> Any:
    """The step of the equation by a method."""
    return stepper(method)(ODE, h)


def score(runs: Any) -> dict[str, Any]:
    """The last state."""
    return {"end": runs.x[:, -1]}


def calls() -> dict[str, Any]:
    schedule = Schedule(0.1, (Segment("rk4", 2, 3), Segment("rkc3", 1, 2)))
    job = Job(STEP, P, 1, 0, np.arange(2))
    lost = Divergence(np.array([np.nan, 0.1]), np.array([-1, 0]))
    limit = room.StepLimit(0.1, 1.0, 0.0, complex(-2.0), 3)
    found = Accuracy("end", 1e-3, 1e-6, 1e-5, 1.0, 2, 0)
    times = {"until": 1e-3, "every": 5e-4}
    how = {"seed": 1, "progress": lambda share: None, "arithmetic": None}
    return {
        "Segment": partial(Segment, "rk4", 2, 3),
        "Schedule": partial(Schedule, 0.1, schedule.segments),
        "Schedule.of": partial(Schedule.of, 0.1, [("rk4", 2), ("rkc3", 1)]),
        "StepLimit": partial(room.StepLimit, 0.1, 1.0, 0.0, complex(-2.0), 3),
        "Accuracy": partial(Accuracy, "end", 1e-3, 1e-6, 1e-5, 1.0, 2, 0),
        "Check": partial(Check, (found,), limit, 2, 4),
        "Choice": partial(Choice, schedule, 1e-3, 1e-4, 2),
        "Trajectories": partial(room.Trajectories, job, np.array([0.0, 0.1]), np.ones((2, 2, 1)), lost),
        "check_by_halving": partial(room.check_by_halving, schedule, make, P, X0, score, 1e-3, 2),
        "choose": partial(
            room.choose, make, P, X0, 1.0, 1e-3, cell=0.5, grid=0.1, methods=("rk4", "rkc3"), arithmetic=None
        ),
        "pilot_rows": partial(room.pilot_rows, P, X0, 1),
        "run": partial(room.run, schedule, make, P, X0, 1, how["progress"], None),
        "simulate": partial(room.simulate, STEP, P, X0, **times, **how, runs=[3, 4], engine=None),
        "simulate_alike": partial(
            room.simulate_alike, [(STEP, HALF), (STEP, HALF)], until=[1e-3, 5e-4], every=5e-4, progress=how["progress"]
        ),
        "simulate_both": partial(room.simulate_both, STEP, HALF, P, X0, **times, **how),
        "step_limit": partial(room.step_limit, room.simulate(STEP, P, X0, **times), 0, 10),
        "check": partial(arithmetic.check, "fused"),
        "signature": partial(arithmetic.signature, "portable"),
        "default_for": partial(arithmetic.default_for, STEP),
        "has_graph": partial(arithmetic.has_graph, STEP),
        "is_compiled": partial(arithmetic.is_compiled, STEP, "portable"),
        "native": partial(arithmetic.native, "portable"),
    }


def arguments() -> dict[str, Any]:
    return {
        "Schedule.h.segment": lambda schedule: schedule.segments[0],
        "cell": lambda schedule: 0.1,
        "choices": lambda schedule: [("rk4", 2)],
    }
