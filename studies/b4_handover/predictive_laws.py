"""A predictive law on a Cortex-M7: its instructions beside those of TinyMPC and OSQP on the same states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.b4_handover.osqp_code import osqp_lacks, osqp_run
from studies.b4_handover.predictive_problems import HORIZONS, IDLE, PUSHED, PredictiveProblem, problems
from studies.b4_handover.solver_program import SolverRun
from studies.b4_handover.tinympc import tinympc_lacks, tinympc_run

WORK = "predictive"
PERIODS = 60
PENALTIES = (0.1, 1.0, 10.0)  # of TinyMPC, of which the one with the fewest instructions counts


@dataclass(frozen=True, eq=False)
class SolverCount:
    """Instructions of a period in the mean and at most, and the root mean square error of the first move in spans.

    `passes` are the sweeps of a period, or iterations in the mean.
    """

    mean: float
    most: float
    error: float
    passes: float


@dataclass(frozen=True, eq=False)
class PredictiveCount:
    """A law on the Cortex-M7, and TinyMPC and OSQP beside it; None for what is not here, with the reasons.

    `active` is the share of first moves at a limit; the stack, and the state with its arrays, are in bytes.
    """

    active: float
    differing_bits: int
    law: SolverCount | None
    stack: int | None
    room: int
    tinympc: SolverCount | None
    osqp: SolverCount | None
    reasons: tuple[str, ...]


def predictive_work() -> wb.Work:
    """The counts of all problems, horizons and runs."""
    return wb.Work(WORK, predictive_count, predictive_keys(), seconds=20.0)


def predictive_keys() -> tuple[str, ...]:
    """The keys of the counts: problem, horizon and run."""
    return tuple(f"{one.name}|{N}|{run}" for one in problems() for N in HORIZONS for run in (PUSHED, IDLE))


def predictive_count(key: str) -> PredictiveCount:
    """The counts of one problem, one horizon and one run."""
    name, horizon, run = key.split("|")
    problem = next(one for one in problems() if one.name == name)
    design = problem.design(int(horizon))
    replay = wb.replay(problem.loop(int(horizon), run), name="law", periods=PERIODS, targets=("cortex-m7",))
    (result,), own = replay.results, replay.results[0].figures
    states, moves = (np.asarray(part, dtype=float) for part in (replay.recording.y, replay.recording.u))
    exact = np.array([design.exact.first_move(state) for state in states])
    active = float(np.mean(_acts(problem, design.problem, exact)))
    law = None
    if own.instructions is not None and own.most is not None:
        law = SolverCount(own.instructions, own.most, _error(problem, moves, exact), design.numbers.sweeps)
    room = 8 * (replay.code.law.memory.size + replay.code.costs.room)
    tinympc = osqp = None
    if not result.reason and not tinympc_lacks():
        runs = (tinympc_run(design.problem, problem.low, problem.high, one, states) for one in PENALTIES)
        tinympc = min((_counted(problem, one, exact) for one in runs), key=lambda count: count.mean)
    if not result.reason and not osqp_lacks() and not problem.cones:
        osqp = _counted(problem, osqp_run(design.problem, problem.low, problem.high, states), exact)
    reasons = tuple(dict.fromkeys(one for one in (result.reason, tinympc_lacks(), osqp_lacks()) if one))
    return PredictiveCount(active, result.differing_bits, law, own.stack, room, tinympc, osqp, reasons)


def _counted(problem: PredictiveProblem, run: SolverRun, exact: wb.Array) -> SolverCount:
    """The count of a run of another solver."""
    mean, passes = float(run.instructions.mean()), float(run.iterations.mean())
    return SolverCount(mean, float(run.instructions.max()), _error(problem, run.u, exact), passes)


def _error(problem: PredictiveProblem, moves: wb.Array, exact: wb.Array) -> float:
    """The root mean square error of moves, in spans of their limits."""
    return float(np.sqrt(np.mean(((moves - exact) / (problem.high - problem.low)) ** 2)))


def _acts(problem: PredictiveProblem, posed: wb.planning.LinearMpc, exact: wb.Array) -> wb.Array:
    """True (T, nu) for first moves (T, nu) at a limit, and for the inputs of a cone at its edge."""
    edge = 1e-9 * (problem.high - problem.low)
    acts = (exact <= problem.low + edge) | (exact >= problem.high - edge)
    for cone in posed.rows.cones:
        across, along = exact[:, list(cone.inputs[:-1])] - cone.centre, exact[:, cone.inputs[-1]]
        radius = cone.slope * along + cone.offset
        acts[:, list(cone.inputs)] |= (np.linalg.norm(across, axis=1) >= radius - 1e-9 * cone.offset)[:, None]
    return np.asarray(acts)
