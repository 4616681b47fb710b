"""Planning: trajectories of least cost within limits, and feedback along them.

`plan` finds a trajectory by collocation or shooting, and the simulator judges it. The package knows equations and their
inputs alone; a plan is followed in a loop by the blocks `wb.PlannedReference` and `wb.TrajectoryFeedback`. Read
`trajectories/plan_trajectory.py` first.

Examples
--------
>>> motor = wb.open_loop(wb.DCMotor())
>>> turn = wb.plan(motor, 1.0, cost="energy", end={"omega": 0.1, "i": 0.5}, limits={"v": (-24.0, 24.0)})
>>> turn.certificate.is_passed
True
"""

from workbench.core.lazy_names import lazy_names

_FILES = {
    "trajectories": "Funnel Phase Plan PlanCertificate PlanConflictError PlanItem PlanOptions TrajectoryRegulator "
    "funnel plan trajectory_lqr"
}
__all__, __getattr__, __dir__ = lazy_names(__name__, _FILES)
