"""The kind `mpc` of the planning exam, as the workbench answers it."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.planning.linear_mpc import ExactMpc, MpcConflictError, MpcLimits, exact_mpc, mpc_problem


def solve(case: dict[str, Any]) -> dict[str, Any]:
    """First moves, objectives and infeasible states."""
    exact = solver(case)
    moves, objectives, flags = [], [], []
    for x in case["X"]:
        try:
            answer = exact.solve(x)
        except MpcConflictError:
            moves.append(np.full(case["B"].shape[1], np.nan))
            objectives.append(np.nan)
            flags.append(True)
            continue
        moves.append(answer.u[0])
        objectives.append(answer.objective)
        flags.append(False)
    return {"u0": np.array(moves), "objective": np.array(objectives), "infeasible": flags}


def solver(case: dict[str, Any]) -> ExactMpc:
    """The exact law of a case."""
    A, B, Q, R, P, N = (case[name] for name in ("A", "B", "Q", "R", "P", "N"))
    limits = MpcLimits(inputs=(case["u_min"], case["u_max"]), states=(case["x_min"], case["x_max"]))
    return exact_mpc(mpc_problem(A, B, Q, R, int(N), limits, P=P))
