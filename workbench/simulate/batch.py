"""B runs of a `Step`, each with its own parameters and initial state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from workbench.core import Step
from workbench.core.numbers import Array, Integers, numbers
from workbench.simulate.divergence import find_divergence
from workbench.simulate.job import Job, March
from workbench.simulate.job import Progress as Progress
from workbench.simulate.kernel import numpy_kernel, virtual_machine
from workbench.simulate.kernel.noise import STEP_BITS
from workbench.simulate.kernel.plan import Plan
from workbench.simulate.trajectories import Trajectories

LARGEST = 4 * 2**30  # bytes of trajectories, and of what is needed beside them, that are not refused
LONGEST = 100 * 3600.0  # s of one processor's time, by a cautious estimate, that are not refused
SECONDS_PER_OPERATION = 1e-10  # of one run in the compiled march, to be told before the start
FEW_RUNS = 64  # up to so many, CasADi's machine is faster than NumPy


def simulate(
    step: Step,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float | None = None,
    seed: int = 0,
    runs: Array | None = None,
    progress: Progress | None = None,
    engine: str | None = None,
) -> Trajectories:
    """Run B copies of `step` from time 0 to `until`, each with its own parameters and initial state.

    What a run gives depends on its own rows of p and x0, its key in `runs` and the seed alone: not on its
    neighbours, its place, the number of threads or the width of this processor's vectors.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx), as `step.parameters.pack` and `step.states.pack` make them; one row serves all.
    until, every
        The horizon and the distance of the kept times, in s: multiples of the step. With `every=until`
        only the end is kept, and memory does not grow with the horizon.
    seed, runs
        The keys of the noise of a noisy step: a whole number, and (B,) whole numbers that name the
        runs, 0, 1, 2, ... unless they are given.
    progress
        Called now and then with the share that is done.
    engine
        "native" is compiled for this processor; "numpy" runs everywhere, some twenty times slower;
        "casadi" is CasADi's virtual machine, several times slower for one run, a hundred times for many.
        Without a name it is the first that can run the step. What "native" calls diverged, "casadi"
        judges, and continues if it stays finite: the first knows no sine beyond 1e12 rad.

    Raises
    ------
    ValueError
        If `step` is none, a number is out of its bounds, a shape is wrong, a time is no multiple of the
        step, or the runs would take too much memory or time. A run that diverges is no error: it is marked.
    """
    p_rows, x_rows = _rows(step, p, x0)
    stride, kept = _plan(step, p_rows, until, every)
    job = Job(step, p_rows, stride, *_keys(seed, runs, len(p_rows)))
    march = march_of(job, engine)
    x = np.empty((len(x_rows), kept + 1, step.states.size))
    x[:, 0] = x_rows
    march(job, x, progress or (lambda share: None))
    divergence = find_divergence(job, x, march)
    return Trajectories(job, np.asarray(np.arange(kept + 1) * stride * step.h), x, divergence)


def continued(job: Job, x: Array, begin: int, steps: int) -> Array:
    """The states (B, nx) of a job's runs `steps` steps after those in x (B, nx), which are at step `begin`."""
    job = replace(job, stride=steps, begin=begin)
    rows = np.stack([x, x], axis=1)
    march_of(job)(job, rows, lambda share: None)
    return np.asarray(rows[:, 1])


