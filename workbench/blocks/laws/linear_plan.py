"""The plan of a linear predictive law: its inputs within their limits, and the states to which they lead."""

from __future__ import annotations

import casadi as ca

from workbench.blocks.laws.predictive_ports import About
from workbench.blocks.laws.predictive_sweeps import PeriodAnswer, SweepNumbers
from workbench.core.bounded_loop import bounded_loop


def planned_inputs(law: SweepNumbers, answer: PeriodAnswer) -> ca.SX:
    """The inputs (nu, N) of an answer within their limits, as deviations from the rest."""
    nu, nc = law.B.shape[1], law.low.shape[0]
    low, high = ca.SX(law.low)[:nu], ca.SX(law.high)[:nu]
    rows = ca.reshape(answer.zeta, nc, law.horizon)[:nu, :], answer.lqr[:nu, :]

    def stage(none: ca.SX, row: ca.SX, lqr: ca.SX, outside: ca.SX) -> tuple[ca.SX, ...]:
        return none, ca.fmin(ca.fmax(ca.if_else(outside, row, lqr), low), high)

    return bounded_loop(law.horizon, stage, ca.SX(0, 1), *rows, constants=(answer.outside,))[1]


def planned_states(law: SweepNumbers, about: About, inputs: ca.SX) -> ca.SX:
    """The states (nx, N + 1) to which inputs (nu, N) lead, as deviations from the rest."""

    def ahead(e: ca.SX, v: ca.SX) -> tuple[ca.SX, ...]:
        after = law.A @ (e - about.at) + law.B @ (v - about.push) + about.at
        return after, after

    return ca.horzcat(about.e, bounded_loop(law.horizon, ahead, about.e, inputs)[1])


def following_plan(law: SweepNumbers, about: About, answer: PeriodAnswer, first: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The plan (nc, N) of the next period about its LQR answer, and the next state (nx, 1), behind a first input."""
    nc, (e, at, push, _) = law.low.shape[0], about
    shifted = ca.reshape(ca.vertcat(answer.zeta[nc:], answer.zeta[-nc:]), nc, law.horizon)
    after = law.A @ (e - at) + law.B @ (first - push)
    rows, closed, rest = law.F - law.E @ law.K, law.A - law.B @ law.K, law.F @ at + law.E @ push

    def about_lqr(e: ca.SX, row: ca.SX, outside: ca.SX) -> tuple[ca.SX, ...]:
        return ca.if_else(outside, closed @ e, e), ca.if_else(outside, row - rows @ e - rest, 0.0)

    _, plan = bounded_loop(law.horizon, about_lqr, after, shifted, constants=(answer.outside,))
    return plan, after + at
