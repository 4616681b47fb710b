"""The compiled march: blocks of runs through one native function, several lots of blocks at once."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from workbench.core.layout import Array
from workbench.simulate import llvm
from workbench.simulate.job import Job, Piece, Progress, crew, lots, pieces
from workbench.simulate.lowering import lower
from workbench.simulate.plan import Plan

FEW = 4
WORTH_COMPILING = 300_000  # steps of blocks, done and to be done, in which better code gains what it costs
ALIGNMENT = 64  # bytes: what the widest vector loads ask for


# How many steps of blocks each plan has marched in this process.
_marched: WeakKeyDictionary[Plan, int] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Kernel:
    """A compiled step: which of its values are made outside the loop, and the functions that do the work."""

    plan: Plan
    width: int
    march: Callable[..., None]
    table: Callable[..., None] | None
    constants: Array


@lru_cache(maxsize=256)
def kernel(plan: Plan, width: int, haste: bool = False) -> Kernel:
    """The kernel of a plan, `width` runs side by side; in `haste`, slower code with the same results."""
    module = llvm.compiled(_ir(plan, width), haste)
    number, pointer = ctypes.c_int64, ctypes.c_void_p
    return Kernel(
        plan,
        width,
        module.function("workbench_march", *[number] * 5, *[pointer] * 7),
        module.function("workbench_table", *[number] * 2, *[pointer] * 3) if plan.table else None,
        _aligned(np.array(plan.constants)),
    )


@lru_cache(maxsize=16)
def _ir(plan: Plan, width: int) -> str:
    return lower(plan, width)


def march(job: Job, x: Array, tell: Progress, width: int | None = None) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps.

    Vectors of `width` runs are as wide as the processor's unless it is given; few runs are served faster by half.
    """
    plan, width = Plan.of_step(job.step, job.varied), width or (llvm.lanes() if len(x) > FEW else FEW)
    todo = pieces(job, x.shape[1] - 1)
    blocks = -(-len(x) // width)
    with crew(blocks) as each:
        for done, piece in enumerate(todo):
            ahead = blocks * sum(later.rows * later.steps for later in todo[done:])
            made = kernel(plan, width, haste=_marched.get(plan, 0) + ahead < WORTH_COMPILING)
            _marched[plan] = _marched.get(plan, 0) + blocks * piece.rows * piece.steps
            chosen = job.p[0, list(plan.parameters)].tobytes()
            table, parts = _table(made, chosen, piece.begin, piece.rows * piece.steps), lots(job, piece, width)
            advanced = each(lambda lot, k=made, of=piece, t=table: _advance(k, job, lot, x[lot], of, t), parts)
            for n, _ in enumerate(advanced):
                tell((done + (n + 1) / len(parts)) / len(todo))
            last = piece.first + piece.rows
            if not np.isfinite(x[:, last - 1]).all(axis=1).any():  # nothing is left to simulate
                x[:, last:] = np.nan
                tell(1.0)
                break


@lru_cache(maxsize=4)  # the same runs from other starts, as in tuning, find it made
def _table(made: Kernel, p: bytes, begin: int, steps: int) -> Array:
    """What depends on time alone, (groups, nt, width), for some steps; p are the parameters of any run."""
    groups = -(-steps // made.width)
    table = _room(groups, len(made.plan.table), made.width)
    if made.table is not None:
        made.table(groups, begin, *_pointers(made.constants, _aligned(np.frombuffer(p)), table))
    return table


def _advance(made: Kernel, job: Job, lot: slice, x: Array, piece: Piece, table: Array) -> None:
    """Fill the rows of a piece in x (runs, rows, nx); a block that is not full repeats its last run."""
    runs, _, nx = x.shape
    blocks = -(-runs // made.width)
    fill = np.minimum(np.arange(blocks * made.width), runs - 1)

    def lanes(rows: Array) -> Array:
        return _aligned(rows[fill].reshape(blocks, made.width, -1).transpose(0, 2, 1))

    p, state = lanes(job.p[lot][:, list(made.plan.parameters)]), lanes(x[:, piece.start])
    keys = _aligned(job.runs[lot][fill])
    out, scratch = _room(blocks, piece.rows, nx, made.width), _room(len(made.plan.lanes), made.width)
    counts = (blocks, piece.rows, piece.steps, piece.begin, job.seed - (job.seed >> 63 << 64))
    made.march(*counts, *_pointers(keys, made.constants, p, scratch, table, state, out))
    x[:, piece.filled] = out.transpose(0, 3, 1, 2).reshape(-1, piece.rows, nx)[:runs]


def _room(*shape: int, kind: type[Any] = float) -> Array:
    """Memory of a shape, of numbers of 8 bytes, that begins at a multiple of the alignment."""
    size = int(np.prod(shape))
    room = np.empty(size + ALIGNMENT // 8, dtype=kind)
    start = (-room.ctypes.data % ALIGNMENT) // 8
    return room[start : start + size].reshape(shape)


def _aligned(array: Any) -> Array:
    """The same numbers in such memory."""
    room = _room(*array.shape, kind=array.dtype.type)
    room[...] = array
    return room


def _pointers(*arrays: Array) -> list[int]:
    return [array.ctypes.data for array in arrays]
