"""Control laws, one a file; each opens with the equations of its book, which the code repeats letter by letter.

A law knows estimates, wanted signals and the model that its designer believes in; it does not know the true plant, the
observer or the simulator. Read `sliding_mode.py` first, for any plant `regulator.py`; `sliding_surface.py` holds what
the sliding laws share.
"""

from workbench.controllers.adaptive_sliding_mode import (
    AbstractAdaptation,
    AdaptiveSlidingMode,
    DeadZone,
    Frozen,
    Leakage,
    Plain,
)
from workbench.controllers.aosmc_rgs import AosmcRgs
from workbench.controllers.cascade import Cascade
from workbench.controllers.compensation import WithCompensation
from workbench.controllers.computed_torque import ComputedTorque
from workbench.controllers.fuzzy_asmc import FuzzyAsmc, RuleBase
from workbench.controllers.pid import PID
from workbench.controllers.pid2 import PID2
from workbench.controllers.rbf_asmc import RbfAsmc
from workbench.controllers.regulator import Regulator
from workbench.controllers.rise import Rise
from workbench.controllers.scheduled_feedback import ScheduledFeedback
from workbench.controllers.sdre import Sdre
from workbench.controllers.sliding_mode import SlidingMode
from workbench.controllers.state_feedback import StateFeedback
from workbench.controllers.super_twisting import SuperTwisting
from workbench.controllers.terminal_sliding_mode import NonsingularTerminalSlidingMode
from workbench.loop.linear_blocks import LinearLaw

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
