"""The compiled march: blocks of runs through one native function, several blocks at once."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.core import Step
from workbench.core.layout import Array
from workbench.simulate import llvm
from workbench.simulate.graph import Graph
from workbench.simulate.lowering import lower
from workbench.simulate.plan import Plan

STEPS_PER_CALL = 20_000  # between two looks at progress; the tables of time are that long
ALIGNMENT = 64  # bytes: what the widest vector loads ask for


@dataclass(frozen=True, eq=False)
class Kernel:
    """A compiled step: which of its values are made outside, and the function that does the rest."""

    plan: Plan
    width: int
    function: llvm.Native


@lru_cache(maxsize=128)
def kernel(step: Step, varied: tuple[int, ...]) -> Kernel:
    """The kernel of a step where the parameters `varied` differ from run to run."""
    plan, width = Plan.of(graph(step), varied), llvm.lanes()
    return Kernel(plan, width, llvm.compiled(lower(plan, width)))


@lru_cache(maxsize=128)
def graph(step: Step) -> Graph:
    """The graph of a step, made once."""
    return Graph.of(step)


def march(step: Step, x: Array, p: Array, stride: int, tell: Callable[[float], None], begin: int = 0) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0], the states at step `begin`, with those every `stride` steps.

    The parameters p are (B, np).
    """
    varied = tuple(int(i) for i in np.flatnonzero((p != p[:1]).any(axis=0)))
    made, kept = kernel(step, varied), x.shape[1] - 1
    starts = range(0, len(x), made.width)
    blocks = [_Block(made, x[i : i + made.width, 0], p[i : i + made.width]) for i in starts]
    chunk = max(1, min(kept, STEPS_PER_CALL // stride))
    with ThreadPoolExecutor(min(len(blocks), os.cpu_count() or 1)) as pool:
        for first in range(0, kept, chunk):
            size = min(chunk, kept - first)
            outs = [x[i : i + made.width, 1 + first : 1 + first + size] for i in starts]
            # a stride longer than a table takes several calls, of which the last one's state stays
            for k in range(0, size * stride, STEPS_PER_CALL):
                steps = min(STEPS_PER_CALL, size * stride - k)
                table = _table(made.plan, p, begin + first * stride + k, steps)
                by = min(stride, steps)
                list(pool.map(lambda b, o, t=table, by=by: b.march(t, by, o), blocks, outs))
            tell((first + size) / kept)
            if not np.isfinite(x[:, first + size]).all(axis=1).any():  # nothing is left to simulate
                x[:, 1 + first + size :] = np.nan
                tell(1.0)
                break


def _table(plan: Plan, p: Array, first: int, steps: int) -> Array:
    """What depends on time only, (steps, nt), for the steps from `first` on."""
    _, _, per_step = plan.evaluated(p[:1], np.arange(first, first + steps, dtype=float))
    columns = [np.broadcast_to(per_step[place], (steps,)) for place in plan.table]
    return np.ascontiguousarray(np.stack(columns, axis=1)) if columns else np.zeros((steps, 1))


class _Block:
    """The memory of up to `width` runs side by side; a block that is not full repeats its last run."""

    def __init__(self, made: Kernel, x: Array, p: Array) -> None:
        self.made, self.runs = made, len(x)
        fill = [*range(len(x)), *([len(x) - 1] * (made.width - len(x)))]
        once, per_run, _ = made.plan.evaluated(p[fill], np.zeros(1))
        self.x = _aligned(x[fill].T)
        self.lanes = _aligned(np.stack([per_run[i] for i in made.plan.lanes]) if made.plan.lanes else np.zeros(1))
        self.uniform = _aligned(np.array([float(once[i]) for i in made.plan.uniform] or [0.0]))

    def march(self, table: Array, stride: int, kept: Array) -> None:
        """Fill the states (runs, times, nx) of the next times; the block is then at the last of them."""
        out = _aligned(np.empty((kept.shape[1], *self.x.shape)))
        pointers = (array.ctypes.data for array in (self.x, self.lanes, self.uniform, table, out))
        self.made.function.march(kept.shape[1], stride, *pointers)
        kept[...] = out.transpose(2, 0, 1)[: self.runs]


def _aligned(array: Any) -> Array:
    """The same numbers in memory that begins at a multiple of the alignment."""
    array = np.asarray(array, dtype=float)
    room = np.empty(array.size + ALIGNMENT // 8)
    start = (-room.ctypes.data % ALIGNMENT) // 8
    result = room[start : start + array.size].reshape(array.shape)
    result[...] = array
    return result
