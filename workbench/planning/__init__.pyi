"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.planning.trajectories import Phase, Plan, PlanCertificate, PlanConflictError, PlanItem, plan

__all__ = ["Phase", "Plan", "PlanCertificate", "PlanConflictError", "PlanItem", "plan"]
