"""The compiled march: blocks of runs through one native function, several lots of blocks at once."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from math import prod
from weakref import WeakKeyDictionary

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.engine.job import BLOCKS_OF_A_LOT, Job, JobPiece, Progress, lots, parallel_map, stages
from workbench.engine.kernel import llvm
from workbench.engine.kernel.loop_emission import waits_in_loops
from workbench.engine.kernel.lowering import lower
from workbench.engine.kernel.plan import KernelPlan

FEW = 4  # runs that are served faster by vectors of so many
WORTH_COMPILING = 400_000  # steps of blocks, done and to be done, in which better code gains what it costs
ALIGNMENT = 128  # bytes: what the widest vector loads ask for


# The steps of blocks that each plan has marched in this process.
_steps_marched: WeakKeyDictionary[KernelPlan, int] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Kernel:
    """A compiled step: which of its values are made outside the loop, and the functions of `lowering`."""

    plan: KernelPlan
    width: int
    table: Callable[..., None] | None
    piece: Callable[..., bool]


@lru_cache(maxsize=256)
def kernel(plan: KernelPlan, width: int, haste: bool = False, fused_products: bool = True) -> Kernel:
    """The kernel of a plan, `width` runs side by side, with `fused_products` or without; in `haste` slower code."""
    module = llvm.compile_module(_ir(plan, width, fused_products), haste)
    number, pointer = ctypes.c_int64, ctypes.c_void_p
    pointers = [pointer] * (8 if plan.record_size else 7)
    piece = module.function("workbench_piece", *[number] * 7, *pointers, result=ctypes.c_bool)
    table = module.function("workbench_table", *[number] * 2, *[pointer] * 3) if plan.table else None
    return Kernel(plan, width, table, piece)


_ir = lru_cache(maxsize=16)(lower)


def march(job: Job, x: Array, tell: Progress, width: int | None = None) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps, `width` runs side by side."""
    job.check(x)
    kept, width = x.shape[1] - 1, width or (FEW if len(x) <= FEW else llvm.lanes())
    made = _kernel(job, kept, width)
    width, parts = made.width, lots(job, made.width)
    done, total = 0.0, kept * job.stride

    def advance(stage: list[JobPiece], lot: slice) -> None:
        _advance(made, job, lot, x[lot], stage)

    with parallel_map(len(parts)) as each:
        for stage in stages(job, kept, width * min(BLOCKS_OF_A_LOT, -(-len(x) // width))):
            length = sum(piece.length for piece in stage)
            for _ in each(partial(advance, stage), parts):
                done += length / len(parts)
                tell(min(done / total, 1.0))
            last = stage[-1].row + stage[-1].rows
            if stage[-1].whole and not np.isfinite(x[:, last - 1]).all(axis=1).any():  # nothing is left to simulate
                x[:, last:] = np.nan
                tell(1.0)
                break


def _kernel(job: Job, kept_rows: int, width: int) -> Kernel:
    """The kernel of a job, compiled with few optimisations as long as its plan has marched little.

    Where the values of loops wait for each other, two vectors of a register's length side by side use it better.
    """
    plan, runs = job.plan, len(job.p)
    steps = _steps_marched.get(plan, 0) + -(-runs // width) * kept_rows * job.stride
    _steps_marched[plan] = steps
    haste = steps < WORTH_COMPILING
    pairs = runs > width == llvm.lanes() and not haste and waits_in_loops(plan.graph)
    return kernel(plan, 2 * width if pairs else width, haste, job.fused_products)


def _advance(compiled_kernel: Kernel, job: Job, lot: slice, x: Array, stage: list[JobPiece]) -> None:
    """Fill the rows of a stage in x (runs, rows, nx); a block that is not full repeats its last run."""
    runs, _, nx = x.shape
    plan, width, blocks = compiled_kernel.plan, compiled_kernel.width, -(-runs // compiled_kernel.width)
    fill = np.minimum(np.arange(blocks * width), runs - 1)

    def lanes(rows: Array) -> Array:
        return _align(rows[fill].reshape(blocks, width, -1).transpose(0, 2, 1))

    first, end = stage[0].row, stage[-1].row + stage[-1].rows
    state, keys, p = lanes(x[:, stage[0].start]), job.runs[lot][fill], _room(blocks, len(plan.parameters), width)
    p[...] = job.p[lot.start, list(plan.parameters), np.newaxis]
    for i in plan.parameters.keys() & set(job.varied_parameters):
        p[:, plan.parameters[i]] = job.p[lot, i][fill].reshape(blocks, width)
    groups = max(-(-piece.length // width) for piece in stage)
    out = _room(blocks, end - first, nx, width)
    scratch, table = _room(plan.scratch, width), _room(groups, len(plan.table), width)
    # all of it is held while the march runs
    memory = (_align(keys), _constants(plan, job.step.h), p, scratch, table, state, out)
    places = [array.ctypes.data for array in memory]
    seed, done = job.seed - (job.seed >> 63 << 64), end
    for piece in stage:
        if compiled_kernel.table:
            compiled_kernel.table(-(-piece.length // width), piece.begin, *places[1:3], places[4])
        row = piece.row - first
        counts = (blocks, piece.rows, piece.steps, piece.begin, row, end - first, seed)
        numbers = [job.record[piece.begin :].ctypes.data] if plan.record_size else []
        alive = compiled_kernel.piece(*counts, *places, *numbers)
        if piece.whole and not alive:  # no run is finite any more
            done = piece.row + piece.rows
            break
    x[:, first:end] = out.transpose(0, 3, 1, 2).reshape(-1, end - first, nx)[:runs]
    x[:, done:end] = np.nan


@lru_cache(maxsize=256)
def _constants(plan: KernelPlan, h: float) -> Array:
    return _align(np.array(plan.constants(h)))


def _room(*shape: int, kind: type[float | np.generic] = float) -> Array:
    """Memory of a shape, of numbers of 8 bytes, that begins at a multiple of the alignment."""
    size = prod(shape)
    room = np.empty(size + ALIGNMENT // 8, dtype=kind)
    start = (-room.ctypes.data % ALIGNMENT) // 8
    return room[start : start + size].reshape(shape)


def _align(array: Array | Integers) -> Array:
    room = _room(*array.shape, kind=array.dtype.type)
    room[...] = array
    return room
