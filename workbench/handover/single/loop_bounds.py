"""The bounds of rounding through the arrays and loops of a graph: a loop is passed, pass by pass, with its bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from workbench.engine.kernel.graph import ARRAYS, Graph, Node, length
from workbench.engine.kernel.plan import Evaluation
from workbench.engine.machines.machine import MachineNumber
from workbench.engine.machines.numpy_spelling import Arrays, Lanes
from workbench.handover.single.further_rounding_rules import FURTHER_RULES
from workbench.handover.single.rounding_rules import (
    INFINITY,
    LARGEST,
    RULES,
    SLACK,
    BoundedValue,
    Reals,
    never_negative,
)

ALL_RULES = {**RULES, **FURTHER_RULES}
OF_ARRAYS = frozenset((*ARRAYS, "loop", "item"))
BoundedPart: TypeAlias = BoundedValue | list[BoundedValue]  # a number, or an array


def bound_of(op: str, operands: Sequence[int], value: Reals, values: Mapping[int, BoundedValue]) -> BoundedValue:
    """The value of an operation with its bound, from those of its operands."""
    bound = ALL_RULES[op](value, *[values[i] for i in operands]) * SLACK
    finite = np.abs(value) + bound <= LARGEST  # false for a value or a bound that is no number
    positive = {i: values[i].positive for i in operands}
    return BoundedValue(value, np.where(finite, bound, INFINITY), never_negative(op, tuple(operands), positive))


@dataclass(frozen=True, eq=False)
class LoopBounds:
    """The values with bounds of a graph or of the body of a loop, in which arrays and loops have their lists.

    Attributes
    ----------
    values
        The numbers, by their places.
    arrays
        The numbers of each array.
    """

    graph: Graph
    values: dict[int, BoundedValue]
    arrays: dict[int, list[BoundedValue]] = field(default_factory=dict)
    loops: dict[int, list[list[BoundedValue]]] = field(default_factory=dict)

    def make_of_arrays(self, place: int, node: Node) -> None:
        """An array, an entry of one, or all passes of a loop."""
        first = node.operands[0]
        match node.op:
            case "loop":
                self.loops[place] = self._passes(node)
            case "loop_end":
                self.arrays[place] = self.loops[first][0]
            case "loop_rows":
                self.arrays[place] = self.loops[first][1 + node.entry]
            case "item":
                self.values[place] = self.arrays[first][node.entry]
            case "slice":
                self.arrays[place] = self.arrays[first][node.entry : node.entry + length(node)]
            case "array":
                self.arrays[place] = self._joined(node.operands)

    def _part(self, place: int) -> BoundedPart:
        return self.arrays[place] if length(self.graph.nodes[place]) else self.values[place]

    def _joined(self, places: Sequence[int]) -> list[BoundedValue]:
        parts = (self._part(i) for i in places)
        return [value for part in parts for value in (part if isinstance(part, list) else [part])]

    def _passes(self, node: Node) -> list[list[BoundedValue]]:
        """The carried values at the end of a loop, and each array of rows that it made."""
        loop, last = node.loop, node.entry
        assert loop is not None
        carried, behind = self._joined(node.operands[:last]), last + len(loop.row_sizes)
        rows = [self._joined([i]) for i in node.operands[last:behind]]
        shared = [self._part(i) for i in node.operands[behind:]]
        passes = list[list[list[BoundedValue]]]()
        for k in range(loop.count):
            i = loop.count - 1 - k if loop.backward else k
            own = [part[i * size : (i + 1) * size] for part, size in zip(rows, loop.row_sizes, strict=True)]
            carried, *made = _one_pass(loop.body, loop.split(loop.body.results), [carried, *own], shared)
            passes.append(made)
        in_order = passes[::-1] if loop.backward else passes
        return [carried, *([value for made in in_order for value in made[i]] for i in range(len(loop.result_sizes)))]


def _one_pass(
    body: Graph, results: Sequence[Sequence[int]], own: Sequence[list[BoundedValue]], shared: Sequence[BoundedPart]
) -> list[list[BoundedValue]]:
    """The next carried values of a body, and the rows that it makes."""
    bounds, machine = LoopBounds(body, {}), Arrays(False)

    def load(place: int) -> Lanes:
        return bounds.values[place].value

    evaluation = Evaluation(body, machine, load)
    for place, node in enumerate(body.nodes):
        if node.op in OF_ARRAYS:
            bounds.make_of_arrays(place, node)
        elif node.operands:
            evaluation.make([place])
            value = np.asarray(evaluation.value(place), float)
            bounds.values[place] = bound_of(node.op, node.operands, value, bounds.values)
        elif node.op == "const":
            bounds.values[place] = BoundedValue(np.float64(node.value), np.float64(0.0), node.value >= 0)
        else:
            part = shared[node.entry] if node.op == "shared" else own[0 if node.op == "carried" else 1 + node.entry]
            if isinstance(part, list):
                bounds.arrays[place] = part
            else:
                bounds.values[place] = part
        if place in bounds.values:
            evaluation.numbers.setdefault(place, MachineNumber(machine, bounds.values[place].value))
    return [bounds._joined(places) for places in results]
