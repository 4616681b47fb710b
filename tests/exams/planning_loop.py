"""The kind `loop` of the planning exam, as the workbench answers it."""

from __future__ import annotations

from typing import Any

import numpy as np

from .planning_mpc import solver

PERIODS = 50


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """The inputs of 50 periods under the exact law, and their cost."""
    exact, x, inputs, cost = solver(case), case["x0"], [], 0.0
    for _ in range(PERIODS):
        u = exact.first_move(x)
        inputs.append(u)
        cost += float(x @ case["Q"] @ x + u @ case["R"] @ u)
        x = case["A"] @ x + case["B"] @ u
    return {"u": np.array(inputs), "cost": cost}
