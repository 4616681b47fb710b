"""The march in NumPy: the same graph, one operation on all runs after the other.

It serves where nothing can be compiled, with the bits of the compiled march, which is tested against it.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array, Integers
from workbench.engine.job import Job, JobPiece, Progress, parallel_map, pieces
from workbench.engine.kernel.plan import Evaluation, KernelPlan
from workbench.engine.kernel.tape import Line, Tape, play
from workbench.engine.machines.numpy_spelling import Arrays, Lanes

RUNS_AT_ONCE = 8192  # the calls of an operation, which threads make one at a time, then cost little beside its work
NORMALS_AT_ONCE = 2**14  # of some steps of all runs: so many are made with few calls, and stay in the cache


def march(job: Job, x: Array, tell: Progress) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps."""
    job.check(x)
    parts = [np.arange(first, min(first + RUNS_AT_ONCE, len(x))) for first in range(0, len(x), RUNS_AT_ONCE)]
    done, total = 0.0, (x.shape[1] - 1) * job.stride

    def advance(piece: JobPiece, lot: Integers) -> None:
        _advance(job, lot, x, piece)

    with parallel_map(len(parts)) as each:
        for piece in pieces(job, x.shape[1] - 1):
            for _ in each(partial(advance, piece), parts):
                done += piece.length / len(parts)
                tell(min(done / total, 1.0))


class TapeLoop(NamedTuple):
    """Lines on a tape with their constants, the places of the nodes that come in, and the places of some results."""

    lines: list[Line]
    constants: dict[int, Lanes]
    sources: dict[int, int]
    results: list[int]

    @staticmethod
    def of(plan: KernelPlan, fused_products: bool, nodes: Sequence[int], results: Sequence[int]) -> TapeLoop:
        """The loop that makes some nodes of a plan, and of them the results."""
        tape, sources = Tape(fused_products), dict[int, int]()

        def load(node: int) -> int:
            return sources.setdefault(node, tape.place(node))

        evaluation = Evaluation(plan.graph, tape, load)
        evaluation.make(nodes)
        places = [evaluation.value(place) for place in results]
        return TapeLoop(tape.lines(places), tape.constants, sources, places)

    def play(self, values: Mapping[int, Lanes]) -> list[Lanes]:
        """The results from the values of the nodes that come in."""
        held = self.constants | {place: values[node] for node, place in self.sources.items()}
        play(self.lines, held)
        return [held[place] for place in self.results]


@lru_cache(maxsize=64)
def _loops(plan: KernelPlan, fused_products: bool) -> tuple[TapeLoop, TapeLoop | None, tuple[int, ...]]:
    """The loop of a step, that of a segment of it, and the nodes that the first makes for the second."""
    results, segments = plan.graph.results[: plan.states], plan.segments
    if segments is None:
        return TapeLoop.of(plan, fused_products, plan.inside, results), None, ()
    segment = TapeLoop.of(plan, fused_products, plan.aside, (segments.more, segments.end, *segments.ends))
    inside = set(plan.inside)
    lent = tuple(node for node in segment.sources if node in inside)
    wanted = (*results, segments.several, *segments.start, *lent)
    return TapeLoop.of(plan, fused_products, plan.inside, wanted), segment, lent


def _advance(job: Job, lot: Integers, x: Array, piece: JobPiece) -> None:
    plan, nodes, part = job.plan, job.plan.graph.nodes, job.part(lot, job.stride, job.begin)
    loop, segment, lent = _loops(plan, job.fused_products)
    steps = np.arange(piece.begin, piece.begin + piece.length)
    in_tables = [i for place in plan.tables for i in nodes[place].operands]
    per_run = _values(job, plan.per_run, (*plan.lanes, *in_tables), part.p.T)
    per_step = _values(job, plan.behind_table + plan.per_step, plan.table, part.p[0], steps.astype(float))
    timed = {node: np.broadcast_to(value, len(steps)) for node, value in per_step.items()}
    moving = {node: nodes[node] for node in loop.sources if nodes[node].op in ("x", "w", "k", "d")}
    state = np.ascontiguousarray(x[lot, piece.start].T)
    none = np.empty((0, len(lot)))
    noise: Iterable[Array] = _noise(part, steps) if job.step.noises else itertools.repeat(none, len(steps))
    recorded = job.record[steps] if job.step.rule.d.numel() else np.empty((len(steps), 0))
    with np.errstate(all="ignore"):
        for step, (k, w, d) in enumerate(zip(steps, noise, recorded, strict=True)):
            now: dict[str, Mapping[int, Lanes] | Array] = {"x": state, "w": w, "d": d, "k": {0: np.float64(k)}}
            values = per_run | {node: row[step : step + 1] for node, row in timed.items()}
            values |= {node: now[source.op][source.entry] for node, source in moving.items()}
            made = [v if np.shape(v) == lot.shape else np.broadcast_to(v, lot.shape) for v in loop.play(values)]
            state = np.array(made[: plan.states])
            if segment is not None:
                values |= zip(lent, made[len(made) - len(lent) :], strict=True)
                _march_segments(plan, segment, values, state, made[plan.states], made[plan.states + 1 :])
            if (step + 1) % piece.steps == 0:
                x[lot, piece.row + step // piece.steps] = state.T


def _noise(job: Job, steps: Integers) -> Iterator[Array]:
    """The normal numbers (nw, B) of one step after the other."""
    some = max(1, NORMALS_AT_ONCE // (len(job.runs) * job.step.noises))
    for first in range(0, len(steps), some):
        yield from job.noise(steps[first : first + some]).transpose(1, 2, 0)


def _march_segments(
    plan: KernelPlan, loop: TapeLoop, values: Mapping[int, Lanes], state: Array, several: Lanes, start: Sequence[Lanes]
) -> None:
    """Put the states at the end of a step into `state` (nx, B) for the runs in which it has several segments."""
    runs = np.flatnonzero(several)
    if not runs.size:
        return
    assert plan.segments is not None
    nodes, n = plan.graph.nodes, len(plan.segments.ends)
    z: NDArray[np.generic] = np.stack(start[:n])[:, runs]
    s: NDArray[np.generic] = np.zeros(len(runs))
    goes = True
    few = {
        node: value[runs] if isinstance(value, np.ndarray) and value.shape == several.shape else value
        for node, value in values.items()
    }
    while goes:
        for node in loop.sources:
            if nodes[node].op in ("s", "z"):
                few[node] = s if nodes[node].op == "s" else z[nodes[node].entry]
        more, s, *ends = (np.broadcast_to(value, len(runs)) for value in loop.play(few))
        z, goes = np.stack(ends), bool(np.any(more))
    state[:n, runs] = z


def _values(
    job: Job, places: Sequence[int], results: Sequence[int], p: Array, k: Array | None = None
) -> dict[int, Lanes]:
    """The values of some of the nodes that are made outside the loop, from the parameters p and the steps k."""
    numbers, nodes = job.plan.graph.numbers(job.step.h), job.plan.graph.nodes

    def load(place: int) -> Lanes:
        if place in numbers:
            return np.float64(numbers[place])
        if nodes[place].op == "k":
            assert k is not None  # which nothing that is made once a run asks for
            return k
        return np.ascontiguousarray(p[nodes[place].entry])

    evaluation = Evaluation(job.plan.graph, Arrays(job.fused_products), load)
    with np.errstate(all="ignore"):
        evaluation.make(places)
        return {place: evaluation.value(place) for place in results}
