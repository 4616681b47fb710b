"""The march in NumPy: the same graph, one operation on all runs after the other, in buffers used again and again.

It serves where nothing can be compiled, with the bits of the compiled march, which is tested against it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.simulate.job import Job, Piece, Progress, crew, pieces
from workbench.simulate.kernel.arrays import FUNCTIONS, Arrays, Note, Tape
from workbench.simulate.kernel.evaluation import Evaluation
from workbench.simulate.kernel.plan import Plan
from workbench.validation.refusals import Array

RUNS_AT_ONCE = 8192  # the calls of an operation, which threads make one at a time, then cost little beside its work


class Line(NamedTuple):
    """A note of the tape, where its result is, and its buffer."""

    note: Note
    place: int
    buffer: int


@dataclass(frozen=True, eq=False)
class Program:
    """The loop of a plan: what is done in which buffers, what comes in and where it is, and what comes out."""

    plan: Plan
    lines: tuple[Line, ...]
    constants: Mapping[int, Any]
    sources: Mapping[int, int]
    results: tuple[int, ...]
    buffers: int


@lru_cache(maxsize=64)
def program(plan: Plan, fused: bool) -> Program:
    """The loop with as few buffers as it can do with: one is free again behind the last use of its value."""
    tape, sources = Tape(fused), dict[int, int]()

    def load(node: int) -> int:
        return sources.setdefault(node, tape.place(node))

    evaluation = Evaluation(plan.graph, tape, load)
    evaluation.make(plan.inside)
    results = tuple(evaluation.value(place) for place in plan.graph.results)
    notes = tape.before(results)
    last = {i: place for place, note in notes.items() for i in note.operands}
    buffer: dict[int, int] = {}
    free: list[int] = []
    count = 0
    for place, note in notes.items():
        if not free:
            free.append(count)
            count += 1
        buffer[place] = free.pop()  # before those of its operands are free: none is overwritten while it is read
        free += {buffer[i] for i in note.operands if i in buffer and last[i] == place and i not in results}
    lines = tuple(Line(note, place, buffer[place]) for place, note in notes.items())
    return Program(plan, lines, tape.constants, sources, results, count)


def march(job: Job, x: Array, tell: Progress) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps."""
    job.check(x)
    made = program(job.plan, job.fused)
    parts = [slice(first, first + RUNS_AT_ONCE) for first in range(0, len(x), RUNS_AT_ONCE)]
    kept = x.shape[1] - 1
    done, total = 0.0, kept * job.stride
    with crew(len(parts)) as each:
        for piece in pieces(job, kept):
            table = _table(job, piece)
            for _ in each(lambda lot, of=piece, t=table: _advance(made, job, lot, x, of, t), parts):
                done += piece.length / len(parts)
                tell(min(done / total, 1.0))


def _table(job: Job, piece: Piece) -> Array:
    """What depends on time alone, (steps, nt)."""
    k = np.arange(piece.begin, piece.begin + piece.rows * piece.steps, dtype=float)
    table, nodes = job.plan.table, job.plan.graph.nodes
    values = _evaluate(job, table, lambda place: k if nodes[place].op == "k" else job.p[0, nodes[place].entry])
    return np.stack([values[place] for place in table], axis=1) if table else np.empty((len(k), 0))


def _advance(made: Program, job: Job, lot: slice, x: Array, piece: Piece, table: Array) -> None:
    """Fill the rows of a piece in x for one lot of runs."""
    plan, nodes, runs = made.plan, made.plan.graph.nodes, len(x[lot])
    columns = _evaluate(job, plan.lanes, lambda place: np.ascontiguousarray(job.p[lot, nodes[place].entry]))
    buffers, row = np.empty((made.buffers, runs)), np.empty(len(plan.table))
    state = np.array(x[lot, piece.start].T, order="C")  # a copy also of one run
    after, noise, k = np.empty_like(state), np.empty((job.step.noises, runs)), np.empty(())
    columns |= {place: row[i : i + 1] for i, place in enumerate(plan.table)}
    sources = {"x": state, "w": noise}
    values: dict[int, Any] = dict(made.constants)
    for node, place in made.sources.items():
        op, _, _, entry = nodes[node]
        values[place] = sources[op][entry] if op in sources else k if op == "k" else columns[node]
    values |= {line.place: _seen(buffers[line.buffer], line.note.kind) for line in made.lines}
    calls = [
        (FUNCTIONS[note.operation], [values[i] for i in note.operands], values[place]) for note, place, _ in made.lines
    ]
    results = [values[place] for place in made.results]
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


def _seen(buffer: Array, kind: type[Any]) -> Any:
    """The memory of a row of doubles as that of as many values of a kind."""
    return buffer.view(kind)[: len(buffer)]


def _evaluate(job: Job, places: Sequence[int], source: Callable[[int], Any]) -> dict[int, Any]:
    """The values of some nodes, and of all they need, from the length of the step and what `source` has."""
    graph = job.plan.graph
    numbers = graph.numbers(job.step.h)
    needed = [place for place in graph.before(places) if place not in numbers]
    evaluation = Evaluation(
        graph,
        Arrays(job.fused),
        lambda place: np.float64(numbers[place]) if place in numbers else source(place),
    )
    with np.errstate(all="ignore"):
        evaluation.make(needed)
        values = {place: evaluation.value(place) for place in places}
    whole = np.broadcast_shapes(*(np.shape(value) for value in values.values()))
    return {place: np.broadcast_to(value, whole) for place, value in values.items()}
