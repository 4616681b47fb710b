"""What a call of the batch may ask for: rows, keys, times, and what they cost."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core import Step
from workbench.core.numbers import Array, Integers, multiple, numbers, seconds
from workbench.simulate.kernel import virtual_machine
from workbench.simulate.kernel.noise import STEP_BITS

HOW = {"Sampled": "Take its `.step(substeps)`.", "ClosedLoop": "Take `rk4(loop.ode(), h)`, or `loop.sampled(period)`."}
LARGEST_COPY = 64 * 2**20  # bytes of rows that are copied; larger ones are taken as they are, for want of room
LARGEST = 4 * 2**30  # bytes of trajectories, and of what is needed beside them, that are not refused
LONGEST = 100 * 3600.0  # s of one processor's time, by a cautious estimate, that are not refused
MOST_STEPS = 2.0**53
SECONDS_PER_OPERATION = 1e-10  # of one run in the compiled march, to be told before the start


def keys_of(seed: Any, runs: Any, count: int) -> tuple[int, Integers]:
    """The keys of the noise, checked; their range is checked where they are used."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or not 0 <= seed < 2**64:
        raise ValueError(f"`simulate(seed=...)` must be a whole number from 0 to 2^64 - 1; got {seed!r}.")
    if runs is None:
        return int(seed), np.arange(count)
    try:
        keys = np.asarray(runs)
    except ValueError:  # rows of unequal length
        keys = np.zeros(())
    if keys.shape != (count,) or keys.dtype.kind not in "iu" or (keys < 0).any() or (keys > 2**63 - 1).any():
        raise ValueError(
            f"`simulate(runs=...)` must be {count} whole numbers from 0 on, one to name each run, below 2^63; "
            f"got {runs!r}."
        )
    return int(seed), keys.astype(np.int64)


def least_of(runs: Any) -> int:
    """How many runs these keys ask for at least."""
    try:
        return max(1, np.size(runs))
    except ValueError:  # rows of unequal length, which `keys_of` refuses
        return 1


def rows_of(call: str, step: Step, p: Array | None, x0: Array | None, least: int = 1) -> tuple[Array, Array]:
    """Parameters and initial states, checked in the name of a call, with one row a run each and `least` runs."""
    if not isinstance(step, Step):
        raise ValueError(
            f"`{call}(step, ...)` must be a `Step`; got {type(step).__name__}. "
            + HOW.get(type(step).__name__, "Wrap an `Ode` in `rk4(ode, h)`.")
        )
    tables = []
    for name, layout, given in (("p", step.parameters, p), ("x0", step.states, x0)):
        try:
            held = isinstance(given, np.ndarray) and given.dtype == float and given.nbytes > LARGEST_COPY
            rows = np.atleast_2d(layout.default if given is None else given if held else numbers(given))
        except (TypeError, ValueError):
            raise ValueError(f"`{call}({name}=...)` must be rows of numbers; got {given!r}.") from None
        if len(rows) == 0:
            raise ValueError(f"`{call}({name}=...)` needs at least one run; got no rows.")
        if rows.ndim != 2 or rows.shape[1] != layout.size:
            raise ValueError(
                f"`{call}({name}=...)` takes one row per run: (B, {layout.size}). Got {rows.shape}. "
                "`pack({...})` of the layout makes such rows from names."
            )
        layout.check(rows)
        tables.append(rows)
    runs = {len(rows) for rows in tables}
    if len(runs - {1}) > 1:
        raise ValueError(f"`{call}(...)` got {len(tables[0])} rows of p and {len(tables[1])} rows of x0.")
    count = max(runs) if max(runs) > 1 else least
    first, second = (np.broadcast_to(rows, (count, rows.shape[1])) for rows in tables)
    return first, second


def plan_of(step: Step, p_rows: Array, until: float, every: float | None) -> tuple[int, int]:
    """How many steps lie between two kept times, and how many such times there are; refused if they do not fit."""
    stride = 1 if every is None else _count_of("every", every, step.h)
    count = _count_of("until", until, step.h)
    if count % stride:
        raise ValueError(
            f"`simulate(until=...)` must be a multiple of `every` = {stride * step.h:g} s; got {until:g} s."
        )
    kept = count // stride
    if step.noises and count > 2**STEP_BITS:
        raise ValueError(
            f"`simulate(until=...)` of a noisy step takes at most 2^{STEP_BITS} steps, as its noise would repeat; "
            f"got {count}."
        )
    afford("simulate", step, p_rows, count, kept)
    return stride, kept


def afford(call: str, step: Step, p_rows: Array, count: int, kept: int) -> None:
    """Refuse what would not fit into memory, or would not end this week."""
    runs = len(p_rows)
    beside = virtual_machine.working_set(step, min(runs, virtual_machine.RUNS_AT_ONCE))
    need = 8 * runs * (kept + 1) * step.states.size + beside
    if need > LARGEST:
        raise ValueError(
            f"`{call}(...)` would need {need / 2**30:.3g} GB of memory for its states; "
            f"the limit is {LARGEST / 2**30:.0f} GB. "
            "Keep fewer times with `every`, or run fewer at once."
        )
    time = SECONDS_PER_OPERATION * runs * count * step.operations
    if time > LONGEST:
        raise ValueError(
            f"`{call}(...)` would take about {time / 3600:.0f} hours of one processor for {runs} runs of {count} "
            f"steps; the limit is {LONGEST / 3600:.0f}. Take a longer step, fewer runs, or a part of them at a time."
        )


def _count_of(name: str, span: Any, h: float) -> int:
    """How many steps make up a span of time."""
    call = f"simulate({name}=...)"
    span = seconds(call, span)
    if span / h >= MOST_STEPS:
        raise ValueError(
            f"`{call}` must be less than 2^53 steps of {h:g} s, as doubles count no further; got {span:g} s."
        )
    return multiple(call, span, h, "the step")
