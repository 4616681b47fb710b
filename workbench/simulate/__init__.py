"""Many runs of one `Step`: trajectories, divergence and the limit on the step.

The variable-step reference mode for one run of an `Ode` is `workbench.simulate.reference`.
"""

from workbench.simulate.batch import simulate
from workbench.simulate.stability import StepLimit, step_limit
from workbench.simulate.trajectories import Trajectories

__all__ = ["StepLimit", "Trajectories", "simulate", "step_limit"]
