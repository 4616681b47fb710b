"""Plans that keep all limits for their stages and end in the terminal ellipsoid, in the graph."""

from __future__ import annotations

from typing import Protocol

import casadi as ca

from workbench.blocks.laws.limit_cones import LimitCone, passes_limits
from workbench.blocks.laws.model_predictive import ModelPredictive
from workbench.core.block import Matrix, Vector
from workbench.core.bounded_loop import bounded_loop

SLACK = 1e-9  # of a limit or of the level, by which a stored plan may pass it after rounding


class SafeSet(Protocol):
    """The limits, the terminal ellipsoid, and the law with the model, as `SafetyFilter` declares them."""

    @property
    def planner(self) -> ModelPredictive: ...
    @property
    def K(self) -> Matrix: ...
    @property
    def P(self) -> Matrix: ...
    @property
    def level(self) -> float: ...
    @property
    def low(self) -> Vector: ...
    @property
    def high(self) -> Vector: ...
    @property
    def cones(self) -> tuple[LimitCone, ...]: ...


def is_safe_plan(safe: SafeSet, e: ca.SX, d: ca.SX) -> ca.SX:
    """1 if the plan u = -K x + d from e (nx, 1), with d (nu, N), keeps all limits and ends in the ellipsoid."""
    own, nx = safe.planner, e.numel()
    rows, closed = own.F - own.E @ own.K, own.A - own.B @ own.K

    def stage(c: ca.SX, change: ca.SX) -> tuple[ca.SX, ...]:
        beyond = passes_limits(safe, rows @ c[:nx] + own.E @ change)
        return (ca.vertcat(closed @ c[:nx] + own.B @ change, ca.fmax(c[nx], beyond)),)

    (end,) = bounded_loop(own.horizon, stage, ca.vertcat(e, 0.0), d)
    last = end[:nx]
    return ca.logic_and(end[nx] == 0, last.T @ safe.P @ last <= safe.level)


def largest_safe_share(safe: SafeSet, e: ca.SX, first: ca.SX, second: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The share of the way from one plan (nu, N) to another that is safe, and 1 if this or the first plan is safe.

    All limits are convex: where g(0) <= 0 < g(1), g(-g(0) / (g(1) - g(0))) <= 0. So the share is safe if the first plan
    is, and it is 1 if the second plan is.
    """
    own, nx = safe.planner, e.numel()
    rows, closed = own.F - own.E @ own.K, own.A - own.B @ own.K
    ends = ca.vertcat(safe.high, -ca.SX(safe.low))
    slack = SLACK * ca.vertcat(ca.fabs(ends), *(cone.offset for cone in safe.cones))

    def gaps(y: ca.SX) -> ca.SX:
        return ca.vertcat(ca.vertcat(y, -y) - ends, *(cone.excess(y) for cone in safe.cones))

    def stage(c: ca.SX, *plans: ca.SX) -> tuple[ca.SX, ...]:
        states = c[:nx], c[nx : 2 * nx]
        start, end = (gaps(rows @ x + own.E @ d) for x, d in zip(states, plans, strict=True))
        after = [closed @ x + own.B @ d for x, d in zip(states, plans, strict=True)]
        share = ca.fmin(c[2 * nx], ca.mmin(_shares(start, end)))
        return (ca.vertcat(*after, share, ca.fmax(c[2 * nx + 1], ca.mmax(start > slack))),)

    (last,) = bounded_loop(own.horizon, stage, ca.vertcat(e, e, 1.0, 0.0), first, second)
    start, end = (x.T @ safe.P @ x - safe.level for x in (last[:nx], last[nx : 2 * nx]))
    share = ca.fmin(last[2 * nx], _shares(start, end))
    is_first_safe = ca.logic_and(last[2 * nx + 1] == 0, start <= SLACK * safe.level)
    return share, ca.logic_or(is_first_safe, share >= 1)


def _shares(start: ca.SX, end: ca.SX) -> ca.SX:
    """-start / (end - start) where start <= 0 < end, 0 where both are above 0, and 1 elsewhere."""
    inner = ca.fmin(start, 0.0)
    return ca.if_else(end > 0, -inner / (ca.fmax(end, 0.0) - inner), 1.0)
