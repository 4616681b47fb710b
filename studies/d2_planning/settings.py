"""One law in two settings: the few sweeps of its design, and as many as a tolerance needs, then a polish."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import workbench as wb
from studies.d2_planning.posed_problems import POSED

STARTS, PERIODS, SEED = 40, 12, 3720
REACH = 4.0  # by which the LQR answer passes a limit at most
TOLERANCE = 1e-8  # of a move, in spans
ACCURACY = 1e-2  # of a move, in spans: what a design asks of its own sample
COUNTS = (3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 60, 80, 100, 150, 200, 300, 500, 1000)


@dataclass(frozen=True)
class Errors:
    """The errors of a number of sweeps beside the exact law, the median and the largest.

    Those of moves are in spans of their limits, those of the costs of loops relative.
    """

    sweeps: int
    median_move: float
    largest_move: float
    beyond: float  # share of moves that err by more than 0.01
    median_cost: float
    largest_cost: float


@dataclass(frozen=True)
class Settings:
    """A problem in both settings, over sampled closed loops of the exact law.

    `moves` are those from states at which the LQR answer passes a limit. `many` has as many sweeps as bring each of
    them within `TOLERANCE`, or the largest number that was tried; `late` is the share of moves that are then still
    beyond it. The certificates are the largest after the polish, and `changes` is the largest number of changes of the
    active set.
    """

    method: str
    moves: int
    loops: int
    few: Errors
    many: Errors
    late: float
    violation: float
    sign: float
    gap: float
    changes: int


@dataclass(frozen=True, eq=False)
class ExactLoops:
    """Closed loops of the exact law: states (B, T, nx), its moves (B, T, nu), and the costs (B,)."""

    states: wb.Array
    moves: wb.Array
    costs: wb.Array
    matters: NDArray[np.bool_]  # (B, T), True where the LQR answer passes a limit
    solutions: tuple[wb.planning.MpcSolution, ...]


def compare_settings(name: str) -> Settings:
    """A posed problem in both settings."""
    posed = POSED[name]()
    exact, numbers = posed.exact, posed.numbers
    loops = exact_loops(exact)
    trials = (replace(numbers, sweeps=sweeps) for sweeps in COUNTS)
    most = replace(numbers, sweeps=COUNTS[-1])
    enough = next((one for one in trials if move_errors(one, loops).max() <= TOLERANCE), most)
    certificates = [answer.certificate for answer in loops.solutions]
    return Settings(
        f"metric, {len(numbers.L)} modes" if numbers.method == "metric" else "ADMM",
        int(loops.matters.sum()),
        len(loops.states),
        errors_of(exact, numbers, loops),
        errors_of(exact, enough, loops),
        float(np.mean(move_errors(enough, loops) > TOLERANCE)),
        max(one.violation for one in certificates),
        max(one.sign for one in certificates),
        max(one.gap for one in certificates),
        max(answer.polish_steps for answer in loops.solutions),
    )


def exact_loops(exact: wb.planning.ExactMpc) -> ExactLoops:
    """Loops of the exact law from drawn directions, in which the LQR answer passes a limit by a drawn factor."""
    rng, problem = np.random.default_rng(SEED), exact.problem
    root = np.linalg.cholesky(problem.P)
    loops: list[list[tuple[wb.Array, wb.planning.MpcSolution]]] = []
    while len(loops) < STARTS:
        direction = np.linalg.solve(root.T, rng.standard_normal(len(problem.A)))
        rows = exact.maps.Y @ direction
        passed = float(np.maximum(rows / problem.high, rows / problem.low).max())
        loop = exact_loop(exact, direction / passed * rng.uniform(1.0, REACH))
        if loop:
            loops.append(loop)
    states, moves = (
        np.array([[pick(x, answer) for x, answer in loop] for loop in loops])
        for pick in (lambda x, _: x, lambda _, answer: answer.u[0])
    )
    rows = states @ exact.maps.Y.T
    matters = np.asarray(((rows < problem.low) | (rows > problem.high)).any(axis=-1))
    solutions = tuple(answer for loop in loops for _, answer in loop)
    return ExactLoops(states, moves, costs_of(exact, states, moves), matters, solutions)


def exact_loop(exact: wb.planning.ExactMpc, x: wb.Array) -> list[tuple[wb.Array, wb.planning.MpcSolution]]:
    """The states and solutions of a loop of the exact law; none if it meets a state without a solution."""
    loop = []
    for _ in range(PERIODS):
        try:
            answer = exact.solve(x)
        except ValueError:
            return []
        loop.append((x, answer))
        x = exact.problem.A @ x + exact.problem.B @ answer.u[0]
    return loop


def move_errors(numbers: wb.planning.SplittingNumbers, loops: ExactLoops) -> wb.Array:
    """The errors of moves in spans where limits matter, of a law with its own memory along loops of the exact law."""
    nu = loops.moves.shape[-1]
    memory, errors = wb.planning.no_memory(numbers, len(loops.states)), []
    for k in range(PERIODS):
        answer = wb.planning.solve_period(numbers, memory, loops.states[:, k])
        memory = answer.memory
        errors.append(np.abs(answer.u - loops.moves[:, k]) / (numbers.high[:nu] - numbers.low[:nu]))
    return np.asarray(np.stack(errors, axis=1).max(axis=-1)[loops.matters])


def errors_of(exact: wb.planning.ExactMpc, numbers: wb.planning.SplittingNumbers, loops: ExactLoops) -> Errors:
    """The errors of a law: of its moves, and of the costs of its own loops from the same starts."""
    x, memory = loops.states[:, 0], wb.planning.no_memory(numbers, len(loops.states))
    states, moves = [], []
    for _ in range(PERIODS):
        answer = wb.planning.solve_period(numbers, memory, x)
        states.append(x)
        moves.append(answer.u)
        memory, x = answer.memory, x @ numbers.A.T + answer.u @ numbers.B.T
    loss = np.abs(costs_of(exact, np.stack(states, axis=1), np.stack(moves, axis=1)) / loops.costs - 1)
    own = move_errors(numbers, loops)
    beyond = float(np.mean(own > ACCURACY))
    costs = float(np.median(loss)), float(loss.max())
    return Errors(numbers.sweeps, float(np.median(own)), float(own.max()), beyond, *costs)


def costs_of(exact: wb.planning.ExactMpc, states: wb.Array, moves: wb.Array) -> wb.Array:
    """The costs (B,) of loops, with that of the LQR law behind their ends."""
    problem = exact.problem
    end = states[:, -1] @ problem.A.T + moves[:, -1] @ problem.B.T
    stages = ((states @ problem.Q) * states).sum(axis=(1, 2)) + ((moves @ problem.R) * moves).sum(axis=(1, 2))
    return np.asarray(stages + ((end @ problem.P) * end).sum(axis=1))
