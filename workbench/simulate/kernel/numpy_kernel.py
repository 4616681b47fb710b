"""The march in NumPy: the same graph, one operation on all runs after the other, in buffers used again and again.

It serves where nothing can be compiled, and it is what the compiled march is tested against.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.core.layout import Array
from workbench.simulate.job import Job, Piece, Progress, crew, pieces
from workbench.simulate.kernel.plan import Plan

RUNS_AT_ONCE = 8192  # the calls of an operation, which threads make one at a time, then cost little beside its work


def _fused(a: Any, b: Any, c: Any, out: Any = None) -> Any:
    return np.add(np.multiply(a, b, out=out), c, out=out)


def _fused_minus(a: Any, b: Any, c: Any, out: Any = None) -> Any:
    return np.subtract(np.multiply(a, b, out=out), c, out=out)


def _minus_fused(a: Any, b: Any, c: Any, out: Any = None) -> Any:
    return np.subtract(c, np.multiply(a, b, out=out), out=out)


def _choice(condition: Any, a: Any, b: Any, out: Any = None) -> Any:
    holds = np.not_equal(condition, 0)
    if out is None:
        return np.where(holds, a, b)
    np.copyto(out, b)
    np.copyto(out, a, where=holds)
    return out


# Truths are 0 and 1. A result may be written over an operand that is read element by element, but no other.
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "fma": _fused,
    "fms": _fused_minus,
    "fnma": _minus_fused,
    "neg": np.negative,
    "inv": np.reciprocal,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "exp": np.exp,
    "log": np.log,
    "tanh": np.tanh,
    "atan2": np.arctan2,
    "fabs": np.fabs,
    "sign": np.sign,
    "floor": np.floor,
    "fmod": np.fmod,
    "fmin": np.fmin,
    "fmax": np.fmax,
    "lt": np.less,
    "le": np.less_equal,
    "eq": np.equal,
    "ne": np.not_equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "if_else": _choice,
}


@dataclass(frozen=True, eq=False)
class Program:
    """The loop of a plan: for each operation its function, the places of its operands, and its buffer."""

    plan: Plan
    lines: tuple[tuple[Callable[..., Any], tuple[int, ...], int], ...]
    places: tuple[int, ...]
    buffers: int


@lru_cache(maxsize=64)
def program(plan: Plan) -> Program:
    """The loop with as few buffers as it can do with: one is free again behind the last use of its value."""
    nodes, kept = plan.graph.nodes, set(plan.graph.results)
    inside = [place for place in plan.inside if nodes[place].operands]
    last = {i: place for place in inside for i in nodes[place].operands}
    buffer: dict[int, int] = {}
    free: list[int] = []
    count = 0
    for place in inside:
        if not free:
            free.append(count)
            count += 1
        buffer[place] = free.pop()  # before those of its operands are free: none is overwritten while it is read
        free += {buffer[i] for i in nodes[place].operands if i in buffer and last[i] == place and i not in kept}
    lines = tuple((FUNCTIONS[nodes[place].op], nodes[place].operands, buffer[place]) for place in inside)
    return Program(plan, lines, tuple(inside), count)


def march(job: Job, x: Array, tell: Progress) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps."""
    job.check(x)
    made = program(Plan.of_step(job.step, job.varied))
    parts = [slice(first, first + RUNS_AT_ONCE) for first in range(0, len(x), RUNS_AT_ONCE)]
    kept = x.shape[1] - 1
    done, total = 0.0, kept * job.stride
    with crew(len(parts)) as each:
        for piece in pieces(job, kept):
            table = _table(made.plan, job, piece)
            for _ in each(lambda lot, of=piece, t=table: _advance(made, job, lot, x, of, t), parts):
                done += piece.length / len(parts)
                tell(min(done / total, 1.0))


def _table(plan: Plan, job: Job, piece: Piece) -> Array:
    """What depends on time alone, (steps, nt)."""
    k = np.arange(piece.begin, piece.begin + piece.rows * piece.steps, dtype=float)
    values = _evaluate(plan, plan.table, job.step.h, lambda op, index: k if op == "k" else job.p[0, index])
    return np.stack([values[place] for place in plan.table], axis=1) if plan.table else np.empty((len(k), 0))


def _advance(made: Program, job: Job, lot: slice, x: Array, piece: Piece, table: Array) -> None:
    """Fill the rows of a piece in x for one lot of runs."""
    plan, graph, runs = made.plan, made.plan.graph, len(x[lot])
    lanes = _evaluate(plan, plan.lanes, job.step.h, lambda op, index: np.ascontiguousarray(job.p[lot, index]))
    buffers, row = np.empty((made.buffers, runs)), np.empty(len(plan.table))
    state = np.array(x[lot, piece.start].T, order="C")  # a copy also of one run
    after, noise, k = np.empty_like(state), np.empty((job.step.noises, runs)), np.empty(())
    sources = {"x": state, "w": noise}
    values: dict[int, Any] = lanes | {place: row[i : i + 1] for i, place in enumerate(plan.table)}
    for place, node in enumerate(graph.nodes):
        if node.op in ("x", "w"):
            values[place] = sources[node.op][node.entry]
        elif node.op in ("const", "k"):
            values.setdefault(place, k if node.op == "k" else np.float64(node.value))
    values |= {place: buffers[buffer] for place, (_, _, buffer) in zip(made.places, made.lines, strict=True)}
    calls = [(function, [values[i] for i in operands], buffers[buffer]) for function, operands, buffer in made.lines]
    results = [values[place] for place in graph.results]
    kept = job.part(np.arange(len(x))[lot], job.stride, piece.begin)
    with np.errstate(all="ignore"):
        for step in range(piece.rows * piece.steps):
            row[:], k[...] = table[step], piece.begin + step
            if len(noise):
                noise[...] = kept.noise(np.array([piece.begin + step]))[:, 0].T
            for function, operands, out in calls:
                function(*operands, out=out)
            for target, result in zip(after, results, strict=True):
                target[:] = result
            state[...] = after
            if (step + 1) % piece.steps == 0:
                x[lot, piece.row + step // piece.steps] = state.T


def _evaluate(plan: Plan, places: Sequence[int], h: float, source: Callable[[str, int], Any]) -> dict[int, Any]:
    """The values of some nodes, and of all they need, from h [s] and what `source` gives for 'p' and 'k'."""
    numbers = plan.graph.numbers(h)
    values: dict[int, Any] = {}
    with np.errstate(all="ignore"):
        for place in plan.graph.before(places):
            node = plan.graph.nodes[place]
            if place in numbers:
                values[place] = np.float64(numbers[place])
            elif not node.operands:
                values[place] = source(node.op, node.entry)
            else:  # a truth becomes a number
                values[place] = FUNCTIONS[node.op](*(values[i] for i in node.operands)) * 1.0
    whole = np.broadcast_shapes(*(np.shape(values[place]) for place in places))
    return {place: np.broadcast_to(values[place], whole) for place in places}
