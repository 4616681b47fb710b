"""Plan: the values of a graph that are made once a run, once a step for all runs, and in the loop."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from workbench.core import Step
from workbench.simulate.kernel.graph import Graph, Level, Node
from workbench.simulate.kernel.reading import read
from workbench.simulate.kernel.rewriting import rewritten, stepped

# Numbers that stand in the code. All others are handed in, so that a step and its half are one kernel.
PLAIN = (0.0, 1.0, -1.0, 2.0, 0.5)


@dataclass(frozen=True, eq=False)
class Plan:
    """The nodes of a graph by where they are evaluated.

    Attributes
    ----------
    numbers, per_run, per_step, inside
        Places of nodes in the order of evaluation: those of the length of the step alone that others use; those of
        parameters too; those of time and of parameters that are equal in all runs; and all others.
    lanes, table
        Those before `inside` that the loop uses and finds in memory: one a run, and one a step.
    """

    graph: Graph
    numbers: tuple[int, ...]
    per_run: tuple[int, ...]
    per_step: tuple[int, ...]
    inside: tuple[int, ...]
    lanes: tuple[int, ...]
    table: tuple[int, ...]

    @staticmethod
    def of_step(step: Step, varied: tuple[int, ...]) -> Plan:
        """The plan of a step's graph, made once for all lengths."""
        return _planned(graph_of(step), varied)

    @staticmethod
    def of(graph: Graph, varied: Iterable[int]) -> Plan:
        """The plan where the parameters `varied` differ from run to run."""
        moving = graph.after("p", set(varied))
        groups: dict[Level, list[int]] = {level: [] for level in Level}
        for place, level in enumerate(graph.levels):
            groups[Level.STATE if level is Level.TIME and place in moving else level].append(place)
        numbers, per_run, per_step, inside = (tuple(group) for group in groups.values())
        used, needed = (
            {i for place in places for i in graph.nodes[place].operands if not _is_plain(graph.nodes[i])}
            for places in (inside, per_run + per_step + inside)
        )
        used |= {place for place in graph.results if not _is_plain(graph.nodes[place])}
        return Plan(
            graph,
            tuple(i for i in numbers if i in needed | used),
            per_run,
            per_step,
            inside,
            *(tuple(i for i in group if i in used) for group in (numbers + per_run, per_step)),
        )

    @cached_property
    def behind_table(self) -> tuple[int, ...]:
        """The nodes made once a run that the table needs."""
        return tuple(i for i in self.graph.before(self.table) if self.graph.levels[i] is Level.PARAMETERS)

    def constants(self, h: float) -> tuple[float, ...]:
        """The numbers that a kernel is handed, for steps of length h [s]."""
        values = self.graph.numbers(h)
        return tuple(values[place] for place in self.numbers)

    @cached_property
    def constant_places(self) -> Mapping[int, int]:
        """The places of the values of nodes among `constants`."""
        return {place: i for i, place in enumerate(self.numbers)}

    @cached_property
    def parameters(self) -> Mapping[int, int]:
        """The places of parameters, by their index, among those that a kernel is handed: those that the graph has."""
        return {i: place for place, i in enumerate(sorted(n.entry for n in self.graph.nodes if n.op == "p"))}


def graph_of(step: Step) -> Graph:
    """The graph of a step as every kernel evaluates it, made once for all lengths; refused as by `read`."""
    return _stepped(pass_of(step), int(step.rule.rate.numel()))


def pass_of(step: Step) -> Graph:
    """The graph of a step's rates and updates, as every stage of it evaluates them; refused as by `read`."""
    return _rewritten(read(step))


_rewritten = lru_cache(maxsize=128)(rewritten)
_stepped = lru_cache(maxsize=128)(stepped)


@lru_cache(maxsize=128)
def _planned(graph: Graph, varied: tuple[int, ...]) -> Plan:
    return Plan.of(graph, varied)


def _is_plain(node: Node) -> bool:
    return node.op == "const" and node.value in PLAIN
