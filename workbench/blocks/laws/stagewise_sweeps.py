r"""Sweeps of a linear-quadratic problem over stages, with limits on inputs and soft limits on outputs.

    minimise  sum over k < N of  |x_k + e_k - r_k|_Q^2 + |v_k - s_k|_R^2 + sum over rows of w d(y_k + C_k e_k)^2
              + |x_N + e_N - r_N|_P^2
    where     e_{k+1} = A_k e_k + B_k (v_k - u_k),   e_0 = 0,   low <= v_k <= high,

and d is the distance of a row from its limits. The change of an input can have limits, too: the last nu states are then
the inputs before, and low and high are the nearer of both limits. A sweep is one step of Newton's method on the set of
active limits, by a Riccati recursion: inputs that the last sweep left at a limit are held there, at the limit of a
change they move with the input before, and rows that it left outside have their weight. The pass forward clips each
input, and those after it answer by their gains. Of some shares of the step the one of least cost is taken, so that no
sweep raises the cost by more than its smallest share does.

Once the active set is the optimum's, one sweep is exact. References: Tassa, Mansard and Todorov (2014), Control-limited
differential dynamic programming, ICRA; Hintermueller, Ito and Kunisch (2002), The primal-dual active set strategy as a
semismooth Newton method, SIAM Journal on Optimization 13.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import accumulate

import casadi as ca

from workbench.core.bounded_loop import bounded_loop

SHARES = (1.0, 0.5, 0.25, 0.1)  # of a sweep's step
NEARLY = 1e-9  # of the cost: rounding of its sum, for which no smaller share is taken


@dataclass(frozen=True)
class StageWeights:
    """Weights and limits of a problem, the same at all stages: of states, inputs and rows."""

    Q: ca.SX
    R: ca.SX
    P: ca.SX
    low: ca.SX
    high: ca.SX
    row_low: ca.SX
    row_high: ca.SX
    row_weight: ca.SX
    rate_low: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    rate_high: ca.SX = field(default_factory=lambda: ca.SX(0, 1))

    @property
    def has_rates(self) -> bool:
        """True if the change of each input is limited. The last states are the inputs before, then."""
        return self.rate_low.numel() > 0

    @property
    def sizes(self) -> tuple[int, int, int]:
        """The numbers of states, inputs and rows."""
        return self.Q.shape[0], self.R.shape[0], self.row_low.numel()

    def before(self, x: ca.SX) -> ca.SX:
        """The inputs (nu, 1) before, of states x (nx, 1), if their changes are limited."""
        return x[x.numel() - self.rate_low.numel() :]

    def clip(self, u: ca.SX, x: ca.SX) -> ca.SX:
        """The inputs within their limits, and within those of their change at states x (nx, 1)."""
        if not self.has_rates:
            return ca.fmin(ca.fmax(u, self.low), self.high)
        least, most = self.before(x) + self.rate_low, self.before(x) + self.rate_high
        return ca.fmin(ca.fmax(u, ca.fmax(self.low, least)), ca.fmin(self.high, most))

    def clamps(self, aim: ca.SX, inside: ca.SX, x: ca.SX) -> ca.SX:
        """0 for free inputs, 1 for those at their limit, and 2 for those at the limit of their change at states x."""
        at_limit = ca.if_else(aim == inside, 0.0, 1.0)
        if not self.has_rates:
            return at_limit
        above = ca.logic_and(aim > inside, self.before(x) + self.rate_high < self.high)
        below = ca.logic_and(aim < inside, self.before(x) + self.rate_low > self.low)
        return at_limit + ca.logic_or(above, below)

    def rate_map(self, clamps: ca.SX) -> ca.SX:
        """The map (nu, nx) from states to inputs whose change is at a limit, which move with the inputs before."""
        nx, nu, _ = self.sizes
        return ca.horzcat(ca.SX.zeros(nu, nx - nu), ca.diag(ca.if_else(clamps == 2, 1.0, 0.0)))

    def beyond(self, y: ca.SX) -> ca.SX:
        """The signed distance of rows from their limits, zero within."""
        return y - ca.fmin(ca.fmax(y, self.row_low), self.row_high)

    def stage_cost(self, x: ca.SX, u: ca.SX, y: ca.SX) -> ca.SX:
        """The cost of a stage, of deviations x and u from the reference and of rows y."""
        own = ca.dot(x, self.Q @ x) + ca.dot(u, self.R @ u)
        return own + ca.dot(self.row_weight, self.beyond(y) ** 2) if y.numel() else own

    def end_cost(self, x: ca.SX) -> ca.SX:
        """The cost of the end, of the deviation x from its reference."""
        return ca.dot(x, self.P @ x)


@dataclass(frozen=True)
class StageRows:
    """A problem about a trajectory: of each stage a column, and the end.

    `columns` has x (nx), u (nu), A and B (column by column), r (nx), s (nu), y (nr) and C below each other; `end` is
    the deviation x_N - r_N.
    """

    columns: ca.SX
    end: ca.SX

    @staticmethod
    def split(column: ca.SX, sizes: tuple[int, int, int]) -> tuple[ca.SX, ...]:
        """The parts x, u, A, B, r, s, y and C of a column."""
        nx, nu, nr = sizes
        shapes = ((nx, 1), (nu, 1), (nx, nx), (nx, nu), (nx, 1), (nu, 1), (nr, 1), (nr, nx))
        return parts_of(column, shapes)


def parts_of(column: ca.SX, shapes: tuple[tuple[int, int], ...]) -> tuple[ca.SX, ...]:
    """The matrices of some shapes that stand below each other in a column."""
    ends = [0, *accumulate(rows * columns for rows, columns in shapes)]
    return tuple(ca.reshape(column[a:b], *shape) for a, b, shape in zip(ends[:-1], ends[1:], shapes, strict=True))


@dataclass(frozen=True)
class Iterate:
    """The answer of a sweep: deviations e (nx, N) and inputs v (nu, N), 1 for inputs at a limit, and gains (nu nx, N).

    `end` is e_N, and `residual` the largest change of an input by the sweep, in units of `scale`.
    """

    e: ca.SX
    v: ca.SX
    clamps: ca.SX
    gains: ca.SX
    end: ca.SX
    residual: ca.SX

    @property
    def column(self) -> ca.SX:
        """All of it as one column."""
        return ca.veccat(self.e, self.v, self.clamps, self.gains, self.end, self.residual)

    @staticmethod
    def of(column: ca.SX, N: int, nx: int, nu: int) -> Iterate:
        """The iterate of a column."""
        return Iterate(*parts_of(column, ((nx, N), (nu, N), (nu, N), (nu * nx, N), (nx, 1), (1, 1))))


def solve_stages(weights: StageWeights, rows: StageRows, v: ca.SX, clamps: ca.SX, scale: ca.SX, count: int) -> Iterate:
    """The iterate after `count` sweeps from inputs v (nu, N) of the trajectory itself, with e = 0."""
    N, (nx, nu, _) = v.shape[1], weights.sizes
    zeros = ca.SX.zeros
    start = Iterate(zeros(nx, N), v, clamps, zeros(nu * nx, N), zeros(nx), ca.SX(0.0))

    def sweep(column: ca.SX, columns: ca.SX, end: ca.SX) -> tuple[ca.SX, ...]:
        return (_sweep(weights, StageRows(columns, end), Iterate.of(column, N, nx, nu), scale).column,)

    (column,) = bounded_loop(count, sweep, start.column, constants=(rows.columns, rows.end))
    return Iterate.of(column, N, nx, nu)


def _sweep(weights: StageWeights, rows: StageRows, last: Iterate, scale: ca.SX) -> Iterate:
    N, (nx, nu, _) = last.v.shape[1], weights.sizes
    before = ca.vertcat(last.e, last.v, last.clamps)
    deviation = rows.end + last.end
    first = ca.vertcat(ca.vec(weights.P), weights.P @ deviation)

    def back(c: ca.SX, own: ca.SX, stage: ca.SX) -> tuple[ca.SX, ...]:
        return _stage_gains(weights, c, own, StageRows.split(stage, weights.sizes))

    _, answers = bounded_loop(N, back, first, before, rows.columns, backward=True)

    def forth(c: ca.SX, own: ca.SX, stage: ca.SX, answer: ca.SX) -> tuple[ca.SX, ...]:
        carries, results = list[ca.SX](), list[ca.SX]()
        for share, part in zip(SHARES, ca.vertsplit(c, nx + 1), strict=True):
            carried, result = _stage_trial(weights, share, part, own, StageRows.split(stage, weights.sizes), answer)
            carries.append(carried)
            results.append(result)
        return ca.vertcat(*carries), ca.vertcat(*results)

    ends, trials = bounded_loop(N, forth, ca.SX.zeros((nx + 1) * len(SHARES)), before, rows.columns, answers)
    costs = [part[nx] + weights.end_cost(rows.end + part[:nx]) for part in ca.vertsplit(ends, nx + 1)]
    flags = better_flags(costs)
    end = choose(flags, ca.vertsplit(ends, nx + 1))[:nx]

    def take(most: ca.SX, own: ca.SX, trial: ca.SX, flags: ca.SX) -> tuple[ca.SX, ...]:
        chosen = choose(flags, ca.vertsplit(trial, nx + 2 * nu))
        change = ca.fabs(chosen[nx : nx + nu] - own[nx : nx + nu]) / scale
        return ca.fmax(most, ca.mmax(change)), chosen

    residual, chosen = bounded_loop(N, take, ca.SX(0.0), before, trials, constants=(flags,))
    e, v, clamps = chosen[:nx, :], chosen[nx : nx + nu, :], chosen[nx + nu :, :]
    return Iterate(e, v, clamps, answers[: nu * nx, :], end, residual)


def _stage_gains(weights: StageWeights, c: ca.SX, own: ca.SX, stage: tuple[ca.SX, ...]) -> tuple[ca.SX, ca.SX]:
    """The cost to go of a stage from that of the next, and K, k, H, G and h of its inputs."""
    nx, nu, nr = weights.sizes
    P, p = parts_of(c, ((nx, nx), (nx, 1)))
    e, v, clamps = parts_of(own, ((nx, 1), (nu, 1), (nu, 1)))
    x, _, A, B, r, s, y, C = stage
    PA, PB = P @ A, P @ B
    H, G = weights.R + B.T @ PB, B.T @ PA
    h = weights.R @ (v - s) + B.T @ p
    if weights.has_rates:
        K, k = _gains_with_rates(weights, clamps, H, G, h)
    else:
        K, k = _gains(1 - clamps, clamps, H, G, h)
    W, q = weights.Q, weights.Q @ (x + e - r)
    if nr:
        distance = weights.beyond(y + C @ e)
        W = W + C.T @ (C * ca.repmat(ca.if_else(distance == 0, 0.0, weights.row_weight), 1, nx))
        q = q + C.T @ (weights.row_weight * distance)
    W, q = W + A.T @ PA - G.T @ K, q + A.T @ p - G.T @ k
    if weights.has_rates:  # of inputs that are held at a limit that moves
        moving = weights.rate_map(clamps)
        W, q = W - moving.T @ (H @ K - G), q - moving.T @ (H @ k - h)
    before = ca.triu2symm(ca.triu(ca.densify(W)))
    return ca.vertcat(ca.vec(before), q), ca.veccat(K, k, H, G, h)


def _gains(free: ca.SX, bound: ca.SX, H: ca.SX, G: ca.SX, h: ca.SX) -> tuple[ca.SX, ca.SX]:
    """K and k of the free inputs; zero for the others."""
    nx = G.shape[1]
    masked = H * (free @ free.T) + ca.diag(bound)
    answer = solve_definite(masked, ca.horzcat(G, h) * ca.repmat(free, 1, nx + 1))
    return answer[:, :nx], answer[:, nx]


def _gains_with_rates(weights: StageWeights, clamps: ca.SX, H: ca.SX, G: ca.SX, h: ca.SX) -> tuple[ca.SX, ca.SX]:
    """K and k, where inputs whose change is at a limit move with the inputs before."""
    moving, bound = weights.rate_map(clamps), ca.if_else(clamps == 0, 0.0, 1.0)
    K, k = _gains(1 - bound, bound, H, G + H @ moving, h)
    return K - moving, k


def _stage_trial(
    weights: StageWeights, share: float, c: ca.SX, own: ca.SX, stage: tuple[ca.SX, ...], answer: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """e and the cost behind a stage, and e, v and the clamps of the stage, with a share of the step."""
    nx, nu, nr = weights.sizes
    new, cost = c[:nx], c[nx]
    e, v, _ = parts_of(own, ((nx, 1), (nu, 1), (nu, 1)))
    K, k, H, G, h = parts_of(answer, ((nu, nx), (nu, 1), (nu, nu), (nu, nx), (nu, 1)))
    x, u, A, B, r, s, y, C = stage
    change = new - e
    move = -(K @ change + share * k)
    slope = share * h + H @ move + G @ change  # zero for free inputs
    diagonal = ca.vertcat(*(H[i, i] for i in range(nu)))
    wanted = v + move - slope / diagonal
    taken = weights.clip(wanted, x + new)
    rows = y + C @ new if nr else y
    cost = cost + weights.stage_cost(x + new - r, taken - s, rows)
    following = A @ new + B @ (taken - u)
    return ca.vertcat(following, cost), ca.vertcat(new, taken, weights.clamps(wanted, taken, x + new))


def better_flags(costs: list[ca.SX]) -> ca.SX:
    """1 for each cost but the first that is below all before it by more than rounding, or the first finite one."""
    best, flags = costs[0], list[ca.SX]()
    for cost in costs[1:]:
        worse = best <= cost + NEARLY * ca.fabs(cost)
        flags.append(ca.if_else(worse, 0.0, 1.0))
        best = ca.if_else(worse, best, cost)
    return ca.vertcat(*flags, ca.SX(0, 1))


def choose(flags: ca.SX, candidates: list[ca.SX]) -> ca.SX:
    """The last of the candidates whose flag is 1, or the first."""
    chosen = candidates[0]
    for i, candidate in enumerate(candidates[1:]):
        chosen = ca.if_else(flags[i] == 1, candidate, chosen)
    return chosen


def solve_definite(H: ca.SX, right: ca.SX) -> ca.SX:
    """H^-1 right for a positive definite H, by factors L D L' without pivots."""
    n, columns = H.shape[0], right.shape[1]
    G = {(i, j): H[i, j] for i in range(n) for j in range(i + 1)}
    X = {(i, c): right[i, c] for i in range(n) for c in range(columns)}
    for j in range(n):
        share = {i: G[i, j] / G[j, j] for i in range(j + 1, n)}
        for i in range(j + 1, n):
            for k in range(j + 1, i + 1):
                G[i, k] -= share[i] * G[k, j]
            for c in range(columns):
                X[i, c] -= share[i] * X[j, c]
        G.update({(i, j): value for i, value in share.items()})
    for j in reversed(range(n)):
        for c in range(columns):
            X[j, c] = X[j, c] / G[j, j] - sum((G[i, j] * X[i, c] for i in range(j + 1, n)), ca.SX(0.0))
    return ca.vertcat(*(ca.horzcat(*(X[i, c] for c in range(columns))) for i in range(n)))
