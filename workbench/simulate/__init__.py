"""Many runs of one `Step`: trajectories, divergence and the limit on the step.

The variable-step reference mode for one run of an `Ode` is `workbench.reference`.
"""

from workbench.simulate.alike import simulate_alike
from workbench.simulate.batch import simulate, simulate_both
from workbench.simulate.stepping.accuracy import check_by_halving
from workbench.simulate.stepping.pilot import choose, pilot_rows
from workbench.simulate.stepping.schedule import Schedule, run
from workbench.simulate.stepping.stability import StepLimit, step_limit
from workbench.simulate.trajectories import Trajectories

__all__ = [
    "Schedule",
    "StepLimit",
    "Trajectories",
    "check_by_halving",
    "choose",
    "pilot_rows",
    "run",
    "simulate",
    "simulate_alike",
    "simulate_both",
    "step_limit",
]
