"""B runs of a `Step` through CasADi's own machine: simple and exact."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from workbench.core import Step
from workbench.core.layout import Array
from workbench.simulate.trajectories import Trajectories

Progress = Callable[[float], None]

STEPS_PER_CALL = 20_000  # between two looks at progress and divergence: about a tenth of a second
LARGEST = 4 * 2**30  # bytes of trajectories that are not refused


def simulate(
    step: Step,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float | None = None,
    progress: Progress | None = None,
) -> Trajectories:
    """Run B copies of `step` from time 0 to `until`, each with its own parameters and initial state.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx), as made by `step.parameters.pack` and `step.states.pack`; one row
        serves all runs.
    until, every
        The horizon and the distance of the times that are kept, in s: multiples of the step.
    progress
        Called now and then with the share that is done.

    Raises
    ------
    ValueError
        If a number is out of its bounds, a shape is wrong, a time is no multiple of the step, or
        the trajectories would not fit into memory. A run that diverges is no error: it is marked.
    """
    p_rows, x_rows = _rows(step, p, x0)
    stride = 1 if every is None else _count("every", every, step.h)
    count = _count("until", until, step.h)
    if count % stride:
        raise ValueError(
            f"`simulate(until=...)` must be a multiple of `every` = {stride * step.h:g} s; got {until:g} s."
        )
    kept = count // stride
    if (need := 8 * len(x_rows) * (kept + 1) * step.states.size) > LARGEST:
        raise ValueError(
            f"`simulate(...)` would keep {need / 2**30:.1f} GB of states; the limit is {LARGEST / 2**30:.0f} GB. "
            "Keep fewer times with `every`, or run fewer at once."
        )
    z = np.vstack([np.zeros((1, len(x_rows))), x_rows.T, p_rows.T])
    states = _march(step, z, stride, kept, progress)
    x = np.concatenate([x_rows[:, np.newaxis], states], axis=1)
    diverged_at = _find_divergence(step, x, p_rows, stride)
    return Trajectories(step, np.asarray(np.arange(kept + 1) * stride * step.h), x, p_rows, diverged_at)


def _rows(step: Step, p: Array | None, x0: Array | None) -> tuple[Array, Array]:
    """Parameters and initial states, checked, with one row a run each."""
    tables = []
    for name, layout, given in (("p", step.parameters, p), ("x0", step.states, x0)):
        rows = np.atleast_2d(layout.default if given is None else np.asarray(given, dtype=float))
        if rows.ndim != 2 or rows.shape[1] != layout.size:
            raise ValueError(
                f"`simulate({name}=...)` takes one row per run: (B, {layout.size}). Got {rows.shape}. "
                "`pack({...})` of the layout makes such rows from names."
            )
        layout.check(rows)
        tables.append(rows)
    runs = {len(rows) for rows in tables}
    if len(runs - {1}) > 1:
        raise ValueError(f"`simulate(...)` got {len(tables[0])} rows of p and {len(tables[1])} rows of x0.")
    return np.repeat(tables[0], max(runs) // len(tables[0]), 0), np.repeat(tables[1], max(runs) // len(tables[1]), 0)


def _count(name: str, span: Any, h: float) -> int:
    """How many steps make up a span of time."""
    try:
        seconds = float(span)
    except (TypeError, ValueError):
        raise ValueError(f"`simulate({name}=...)` must be a number of seconds; got {span!r}.") from None
    if not (np.isfinite(seconds) and seconds > 0):
        raise ValueError(f"`simulate({name}=...)` must be a positive, finite number of seconds; got {seconds:g}.")
    count = round(seconds / h)
    # 1e-6 of a step: what the rounding of span / h can do at a billion steps
    if count < 1 or abs(seconds / h - count) > 1e-6 * max(1.0, count * 1e-6):
        raise ValueError(f"`simulate({name}=...)` must be a multiple of the step {h:g} s; got {seconds:g} s.")
    return count


@lru_cache(maxsize=64)
def _marcher(step: Step, stride: int, kept: int, runs: int) -> ca.Function:
    """[k; x; p] through `kept` times `stride` steps, all kept ones side by side, for each run."""
    z = ca.SX.sym("z", 1 + step.states.size + step.parameters.size)
    k, x, p = ca.vertsplit(z, [0, 1, 1 + step.states.size, z.numel()])
    one = ca.Function("workbench_one", [z], [ca.vertcat(k + 1, step.F(k, x, p), p)], {"cse": True})
    march = one.fold(stride).mapaccum(kept)
    return march if runs == 1 else march.map(runs, "thread", min(runs, 8))


def _march(step: Step, z: Array, stride: int, kept: int, progress: Progress | None) -> Array:
    """The kept states (B, kept, nx)."""
    nx, runs = step.states.size, z.shape[1]
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
        if progress is not None:
            progress(done / kept)
    return np.concatenate(parts, axis=1)


def _find_divergence(step: Step, x: Array, p: Array, stride: int) -> Array:
    """The time of the first step that is not finite in each run; its later rows in x become NaN."""
    at = np.full(len(x), np.nan)
    for run in np.flatnonzero(~np.isfinite(x).all(axis=(1, 2))):
        first = int(np.argmin(np.isfinite(x[run]).all(axis=1)))
        state, k = x[run, first - 1], (first - 1) * stride
        while np.isfinite(state).all():
            state, k = np.array(step.F(k, state, p[run])).ravel(), k + 1
        at[run] = k * step.h
        x[run, first:] = np.nan
    return at
