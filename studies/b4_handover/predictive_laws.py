"""A predictive law on a Cortex-M7: its instructions beside those of TinyMPC on the same states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.b4_handover.predictive_problems import HORIZONS, IDLE, PUSHED, PredictiveProblem, problems
from studies.b4_handover.tinympc import TinyMpcRun, lacking, tinympc_run

WORK = "predictive"
PERIODS = 60
PENALTIES = (0.1, 1.0, 10.0)  # of TinyMPC, of which the one with the fewest instructions counts


@dataclass(frozen=True, eq=False)
class SolverCount:
    """Instructions of a period in the mean and at most, and the root mean square error of the first move in spans.

    `passes` are the sweeps of a period, or iterations in the mean; `penalty` is that of TinyMPC.
    """

    mean: float
    most: float
    error: float
    passes: float
    penalty: float = 0.0


@dataclass(frozen=True, eq=False)
class PredictiveCount:
    """A law on the Cortex-M7 and TinyMPC beside it, None where it is not here.

    `active` is the share of first moves at a limit; stack, and the state with its arrays, are in bytes.
    """

    active: float
    differing_bits: int
    law: SolverCount | None
    stack: int | None
    room: int
    peer: SolverCount | None
    reason: str


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
    (result,) = replay.results
    states, moves = (np.asarray(part, dtype=float) for part in (replay.recording.y, replay.recording.u))
    exact = np.array([design.exact.first_move(state) for state in states])
    span = problem.high - problem.low
    edge = 1e-9 * span
    active = float(np.mean((exact <= problem.low + edge) | (exact >= problem.high - edge)))
    own, reason = result.figures, result.reason or lacking()
    law = None
    if own.instructions is not None and own.most is not None:
        law = SolverCount(own.instructions, own.most, _error(moves, exact, span), design.numbers.sweeps)
    peer = None if reason else _peer_count(problem, design, states, exact)
    room = 8 * (replay.code.law.memory.size + replay.code.costs.room)
    return PredictiveCount(active, result.differing_bits, law, own.stack, room, peer, reason)


def _peer_count(
    problem: PredictiveProblem, design: wb.planning.PredictiveDesign, states: wb.Array, exact: wb.Array
) -> SolverCount:
    """The count of TinyMPC, for the penalty with which it takes the fewest instructions."""
    span, counts = problem.high - problem.low, list[SolverCount]()
    for penalty in PENALTIES:
        run: TinyMpcRun = tinympc_run(design.problem, problem.low, problem.high, penalty, states)
        means = [float(part.mean()) for part in (run.instructions, run.iterations)]
        most = float(run.instructions.max())
        counts.append(SolverCount(means[0], most, _error(run.u, exact, span), means[1], penalty))
    return min(counts, key=lambda count: count.mean)


def _error(moves: wb.Array, exact: wb.Array, span: float) -> float:
    """The root mean square error of moves, in spans."""
    return float(np.sqrt(np.mean((moves - exact) ** 2)) / span)
