"""An iteration of a nonlinear plan: the plant linearised along the last plan, sweeps, and a roll of the plant itself.

The roll is that of Giftthaler et al. (2018), A family of iterative Gauss-Newton shooting methods for nonlinear optimal
control, IROS: the plant moves along the solution of the linearised problem with its gains, so a plan always obeys the
plant's equations. Shares of the way, and the law behind the horizon alone, are candidates. The one of least cost is the
plan, so an iteration from the same state raises no cost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca

from workbench.blocks.laws.queued_stages import QueuedStages
from workbench.blocks.laws.stagewise_sweeps import (
    Iterate,
    StageRows,
    StageWeights,
    better_flags,
    choose,
    parts_of,
    solve_stages,
)
from workbench.blocks.observers.observer_model import jacobian
from workbench.core.bounded_loop import bounded_loop

SHARES = (1.0, 0.5, 0.25, 0.0)  # of the way from the last plan to the solution of a linearised problem
ALONE = -1.0  # the share of the law behind the horizon, which goes no such way
LARGEST = 1e100  # a cost beyond it is none
NO_LIMIT = 1e30  # the size of a limit that is none


@dataclass(frozen=True)
class NonlinearPlan:
    """A plan: states x (nx, N) and inputs u (nu, N) about the rest, 1 for inputs at a limit, gains (nu nx, N), the end
    (nx, 1), and what it is worth.
    """

    x: ca.SX
    u: ca.SX
    clamps: ca.SX
    gains: ca.SX
    end: ca.SX
    residual: ca.SX
    cost: ca.SX
    share: ca.SX

    @property
    def column(self) -> ca.SX:
        """All of it as one column."""
        parts = self.clamps, self.gains, self.end, self.residual, self.cost, self.share
        return ca.veccat(self.x, self.u, *parts)

    @staticmethod
    def of(column: ca.SX, N: int, nx: int, nu: int) -> NonlinearPlan:
        """The plan of a column."""
        shapes = ((nx, N), (nu, N), (nu, N), (nu * nx, N), (nx, 1), (1, 1), (1, 1), (1, 1))
        return NonlinearPlan(*parts_of(column, shapes))


@dataclass(frozen=True)
class PeriodProblem:
    """The problem of a period: the plant, weights, the law behind the horizon, and what is wanted.

    Parameters
    ----------
    stages, weights
        The plant over a period, with the inputs on their way as states, and weights and limits.
    x0, u0
        The rest.
    feedback
        Gain (nu, nx) of the law behind the horizon.
    horizon, sweeps
        The numbers of stages and of sweeps.
    t
        The time of the first stage in s.
    target
        The wanted states and inputs of a stage, by its number and its column of `window`.
    window
        The signals of a previewed reference at the stages 0 ... N, (m, N + 1); m = 0 without them.
    rows
        The softly limited signals (nr, 1) at a time and states.
    disturbances
        The places of the disturbances of the inputs among the states.
    """

    stages: QueuedStages
    weights: StageWeights
    x0: ca.SX
    u0: ca.SX
    feedback: ca.SX
    horizon: int
    sweeps: int
    t: ca.SX
    target: Callable[[ca.SX, ca.SX], tuple[ca.SX, ca.SX]]
    window: ca.SX
    rows: Callable[[ca.SX, ca.SX], ca.SX]
    disturbances: slice

    def wanted_at(self, k: ca.SX, own: ca.SX, x: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The wanted states and inputs of a stage, where the inputs cancel the disturbances in the states x."""
        r, s = self.target(k, own)
        d = x[self.disturbances]
        if not d.numel():
            return r, s
        nq = x.numel() - self.disturbances.stop
        shift = ca.vertcat(ca.SX.zeros(self.disturbances.stop, 1), ca.repmat(d, nq // d.numel(), 1))
        return r - shift, s - d

    def iterate(self, begin: ca.SX, last: NonlinearPlan) -> NonlinearPlan:
        """The plan after one linearisation about the last one, from the state `begin` on."""
        nx, nu, _ = self.weights.sizes
        rows = self._linearise(begin, last)
        u = rows.columns[nx : nx + nu, :]
        return self._roll(begin, solve_stages(self.weights, rows, u, last.clamps, self.scale, self.sweeps), rows)

    @property
    def scale(self) -> ca.SX:
        """The distances between the limits of the inputs (nu, 1), 1 where one is missing."""
        distance = self.weights.high - self.weights.low
        return ca.if_else(distance < NO_LIMIT, distance, 1.0)

    def end_target(self, x: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The wanted states and inputs behind the last stage, at states x with the same disturbances."""
        return self.wanted_at(ca.SX(self.horizon), self.window[:, -1], x)

    def _time(self, k: ca.SX) -> ca.SX:
        return self.t + k * self.stages.period

    def _linearise(self, begin: ca.SX, last: NonlinearPlan) -> StageRows:
        """The problem about the last plan, rolled from the state `begin` on with its gains."""
        nx, nu, _ = self.weights.sizes

        def stage(c: ca.SX, x: ca.SX, u: ca.SX, gains: ca.SX, *wanted: ca.SX) -> tuple[ca.SX, ...]:
            now, k = c[:nx], c[nx]
            own = self.weights.clip(self.u0 + u - ca.reshape(gains, nu, nx) @ (now - self.x0 - x), now)
            after, A, B = self.stages.after_with_slopes(self._time(k), now, own)
            r, s = self.wanted_at(k, wanted[0] if wanted else ca.SX(0, 1), now)
            y, C = jacobian(lambda v: self.rows(self._time(k), v), now)
            return ca.vertcat(after, k + 1), ca.veccat(now, own, A, B, r, s, y, C)

        rows = [last.x, last.u, last.gains, *([self.window[:, :-1]] if self.window.numel() else [])]
        end, columns = bounded_loop(self.horizon, stage, ca.vertcat(begin, 0.0), *rows)
        return StageRows(columns, end[:nx] - self.end_target(begin)[0])

    def _roll(self, begin: ca.SX, way: Iterate, rows: StageRows) -> NonlinearPlan:
        """The plant along shares of the way, and under the law behind the horizon; the candidate of least cost."""
        (nx, nu, _), N = self.weights.sizes, self.horizon
        trials = (*SHARES, ALONE)

        def stage(c: ca.SX, own: ca.SX, gains: ca.SX, column: ca.SX) -> tuple[ca.SX, ...]:
            parts = ca.vertsplit(c[:-1], nx + 1)
            each = [
                self._trial(share, c[-1], part, own, gains, column) for share, part in zip(trials, parts, strict=True)
            ]
            carries, results = zip(*each, strict=True)
            return ca.vertcat(*carries, c[-1] + 1), ca.vertcat(*results)

        first = ca.vertcat(*(ca.vertcat(begin, 0.0) for _ in trials), 0.0)
        ends, results = bounded_loop(N, stage, first, ca.vertcat(way.e, way.v), way.gains, rows.columns)
        target, parts = self.end_target(begin)[0], ca.vertsplit(ends[:-1], nx + 1)
        costs = [part[nx] + self.weights.end_cost(part[:nx] - target) for part in parts]
        flags = better_flags(costs)

        def take(none: ca.SX, result: ca.SX, flags: ca.SX) -> tuple[ca.SX, ...]:
            return none, choose(flags, ca.vertsplit(result, nx + nu + nu * nx))

        _, chosen = bounded_loop(N, take, ca.SX(0, 1), results, constants=(flags,))
        x, u, gains = ca.vertsplit(chosen, [0, nx, nx + nu, nx + nu + nu * nx])
        end, cost = choose(flags, parts)[:nx], choose(flags, costs)
        share = choose(flags, [ca.SX(share) for share in trials])
        return NonlinearPlan(x, u, way.clamps, gains, end, way.residual, cost, share)

    def _trial(self, share: float, k: ca.SX, c: ca.SX, own: ca.SX, gains: ca.SX, column: ca.SX) -> tuple[ca.SX, ca.SX]:
        """States and cost behind a stage, and states, inputs and gains of the stage, of one candidate."""
        nx, nu, _ = self.weights.sizes
        x, u, _, _, r, s, _, _ = StageRows.split(column, self.weights.sizes)
        e, v = ca.vertsplit(own, [0, nx, nx + nu])
        now, cost, K = c[:nx], c[nx], ca.reshape(gains, nu, nx)
        wanted = u + share * (v - u) - K @ (now - x - share * e)
        if share == ALONE:
            wanted, gains = s - self.feedback @ (now - r), ca.vec(self.feedback)
        taken = self.weights.clip(wanted, now)
        cost = cost + self.weights.stage_cost(now - r, taken - s, self.rows(self._time(k), now))
        after = self.stages.after(self._time(k), now, taken)
        return ca.vertcat(after, cost), ca.vertcat(now - self.x0, taken - self.u0, gains)


@dataclass(frozen=True)
class SolvedPeriod:
    """A problem, the state (nx, 1) from which it was solved, its plan, and 1 if all that the law reads is finite."""

    problem: PeriodProblem
    begin: ca.SX
    plan: NonlinearPlan
    readable: ca.SX | None

    @property
    def input(self) -> ca.SX:
        """The first input of the plan, (nu, 1)."""
        return self.plan.u[:, 0] + self.problem.u0

    def clip(self, u: ca.SX) -> ca.SX:
        """An input (nu, 1) within the limits of the period."""
        return self.problem.weights.clip(u, self.begin)

    @property
    def behind_horizon(self) -> ca.SX:
        """The input of the law behind the horizon at the present state, (nu, 1)."""
        own = self.problem
        r, s = own.wanted_at(ca.SX(0.0), own.window[:, 0], self.begin)
        return self.clip(s - own.feedback @ (self.begin - r))

    @property
    def next_plan(self) -> dict[str, ca.SX]:
        """The plan for the next period, to which the law behind the horizon adds a stage."""
        own, plan = self.problem, self.plan
        r, s = own.end_target(plan.end)
        last = own.weights.clip(s - own.feedback @ (plan.end - r), plan.end)
        return {
            "plan_x": ca.horzcat(plan.x[:, 1:], plan.end - own.x0),
            "plan_u": ca.horzcat(plan.u[:, 1:], last - own.u0),
            "clamps": ca.horzcat(plan.clamps[:, 1:], ca.SX.zeros(last.numel())),
            "gains": ca.horzcat(plan.gains[:, 1:], ca.vec(own.feedback)),
        }
