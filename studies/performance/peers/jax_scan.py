"""JAX: `scan` over the steps and `vmap` over the runs, in double precision, on one core."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from studies.performance.peers.contract import Runner
from studies.performance.workload import STATES, H, rmse
from studies.performance.written import in_scalars
from workbench.validation.refusals import Array


def runner(horizon: float) -> Runner:
    """All runs side by side; compiled for their number at the first call."""
    with _one_thread():
        import jax

        jax.config.update("jax_enable_x64", True)
        device = jax.devices("cpu")[0]
    march = jax.jit(jax.vmap(_march(round(horizon / H))))

    def run(rows: Array) -> Array:
        with jax.default_device(device):
            return rmse(np.asarray(march(rows)[0]), horizon)

    return run


@contextmanager
def _one_thread() -> Iterator[None]:
    """XLA's pool, made when a device is first asked for, has one thread: others only wait at their own cost."""
    before = os.environ.get("NPROC")
    os.environ["NPROC"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["NPROC"]
        else:
            os.environ["NPROC"] = before


def _march(steps: int) -> Any:
    """Parameters (40,) of one run to its state (21,) and total variation."""
    import jax
    import jax.numpy as jnp

    scalars, h = in_scalars(jnp), H

    def rate(t: Any, x: Any, p: Any) -> tuple[Any, Any]:
        parts = scalars(t, x, p)
        return jnp.stack(parts[: STATES.size]), jnp.stack(parts[STATES.size :])

    def march(p: Any) -> Any:
        def step(carried: Any, k: Any) -> Any:
            (x, before, variation), t = carried, k * h
            k1, tau = rate(t, x, p)
            k2, _ = rate(t + h / 2, x + h / 2 * k1, p)
            k3, _ = rate(t + h / 2, x + h / 2 * k2, p)
            k4, _ = rate(t + h, x + h * k3, p)
            change = jnp.where(k > 0, jnp.abs(tau - before).sum(), 0.0)
            return (x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), tau, variation + change), None

        start = (jnp.asarray(STATES.default), jnp.zeros(2), 0.0)
        (x, _, variation), _ = jax.lax.scan(step, start, jnp.arange(float(steps)))
        return x, variation

    return march
