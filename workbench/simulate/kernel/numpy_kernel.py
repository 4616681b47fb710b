"""The march in NumPy: the same graph, one operation on all runs after the other.

It serves where nothing can be compiled, with the bits of the compiled march, which is tested against it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.simulate.job import Job, Piece, Progress, crew, pieces
from workbench.simulate.kernel.arrays import Arrays, Line, Tape, play
from workbench.simulate.kernel.plan import Evaluation, Plan
from workbench.simulate.kernel.target_operations import Value
from workbench.validation.refusals import Array

RUNS_AT_ONCE = 8192  # the calls of an operation, which threads make one at a time, then cost little beside its work


def march(job: Job, x: Array, tell: Progress) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps."""
    job.check(x)
    parts = [np.arange(first, min(first + RUNS_AT_ONCE, len(x))) for first in range(0, len(x), RUNS_AT_ONCE)]
    done, total = 0.0, (x.shape[1] - 1) * job.stride
    with crew(len(parts)) as each:
        for piece in pieces(job, x.shape[1] - 1):
            for _ in each(lambda lot, of=piece: _advance(job, lot, x, of), parts):
                done += piece.length / len(parts)
                tell(min(done / total, 1.0))


@lru_cache(maxsize=64)
def _loop(plan: Plan, fused: bool) -> tuple[list[Line], dict[int, Value], dict[int, int], list[int]]:
    """The loop of a plan on a tape: its lines, its constants, where the nodes are that come in, and the results."""
    tape, sources = Tape(fused), dict[int, int]()

    def load(node: int) -> int:
        return sources.setdefault(node, tape.place(node))

    evaluation = Evaluation(plan.graph, tape, load)
    evaluation.make(plan.inside)
    results = [evaluation.value(place) for place in plan.graph.results]
    return tape.lines(results), tape.constants, sources, results


def _advance(job: Job, lot: Any, x: Array, piece: Piece) -> None:
    plan, nodes, part = job.plan, job.plan.graph.nodes, job.part(lot, job.stride, job.begin)
    lines, constants, sources, results = _loop(plan, job.fused)
    steps = np.arange(piece.begin, piece.begin + piece.length)
    per_run = _values(job, plan.per_run, plan.lanes, part.p.T)
    per_step = _values(job, plan.behind_table + plan.per_step, plan.table, part.p[0], steps.astype(float))
    values = constants | {place: per_run[node] for node, place in sources.items() if node in per_run}
    timed = {place: np.broadcast_to(per_step[node], len(steps)) for node, place in sources.items() if node in per_step}
    moving = {place: nodes[node] for node, place in sources.items() if nodes[node].op in ("x", "w", "k")}
    state = np.ascontiguousarray(x[lot, piece.start].T)
    with np.errstate(all="ignore"):
        for step, k in enumerate(steps):
            now: dict[str, Any] = {"x": state, "w": part.noise(steps[step : step + 1])[:, 0].T, "k": {0: np.float64(k)}}
            values |= {place: row[step : step + 1] for place, row in timed.items()}
            values |= {place: now[node.op][node.entry] for place, node in moving.items()}
            play(lines, values)
            state = np.stack([np.broadcast_to(values[place], len(lot)) for place in results])
            if (step + 1) % piece.steps == 0:
                x[lot, piece.row + step // piece.steps] = state.T


def _values(job: Job, places: Sequence[int], wanted: Sequence[int], p: Array, k: Array | None = None) -> dict[int, Any]:
    """The values of some of the nodes that are made outside the loop, from the parameters p and the steps k."""
    numbers, nodes = job.plan.graph.numbers(job.step.h), job.plan.graph.nodes

    def load(place: int) -> Any:
        if place in numbers:
            return np.float64(numbers[place])
        return k if nodes[place].op == "k" else np.ascontiguousarray(p[nodes[place].entry])

    evaluation = Evaluation(job.plan.graph, Arrays(job.fused), load)
    with np.errstate(all="ignore"):
        evaluation.make(places)
        return {place: evaluation.value(place) for place in wanted}
