"""The march in NumPy: the same graph, one operation on all runs after the other.

It serves where nothing can be compiled, with the bits of the compiled march, which is tested against it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core.layout import Array
from workbench.simulate.job import Job, Piece, Progress, crew, pieces
from workbench.simulate.kernel.arrays import Arrays
from workbench.simulate.kernel.evaluation import Evaluation

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


def _advance(job: Job, lot: Any, x: Array, piece: Piece) -> None:
    """Fill the rows of a piece in x for one lot of runs."""
    plan, graph, part = job.plan, job.plan.graph, job.part(lot, job.stride, job.begin)
    numbers, p = graph.numbers(job.step.h), np.ascontiguousarray(part.p.T)
    sources: dict[str, Any] = {"p": p, "x": np.ascontiguousarray(x[lot, piece.start].T)}

    def load(place: int) -> Any:
        node = graph.nodes[place]
        if place in numbers:
            return np.float64(numbers[place])
        return sources["k"] if node.op == "k" else sources[node.op][node.entry]

    before = Evaluation(graph, Arrays(job.fused), load)
    loop = sorted(plan.per_step + plan.inside)
    with np.errstate(all="ignore"):
        before.make(plan.per_run)
        for step in range(piece.rows * piece.steps):
            k = piece.begin + step
            sources |= {"k": np.float64(k), "w": part.noise(np.array([k]))[:, 0].T}
            now = Evaluation(graph, before.machine, load)
            now.numbers |= before.numbers
            now.truths |= before.truths
            now.angles |= before.angles
            now.make(loop)
            sources["x"] = np.stack([np.broadcast_to(now.value(place), len(lot)) for place in graph.results])
            if (step + 1) % piece.steps == 0:
                x[lot, piece.row + step // piece.steps] = sources["x"].T
