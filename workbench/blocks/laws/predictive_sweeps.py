"""Sweeps of predictive laws in the graph: in a metric of diagonal and low rank, and by ADMM."""

from __future__ import annotations

from functools import reduce
from typing import NamedTuple, Protocol

import casadi as ca

from workbench.blocks.laws.limit_cones import LimitCone, passes_limits, within_limits
from workbench.core.block import Matrix, Vector
from workbench.core.bounded_loop import bounded_loop


class SweepNumbers(Protocol):
    """The numbers of a law that a sweep needs, as `ModelPredictive` declares them."""

    @property
    def horizon(self) -> int: ...
    @property
    def sweeps(self) -> int: ...
    @property
    def A(self) -> Matrix: ...
    @property
    def B(self) -> Matrix: ...
    @property
    def K(self) -> Matrix: ...
    @property
    def S(self) -> Matrix: ...
    @property
    def F(self) -> Matrix: ...
    @property
    def E(self) -> Matrix: ...
    @property
    def low(self) -> Vector: ...
    @property
    def high(self) -> Vector: ...
    @property
    def softness(self) -> Vector: ...
    @property
    def sigma(self) -> Vector: ...
    @property
    def W(self) -> Matrix: ...
    @property
    def L(self) -> Vector: ...
    @property
    def cap(self) -> float: ...
    @property
    def Y(self) -> Matrix: ...
    @property
    def D(self) -> Matrix: ...
    @property
    def gains(self) -> Matrix: ...
    @property
    def inverses(self) -> Matrix: ...
    @property
    def cones(self) -> tuple[LimitCone, ...]: ...


class PeriodAnswer(NamedTuple):
    """The answer of a period: zeta (N nc, 1) of the sweeps and their residual, and the rows (nc, N) of LQR.

    `outside` is 1 if a row of LQR passes a limit. Else the answer is that of LQR, which is the optimum then.
    """

    zeta: ca.SX
    lqr: ca.SX
    residual: ca.SX
    outside: ca.SX


def answer_of_period(law: SweepNumbers, plan: ca.SX, e: ca.SX, rest: ca.SX) -> PeriodAnswer:
    """The answer at a state e (nx, 1), from the plan (nc, N) of the period before and the rows (nc, 1) of the rest."""
    one = metric_sweep if law.gains is None else admm_sweep

    def start(outside: ca.SX, own: ca.SX, Y: ca.SX, e: ca.SX, rest: ca.SX) -> tuple[ca.SX, ...]:
        answer = rows_of_stage(Y, e) + rest
        return ca.if_else(passes_limits(law, answer), 1.0, outside), answer, own + answer

    def sweep(both: ca.SX, lqr: ca.SX, outside: ca.SX) -> tuple[ca.SX, ...]:
        return (ca.if_else(outside, ca.vertcat(*one(law, ca.reshape(both[:-1], *plan.shape), lqr)), both),)

    outside, lqr, zeta = bounded_loop(law.horizon, start, ca.SX(0.0), plan, lqr_rows(law), constants=(e, rest))
    (both,) = bounded_loop(law.sweeps, sweep, ca.vertcat(ca.vec(zeta), 0.0), constants=(lqr, outside))
    return PeriodAnswer(both[:-1], lqr, both[-1], outside)


def lqr_rows(law: SweepNumbers) -> ca.SX:
    """The rows of the LQR law with those of a stage in a column (nx nc, N), for `rows_of_stage`."""
    return ca.reshape(ca.SX(law.Y), -1, law.horizon)


def rows_of_stage(Y: ca.SX, e: ca.SX) -> ca.SX:
    """The rows (nc, 1) of a stage under the LQR law from a state e (nx, 1)."""
    return ca.reshape(Y, e.numel(), -1).T @ e


