"""Plan: which values of a graph are made once a run, which once a step for all runs, and which in the loop."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from workbench.core import Step
from workbench.simulate.kernel.graph import Graph, Level, Node
from workbench.simulate.kernel.reading import read
from workbench.simulate.kernel.rewriting import rewritten

# Numbers that stand in the code. All others are handed in, so that a step and its half are one kernel.
PLAIN = (0.0, 1.0, -1.0, 2.0, 0.5)


@dataclass(frozen=True, eq=False)
class Plan:
    """The nodes of a graph by where they are evaluated.

    Attributes
    ----------
    per_run, per_step, inside
        Places of nodes in the order of evaluation: those of constants and parameters only; those of
        time and of parameters that are equal in all runs; and all others.
    lanes, table
        Those of the first two that the loop uses and finds in memory.
    """

    graph: Graph
    per_run: tuple[int, ...]
    per_step: tuple[int, ...]
    inside: tuple[int, ...]
    lanes: tuple[int, ...]
    table: tuple[int, ...]

    @staticmethod
    @lru_cache(maxsize=128)
    def of_step(step: Step, varied: tuple[int, ...]) -> Plan:
        """The plan of a step's graph, each made once."""
        return Plan.of(graph_of(step), varied)

    @staticmethod
    def of(graph: Graph, varied: Iterable[int]) -> Plan:
        """The plan where the parameters `varied` differ from run to run."""
        moving = graph.after("p", set(varied))
        groups: dict[str, list[int]] = {"per_run": [], "per_step": [], "inside": []}
        for place, level in enumerate(graph.levels):
            timed = level is Level.TIME and place not in moving
            groups["per_run" if level is Level.PARAMETERS else "per_step" if timed else "inside"].append(place)
        used = {i for place in groups["inside"] for i in graph.nodes[place].operands} | set(graph.results)
        used -= {place for place in used if _is_plain(graph.nodes[place])}
        return Plan(
            graph,
            *(tuple(group) for group in groups.values()),
            *(tuple(i for i in groups[group] if i in used) for group in ("per_run", "per_step")),
        )

    @cached_property
    def behind_table(self) -> tuple[int, ...]:
        """Those made once a run that the table needs."""
        return tuple(i for i in self.graph.before(self.table) if self.graph.levels[i] is Level.PARAMETERS)

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """The numbers that a kernel is handed."""
        return tuple(self.graph.nodes[place].value for place in self.constant_places)

    @cached_property
    def constant_places(self) -> Mapping[int, int]:
        """Where a node's number is among `constants`."""
        handed = (i for i in self.per_run if self.graph.nodes[i].op == "const" and not _is_plain(self.graph.nodes[i]))
        return {place: i for i, place in enumerate(handed)}

    @cached_property
    def parameters(self) -> Mapping[int, int]:
        """Where a parameter, by its index, is among those that a kernel is handed: those that the graph has."""
        return {i: place for place, i in enumerate(sorted(n.entry for n in self.graph.nodes if n.op == "p"))}


@lru_cache(maxsize=128)
def graph_of(step: Step) -> Graph:
    """The graph of a step as every kernel evaluates it, made once."""
    return rewritten(read(step))


def _is_plain(node: Node) -> bool:
    return node.op == "const" and node.value in PLAIN
