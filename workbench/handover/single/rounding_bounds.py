"""A bound, proved row by row, of what a sampled law in single precision differs from the same law in doubles.

The bound is carried along with the values in doubles, operation by operation (`rounding_rules`), from the exact errors
of the inputs as floats. It holds for one period from the same memory. The proof asks of single precision that sums,
products, reciprocals and roots are rounded correctly, and that elementary functions have the errors that are stated:
so it covers fused products too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from workbench.core import SampledLaw
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.engine.kernel.plan import Evaluation
from workbench.engine.machines.numpy_spelling import Arrays, Lanes
from workbench.handover.law_graph import StepGraph
from workbench.handover.single.further_rounding_rules import FURTHER_REASONS
from workbench.handover.single.loop_bounds import OF_ARRAYS, LoopBounds, bound_of
from workbench.handover.single.rounding_rules import BoundedValue, Reals
from workbench.handover.single.single_precision import LawArguments, input_place, instant_values, rows_of, step_graph

NO_CAUSE = -1  # where there is a bound
REASONS = {
    "sign": "sign of {}",
    "floor": "floor of {}",
    "fmod": "remainder of {} by {}",
    "inv": "reciprocal of {}",
    "div": "quotient by {1}",
    "sqrt": "root of {}",
    "log": "logarithm of {}",
    "exp": "exponential of {}",
    "atan2": "angle of {1} and {0}",
    "sin": "sine of {}",
    "cos": "cosine of {}",
    "lt": "{} < {}",
    "le": "{} <= {}",
    "eq": "{} == {}",
    "ne": "{} != {}",
    **FURTHER_REASONS,
}


@dataclass(frozen=True, eq=False)
class RoundingBound:
    """The results of a law in doubles, row by row, and bounds of what those in single precision differ from them.

    Attributes
    ----------
    z_next, u
        Memory (B, nz) and commands (B, nu) in doubles.
    z_bound, u_bound
        |single - double| at most, infinite where there is no bound.
    z_cause, u_cause
        The operation for which there is none, as a key of `reasons`; -1 where there is a bound.
    reasons
        The same operations in words, as 'sign of s[0]'.
    """

    z_next: Array
    u: Array
    z_bound: Array
    u_bound: Array
    z_cause: np.ndarray
    u_cause: np.ndarray
    reasons: Mapping[int, str]

    def __repr__(self) -> str:
        return f"<RoundingBound: {len(self.u)} rows, {int(self.has_bound.sum())} with a bound>"

    @cached_property
    def has_bound(self) -> np.ndarray:
        """True for the rows (B,) in which each number has a bound."""
        return np.asarray(np.isfinite(np.concatenate([self.z_bound, self.u_bound], axis=1)).all(axis=1))


@check_arguments
def rounding_bound(
    law: SampledLaw,
    k: float | ArrayLike,
    z: ArrayLike,
    y: ArrayLike,
    r: ArrayLike | None = None,
    p: ArrayLike | None = None,
) -> RoundingBound:
    """Bounds of |single - double| for memory and commands of a law after one period, for each row of its arguments.

    Parameters
    ----------
    k
        Numbers of the instants, (B,) or one for all.
    z, y, r
        Memory (B, nz), readings (B, ny) and references (B, nr; none for a law without), in doubles.
    p
        Parameters (np,), those of the law unless given.

    Raises
    ------
    ValueError
        If an array has another shape than the law's layout says.
    """
    rows, graph = rows_of("rounding_bound", law, k, z, y, r), step_graph(law, p)
    walk = RoundingAnalysis.of(law, graph, rows)
    with np.errstate(all="ignore"):
        walk.make()
    count, nz = len(rows.k), law.memory.size
    results = graph.graph.results
    values = np.stack([np.broadcast_to(walk.value(place), count) for place in results], axis=1)
    bounds = np.stack([np.broadcast_to(walk.bound(place), count) for place in results], axis=1)
    causes = np.stack([np.broadcast_to(walk.cause(place), count) for place in results], axis=1)
    words = {int(place): reason(law, graph, int(place)) for place in np.unique(causes) if place != NO_CAUSE}
    (z, u), (z_bound, u_bound) = (np.split(part, [nz], axis=1) for part in (values, bounds))
    z_cause, u_cause = np.split(causes, [nz], axis=1)
    return RoundingBound(z, u, z_bound, u_bound, z_cause, u_cause, words)


@dataclass(frozen=True, eq=False)
class RoundingAnalysis:
    """The nodes of a graph in their order, each with its value, its bound, and the cause where it has none."""

    graph: StepGraph
    variable_nodes: tuple[int, ...]
    evaluation: Evaluation[Lanes]
    sources: Mapping[int, Lanes]
    bounded_values: dict[int, BoundedValue]
    causes: dict[int, NDArray[np.int64]]

    @cached_property
    def lists(self) -> LoopBounds:
        """The arrays and loops, with the values of this walk."""
        return LoopBounds(self.graph.graph, self.bounded_values)

    @staticmethod
    def of(law: SampledLaw, graph: StepGraph, rows: LawArguments) -> RoundingAnalysis:
        """The walk at its start: all that single precision reads is a double, rounded once."""
        nodes, place_of, inputs = graph.graph.nodes, input_place(law), rows.inputs
        needed = set(graph.graph.before(graph.graph.results))
        moving = tuple(i for i in graph.variable_nodes if i in needed)
        sources: dict[int, Lanes] = {
            i: inputs[:, place_of(nodes[i].op, nodes[i].entry)] for i in moving if not nodes[i].operands
        }
        sources |= {i: value for i, value in instant_values(graph, rows.k).items() if i in needed}
        return RoundingAnalysis(
            graph, moving, Evaluation(graph.graph, Arrays(False), sources.__getitem__), sources, {}, {}
        )

    def make(self) -> None:
        """All nodes."""
        for place in self.sources:
            self._source(place)
        self.evaluation.make(self.variable_nodes)
        for place in self.variable_nodes:
            if place not in self.sources:
                self._node(place)

    def value(self, place: int) -> Reals:
        """The value in doubles."""
        return self.bounded_values[place].value

    def bound(self, place: int) -> Reals:
        """The bound of |single - double|."""
        return self.bounded_values[place].bound

    def cause(self, place: int) -> NDArray[np.int64] | np.int64:
        """The place of the operation for which a value has no bound, or -1."""
        return self.causes.get(place, np.int64(NO_CAUSE))

    def _source(self, place: int) -> None:
        value = np.asarray(self.sources[place], float)
        single = value.astype(np.float32).astype(float)
        bound = np.where(single == value, 0.0, np.abs(single - value))
        positive = place in self.graph.numbers and bool(value >= 0)
        self._keep(place, BoundedValue(value, bound, positive), ())

    def _node(self, place: int) -> None:
        node = self.graph.graph.nodes[place]
        if node.op in OF_ARRAYS:
            self.lists.make_of_arrays(place, node)
            if place in self.bounded_values:  # of an item: what has no bound in an array has lost it in a loop
                self._keep(place, self.bounded_values[place], ())
            return
        value = np.asarray(self.evaluation.value(place), float)
        self._keep(place, bound_of(node.op, node.operands, value, self.bounded_values), node.operands)

    def _keep(self, place: int, enclosed: BoundedValue, operands: tuple[int, ...]) -> None:
        """Keep a value; where it has no bound, the cause is that of the first operand without one, or itself."""
        self.bounded_values[place] = enclosed
        lost = ~np.isfinite(enclosed.bound)
        if lost.any():
            cause = np.where(lost, place, NO_CAUSE)
            for i in reversed(operands):
                if i in self.causes:
                    cause = np.where(lost & (self.causes[i] != NO_CAUSE), self.causes[i], cause)
            self.causes[place] = cause


def reason(law: SampledLaw, graph: StepGraph, place: int) -> str:
    """The operation at a place in words, with the names that its operands have among the law's values."""
    op, operands, *_ = graph.graph.nodes[place]
    if op in REASONS:
        return REASONS[op].format(*(name(law, graph, i) for i in operands))
    return f"size of {name(law, graph, place)}"


def name(law: SampledLaw, graph: StepGraph, place: int) -> str:
    """The name of a value: a number, an input, a value of a stage, or the one that it leads to."""
    node = graph.graph.nodes[place]
    if place in graph.numbers:
        return f"{graph.numbers[place]:.6g}"
    if node.op == "x":
        return law.memory.labels[node.entry]
    if node.op == "p":
        return law.step.parameters.labels[node.entry]
    if node.op in ("neg", "fabs"):
        inner = name(law, graph, node.operands[0])
        return f"-{inner}" if node.op == "neg" else f"|{inner}|"
    values = _values(graph)
    if place in values:
        return values[place]
    needed = {target: set(graph.graph.before([target])) for target in values}
    beyond = min((target for target in values if place in needed[target]), key=lambda i: len(needed[i]), default=None)
    return f"operation {place}" if beyond is None else f"a part of {values[beyond]}"


def _values(graph: StepGraph) -> dict[int, str]:
    """The names of the nodes that the stages of a law name, the first name of each."""
    names: dict[int, str] = {}
    for stage in graph.values:
        for label, places in stage.items():
            for i, place in enumerate(places):
                if place is not None:
                    names.setdefault(place, f"{label}[{i}]" if len(places) > 1 else label)
    return names
