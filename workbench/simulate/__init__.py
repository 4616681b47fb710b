"""Many runs of one `Step`: trajectories, divergence, the limit on the step, and the step for a stated tolerance.

The room knows steps and numbers; it does not know what a plant or a law is. `kernel` turns a step into a loop of
machine code. Read `batch.py` first, then `arithmetic.py` and `kernel/plan.py`; one run with every switch located is
`workbench.reference`.
"""

from workbench.simulate.simulation import simulate
from workbench.simulate.stability import StepLimit
from workbench.simulate.step_size import step_limit
from workbench.simulate.trajectories import Trajectories

__all__ = ["StepLimit", "Trajectories", "simulate", "step_limit"]
