"""Control laws for any plant, one a file: PID, cascade, state feedback, gain scheduling, and linear laws with limits.

A law reads estimates and references, and gives commands; it does not know the plant, the observer or the simulator.
Its ports declare the signals that it reads, follows and drives. Read `state_feedback.py` first, then `pid.py`.
"""

from workbench.blocks.laws.cascade import Cascade
from workbench.blocks.laws.limited_law import LimitedLaw
from workbench.blocks.laws.model_predictive import ModelPredictive
from workbench.blocks.laws.nonlinear_predictive import NonlinearPredictive
from workbench.blocks.laws.pid import PID
from workbench.blocks.laws.safety_filter import SafetyFilter
from workbench.blocks.laws.scheduled_law import ScheduledLaw
from workbench.blocks.laws.state_feedback import StateFeedback
from workbench.blocks.laws.trajectory_feedback import TrajectoryFeedback
from workbench.blocks.loop.linear_blocks import LinearLaw

__all__ = [
    "Cascade",
    "LimitedLaw",
    "ModelPredictive",
    "NonlinearPredictive",
    "PID",
    "SafetyFilter",
    "ScheduledLaw",
    "StateFeedback",
    "LinearLaw",
    "TrajectoryFeedback",
]
