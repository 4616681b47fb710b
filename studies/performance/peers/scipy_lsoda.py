"""SciPy: `solve_ivp` by LSODA at a relative tolerance of 1e-6."""

from __future__ import annotations

import numpy as np

from studies.performance.peers.contract import Runner
from studies.performance.workload import STATES, rmse
from studies.performance.written import in_matrices
from workbench.validation.refusals import Array

TOLERANCE = 1e-6


def runner(horizon: float) -> Runner:
    """One run after the other."""
    from scipy.integrate import solve_ivp

    def run(p: Array) -> Array:
        rate = in_matrices(p)
        found = solve_ivp(
            lambda t, x: rate(t, x)[0],
            (0.0, horizon),
            STATES.default,
            method="LSODA",
            t_eval=[horizon],
            rtol=TOLERANCE,
            atol=TOLERANCE,
        )
        return rmse(found.y[:, -1], horizon)

    return lambda rows: np.array([run(p) for p in rows])
