"""Many runs of one `Step`: trajectories, divergence, the limit on the step, and the step for a stated tolerance.

The room knows steps and numbers; it does not know what a plant or a law is. `kernel` turns a step into a loop of
machine code; `machines` has the table of operations, spelled for each language. Read `batch.py` first, then
`arithmetic.py` and `kernel/plan.py`; one run with every switch located is `workbench.engine.reference`.
"""

from workbench.engine.simulation import simulate
from workbench.engine.stability import StepLimit
from workbench.engine.step_size import step_limit
from workbench.engine.trajectories import Trajectories

__all__ = ["StepLimit", "Trajectories", "simulate", "step_limit"]
