"""Control laws for arms, one a file; each opens with the equations of its book, and the code repeats them by letter.

A law uses estimates, references and a model of the arm; it does not use the arm that is simulated.
`sliding_surface.py` has the base class of the sliding mode laws. Read `sliding_mode.py` first.
"""

from workbench.arms.laws.adaptive_sliding_mode import (
    AbstractAdaptation,
    AdaptiveSlidingMode,
    DeadZoneAdaptation,
    LeakageAdaptation,
    NoAdaptation,
    PlainAdaptation,
)
from workbench.arms.laws.aosmc_rgs import K_STAYS_DEFINITE, SHAPES, AosmcRgs
from workbench.arms.laws.arm_pid import ArmPID
from workbench.arms.laws.arm_state_feedback import ArmStateFeedback
from workbench.arms.laws.computed_torque import ComputedTorque
from workbench.arms.laws.disturbance_compensation import DisturbanceCompensation
from workbench.arms.laws.fuzzy_asmc import FuzzyAsmc, RuleBase
from workbench.arms.laws.rbf_asmc import RbfAsmc
from workbench.arms.laws.rise import Rise
from workbench.arms.laws.scheduled_feedback import ScheduledFeedback
from workbench.arms.laws.sdre import Sdre
from workbench.arms.laws.sliding_mode import SlidingMode
from workbench.arms.laws.sliding_surface import AbstractSlidingMode
from workbench.arms.laws.super_twisting import SuperTwisting
from workbench.arms.laws.terminal_sliding_mode import NonsingularTerminalSlidingMode

__all__ = [
    "AbstractAdaptation",
    "AbstractSlidingMode",
    "AdaptiveSlidingMode",
    "AosmcRgs",
    "ComputedTorque",
    "DeadZoneAdaptation",
    "NoAdaptation",
    "FuzzyAsmc",
    "K_STAYS_DEFINITE",
    "LeakageAdaptation",
    "NonsingularTerminalSlidingMode",
    "ArmPID",
    "PlainAdaptation",
    "RbfAsmc",
    "Rise",
    "RuleBase",
    "SHAPES",
    "ScheduledFeedback",
    "Sdre",
    "SlidingMode",
    "ArmStateFeedback",
    "SuperTwisting",
    "DisturbanceCompensation",
]
