"""The graph of a sampled law: the values that a reader looks for by name, and when each value can be made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import SampledLaw, StepMap
from workbench.core.validation.signatures import check_arguments
from workbench.engine.kernel.casadi_to_graph import read_with
from workbench.engine.kernel.graph import ARRAYS, COMMUTATIVE, Graph, Node
from workbench.engine.kernel.graph_rewriting import rewrite, without_barriers
from workbench.engine.kernel.plan import Evaluation
from workbench.engine.kernel.step_graph import step_graph
from workbench.engine.machines.numpy_spelling import Arrays


@dataclass(frozen=True, eq=False)
@check_arguments
class StepGraph:
    """The nodes of a step as every machine evaluates them, by what they depend on.

    Attributes
    ----------
    numbers
        The values of the nodes that depend on numbers alone: those of the equations and, unless they can be set, of
        parameters. Made in the portable arithmetic of doubles.
    parameter_nodes
        The nodes that depend on parameters that can be set, and on numbers.
    instant_nodes
        The others that depend on the number of the instant, and on nothing that changes otherwise.
    variable_nodes
        All other nodes, in the order of evaluation.
    values
        The nodes of the named values of each stage, by stage and name.
    """

    graph: Graph
    numbers: Mapping[int, float]
    parameter_nodes: tuple[int, ...]
    instant_nodes: tuple[int, ...]
    variable_nodes: tuple[int, ...]
    values: tuple[Mapping[str, tuple[int | None, ...]], ...]


def graph_of_law(law: SampledLaw, settable: bool = False, fused_products: bool = False) -> StepGraph:
    """The graph of a law, with its results z+ and u, with the numbers of its parameters unless they are `settable`.

    Numbers are made in the portable arithmetic, or in the fused one.
    """
    stages = [{name: ca.vertsplit(ca.vec(ca.SX(part))) for name, part in s.values.items()} for s in law.stages]
    return split(law.step, law.parameters.default, settable, stages, fused_products)


def split(
    step: StepMap,
    parameters: np.ndarray,
    settable: bool = False,
    stages: list[dict[str, list[ca.SX]]] | None = None,
    fused_products: bool = False,
) -> StepGraph:
    """The graph of a step of which the first parameters have these numbers; the others move."""
    stages = stages or []
    flat = [value for stage in stages for part in stage.values() for value in part]
    first, held = read_with(step, flat)
    graph = without_barriers(step_graph(rewrite(first), int(step.rule.rate.numel())))
    places = iter([None if i is None else graph.results[i] for i in held])
    named = tuple({name: tuple(next(places) for _ in part) for name, part in stage.items()} for stage in stages)
    graph = Graph(graph.nodes, graph.results[: step.states.size])
    groups = _groups(graph, len(parameters))
    known = set(groups["number"]) | (set() if settable else set(groups["parameter"]))
    numbers = _numbers(graph, known, step.h, parameters, fused_products)
    same = _same(graph, numbers)
    named = tuple({name: tuple(i if i is None else same[i] for i in part) for name, part in s.items()} for s in named)
    graph = Graph(_seen(graph, same), tuple(same[i] for i in graph.results))
    adjustable = tuple(groups["parameter"]) if settable else ()
    return StepGraph(graph, numbers, adjustable, tuple(groups["time"]), tuple(groups["state"]), named)


def behind_limits(graph: Graph) -> list[int]:
    """The values that the limits of results stand before: of one that is no number `fmin` and `fmax` give the limit."""
    limits, behind = {"fmin", "fmax"}, dict[int, None]()
    stack = [i for i in graph.results if graph.nodes[i].op in limits]
    while stack:
        for i in graph.nodes[stack.pop()].operands:
            if graph.nodes[i].op in limits:
                stack.append(i)
            elif graph.nodes[i].op not in ("const", "h"):
                behind[i] = None
    return sorted(behind)


def _groups(graph: Graph, parameters: int) -> dict[str, list[int]]:
    """The places of the nodes by what they depend on."""
    kinds = ("number", "parameter", "time", "state")
    own = {"const": 0, "h": 0, "k": 2, "t": 2, "x": 3, "w": 3, **dict.fromkeys((*ARRAYS, "loop"), 3)}
    levels: list[int] = []
    for node in graph.nodes:
        level = own.get(node.op, 0) if node.op != "p" else 1 if node.entry < parameters else 3
        levels.append(max([level, *(levels[i] for i in node.operands)]))
    groups: dict[str, list[int]] = {kind: [] for kind in kinds}
    for place, level in enumerate(levels):
        groups[kinds[level]].append(place)
    return groups


def _numbers(graph: Graph, known: set[int], h: float, parameters: np.ndarray, fused: bool) -> dict[int, float]:
    """The values of the nodes that are known, in the portable arithmetic or the fused one."""

    def load(place: int) -> np.float64:
        node = graph.nodes[place]
        return np.float64({"const": node.value, "h": h}.get(node.op, parameters[node.entry] if node.op == "p" else 0.0))

    evaluation = Evaluation(graph, Arrays(fused), load)
    with np.errstate(all="ignore"):
        evaluation.make(sorted(known))
        return {place: float(evaluation.value(place)) for place in sorted(known)}


def _same(graph: Graph, numbers: Mapping[int, float]) -> list[int]:
    """For each node the first that has its bits, as the numbers are known: equal operations on equal values, a product
    with one, a difference from zero, and a choice whose condition is known.
    """
    same: list[int] = []
    first: dict[tuple[object, ...], int] = {}
    for place, node in enumerate(graph.nodes):
        given, other = [same[i] for i in node.operands], place
        if node.op == "mul" and 1.0 in [numbers.get(i) for i in given]:
            other = given[1] if numbers.get(given[0]) == 1.0 else given[0]
        elif node.op == "sub" and numbers.get(given[1], -1.0).hex() == (0.0).hex():
            other = given[0]
        elif node.op == "if_else" and given[0] in numbers:
            other = given[1] if numbers[given[0]] != 0.0 else given[2]
        elif node.operands and place not in numbers:
            key = tuple(numbers[i].hex() if i in numbers else i for i in given)
            same_kind = (node.op, node.value, node.entry, node.loop)
            other = first.setdefault((*same_kind, *(sorted(key, key=str) if node.op in COMMUTATIVE else key)), place)
        same.append(place if place in numbers else other)
    return same


def _seen(graph: Graph, same: list[int]) -> tuple[Node, ...]:
    """The nodes with each operand as the first that has its bits, and no choice twice by one condition."""
    nodes: list[Node] = []
    for node in graph.nodes:
        operands = [same[i] for i in node.operands]
        for branch in (1, 2) if node.op == "if_else" else ():
            inner = nodes[operands[branch]]
            if inner.op == "if_else" and inner.operands[0] == operands[0]:
                operands[branch] = inner.operands[branch]
        nodes.append(node._replace(operands=tuple(operands)))
    return tuple(nodes)
