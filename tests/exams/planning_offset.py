"""The kind `offset` of the planning exam, as the workbench answers it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.linear_mpc import (
    MpcLimits,
    limited_target,
    mpc_problem,
    no_memory,
    offset_free,
    solve_period,
    splitting_numbers,
)


def solve(case: dict[str, Any]) -> Callable[[Array], Array]:
    """The law with a fixed number of sweeps, about the target of its disturbance observer."""
    limits = MpcLimits(inputs=(case["u_min"], case["u_max"]))
    problem = mpc_problem(case["A"], case["B"], case["Q"], case["R"], int(case["N"]), limits)
    numbers, offset = splitting_numbers(problem), offset_free(problem, case["C"])
    nx, r = len(problem.A), np.asarray(case["r"], dtype=float)
    estimate = np.concatenate([case["x0"], np.zeros(len(r))])
    memory = no_memory(numbers)

    def law(y: Array) -> Array:
        nonlocal estimate, memory
        estimate = offset.correct(estimate, np.asarray(y, dtype=float))
        target = limited_target(offset, problem, estimate[nx:], r)
        answer = solve_period(numbers, memory, estimate[:nx], target)
        memory = answer.memory
        estimate = offset.predict(estimate, answer.u)
        return answer.u

    return law
