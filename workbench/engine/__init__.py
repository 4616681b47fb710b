"""The simulation of many runs of one `Step` at once, and the metrics of these runs.

`kernel` turns a step into a loop of machine code, by the table of operations in `machines`; `metrics` measures runs
while they go on; `factors.py` gives each run its numbers; `reference` follows one run and locates each of its switches.
The room knows steps and numbers, and no plant or law. Read `batch.py` first, then `arithmetic.py` and `kernel/plan.py`.
"""

from workbench.engine.simulation import simulate
from workbench.engine.stability import StepLimit
from workbench.engine.step_limits import step_limit
from workbench.engine.trajectories import Trajectories

__all__ = ["StepLimit", "Trajectories", "simulate", "step_limit"]
