"""The plan of a linear predictive law: its inputs within their limits, and the states to which they lead."""

from __future__ import annotations

from typing import Protocol

import casadi as ca
import numpy as np

from workbench.blocks.laws.limit_cones import inputs_within_limits
from workbench.blocks.laws.predictive_ports import DISTURBANCE, About, all_finite, column
from workbench.blocks.laws.predictive_sweeps import PeriodAnswer, SweepNumbers, lqr_rows, rows_of_stage
from workbench.blocks.loop.contracts import Follows, Parts, Reads
from workbench.core import Entry, Layout
from workbench.core.block import Matrix, Vector
from workbench.core.bounded_loop import bounded_loop
from workbench.core.numbers import Bounds
from workbench.core.units import ANY

REST = "rest_beyond_limits"
ROUNDING = 1e-9  # of a rest at a limit


class RestNumbers(SweepNumbers, Protocol):
    """The ports and numbers of a law that its wanted rest needs, as `ModelPredictive` declares them."""

    @property
    def states(self) -> Layout: ...
    @property
    def inputs(self) -> Layout: ...
    @property
    def outputs(self) -> Layout: ...
    @property
    def follow(self) -> tuple[str, ...]: ...
    @property
    def x0(self) -> Vector: ...
    @property
    def y0(self) -> Vector: ...
    @property
    def target(self) -> Matrix | None: ...
    @property
    def safe_command(self) -> Vector | None: ...


def about_period(law: RestNumbers, z: Parts, est: Reads, ref: Follows) -> About:
    """The state, and the rest that is wanted; both at x0 where a number that is read is not finite."""
    nx, x = law.A.shape[0], column(est, law.states)
    waiting, push = nx - law.states.size, ca.SX.zeros(law.inputs.size)
    wanted = {**law.states.view(ca.SX(law.x0)), **{name: ref[name] for name in law.follow}}
    both = law.states.flatten(wanted) - law.x0
    if law.target is not None:
        both = ca.vertcat(est[DISTURBANCE], column(ref, law.outputs) - law.y0)
    valid = None if law.safe_command is None else all_finite(ca.vertcat(x, both))
    if valid is not None:
        x = ca.if_else(valid, x, ca.SX(law.x0))
        both = ca.if_else(valid, both, ca.SX.zeros(both.numel()))
    at = ca.vertcat(both, ca.SX.zeros(waiting))
    if law.target is not None:
        both = law.target @ both
        at, push = both[:nx], both[nx:]
    e = x - law.x0
    return About(ca.vertcat(e, z["sent"]) if waiting else e, at, push, valid)


def rest_memory(law: RestNumbers) -> tuple[Entry, ...]:
    """The memory of `rest_beyond_limits`, whose bound a run passes that asks for such a rest."""
    return () if law.target is None else (Entry(REST, np.zeros(()), ANY, Bounds(high=ROUNDING)),)


def rest_beyond_limits(law: RestNumbers, about: About) -> dict[str, ca.SX]:
    """The largest distance of the wanted rest beyond a limit, in the unit of its row, by its name in the memory."""
    if law.target is None:
        return {}
    rest = ca.SX(law.F) @ about.at + ca.SX(law.E) @ about.push
    return {REST: ca.mmax(ca.fmax(ca.fmax(rest - law.high, law.low - rest), 0.0))}


def planned_inputs(law: SweepNumbers, answer: PeriodAnswer) -> ca.SX:
    """The inputs (nu, N) of an answer within their limits, as deviations from the rest."""
    nu, nc = law.B.shape[1], law.low.shape[0]
    rows = ca.reshape(answer.zeta, nc, law.horizon)[:nu, :], answer.lqr[:nu, :]

    def stage(none: ca.SX, row: ca.SX, lqr: ca.SX, outside: ca.SX) -> tuple[ca.SX, ...]:
        return none, inputs_within_limits(law, ca.if_else(outside, row, lqr))

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
    rest = law.F @ at + law.E @ push

    def about_lqr(none: ca.SX, row: ca.SX, Y: ca.SX, e: ca.SX, outside: ca.SX, rest: ca.SX) -> tuple[ca.SX, ...]:
        return none, ca.if_else(outside, row - rows_of_stage(Y, e) - rest, 0.0)

    constants = after, answer.outside, rest
    _, plan = bounded_loop(law.horizon, about_lqr, ca.SX(0, 1), shifted, lqr_rows(law), constants=constants)
    return plan, after + at
