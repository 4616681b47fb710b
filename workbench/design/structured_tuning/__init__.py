"""Controllers of given structure by a nonsmooth search over exact gradients, certified afresh.

Read `structured_design.py` first, then `multistart.py` and `nonsmooth_search.py`; `figure_pieces.py` has the peaks and
poles of which the goals are made.

Examples
--------
>>> wb.structured_tuning.DesignGoal("hinf").words
'H-infinity norm as small as possible'
"""

from workbench.design.structured_tuning.controller_structure import ControllerStructure
from workbench.design.structured_tuning.design_goals import DesignGoal, GoalValue
from workbench.design.structured_tuning.loop_goals import LoopGoal
from workbench.design.structured_tuning.multistart import StartResult
from workbench.design.structured_tuning.parametric_systems import ParametricSystem
from workbench.design.structured_tuning.structured_answer import StructuredDesign
from workbench.design.structured_tuning.structured_design import structured_controller, tune_systems

__all__ = [
    "ControllerStructure",
    "DesignGoal",
    "GoalValue",
    "LoopGoal",
    "ParametricSystem",
    "StartResult",
    "StructuredDesign",
    "structured_controller",
    "tune_systems",
]
