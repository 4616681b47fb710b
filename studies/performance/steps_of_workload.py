"""The steps of W at equal error: by each method, chosen by pilot runs for a tolerance of the RMSE."""

from __future__ import annotations

from functools import cache

import numpy as np

import workbench as wb
from studies.paper.workload import STATES, loop, rmse
from studies.performance.inner_parts import Pilots, StepChoice, Trajectories, pilot_runs, search_step


@cache
def workload_step(h: float, method: str = "rk4") -> wb.core.StepMap:
    """A step of W, with the integrals that score it, as CVODES has them, and no sum over steps."""
    return wb.runge_kutta_step(loop(), h, method)


def through(p: wb.Array, horizon: float, h: float, method: str = "rk4") -> wb.Array:
    """The RMSE (B, 2) of runs at the step h [s] of a method."""
    return rmse(wb.simulate(workload_step(h, method), p, until=horizon, every=horizon).x[:, -1], horizon)


def by_choice(choice: StepChoice, p: wb.Array, horizon: float) -> wb.Array:
    """The RMSE (B, 2) of runs at a chosen step."""
    return through(p, horizon, choice.h, choice.method)


def choose_step(p: wb.Array, tolerance: float, horizon: float) -> StepChoice:
    """The step that pilots among the runs choose for a tolerance of their RMSE."""
    few = pilot_runs(p, x0 := np.broadcast_to(STATES.default, (len(p), STATES.size)))

    def errors(fine: Trajectories, coarse: Trajectories) -> tuple[float, str]:
        value, other = (rmse(runs.x[:, -1], horizon) for runs in (fine, coarse))
        return float(np.nan_to_num(2 * np.abs(other / value - 1), nan=np.inf).max()), "the RMSE"

    return search_step(Pilots(loop(), workload_step, errors, p[few], x0[few], horizon, horizon), tolerance)
