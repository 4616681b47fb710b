"""The kind `conflict` of the planning exam, as the workbench answers it."""

from __future__ import annotations

from typing import Any

from workbench.planning import PlanConflictError, PlanItem

from .planning_plan import planned


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The names of the limits and values at fault."""
    try:
        planned(case)
    except PlanConflictError as conflict:
        return {"status": "infeasible", "conflict": [_name(item) for item in conflict.items]}
    return {"status": "solved", "conflict": []}


def _name(item: PlanItem) -> str:
    prefix = {"start": "x0:", "end": "xT:"}.get(item.kind, "")
    return "T" if item.kind == "duration" else prefix + item.label
