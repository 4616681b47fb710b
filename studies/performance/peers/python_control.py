"""python-control: `nlsys` and `input_output_response` with their default settings."""

from __future__ import annotations

import numpy as np

from studies.performance.peers.contract import Runner
from studies.performance.workload import STATES, H, rmse
from studies.performance.written import in_matrices
from workbench.validation.refusals import Array


def runner(horizon: float) -> Runner:
    """One run after the other, with the torque as output at every step of W, as its total variation asks for."""
    import control

    times = np.linspace(0.0, horizon, round(horizon / H) + 1)

    def run(p: Array) -> Array:
        rate = in_matrices(p)
        system = control.nlsys(
            lambda t, x, u, params: rate(t, x)[0],
            lambda t, x, u, params: rate(t, x)[1],
            inputs=0,
            outputs=2,
            states=STATES.size,
        )
        response = control.input_output_response(system, times, 0.0, STATES.default)
        return rmse(np.asarray(response.states)[:, -1], horizon)

    return lambda rows: np.array([run(p) for p in rows])
