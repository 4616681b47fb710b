"""CasADi: the same step on its virtual machine, one after the other by `mapaccum`."""

from __future__ import annotations

import casadi as ca
import numpy as np

from studies.performance.peers.contract import Runner
from studies.performance.workload import H, rmse, workload


def runner(horizon: float) -> Runner:
    """One run after the other."""
    step, steps = workload(), round(horizon / H)
    times = ca.DM(range(steps)).T
    k, x, p = step.rule.k, step.rule.x, step.rule.p
    one = ca.Function("one", [x, k, p], [step.F(k, x, p, [])], {"cse": True})
    begin, numbers = ca.MX.sym("x", step.states.size), ca.MX.sym("p", step.parameters.size)
    end = one.mapaccum(steps)(begin, times, ca.repmat(numbers, 1, steps))[:, -1]
    march = ca.Function("march", [begin, numbers], [end])
    start = step.states.default
    return lambda rows: rmse(np.array([np.array(march(start, row)).ravel() for row in rows]), horizon)