def metric_sweep(law: SweepNumbers, zeta: ca.SX, answer: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The next zeta (N nc, 1) by a step in the metric, and the residual of the one that came."""
    nc, N, r = law.low.shape[0], law.horizon, law.L.shape[0]
    shares = _inverse_spans(law)
    gap, acts = (gap_by_stages if law.D is None else gap_by_columns)(law, zeta, answer)
    modes = (_by_stage(law.W, N),) if r else ()
    t = (_solve_quasidefinite(law.L, *_active_sums(law, gap, acts, *modes)),) if r else ()

    def without_modes(most: ca.SX, own: ca.SX, gap: ca.SX, *modes: ca.SX) -> tuple[ca.SX, ...]:
        step = gap - ca.reshape(modes[0], nc, r) @ modes[1] if r else gap
        above = ca.if_else(own <= law.high, own + step - law.high, 0.0)  # it was not above before
        below = ca.if_else(own >= law.low, law.low - own - step, 0.0)
        beyond, largest = most[0], most[1]
        for i in range(nc):
            beyond = _larger(beyond, _larger(above[i], below[i]) * shares[i])
            largest = _larger(largest, ca.fabs(gap[i]) * shares[i])
        return ca.vertcat(beyond, largest), step

    most, change = bounded_loop(N, without_modes, ca.SX.zeros(2), zeta, gap, *modes, constants=t)
    scale = ca.fmin(1.0, law.cap / ca.fmax(most[0], law.cap))

    def take(none: ca.SX, own: ca.SX, step: ca.SX, share: ca.SX) -> tuple[ca.SX, ...]:
        return none, own + step * share

    _, following = bounded_loop(N, take, ca.SX(0, 1), zeta, change, constants=(scale,))
    return ca.vec(following), most[1]


def gap_by_stages(law: SweepNumbers, zeta: ca.SX, answer: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The gap y - v (nc, N) of all rows, and 1 / sigma of those that act (nc, N), else 0.

    It takes a pass backward and one forward, which are left out over stages at which nothing acts.
    """
    (_, nx), N = law.K.shape, law.horizon
    rows, closed = law.F - law.E @ law.K, law.A - law.B @ law.K

    def back(c: ca.SX, own: ca.SX) -> tuple[ca.SX, ...]:
        p, above = c[:nx], c[nx]
        v = ca.fmin(ca.fmax(own, law.low), law.high)
        acts = ca.if_else(own == v, 0.0, 1 / law.sigma)
        some = ca.if_else(_any(own != v), 1.0, above)
        force = (own - v) / law.sigma
        d = ca.if_else(some, law.S @ (law.B.T @ p + law.E.T @ force), 0.0)
        before = ca.if_else(some, closed.T @ p + rows.T @ force, p)
        return ca.vertcat(before, some), d, v + law.softness * force, acts

    first, moves, kept, acts = bounded_loop(N, back, ca.SX.zeros(nx + 1), zeta, backward=True)

    def forth(e: ca.SX, d: ca.SX, own: ca.SX, lqr: ca.SX, some: ca.SX) -> tuple[ca.SX, ...]:
        gap = lqr - ca.if_else(some, rows @ e + law.E @ d, 0.0) - own
        return ca.if_else(some, closed @ e + law.B @ d, e), gap

    _, gap = bounded_loop(N, forth, ca.SX.zeros(nx), moves, kept, answer, constants=(first[nx],))
    return gap, acts


def gap_by_columns(law: SweepNumbers, zeta: ca.SX, answer: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The same from the columns of D at the stages at which a row acts: y - v = y0 - zeta - D (zeta - v)."""
    nc, M, N = law.low.shape[0], zeta.numel(), law.horizon

    def take_columns(gap: ca.SX, own: ca.SX, columns: ca.SX) -> tuple[ca.SX, ...]:
        beyond = ca.if_else(own > law.high, own - law.high, ca.if_else(own < law.low, own - law.low, 0.0))
        acts = beyond != 0.0
        gap = ca.if_else(_any(acts), gap - ca.reshape(columns, M, nc) @ beyond, gap)
        return gap, ca.if_else(acts, 1 / law.sigma, 0.0)

    columns = ca.reshape(ca.SX(law.D), M * nc, N)
    gap, acts = bounded_loop(N, take_columns, ca.vec(answer - zeta), zeta, columns)
    return ca.reshape(gap, nc, N), acts


def _active_sums(law: SweepNumbers, gap: ca.SX, acts: ca.SX, modes: ca.SX) -> tuple[list[tuple[int, int]], ca.SX]:
    """W' diag W of the active rows by the places of its entries, and behind them W' diag gap.

    A stage without an active row leaves the sums as they are.
    """
    nc, r = law.low.shape[0], law.L.shape[0]
    places = [(i, j) for j in range(r) for i in range(j, r)]

    def add(sums: ca.SX, own: ca.SX, active: ca.SX, W: ca.SX) -> tuple[ca.SX, ...]:
        W = ca.reshape(W, nc, r)
        weighted = W * ca.repmat(active, 1, r)
        terms = [ca.dot(weighted[:, i], W[:, j]) for i, j in places] + [weighted[:, i].T @ own for i in range(r)]
        return (ca.if_else(_any(active != 0.0), sums + ca.vertcat(*terms), sums),)

    (sums,) = bounded_loop(law.horizon, add, ca.SX.zeros(len(places) + r), gap, acts, modes)
    return places, sums


def admm_sweep(law: SweepNumbers, zeta: ca.SX, answer: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The next zeta (N nc, 1), and the residual of the one that came, by a pass backward and one forward:

    zeta <- zeta + cap (y - v),    v = clip(zeta),    y the rows of the plan of least cost near 2 v - zeta.

    Rows of cones are not clipped, but take the nearest point of their cone.
    """
    (nu, nx), N = law.K.shape, law.horizon
    rows, closed = law.F - law.E @ law.K, law.A - law.B @ law.K
    pull = ca.SX(1.0) / (ca.SX(law.sigma) + ca.SX(law.softness))
    give, shares = law.softness * pull, _inverse_spans(law)

    def back(p: ca.SX, own: ca.SX, lqr: ca.SX, gain: ca.SX, inverse: ca.SX) -> tuple[ca.SX, ...]:
        v = within_limits(law, own)
        aims = 2 * v - own - lqr
        force = pull * aims
        push = law.B.T @ p + law.E.T @ force
        after = closed.T @ p + rows.T @ force - ca.reshape(gain, nu, nx).T @ push
        return after, ca.reshape(inverse, nu, nu) @ push, v, aims

    def forth(c: ca.SX, own: ca.SX, lqr: ca.SX, d: ca.SX, v: ca.SX, aims: ca.SX, gain: ca.SX) -> tuple[ca.SX, ...]:
        e = c[:nx]
        d = d - ca.reshape(gain, nu, nx) @ e
        moved = rows @ e + law.E @ d
        gap = lqr + moved + give * (aims - moved) - v
        largest = ca.fmax(c[nx], ca.mmax(ca.fabs(gap) * shares))
        return ca.vertcat(closed @ e + law.B @ d, largest), own + law.cap * gap

    gains, inverses = (_by_stage(part, N) for part in (law.gains, law.inverses))
    _, moves, kept, aims = bounded_loop(N, back, ca.SX.zeros(nx), zeta, answer, gains, inverses, backward=True)
    end, following = bounded_loop(N, forth, ca.SX.zeros(nx + 1), zeta, answer, moves, kept, aims, gains)
    return ca.vec(following), end[nx]


def _by_stage(numbers: Matrix, horizon: int) -> ca.SX:
    """Matrices below each other with those of a stage in a column."""
    below = ca.SX(numbers)
    return ca.horzcat(*(ca.vec(part) for part in ca.vertsplit(below, below.shape[0] // horizon)))


def _inverse_spans(law: SweepNumbers) -> ca.SX:
    """1 / (high - low) of the rows (nc, 1), zero where a limit is missing."""
    return ca.SX(1.0) / (ca.SX(law.high) - ca.SX(law.low))


def _larger(a: ca.SX, b: ca.SX) -> ca.SX:
    """The larger of two numbers; of a number and NaN behind it, the number."""
    return ca.if_else(b > a, b, a)


def _any(truths: ca.SX) -> ca.SX:
    """True if one of the truths (n, 1) holds."""
    return reduce(ca.logic_or, ca.vertsplit(truths))


def _solve_quasidefinite(L: Vector, places: list[tuple[int, int]], sums: ca.SX) -> ca.SX:
    """t (r, 1) of (L^-1 + W' diag W) t = W' diag gap, by factors L D L' without pivots."""
    r = L.shape[0]
    G = {place: sums[i] for i, place in enumerate(places)}
    t = [sums[len(places) + i] for i in range(r)]
    for i in range(r):
        G[i, i] += 1 / L[i]
    for j in range(r):
        column = {i: G[i, j] / G[j, j] for i in range(j + 1, r)}
        for i in range(j + 1, r):
            for k in range(j + 1, i + 1):
                G[i, k] -= column[i] * G[k, j]
            t[i] -= column[i] * t[j]
        G.update({(i, j): value for i, value in column.items()})
    for j in reversed(range(r)):
        t[j] = t[j] / G[j, j] - sum((G[i, j] * t[i] for i in range(j + 1, r)), ca.SX(0.0))
    return ca.vertcat(*t)
