"""Plan: which values of a graph are made once, which once a run, which once a step, and which in the loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.core.layout import Array
from workbench.simulate.graph import Depends, Graph, Node

OUTSIDE = Depends.UNIFORM | Depends.VARIED


@dataclass(frozen=True, eq=False)
class Plan:
    """The nodes of a graph by where they are evaluated.

    Attributes
    ----------
    once, per_run, per_step, inside
        Places of nodes in the order of evaluation: those that depend on nothing or on parameters
        equal in all runs; on parameters that vary; on time but on no run; and all others.
    uniform, lanes, table
        Those of the first three that the loop uses: what a kernel is handed.
    """

    graph: Graph
    varied: tuple[int, ...]
    once: tuple[int, ...]
    per_run: tuple[int, ...]
    per_step: tuple[int, ...]
    inside: tuple[int, ...]
    uniform: tuple[int, ...]
    lanes: tuple[int, ...]
    table: tuple[int, ...]

    @staticmethod
    def of(graph: Graph, varied: Sequence[int]) -> Plan:
        """The plan where the parameters `varied` differ from run to run."""
        groups: dict[str, list[int]] = {"once": [], "per_run": [], "per_step": [], "inside": []}
        where = [_group(depends) for depends in graph.depends(varied)]
        for place, group in enumerate(where):
            groups[group].append(place)
        used = {i for place in groups["inside"] for i in graph.nodes[place].operands} | set(graph.results)
        handed = {group: tuple(i for i in groups[group] if i in used) for group in ("once", "per_run", "per_step")}
        return Plan(
            graph,
            tuple(varied),
            *(tuple(groups[group]) for group in ("once", "per_run", "per_step", "inside")),
            *(handed[group] for group in ("once", "per_run", "per_step")),
        )

    def evaluated(self, p: Array, k: Array) -> tuple[dict[int, Any], dict[int, Array], dict[int, Array]]:
        """The values outside the loop: by place, scalars, arrays (B,) over runs and arrays (steps,) over time.

        Parameters
        ----------
        p
            (B, np), equal in all runs but for the varied ones.
        k
            (steps,), the numbers of the steps.
        """
        once = evaluate(self.graph, self.once, {"p": lambda i: p[0, i]}, {})
        per_run = evaluate(self.graph, self.per_run, {"p": lambda i: p[:, i]}, once)
        per_step = evaluate(self.graph, self.per_step, {"k": lambda i: k}, once)
        return once, per_run, per_step


def _group(depends: Depends) -> str:
    if Depends.STATE in depends or (Depends.TIME in depends and Depends.VARIED in depends):
        return "inside"
    if Depends.TIME in depends:
        return "per_step"
    return "per_run" if Depends.VARIED in depends else "once"


def _truth(a: Any) -> Any:
    return np.not_equal(a, 0)


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
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
    "lt": lambda a, b: np.less(a, b) * 1.0,
    "le": lambda a, b: np.less_equal(a, b) * 1.0,
    "eq": lambda a, b: np.equal(a, b) * 1.0,
    "ne": lambda a, b: np.not_equal(a, b) * 1.0,
    "and": lambda a, b: (_truth(a) & _truth(b)) * 1.0,
    "or": lambda a, b: (_truth(a) | _truth(b)) * 1.0,
    "not": lambda a: np.equal(a, 0) * 1.0,
    "if_else_zero": lambda c, a: np.where(_truth(c), a, 0.0),
}


def evaluate(
    graph: Graph,
    places: Sequence[int],
    sources: Mapping[str, Callable[[int], Any]],
    known: Mapping[int, Any],
) -> dict[int, Any]:
    """The values of some nodes in NumPy, from sources and from values that are known already."""
    values: dict[int, Any] = {}

    def value(place: int) -> Any:
        return values[place] if place in values else known[place]

    with np.errstate(all="ignore"):
        for place in places:
            node: Node = graph.nodes[place]
            if node.op == "const":
                values[place] = np.float64(node.value)
            elif node.op in sources:
                values[place] = np.asarray(sources[node.op](node.index), dtype=float)
            else:
                values[place] = FUNCTIONS[node.op](*(value(i) for i in node.operands))
    return values
