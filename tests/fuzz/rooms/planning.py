from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from workbench.planning.linear_mpc import (
    MpcConflictError,
    MpcLimits,
    dual_product,
    exact_loops,
    exact_mpc,
    limited_target,
    move_bound,
    mpc_problem,
    no_memory,
    offset_free,
    operation_count,
    plan_gap,
    recursion_numbers,
    sampled_loss,
    solve_period,
    splitting_numbers,
    tune_splitting,
)

A, B, C = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.0], [0.1]]), np.array([[1.0, 0.0]])
LIMITS = MpcLimits(inputs=(-1.0, 1.0))
PROBLEM = mpc_problem(A, B, np.eye(2), np.array([[0.1]]), 6, LIMITS)
HARD = mpc_problem(A, B, np.eye(2), np.array([[0.1]]), 6, MpcLimits(inputs=(-1.0, 1.0), states=(-2.0, 2.0)))
NUMBERS, EXACT = splitting_numbers(PROBLEM), exact_mpc(PROBLEM)
START = np.array([1.0, 0.0])


def calls() -> dict[str, Any]:
    states, moves = exact_loops(EXACT, START[np.newaxis], 3)
    answer = solve_period(NUMBERS, no_memory(NUMBERS), START)
    tuning = tune_splitting(EXACT, states, moves, accuracy=0.1)
    try:
        exact_mpc(HARD).solve(np.array([1.9, 30.0]))
    except MpcConflictError as error:
        proof = error.proof
    zeta = np.zeros(len(NUMBERS.low))
    return {
        "exact_loops": partial(exact_loops, EXACT, START[np.newaxis], 3),
        "move_bound": partial(move_bound, EXACT, NUMBERS, START, zeta),
        "plan_gap": partial(plan_gap, EXACT, START, zeta),
        "sampled_loss": partial(sampled_loss, EXACT, NUMBERS, START[np.newaxis], 3),
        "SampledLoss": partial(type(sampled_loss(EXACT, NUMBERS, START[np.newaxis], 3)), np.zeros(1), *[0.0] * 5, 0),
        "dual_product": partial(dual_product, recursion_numbers(PROBLEM), zeta),
        "OperationCount": partial(type(operation_count(NUMBERS)), *[1] * 8),
        "SplittingAnswer": partial(type(answer), *answer),
        "tune_splitting": partial(tune_splitting, EXACT, states, moves, accuracy=0.1),
        "SplittingTuning": partial(type(tuning), tuning.numbers, tuning.table),
        "TuningRow": partial(type(tuning.table[0]), "metric", "2 modes", 3, 100, 0.1),
        "limited_target": partial(limited_target, offset_free(PROBLEM, C), PROBLEM, [0.0], [0.5]),
        "InfeasibilityProof": partial(type(proof), proof.limits, proof.multipliers, proof.margin, proof.is_proved),
        "MpcConflictError": partial(MpcConflictError, "no input keeps all limits", proof),
    }


def arguments() -> dict[str, Any]:
    return {}