def _keys(seed: Any, runs: Any, count: int) -> tuple[int, Integers]:
    """The keys of the noise, checked; their range is checked where they are used."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**64:
        raise ValueError(f"`simulate(seed=...)` must be a whole number from 0 to 2^64 - 1; got {seed!r}.")
    if runs is None:
        return int(seed), np.arange(count)
    keys = np.asarray(runs)
    if keys.shape != (count,) or keys.dtype.kind not in "iu" or (keys < 0).any():
        raise ValueError(
            f"`simulate(runs=...)` must be {count} whole numbers from 0 on, one to name each run; got {runs!r}."
        )
    return int(seed), keys.astype(np.int64)


def _rows(step: Step, p: Array | None, x0: Array | None) -> tuple[Array, Array]:
    """Parameters and initial states, checked, with one row a run each."""
    if not isinstance(step, Step):
        raise ValueError(
            f"`simulate(step, ...)` must be a `Step`; got {type(step).__name__}. Wrap an `Ode` in `rk4(ode, h)`."
        )
    tables = []
    for name, layout, given in (("p", step.parameters, p), ("x0", step.states, x0)):
        try:
            held = isinstance(given, np.ndarray) and given.dtype == float  # not copied: a million rows are 300 MB
            rows = np.atleast_2d(layout.default if given is None else given if held else numbers(given))
        except (TypeError, ValueError):
            raise ValueError(f"`simulate({name}=...)` must be rows of numbers; got {given!r}.") from None
        if len(rows) == 0:
            raise ValueError(f"`simulate({name}=...)` needs at least one run; got no rows.")
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
    first, second = (np.broadcast_to(rows, (max(runs), rows.shape[1])) for rows in tables)
    return first, second


def _plan(step: Step, p_rows: Array, until: float, every: float | None) -> tuple[int, int]:
    """How many steps lie between two kept times, and how many such times there are; refused if they do not fit."""
    stride = 1 if every is None else _count("every", every, step.h)
    count = _count("until", until, step.h)
    if count % stride:
        raise ValueError(
            f"`simulate(until=...)` must be a multiple of `every` = {stride * step.h:g} s; got {until:g} s."
        )
    kept = count // stride
    if step.w.numel() and count > 2**STEP_BITS:
        raise ValueError(
            f"`simulate(until=...)` of a noisy step takes at most 2^{STEP_BITS} steps, as its noise would repeat; "
            f"got {count}."
        )
    _afford(step, p_rows, count, kept)
    return stride, kept


def _afford(step: Step, p_rows: Array, count: int, kept: int) -> None:
    """Refuse what would not fit into memory, or would not end this week."""
    runs = len(p_rows)
    need = 8 * runs * (kept + 1) * step.states.size + virtual_machine.working_set(step, min(runs, FEW_RUNS))
    if need > LARGEST:
        raise ValueError(
            f"`simulate(...)` would need {need / 2**30:.1f} GB of memory for its states; "
            f"the limit is {LARGEST / 2**30:.0f} GB. "
            "Keep fewer times with `every`, or run fewer at once."
        )
    time = SECONDS_PER_OPERATION * runs * count * step.F.n_instructions()
    if time > LONGEST:
        raise ValueError(
            f"`simulate(...)` would take about {time / 3600:.0f} hours of one processor for {runs} runs of {count} "
            f"steps; the limit is {LONGEST / 3600:.0f}. Take a longer step, fewer runs, or a part of them at a time."
        )


def seconds(name: str, span: Any) -> float:
    """A span of time, or a refusal."""
    try:
        time = float(numbers(span).reshape(()))
    except (TypeError, ValueError):
        raise ValueError(f"`simulate({name}=...)` must be a number of seconds; got {span!r}.") from None
    if not (np.isfinite(time) and time > 0):
        raise ValueError(f"`simulate({name}=...)` must be a positive, finite number of seconds; got {time:g}.")
    return time


def _count(name: str, span: Any, h: float) -> int:
    """How many steps make up a span of time."""
    time = seconds(name, span)
    count = round(time / h)
    # 1e-6 of a step: what the rounding of span / h can do at a billion steps
    if count < 1 or abs(time / h - count) > 1e-6 * max(1.0, count * 1e-6):
        raise ValueError(f"`simulate({name}=...)` must be a multiple of the step {h:g} s; got {time:g} s.")
    return count


def march_of(job: Job, engine: str | None = None) -> March:
    """The compiled march where it can be had, another elsewhere; by name, that one or a refusal."""
    if engine not in (None, "native", "numpy", "casadi"):
        raise ValueError(
            f"`simulate(engine=...)` is 'native', 'numpy', 'casadi' or None for the best of them; got {engine!r}."
        )
    if engine == "casadi":
        return virtual_machine.march
    try:
        Plan.of_step(job.step, job.varied)
    except ValueError as error:  # an operation that the graph does not know
        if engine is not None:
            raise ValueError(f"`simulate(engine='{engine}')` cannot run this step: {error}") from error
        return virtual_machine.march
    if engine == "numpy":
        return numpy_kernel.march
    try:
        return _native()
    except ImportError as error:
        if engine == "native":
            raise ValueError(f"`simulate(engine='native')` cannot run here: {error}.") from error
        return virtual_machine.march if len(job.p) <= FEW_RUNS else numpy_kernel.march


def _native() -> March:
    """The compiled march; an ImportError where nothing can be compiled."""
    from workbench.simulate.kernel import llvm, native

    if not llvm.has_fma():
        raise ImportError("this processor has no fused multiply-add")
    return native.march
