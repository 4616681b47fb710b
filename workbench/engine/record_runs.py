"""Runs of a step along a record: the states of many runs at each of its instants."""

from __future__ import annotations

import numpy as np

from workbench.core import StepMap
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.engine.arithmetic import arithmetic_of, march_of
from workbench.engine.job import Job, stop_check


@check_arguments
def run_along(step: StepMap, p: Array, x0: Array, arithmetic: str = "") -> Array:
    """The states (B, N + 1, nx) of B runs of a step of `recorded_step` at the N + 1 instants of its record.

    `p` (B, np) and `x0` (B, nx) are the parameters and initial states, checked by the caller. A run that diverges has
    rows that are not finite. `arithmetic` is that of `simulate`, by default the one that follows from the step.
    """
    rows = step.recorded_numbers
    assert rows is not None  # as `recorded_step` makes them
    look = stop_check()
    job = Job(step, p, 1, 0, np.arange(len(p)), arithmetic=arithmetic or arithmetic_of(step))
    x = np.empty((len(p), len(rows) + 1, step.states.size))
    x[:, 0] = x0
    march_of(job)(job, x, lambda share: look())
    return x
