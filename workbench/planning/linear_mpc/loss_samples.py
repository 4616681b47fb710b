r"""The loss of a fixed number of sweeps: sampled over states, and bounded for each plan by duality.

`sampled_loss` runs the law and the exact law from the same states in closed loop. What it finds is the worst of the
samples, not of the set. Four statements are proved instead, without sampling:

- `contraction` of `splitting_numbers`, for every active set where D is regular;
- the gap of a plan, `plan_gap`: any multipliers give a lower bound of the optimum, and a plan that keeps its limits an
  upper bound, whatever the sweeps were (weak duality);
- the error of a move, `move_bound`, from the residual g of the zeta that gives it. As lambda pushes against v and
  lambda* against v*, (lambda - lambda*)'(v - v*) >= 0; with v - v* = -D (lambda - lambda*) - g this gives
  |z - z*| = |lambda - lambda*|_D <= |g|_{D^-1}, where D is regular;
- where no limit acts, the law is LQR.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array, matrix, whole
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import DesignError
from workbench.planning.linear_mpc.array_doors import finite_vector
from workbench.planning.linear_mpc.cone_limits import nearest
from workbench.planning.linear_mpc.exact_solution import ExactMpc
from workbench.planning.linear_mpc.infeasibility import MpcConflictError
from workbench.planning.linear_mpc.splitting import SplittingNumbers, no_memory, solve_period

FIRST_SWEEPS = 100  # of a period that has no memory


@dataclass(frozen=True, eq=False)
@show
class SampledLoss:
    """The worst of sampled closed loops under the law, beside the exact law: sampled, not proved.

    Parameters
    ----------
    cost_loss
        (B,), the relative excess of the closed-loop cost over the exact law's; NaN where either left the range.
    worst_cost_loss, worst_violation, worst_move_error
        The largest loss; the largest violation of a row of the next stage beyond the exact law's, in spans; and the
        largest error of a first move at the same state, in spans of the inputs.
    active_share
        The share of periods in which the exact law has an input at a limit.
    worst_residual
        The largest residual that the law reported, in spans.
    infeasible
        The number of starts from which the exact law met a state without a certified move; they are left out.
    """

    cost_loss: Array
    worst_cost_loss: float
    worst_violation: float
    worst_move_error: float
    active_share: float
    worst_residual: float
    infeasible: int


@check_arguments
def sampled_loss(
    exact: ExactMpc, numbers: SplittingNumbers, states: Numbers, periods: int, *, warm: bool = False
) -> SampledLoss:
    """The loss of a law over closed loops of the model from states (B, nx), beside the exact law.

    The first period is without memory and takes the sweeps of any other, unless `warm`, when it takes a hundred.

    Raises
    ------
    ValueError
        If the states have no row of size nx, or every state is infeasible.
    """
    X = matrix("sampled_loss(states=...)", states, None, len(numbers.A))
    periods = whole("sampled_loss(periods=...)", periods)
    truth = [_exact_loop(exact, x, periods) for x in X]
    kept = [i for i, loop in enumerate(truth) if loop is not None]
    if not kept:
        raise ValueError("`sampled_loss(states=...)` must have a state from which the limits can be kept; none has.")
    loops = [loop for loop in truth if loop is not None]
    visited, moves = (np.array([loop[i] for loop in loops]) for i in (0, 1))
    own_x, own_u, residual = _law_loop(numbers, X[kept], periods, warm)
    along = _law_along(numbers, visited, warm)
    problem, nu = exact.problem, numbers.B.shape[1]
    span = problem.rows.high[:nu] - problem.rows.low[:nu]
    span = np.where(np.isfinite(span), span, np.maximum(np.abs(moves).max(axis=(0, 1)), 1e-12))
    costs = [_cost(exact, x, u) for x, u in ((own_x, own_u), (visited, moves))]
    loss = np.where(np.isfinite(costs[0]), costs[0] / np.maximum(costs[1], 1e-300) - 1, np.nan)
    excess = _violation(exact, own_x, own_u) - _violation(exact, visited, moves)
    at_limit = (moves <= problem.rows.low[:nu]) | (moves >= problem.rows.high[:nu])
    return SampledLoss(
        loss,
        float(np.nanmax(loss)),
        float(max(np.nanmax(excess), 0.0)),
        float((np.abs(along - moves) / span).max()),
        float(at_limit.any(axis=-1).mean()),
        residual,
        len(X) - len(kept),
    )


@check_arguments
def plan_gap(exact: ExactMpc, x: Numbers, multipliers: Numbers) -> tuple[float, float]:
    """A lower and an upper bound of the optimum from x (nx,), by any multipliers (N nc,) of half the cost.

    The upper bound is the cost of the multipliers' plan with its inputs clipped to their limits; it is infinite where
    this plan breaks a hard limit. Rounding is not enclosed.

    Raises
    ------
    ValueError
        If x or the multipliers have another size, or a limit is a cone.
    """
    if exact.problem.rows.cones:
        raise ValueError(
            "`plan_gap(exact, ...)` must be for limits without cones, as it sums over bounds of rows. Take the "
            "certificate of `exact.solve(x)`."
        )
    problem, maps = exact.problem, exact.maps
    x = finite_vector("plan_gap(x=...)", x, len(problem.A), "states")
    multipliers = finite_vector("plan_gap(multipliers=...)", multipliers, len(problem.low), "multipliers")
    y0 = maps.Y @ x
    end = np.where(multipliers > 0, problem.high, problem.low)
    z = -exact.T.T @ multipliers
    support = np.sum(multipliers[multipliers != 0] * end[multipliers != 0])
    lower = float(x @ maps.P0 @ x - z @ z + 2 * (multipliers @ y0 - support))
    d = solve_triangular(maps.roots, z[: maps.G.shape[1]])
    nu = problem.B.shape[1]
    plan = (maps.V @ x + maps.G @ d).reshape(problem.horizon, nu)
    state, upper = x, 0.0
    for u in np.clip(plan, problem.rows.low[:nu], problem.rows.high[:nu]):
        rows = problem.rows.F @ state + problem.rows.E @ u
        over = np.maximum(np.maximum(rows - problem.rows.high, problem.rows.low - rows), 0.0)
        soft = problem.rows.softness
        if (over[soft == 0] > 1e-9 * (1 + np.abs(rows[soft == 0]))).any():
            return lower, np.inf
        upper += float(state @ problem.Q @ state + u @ problem.R @ u)
        upper += float(np.sum(over[soft > 0] ** 2 / soft[soft > 0]))
        state = problem.A @ state + problem.B @ u
    return lower, upper + float(state @ problem.P @ state)


@check_arguments
def exact_loops(exact: ExactMpc, states: Numbers, periods: int) -> tuple[Array, Array]:
    """The states (B, periods, nx) and moves (B, periods, nu) of the exact law from states (B, nx) that have solutions.

    Raises
    ------
    ValueError
        If the states have no row of size nx, or every state is infeasible.
    """
    X = matrix("exact_loops(states=...)", states, None, len(exact.problem.A))
    periods = whole("exact_loops(periods=...)", periods)
    loops = [loop for x in X if (loop := _exact_loop(exact, x, periods)) is not None]
    if not loops:
        raise ValueError("`exact_loops(states=...)` must have a state from which the limits can be kept; none has.")
    return np.array([loop[0] for loop in loops]), np.array([loop[1] for loop in loops])


@check_arguments
def move_bound(exact: ExactMpc, numbers: SplittingNumbers, x: Numbers, zeta: Numbers) -> Array:
    """A bound of the error of each first input (nu,) that zeta (M,) gives at x (nx,); infinite where D is singular.

    Rounding is not enclosed.
    """
    x = finite_vector("move_bound(x=...)", x, len(numbers.A), "states")
    zeta = finite_vector("move_bound(zeta=...)", zeta, len(numbers.low), "numbers")
    v = np.clip(zeta, numbers.low, numbers.high)
    D, nu = exact.numbers.matrix, numbers.B.shape[1]
    gap = numbers.Y @ x - D @ ((zeta - v) / numbers.sigma) - v
    if not exact.numbers.is_proved:
        return np.full(nu, np.inf)
    distance = float(np.sqrt(gap @ np.linalg.solve(D, gap)))
    first = np.linalg.inv(exact.maps.roots[:nu, :nu])
    return np.asarray(np.abs(gap[:nu]) + np.linalg.norm(first, axis=1) * distance)


def _exact_loop(exact: ExactMpc, x: Array, periods: int) -> tuple[Array, Array] | None:
    """The states (periods, nx) and moves (periods, nu) of the exact law; None if one of them cannot be certified."""
    states, moves = [], []
    for _ in range(periods):
        try:
            u = exact.first_move(x)
        except (MpcConflictError, DesignError):
            return None
        states.append(x)
        moves.append(u)
        x = exact.problem.A @ x + exact.problem.B @ u
    return np.array(states), np.array(moves)


def _law_loop(numbers: SplittingNumbers, x: Array, periods: int, warm: bool) -> tuple[Array, Array, float]:
    memory, states, moves, residuals = no_memory(numbers, len(x)), [], [], []
    for k in range(periods):
        answer = solve_period(numbers, memory, x, sweeps=FIRST_SWEEPS if warm and k == 0 else None)
        states.append(x)
        moves.append(answer.u)
        residuals.append(answer.residual)
        memory, x = answer.memory, x @ numbers.A.T + answer.u @ numbers.B.T
    return np.stack(states, axis=1), np.stack(moves, axis=1), float(np.max(residuals))


def _law_along(numbers: SplittingNumbers, visited: Array, warm: bool) -> Array:
    """The law's moves (B, periods, nu) at states (B, periods, nx) that another law visits."""
    memory, moves = no_memory(numbers, len(visited)), []
    for k in range(visited.shape[1]):
        answer = solve_period(numbers, memory, visited[:, k], sweeps=FIRST_SWEEPS if warm and k == 0 else None)
        memory = answer.memory
        moves.append(answer.u)
    return np.stack(moves, axis=1)


def _cost(exact: ExactMpc, x: Array, u: Array) -> Array:
    """The closed-loop costs (B,) of states (B, periods, nx) and inputs (B, periods, nu), with soft violations."""
    problem = exact.problem
    stage = np.einsum("bki,ij,bkj->b", x, problem.Q, x) + np.einsum("bki,ij,bkj->b", u, problem.R, u)
    soft = problem.rows.softness > 0
    over = _over(exact, x, u)[..., soft]
    return np.asarray(stage + np.sum(over**2 / problem.rows.softness[soft], axis=(1, 2)))


def _over(exact: ExactMpc, x: Array, u: Array) -> Array:
    rows = exact.problem.rows
    y = x @ rows.F.T + u @ rows.E.T
    return np.abs(y - nearest(rows.cones, rows.count, y, rows.low, rows.high))


def _violation(exact: ExactMpc, x: Array, u: Array) -> Array:
    """The largest violation (B,) of a loop, in spans."""
    span = exact.problem.rows.high - exact.problem.rows.low
    return np.asarray((_over(exact, x, u) / np.where(np.isfinite(span), span, 1.0)).max(axis=(1, 2)))
