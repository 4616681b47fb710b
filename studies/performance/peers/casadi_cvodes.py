"""CasADi: CVODES of SUNDIALS at a given tolerance, with the exact sparse Jacobian."""

from __future__ import annotations

import casadi as ca
import numpy as np

from studies.performance.peers.contract import Runner
from studies.performance.workload import loop, rmse


def runner(horizon: float, tolerance: float) -> Runner:
    """One run after the other."""
    ode = loop()
    equations = {"x": ode.x, "t": ode.t, "p": ode.p, "ode": ode.rate}
    options = {"reltol": tolerance, "abstol": tolerance, "max_num_steps": 1_000_000}  # it gives up at 10,000
    march = ca.integrator("march", "cvodes", equations, 0.0, horizon, options)
    start = ode.states.default
    return lambda rows: rmse(np.array([np.array(march(x0=start, p=row)["xf"]).ravel() for row in rows]), horizon)
