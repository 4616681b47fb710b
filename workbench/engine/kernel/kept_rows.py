"""Rows that a march keeps: what only they need is made behind the last step of a row, and not in each step."""

from __future__ import annotations

from collections.abc import Callable

from workbench.engine.kernel.emission import Emission
from workbench.engine.kernel.plan import KernelPlan


def states_of_rows(plan: KernelPlan) -> frozenset[int]:
    """The states that no step reads, as signals that are held and nothing else; none beside segments."""
    read = {node.entry for node in plan.graph.nodes if node.op == "x"}
    return frozenset(() if plan.segments else set(range(plan.states)) - read)


def nodes_of_steps(plan: KernelPlan) -> tuple[int, ...]:
    """The nodes of `plan.inside` that each step makes."""
    own = states_of_rows(plan)
    needed = set(plan.graph.before(place for i, place in enumerate(plan.graph.results) if i not in own))
    return tuple(i for i in plan.inside if i in needed)


def make_rows(plan: KernelPlan, step: Emission, load: Callable[[Emission, int], str]) -> tuple[Emission, list[str]]:
    """The lines behind the last step of a row, which make what only rows need, and all states at the end of a step."""
    made, own = frozenset(nodes_of_steps(plan)), states_of_rows(plan)

    def value(e: Emission, place: int) -> str:
        return step.evaluation.value(place) if place in made else load(e, place)

    rows = Emission(plan.graph, step.width, step.fused_products, "t", value, "keep", step.room)
    rows.evaluation.arrays |= step.evaluation.arrays
    rows.evaluation.loops |= step.evaluation.loops
    rows.evaluation.make(i for i in plan.inside if i not in made)
    ends = enumerate(plan.graph.results[: plan.states])
    return rows, [(rows if i in own else step).evaluation.value(place) for i, place in ends]
