"""numba: the right-hand side in scalars, RK4 and the loop over steps and runs, all compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from studies.performance.peers.contract import Runner
from studies.performance.workload import PARAMETERS, STATES, H, rmse
from studies.performance.written import in_scalars
from workbench.validation.refusals import Array


def runner(horizon: float) -> Runner:
    """One run after the other, without an allocation in the loop."""
    march, steps = _compiled(), round(horizon / H)
    march(PARAMETERS.default[np.newaxis], STATES.default, 1, H)
    return lambda rows: rmse(march(rows, STATES.default, steps, H)[0], horizon)


def _compiled() -> Any:
    """The states (B, 21) and the total variations (B,) after so many steps."""
    import numba

    jit: Callable[[Any], Any] = numba.njit(fastmath=True, error_model="numpy")
    nx, rate = STATES.size, in_scalars(np, jit)

    @jit
    def put(to: Array, t: float, x: Array, p: Array) -> None:
        # a tuple of unlike parts has no loop in numba, and an array made of it would be an allocation
        (to[0], to[1], to[2], to[3], to[4], to[5], to[6], to[7], to[8], to[9], to[10], to[11], to[12], to[13],
         to[14], to[15], to[16], to[17], to[18], to[19], to[20], to[21], to[22]) = rate(t, x, p)  # fmt: skip

    @jit
    def march(rows: Array, start: Array, steps: int, h: float) -> tuple[Array, Array]:
        states, variation = np.empty((len(rows), nx)), np.zeros(len(rows))
        k1, k2, k3, k4, y = np.empty(nx + 2), np.empty(nx + 2), np.empty(nx + 2), np.empty(nx + 2), np.empty(nx)
        for run in range(len(rows)):
            p, x = rows[run], states[run]
            x[:] = start
            before1 = before2 = 0.0
            for k in range(steps):
                t = k * h
                put(k1, t, x, p)
                for i in range(nx):
                    y[i] = x[i] + h / 2 * k1[i]
                put(k2, t + h / 2, y, p)
                for i in range(nx):
                    y[i] = x[i] + h / 2 * k2[i]
                put(k3, t + h / 2, y, p)
                for i in range(nx):
                    y[i] = x[i] + h * k3[i]
                put(k4, t + h, y, p)
                for i in range(nx):
                    x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i])
                if k > 0:
                    variation[run] += abs(k1[nx] - before1) + abs(k1[nx + 1] - before2)
                before1, before2 = k1[nx], k1[nx + 1]
        return states, variation

    return march
