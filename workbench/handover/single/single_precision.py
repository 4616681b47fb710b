"""A sampled law in single precision: the same graph with 32-bit floats, for many rows at once.

What depends on numbers alone, on parameters or on the number of the instant is made in doubles and rounded once; all
that depends on memory, readings or references is made in floats, one operation after the other, none of them fused.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from workbench.core import SampledLaw
from workbench.core.validation.refusals import Array, describe, numbers
from workbench.core.validation.signatures import check_arguments
from workbench.engine.kernel.plan import Evaluation
from workbench.engine.machines.formula_table import IN_SINGLE
from workbench.engine.machines.numpy_spelling import Arrays, Lanes, Singles
from workbench.handover.law_graph import StepGraph, graph_of_law, split


class LawArguments(NamedTuple):
    """The arguments of a law, one row each: instants (B,), memory (B, nz), readings (B, ny), references (B, nr)."""

    k: Array
    z: Array
    y: Array
    r: Array

    @property
    def inputs(self) -> Array:
        """All but the instants, side by side."""
        return np.concatenate([self.z, self.y, self.r], axis=1)


class SinglePrecisionResult(NamedTuple):
    """Memory (B, nz) and commands (B, nu) of a law in single precision, as floats."""

    z_next: np.ndarray
    u: np.ndarray

    def __repr__(self) -> str:
        return f"<Singly: {len(self.u)} rows, {self.u.shape[1]} commands>"


@check_arguments
def single_precision(
    law: SampledLaw,
    k: float | ArrayLike,
    z: ArrayLike,
    y: ArrayLike,
    r: ArrayLike | None = None,
    p: ArrayLike | None = None,
) -> SinglePrecisionResult:
    """z+ = g(k, z, y, r, p) and u = c(k, z, y, r, p) of a law in single precision, row by row.

    Parameters
    ----------
    k
        Numbers of the instants, (B,) or one for all.
    z, y, r
        Memory (B, nz), readings (B, ny) and references (B, nr; none for a law without).
    p
        Parameters (np,), those of the law unless given.

    Raises
    ------
    ValueError
        If an array has another shape than the law's layout says.
    """
    rows = rows_of("single_precision", law, k, z, y, r)
    graph = step_graph(law, p)
    with np.errstate(all="ignore"):
        results = evaluate(law, graph, rows)
    nz = law.memory.size
    return SinglePrecisionResult(results[:, :nz], results[:, nz:])


def step_graph(law: SampledLaw, p: ArrayLike | None = None) -> StepGraph:
    """The graph of a law with these parameters (np,), or its own."""
    if p is None:
        return graph_of_law(law)
    held = numbers("single_precision(p=...)", p)
    if held.shape != (law.parameters.size,):
        wanted = f"({law.parameters.size},), one for each parameter of '{law.name}'"
        raise ValueError(f"The parameters of a law must have the shape {wanted}; it is {held.shape}.")
    return split(law.step, held)


def rows_of(
    call: str, law: SampledLaw, k: float | ArrayLike, z: ArrayLike, y: ArrayLike, r: ArrayLike | None
) -> LawArguments:
    """The arguments of a law as rows of doubles, or a refusal that names the call and the shape."""
    layouts = {"z": law.memory, "y": law.readings, "r": law.references}
    readings = numbers(f"{call}(y=...)", y)
    count = len(np.atleast_2d(readings))
    wanted = np.zeros((count, 0)) if r is None else numbers(f"{call}(r=...)", r)
    held = {"z": numbers(f"{call}(z=...)", z), "y": readings, "r": wanted}
    for name, layout in layouts.items():
        if held[name].shape != (count, layout.size):
            raise ValueError(
                f"`{call}({name}=...)` must have the shape ({count}, {layout.size}): one row for each of y, with one "
                f"number for each of {', '.join(layout.labels) or 'nothing'}; it is {held[name].shape}."
            )
    instants = numbers(f"{call}(k=...)", k)
    if instants.shape not in ((), (1,), (count,)) or not np.all((instants >= 0) & (instants == np.floor(instants))):
        raise ValueError(
            f"`{call}(k=...)` must be a whole number from 0 on, or {count} of them, one for each row; it is "
            f"{describe(k)}."
        )
    return LawArguments(np.broadcast_to(instants, (count,)), *held.values())


def evaluate(law: SampledLaw, graph: StepGraph, rows: LawArguments) -> np.ndarray:
    """The results [z+; u] (B, nz + nu) in floats."""
    early = instant_values(graph, rows.k)
    nodes, place_of, inputs = graph.graph.nodes, input_place(law), rows.inputs

    def load(place: int) -> Lanes:
        if place in early:
            return np.asarray(early[place]).astype(np.float32)
        return inputs[:, place_of(nodes[place].op, nodes[place].entry)].astype(np.float32)

    evaluation = Evaluation(graph.graph, Singles(), load, IN_SINGLE)
    needed = set(graph.graph.before(graph.graph.results))
    evaluation.make(i for i in graph.variable_nodes if i in needed)
    results = [np.broadcast_to(evaluation.value(place), rows.k.shape) for place in graph.graph.results]
    return np.stack(results, axis=1).astype(np.float32, casting="no")


def instant_values(graph: StepGraph, k: Array) -> dict[int, Lanes]:
    """The values, in doubles, of the nodes that depend on numbers and on the number of the instant alone."""

    def load(place: int) -> Lanes:
        return np.float64(graph.numbers[place]) if place in graph.numbers else k

    evaluation = Evaluation(graph.graph, Arrays(False), load)
    evaluation.make(graph.instant_nodes)
    return {place: evaluation.value(place) for place in (*graph.numbers, *graph.instant_nodes)}


def input_place(law: SampledLaw) -> Callable[[str, int], int]:
    """Where an input of the graph of a law stands among memory, readings and references."""
    parameters, memory = law.parameters.size, law.memory.size
    return lambda op, entry: entry if op == "x" else memory + entry - parameters
