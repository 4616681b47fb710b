"""Control laws, one a file; each opens with the equations of its book, which the code repeats letter by letter.

A law knows estimates, wanted signals and the model that its designer believes in; it does not know the true plant, the
observer or the simulator. Read `sliding_mode.py` first, for any plant `regulator.py`; `sliding_surface.py` holds what
the sliding laws share.
"""

from workbench.arms.laws.adaptive_sliding_mode import (
    AbstractAdaptation,
    AdaptiveSlidingMode,
    DeadZone,
    Frozen,
    Leakage,
    Plain,
)
from workbench.arms.laws.aosmc_rgs import AosmcRgs
from workbench.arms.laws.compensation import WithCompensation
from workbench.arms.laws.computed_torque import ComputedTorque
from workbench.arms.laws.fuzzy_asmc import FuzzyAsmc, RuleBase
from workbench.arms.laws.pid import PID
from workbench.arms.laws.rbf_asmc import RbfAsmc
from workbench.arms.laws.rise import Rise
from workbench.arms.laws.scheduled_feedback import ScheduledFeedback
from workbench.arms.laws.sdre import Sdre
from workbench.arms.laws.sliding_mode import SlidingMode
from workbench.arms.laws.state_feedback import StateFeedback
from workbench.arms.laws.super_twisting import SuperTwisting
from workbench.arms.laws.terminal_sliding_mode import NonsingularTerminalSlidingMode
from workbench.blocks.laws.cascade import Cascade
from workbench.blocks.laws.pid2 import PID2
from workbench.blocks.laws.regulator import Regulator
from workbench.blocks.loop.linear_blocks import LinearLaw

__all__ = [
    "PID",
    "PID2",
    "AbstractAdaptation",
    "AdaptiveSlidingMode",
    "AosmcRgs",
    "Cascade",
    "ComputedTorque",
    "DeadZone",
    "Frozen",
    "FuzzyAsmc",
    "Leakage",
    "LinearLaw",
    "NonsingularTerminalSlidingMode",
    "Plain",
    "RbfAsmc",
    "Regulator",
    "Rise",
    "RuleBase",
    "ScheduledFeedback",
    "Sdre",
    "SlidingMode",
    "StateFeedback",
    "SuperTwisting",
    "WithCompensation",
]
