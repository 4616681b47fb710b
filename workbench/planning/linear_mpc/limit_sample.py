r"""Closed loops of the exact law from starts and steps at which limits act: the sample that judges a number of sweeps.

A loop begins at rest with a state off its reference, which is the same as a step of the reference. Half way the state
jumps once more, so that the plan of the period before is wrong. Every second start lies in a direction of rests of the
plant, along which references step; the others lie in directions of a Sobol sequence, which are drawn alike for every
design. The size of a start is such that the LQR answer passes a limit of an input by a factor of up to 4, or one of a
state by up to 1.5. It is reduced until the exact law keeps the limits and comes nearer to the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, qmc

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.exact_solution import ExactMpc
from workbench.planning.linear_mpc.infeasibility import MpcConflictError

LOOPS, OTHERS, PERIODS = 12, 24, 12  # loops with a jump in the middle of 2 x 12 periods
SIZES = (1.5, 4.0, 2.5)  # of the LQR answer over the limits of inputs, one start after the other
OF_STATES = 1.5  # of the same over limits of states and outputs
OF_RATES = 4.0  # times as much over limits of changes, which a step of the reference passes by far
SMALLER = (1.0, 0.6, 0.4, 0.25, 0.15)
RUNAWAY = 8.0  # times the cost of the start: the loop is lost


@dataclass(frozen=True, eq=False)
@show
class LimitSample:
    """Closed loops of the exact law: states (B, T, nx), moves (B, T, nu), and the share of periods with a limit."""

    states: Array
    moves: Array
    active_share: float

    @property
    def count(self) -> int:
        """The number of moves."""
        return int(self.moves.shape[0] * self.moves.shape[1])


def limit_samples(exact: ExactMpc, plant_states: int) -> tuple[LimitSample, LimitSample]:
    """A sample by which sweeps are chosen, and another one; the first `plant_states` states are the plant's.

    Raises
    ------
    DesignError
        If the limits cannot be kept from any start at which one of them acts.
    """
    directions = _directions(exact, plant_states, 4 * (LOOPS + OTHERS))
    sample = _sample(exact, directions[: 4 * LOOPS], LOOPS)
    if sample is None:
        raise DesignError(
            "`predictive_design(limits=...)`: from no start at which a limit acts could the limits be kept, among "
            f"{2 * LOOPS}. Widen the limits, make those of states soft by `soft_weight`, or take a longer horizon."
        )
    return sample, _sample(exact, directions[4 * LOOPS :], OTHERS) or sample


def _sample(exact: ExactMpc, directions: Array, count: int) -> LimitSample | None:
    """So many loops, each from the next two directions that succeed; None if none does."""
    loops: list[tuple[Array, Array]] = []
    for i in range(len(directions) // 2):
        first = _loop_along(exact, directions[2 * i], i, np.zeros(len(exact.problem.A)))
        second = None if first is None else _loop_along(exact, directions[2 * i + 1], i + 1, first[2])
        if first is not None and second is not None:
            loops.append((np.vstack([first[0], second[0]]), np.vstack([first[1], second[1]])))
        if len(loops) == count:
            break
    if not loops:
        return None
    states, moves = (np.array([loop[part] for loop in loops]) for part in (0, 1))
    return LimitSample(states, moves, _active_share(exact, states, moves))


def _directions(exact: ExactMpc, n: int, count: int) -> Array:
    """Directions (count, nx) of the states of the plant, with zeros for inputs that are on their way."""
    problem, whole = exact.problem, np.zeros((count, len(exact.problem.A)))
    draws = qmc.Sobol(n, scramble=False).random(256)[1 : count + 1]
    P = problem.P[:n, :n]
    root = np.linalg.cholesky(P + 1e-9 * np.trace(P) * np.eye(n))
    whole[:, :n] = np.linalg.solve(root.T, norm.ppf(np.clip(draws, 1e-3, 1 - 1e-3)).T).T
    rests = _rests(problem.A, problem.B, n)
    for i in range(0, count, 4 if len(rests) else count + 1):
        for j, sign in ((i, 1.0), (i + 1, -1.0)):
            whole[j, :n] = sign * rests[(i // 4) % len(rests)]
    return whole


def _rests(A: Array, B: Array, n: int) -> Array:
    """A basis (k, n) of the states of the plant at which it can rest."""
    nx = len(A)
    sizes, modes = np.linalg.svd(np.hstack([A - np.eye(nx), B]))[1:]
    rests = modes[int((sizes > 1e-9 * sizes[0]).sum()) :, :n]
    return np.asarray(rests[np.linalg.norm(rests, axis=1) > 1e-6])


def _loop_along(exact: ExactMpc, direction: Array, index: int, base: Array) -> tuple[Array, Array, Array] | None:
    """States, moves and the last state of a loop from a state off `base`, of the largest size that succeeds."""
    problem, nu = exact.problem, exact.problem.B.shape[1]
    lqr = exact.maps.Y @ direction
    span = problem.high - problem.low  # in the place of a limit at which the plant rests
    above, below = (np.where(end != 0, np.abs(end), span) for end in (problem.high, problem.low))
    ratios = np.maximum(lqr / above, -lqr / below).reshape(problem.horizon, -1).max(axis=0)
    top = SIZES[index % len(SIZES)]
    allowed = np.full(problem.rows.count, min(top, OF_STATES))
    allowed[:nu] = top
    if problem.rows.has_rates:
        allowed[-nu:] = OF_RATES * top
    largest = float((ratios / allowed).max(initial=0.0))
    for cone in problem.rows.cones:
        over = float(cone.ratio(lqr.reshape(problem.horizon, -1)).max())
        largest = max(largest, over / (top if cone.inputs else min(top, OF_STATES)))
    if not 0 < largest < np.inf:
        return None
    for share in SMALLER:
        x = base + direction * share / largest
        loop = _loop(exact, x)
        if loop is not None and loop[2] @ problem.P @ loop[2] < x @ problem.P @ x:
            return loop
    return None


def _loop(exact: ExactMpc, x: Array) -> tuple[Array, Array, Array] | None:
    """The loop of the exact law, or None if it cannot keep the limits or runs away."""
    problem, states, moves = exact.problem, [], []
    most = RUNAWAY * float(x @ problem.P @ x)
    for _ in range(PERIODS):
        if not x @ problem.P @ x <= most:
            return None
        try:
            u = exact.first_move(x)
        except (MpcConflictError, DesignError):
            return None
        states.append(x)
        moves.append(u)
        x = problem.A @ x + problem.B @ u
    return np.array(states), np.array(moves), x


def _active_share(exact: ExactMpc, states: Array, moves: Array) -> float:
    """The share of periods in which a limit acts on the next stage."""
    rows = exact.problem.rows
    y = states @ rows.F.T + moves @ rows.E.T
    near = 1e-7 * (1 + np.abs(y))
    acts = ((y >= rows.high - near) | (y <= rows.low + near)).any(axis=-1)
    for cone in rows.cones:
        acts |= cone.excess(y) >= -near[..., list(cone.rows)].max(axis=-1)
    return float(acts.mean())
