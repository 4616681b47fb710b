"""The simulation of many runs of one equation at once, and the metrics of these runs.

`kernel` compiles the step of an equation; `machines` lists the operations of a step and spells them for each
language; `metrics` measures runs while they go on; `factors.py` gives each run its numbers; `reference` follows one
run and locates each of its switches. Plants and laws are not known here. Read `batch.py` first, then `arithmetic.py`
and `kernel/plan.py`.
"""

from workbench.engine.simulation import simulate
from workbench.engine.stability import StepLimit
from workbench.engine.step_limits import step_limit
from workbench.engine.trajectories import Trajectories

__all__ = ["StepLimit", "Trajectories", "simulate", "step_limit"]
