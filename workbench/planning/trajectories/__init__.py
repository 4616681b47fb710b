"""Trajectories: plans of least cost within limits, their certificates and conflicts, and feedback along them.

Read `plan_trajectory.py` first, then `plan_problem.py`, `transcription.py` and `plan_search.py`.
"""

from workbench.planning.trajectories.conflict_search import PlanConflictError as PlanConflictError
from workbench.planning.trajectories.phase import Phase as Phase
from workbench.planning.trajectories.plan_certificate import PlanCertificate as PlanCertificate
from workbench.planning.trajectories.plan_items import PlanItem as PlanItem
from workbench.planning.trajectories.plan_options import PlanOptions as PlanOptions
from workbench.planning.trajectories.plan_trajectory import plan as plan
from workbench.planning.trajectories.sampled_funnel import Funnel as Funnel
from workbench.planning.trajectories.sampled_funnel import funnel as funnel
from workbench.planning.trajectories.trajectory_plan import Plan as Plan
from workbench.planning.trajectories.trajectory_regulator import TrajectoryRegulator as TrajectoryRegulator
from workbench.planning.trajectories.trajectory_regulator import trajectory_lqr as trajectory_lqr
