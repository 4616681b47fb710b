"""CasADi: the same step on its virtual machine, one after the other by `mapaccum`."""

from __future__ import annotations

import casadi as ca
import numpy as np

from workbench.bench.peers.contract import Runner
from workbench.bench.workload import H, rmse, workload


def runner(horizon: float) -> Runner:
    """One run after the other."""
    step, steps = workload(), round(horizon / H)
    k = ca.DM(range(steps)).T
    one = ca.Function("one", [step.x, step.k, step.p], [step.next], {"cse": True})
    x, p = ca.MX.sym("x", step.states.size), ca.MX.sym("p", step.parameters.size)
    march = ca.Function("march", [x, p], [one.mapaccum(steps)(x, k, ca.repmat(p, 1, steps))[:, -1]])
    start = step.states.default
    return lambda rows: rmse(np.array([np.array(march(start, row)).ravel() for row in rows]), horizon)
