"""B runs of a `Step`, each with its own parameters and initial state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.core import Step
from workbench.core.layout import Array, numbers
from workbench.simulate import virtual_machine
from workbench.simulate.divergence import find_divergence, second_opinion
from workbench.simulate.trajectories import Trajectories

Progress = Callable[[float], None]
March = Callable[[Step, Array, Array, int, Progress], None]

LARGEST = 4 * 2**30  # bytes of trajectories, and of what is needed beside them, that are not refused


def simulate(
    step: Step,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float | None = None,
    progress: Progress | None = None,
    engine: str | None = None,
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
    engine
        "native" is compiled for this processor, "casadi" is CasADi's virtual machine: several
        times slower for one run, about a hundred times for many. Without a name it is the first
        that can run the step. "native" knows no sine of an angle beyond 1e12 rad; whatever it calls
        diverged, "casadi" repeats from the last finite kept state, and continues if it stays finite.

    Raises
    ------
    ValueError
        If `step` is none, a number is out of its bounds, a shape is wrong, a time is no multiple of
        the step, or the trajectories would not fit into memory (what an engine needs beside them
        does not grow with the horizon). A run that diverges is no error: it is marked.
    """
    p_rows, x_rows = _rows(step, p, x0)
    stride, kept = _plan(step, p_rows, until, every)
    march = _engine(step, engine)
    x = np.empty((len(x_rows), kept + 1, step.states.size))
    x[:, 0] = x_rows
    march(step, x, p_rows, stride, progress or (lambda share: None))
    if march is not virtual_machine.march:
        second_opinion(step, x, p_rows, stride)
    diverged_at = find_divergence(step, x, p_rows, stride)
    return Trajectories(step, np.asarray(np.arange(kept + 1) * stride * step.h), x, p_rows, diverged_at)


def _rows(step: Step, p: Array | None, x0: Array | None) -> tuple[Array, Array]:
    """Parameters and initial states, checked, with one row a run each."""
    if not isinstance(step, Step):
        raise ValueError(
            f"`simulate(step, ...)` must be a `Step`; got {type(step).__name__}. Wrap an `Ode` in `rk4(ode, h)`."
        )
    tables = []
    for name, layout, given in (("p", step.parameters, p), ("x0", step.states, x0)):
        try:
            rows = np.atleast_2d(layout.default if given is None else numbers(given))
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
    return np.repeat(tables[0], max(runs) // len(tables[0]), 0), np.repeat(tables[1], max(runs) // len(tables[1]), 0)


def _plan(step: Step, p_rows: Array, until: float, every: float | None) -> tuple[int, int]:
    """How many steps lie between two kept times, and how many such times there are; refused if they do not fit."""
    stride = 1 if every is None else _count("every", every, step.h)
    count = _count("until", until, step.h)
    if count % stride:
        raise ValueError(
            f"`simulate(until=...)` must be a multiple of `every` = {stride * step.h:g} s; got {until:g} s."
        )
    kept = count // stride
    need = 8 * (len(p_rows) * (kept + 1) * step.states.size + p_rows.size)
    need += virtual_machine.working_set(step, len(p_rows))
    if need > LARGEST:
        raise ValueError(
            f"`simulate(...)` would need {need / 2**30:.1f} GB of memory for its states; "
            f"the limit is {LARGEST / 2**30:.0f} GB. "
            "Keep fewer times with `every`, or run fewer at once."
        )
    return stride, kept


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


def _engine(step: Step, engine: str | None) -> March:
    """The compiled march where it can be had, CasADi's elsewhere; by name, that one or a refusal."""
    if engine not in (None, "native", "casadi"):
        raise ValueError(f"`simulate(engine=...)` is 'native', 'casadi' or None for the best of them; got {engine!r}.")
    if engine == "casadi":
        return virtual_machine.march
    try:
        from workbench.simulate import native

        native.graph(step)
    except (ImportError, ValueError) as error:  # no wheel of llvmlite for this platform; an operation it does not know
        if engine == "native":
            raise ValueError(f"`simulate(engine='native')` cannot run this step: {error}") from error
        return virtual_machine.march
    return native.march
