"""Many runs of one `Step`: trajectories, divergence and the limit on the step."""

from workbench.simulate.batch import simulate
from workbench.simulate.schedule import StepLimit, step_limit
from workbench.simulate.trajectories import Trajectories

__all__ = ["StepLimit", "Trajectories", "simulate", "step_limit"]
