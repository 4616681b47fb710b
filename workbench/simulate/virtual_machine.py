"""The march through CasADi's own machine: simple, exact, and there on every platform."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Step
from workbench.core.layout import Array

STEPS_PER_CALL = 20_000  # of all runs, between two looks at progress and divergence: about a tenth of a second


def working_set(step: Step, runs: int) -> int:
    """The bytes that a march needs beside what it fills: each step of a call leaves all it knows, three times."""
    return 3 * 8 * (1 + step.states.size + step.parameters.size) * max(STEPS_PER_CALL, runs)


def march(
    step: Step,
    x: Array,
    p: Array,
    stride: int,
    tell: Callable[[float], None] = lambda done: None,
    first: int | Array = 0,
) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0], the states at step `first`, with those every `stride` steps.

    The parameters p are (B, np).
    """
    runs, kept = len(x), x.shape[1] - 1
    now = np.vstack([np.full((1, runs), first, dtype=float), x[:, 0].T])
    most = max(1, STEPS_PER_CALL // runs)
    chunk = max(1, most // stride)
    # one stride may be longer than a call: then it is made of several, and only the last is kept
    pieces = [stride] if stride <= most else [most] * (stride // most) + [stride % most] * (stride % most > 0)
    done = 0
    while done < kept:
        size = min(chunk, kept - done)
        for piece in pieces:
            out = np.array(_marcher(step, piece, size, runs)(np.vstack([now, p.T])))
            out = out.reshape(len(now), runs, size)
            now = out[:, :, -1]
        x[:, 1 + done : 1 + done + size] = out[1:].transpose(1, 2, 0)
        done += size
        if not np.isfinite(now).all(axis=0).any():  # nothing is left to simulate
            x[:, 1 + done :] = np.nan
            done = kept
        tell(done / kept)


@lru_cache(maxsize=64)
def _marcher(step: Step, stride: int, kept: int, runs: int) -> ca.Function:
    """[k; x; p] to [k; x] at `kept` times, `stride` steps apart, all side by side, for each run."""
    z = ca.SX.sym("z", 1 + step.states.size + step.parameters.size)
    k, x, p = ca.vertsplit(z, [0, 1, 1 + step.states.size, z.numel()])
    one = ca.Function(
        "workbench_one", [z], [ca.vertcat(k + 1, step.F(k, x, p, ca.SX.zeros(step.w.shape)), p)], {"cse": True}
    )
    start = ca.MX.sym("start", z.numel())
    states = one.fold(stride).mapaccum(kept)(start)[: 1 + step.states.size, :]
    march = ca.Function("workbench_march", [start], [states])
    return march if runs == 1 else march.map(runs, "thread", min(runs, 8))
