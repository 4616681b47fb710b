"""NumPy as it is here: the graph of a law, one operation on all instants after the other."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.engine.kernel.plan import Evaluation, graph_of
from workbench.engine.machines.numpy_spelling import Arrays, Lanes
from workbench.handover.c99.c_files import CCode
from workbench.handover.memory_digest import digest
from workbench.handover.recording import BLOCK, Recording
from workbench.handover.targets.external_programs import TargetError
from workbench.handover.targets.harness import TargetAnswers
from workbench.handover.targets.target import AbstractTarget, TargetCost


@dataclass(frozen=True)
class ArrayTarget(AbstractTarget):
    """Each instant from the memory that was recorded before it: if all are equal, so are runs from the first on."""

    name: str

    @property
    def programs(self) -> tuple[str, ...]:
        """None."""
        return ()

    def answers(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetAnswers:
        """Commands and memories, block by block."""
        if code.real != "double":
            raise TargetError("NumPy is the reference of single precision itself")
        nz, shares = code.law.memory.size, list[Array]()
        digests = []
        for first in range(0, recording.periods, BLOCK):
            last = min(first + BLOCK, recording.periods)
            new = _instants(recording, first, last)
            shares.append(new[:, nz:])
            digests.append(digest(new[:, :nz]))
        u, none = np.concatenate(shares), np.zeros(recording.periods, dtype=np.uint64)
        return TargetAnswers(u, none, np.concatenate(digests), new[-1, :nz])

    def figures(self, code: CCode, recording: Recording, folder: Path, seconds: float) -> TargetCost:
        """None of them."""
        return TargetCost()


def _instants(recording: Recording, first: int, last: int) -> Array:
    """Memory and commands behind the instants, (last - first, nz + nu)."""
    law, graph = recording.law, graph_of(recording.law.step)
    numbers, count = graph.numbers(law.period), last - first
    z = recording.memory(first, last)[:-1]
    states = np.concatenate([z, np.zeros((count, law.commands.size))], axis=1)
    p = np.broadcast_to(law.parameters.default, (count, law.parameters.size))
    p = np.concatenate([p, recording.y[first:last], recording.r[first:last]], axis=1)
    k = np.arange(first, last).astype(float)

    def load(place: int) -> Lanes:
        node = graph.nodes[place]
        if place in numbers:
            return np.float64(numbers[place])
        return k if node.op == "k" else (states if node.op == "x" else p)[:, node.entry]

    evaluation = Evaluation(graph, Arrays(fused_products=False), load)
    with np.errstate(all="ignore"):
        evaluation.make(range(len(graph.nodes)))
        return np.stack([np.broadcast_to(evaluation.value(place), count) for place in graph.results], axis=1)
