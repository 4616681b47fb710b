"""The room for editors and mypy: each of its names, and the file that it comes from."""

from workbench.planning.trajectories import (
    Funnel,
    Phase,
    Plan,
    PlanCertificate,
    PlanConflictError,
    PlanItem,
    PlanOptions,
    TrajectoryRegulator,
    funnel,
    plan,
    trajectory_lqr,
)

__all__ = [
    "Funnel",
    "Phase",
    "Plan",
    "PlanCertificate",
    "PlanConflictError",
    "PlanItem",
    "PlanOptions",
    "TrajectoryRegulator",
    "funnel",
    "plan",
    "trajectory_lqr",
]
