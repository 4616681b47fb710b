"""The march through CasADi's own machine: simple, exact, and there on every platform."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Step
from workbench.core.layout import Array

STEPS_PER_CALL = 20_000  # between two looks at progress and divergence: about a tenth of a second


def march(step: Step, x: Array, p: Array, stride: int, kept: int, tell: Callable[[float], None]) -> Array:
    """The states (B, kept, nx) after every `stride` steps from x (B, nx), with parameters p (B, np)."""
    nx, runs = step.states.size, len(x)
    z = np.vstack([np.zeros((1, runs)), x.T, p.T])
    chunk = max(1, min(kept, STEPS_PER_CALL // stride))
    parts, done = [], 0
    while done < kept:
        size = min(chunk, kept - done)
        out = np.array(_marcher(step, stride, size, runs)(z)).reshape(z.shape[0], runs, size)
        z = out[:, :, -1]
        parts.append(out[1 : 1 + nx].transpose(1, 2, 0))
        done += size
        if not np.isfinite(z).all(axis=0).any():  # nothing is left to simulate
            parts.append(np.full((runs, kept - done, nx), np.nan))
            done = kept
        tell(done / kept)
    return np.concatenate(parts, axis=1)


@lru_cache(maxsize=64)
def _marcher(step: Step, stride: int, kept: int, runs: int) -> ca.Function:
    """[k; x; p] through `kept` times `stride` steps, all kept ones side by side, for each run."""
    z = ca.SX.sym("z", 1 + step.states.size + step.parameters.size)
    k, x, p = ca.vertsplit(z, [0, 1, 1 + step.states.size, z.numel()])
    one = ca.Function("workbench_one", [z], [ca.vertcat(k + 1, step.F(k, x, p), p)], {"cse": True})
    march = one.fold(stride).mapaccum(kept)
    return march if runs == 1 else march.map(runs, "thread", min(runs, 8))
