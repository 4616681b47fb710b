"""The simulation of B runs of a `StepMap`, each with its own parameters and initial state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench.core import Layout, StepMap
from workbench.core.switches import DENSEST
from workbench.core.validation import refusals
from workbench.core.validation.permission import refuse_in_pages
from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import answer
from workbench.engine.arithmetic import arithmetic_of, march_of
from workbench.engine.divergence import find_divergence
from workbench.engine.job import Job, Progress, stop_check
from workbench.engine.kernel.noise import STEP_BITS
from workbench.engine.state_bounds import StateExtremes, watch_memory, with_watch
from workbench.engine.trajectories import Trajectories

LARGEST_COPY = 64 * 2**20  # bytes of rows that are copied; larger ones are taken as they are, for want of room
LARGEST = 4 * 2**30  # bytes of trajectories that are not refused
LONGEST = 100 * 3600.0  # s of one processor's time, by a cautious estimate, that are not refused
SECONDS_PER_OPERATION = 1e-10  # of one run in the compiled march, to be told before the start


def run_step(
    step: StepMap,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float | None = None,
    seed: int = 0,
    noise_keys: Integers | None = None,
    progress: Progress | None = None,
    arithmetic: str | None = None,
    engine: str | None = None,
) -> Trajectories:
    """Run B copies of a step, as `simulate` says."""
    refuse_in_pages("simulate(...)")
    tell = progress_of("simulate", progress)
    p_rows, x_rows = rows_of("simulate", step, p, x0, least=1 if noise_keys is None else max(1, noise_keys.size))
    stride, kept = _row_spacing(step, p_rows, until, every)
    rounding = arithmetic_of(step, arithmetic, engine)
    job = Job(step, p_rows, stride, *_keys(seed, noise_keys, len(p_rows)), arithmetic=rounding)
    march, n = march_of(job, engine), step.states.size
    watched = job if stride == 1 else replace(job, step=with_watch(step))  # where all are kept, they tell themselves
    x = np.empty((len(x_rows), kept + 1, watched.step.states.size))
    x[:, 0, :n], x[:, 0, n:] = x_rows, watched.step.states.default[n:]
    march(watched, x, tell)
    divergence = find_divergence(watched, x, march)
    t = np.asarray(np.arange(kept + 1) * stride * step.h)
    if watched.step is step:
        return Trajectories(job, t, x, divergence)
    extremes = StateExtremes.of_totals(step, step.states, watch_memory(step.states), x[:, -1, n:])
    return Trajectories(job, t, np.ascontiguousarray(x[..., :n]), divergence, extremes=extremes)


def _keys(seed: int, noise_keys: Integers | None, count: int) -> tuple[int, Integers]:
    seed = refusals.seed("simulate(seed=...)", seed)
    if noise_keys is None:
        return seed, np.arange(count)
    if noise_keys.shape != (count,) or (noise_keys < 0).any():
        must = f"{count} whole numbers from 0 on, one to name each run, below 2^63"
        raise refusals.refusal("simulate(noise_keys=...)", must, noise_keys.tolist())
    return seed, noise_keys


def table_of(call: str, layout: Layout, rows: Array | None) -> Array:
    """Rows (B, size) of a layout, copied unless they are large; one row of its defaults if none are given."""
    rows = np.atleast_2d(layout.default if rows is None else rows)
    if rows.ndim != 2 or rows.shape[1] != layout.size:
        raise ValueError(
            f"`{call}` takes one row per run: (B, {layout.size}). Got {rows.shape}. "
            "`pack({...})` of the layout makes such rows from names."
        )
    if len(rows) == 0:
        raise ValueError(f"`{call}` needs at least one run; got no rows.")
    layout.check(rows)
    return rows if rows.nbytes > LARGEST_COPY else rows.copy()


def rows_of(call: str, step: StepMap, p: Array | None, x0: Array | None, least: int = 1) -> tuple[Array, Array]:
    """Parameters and initial states, checked in the name of a call, with one row a run each and `least` runs."""
    if not step.states.size:
        raise ValueError(
            f"`{call}(...)` must have a step with at least one state, as nothing else moves; '{step.flow.name}' has "
            "none: take its `outputs_at(t, x)`."
        )
    tables = (table_of(f"{call}(p=...)", step.parameters, p), table_of(f"{call}(x0=...)", step.states, x0))
    runs = {len(rows) for rows in tables}
    if len(runs - {1}) > 1:
        raise ValueError(f"`{call}(...)` got {len(tables[0])} rows of p and {len(tables[1])} rows of x0.")
    count = max(runs) if max(runs) > 1 else least
    first, second = (np.broadcast_to(rows, (count, rows.shape[1])) for rows in tables)
    return first, second


def progress_of(call: str, progress: Progress | None) -> Progress:
    """The function that is told the share that is done; it is told 0 first, so that one that fails costs no run."""
    look = stop_check()
    if progress is None:
        return lambda share: look()
    must = "be a function of the share that is done, from 0 to 1"
    answer(f"{call}(progress=...)", must, lambda: progress(0.0), lambda given: given)

    def tell(share: float) -> None:
        look()
        progress(share)

    return tell


def _row_spacing(step: StepMap, p_rows: Array, until: float, every: float | None) -> tuple[int, int]:
    """The number of steps between two kept times, and of such times; refused if they do not fit."""
    until = refusals.seconds("simulate(until=...)", until)
    step.flow.refuse_beyond("simulate(until=...)", until)
    refuse_dense(step, p_rows)
    count = refusals.multiple("simulate(until=...)", until, step.h, "the step")
    stride = 1
    if every is not None:
        stride = refusals.multiple(
            "simulate(every=...)", refusals.seconds("simulate(every=...)", every), step.h, "the step"
        )
    if count % stride:
        raise ValueError(
            f"`simulate(until=...)` must be a multiple of `every` = {stride * step.h:g} s; got {until:g} s."
        )
    kept = count // stride
    if step.recorded_numbers is not None and count > len(step.recorded_numbers):
        raise ValueError(
            f"`simulate(until=...)` must be at most the {len(step.recorded_numbers)} steps that are recorded of "
            f"'{step.flow.name}'; got {count}."
        )
    if step.noises and count > 2**STEP_BITS:
        raise ValueError(
            f"`simulate(until=...)` of a noisy step takes at most 2^{STEP_BITS} steps, as its noise would repeat; "
            f"got {count}."
        )
    afford(step, len(p_rows), count, kept)
    return stride, kept


def refuse_dense(step: StepMap, p_rows: Array) -> None:
    """Refuse a step with more switches of one kind than it can be divided at."""
    spacing = step.flow.switches.densest(p_rows)
    if spacing * DENSEST < step.h:
        raise ValueError(
            f"`simulate(step, ...)` must have at most {DENSEST} switches of one kind in a step; '{step.flow.name}' "
            f"switches every {spacing:g} s and the step is {step.h:g} s: take a shorter step, or longer pulses."
        )


def afford(step: StepMap, runs: int, count: int, kept_rows: int) -> None:
    """Refuse a batch that does not fit into memory, or that takes far too long."""
    need = 8 * runs * (kept_rows + 1) * step.states.size
    if need > LARGEST:
        raise ValueError(
            f"`simulate(...)` would need {need / 2**30:.3g} GB of memory for its states; "
            f"the limit is {LARGEST / 2**30:.0f} GB. "
            "Keep fewer times with `every`, or run fewer at once."
        )
    time = SECONDS_PER_OPERATION * runs * count * step.operations
    if time > LONGEST:
        raise ValueError(
            f"`simulate(...)` would take about {time / 3600:.0f} hours of one processor for {runs} runs of {count} "
            f"steps; the limit is {LONGEST / 3600:.0f}. Take a longer step, fewer runs, or a part of them at a time."
        )
