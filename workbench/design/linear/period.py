"""The linear model of one period of a computer's loop."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, Sampled
from workbench.core.step import runge_kutta
from workbench.design.certificates import Refused
from workbench.design.linear.arguments import jacobians, places_of
from workbench.design.linear.smoothness import refuse_jump_at
from workbench.notation.program import walk
from workbench.proofs.interval import jumps
from workbench.validation.refusals import MOST, Array

CONVERGED = 1e-12  # between a number of steps and twice as many, relative
FEWEST, MOST_STEPS = 8, 2**14
STAIRS = {"FLOOR", "CEIL", "FMOD", "REMAINDER"}


@dataclass(frozen=True, eq=False)
class Period:
    """The state at the end of a period (nx,), and the model dx+ = A dx + B du, dy = Cy dx + D du."""

    end: Array
    A: Array
    B: Array
    Cy: Array
    D: Array


def one_period(call: str, sampled: Sampled, t: float, x: Array, p: Array) -> Period:
    """The linear model of the jump at t and the flow that follows it; the outputs are those just after the jump.

    Raises
    ------
    ValueError
        If t is no instant of the computer; if its blocks have several periods; if a reading comes in steps; if the
        jump or the flow jumps as a state or an input changes; or if a derivative is not finite.
    Refused
        If the flow over one period does not converge.
    """
    k = _instant(call, sampled, t)
    jump = _jump(sampled)
    _refuse_stairs(call, jump, k, p)
    refuse_jump_at(call, jump, k, x, p)
    A, B, _, _ = jacobians(call, jump, k, x, p)
    after = jump.rate_at(k, x, p)
    refuse_jump_at(call, sampled.flow, t, after, p)
    _, _, Cy, D = jacobians(call, sampled.flow, t, after, p)
    end, by_x, by_u = _flow(call, sampled, t, after, p)
    return Period(end, by_x @ A, by_x @ B + by_u, Cy @ A, Cy @ B + D)


def _instant(call: str, sampled: Sampled, t: float) -> float:
    k = t / sampled.period
    if not 0 <= k <= MOST or abs(k - round(k)) > 1e-6:
        raise ValueError(f"`{call}(t=...)` must be a multiple of the period {sampled.period:g} s; got {t:g} s.")
    return float(round(k))


def _jump(sampled: Sampled) -> Ode:
    """The jump without noise, as an equation whose rate is the state after it and whose time is k."""
    flow = sampled.flow
    rest = flow.x[sampled.jump.numel() :, 0]
    rate = ca.substitute(ca.vertcat(sampled.jump, rest), sampled.w, ca.SX.zeros(sampled.w.shape))
    return replace(flow, t=sampled.k, rate=rate, outputs=Layout(), output=ca.SX(0, 1))


def _refuse_stairs(call: str, jump: Ode, k: float, p: Array) -> None:
    """Refuse a jump whose slope is zero between its steps, or that is another one at the next instant."""
    fixed = [place for place in range(len(p)) if place not in places_of(jump)]
    rate = ca.densify(ca.substitute(jump.rate, jump.p[fixed], ca.SX(p[fixed])))
    steps = walk(rate)
    if odd := STAIRS & set(jumps(steps, [symbol.name() for symbol in ca.vertsplit(jump.x)])):
        raise ValueError(
            f"`{call}(...)`: the computer of '{jump.name}' reads in steps ({odd.pop().lower()}), between which its "
            "slope is zero: a linear model would see no feedback. Set `quantum` to zero for it."
        )
    in_time = jumps(steps, [jump.t.name()])
    if "FMOD" in in_time or (in_time and k == 0):
        when = "every few periods" if "FMOD" in in_time else "from the second instant on: take t of one period"
        raise ValueError(
            f"`{call}(...)` must have one jump that is the same at each instant; a block of '{jump.name}' runs {when}."
        )


def _flow(call: str, sampled: Sampled, t: float, x: Array, p: Array) -> tuple[Array, Array, Array]:
    """The state after a period of flow, and its derivatives by the state and the inputs at its start.

    They are those of Runge-Kutta steps, twice as many until nothing changes.
    """
    flow, h, now = sampled.flow, ca.SX.sym("h"), ca.SX.sym("now")
    f = ca.Function("f", [flow.t, flow.x, flow.p], [flow.rate])
    end = runge_kutta(f, now, flow.x, flow.p, h)
    slopes = [ca.densify(ca.jacobian(end, z)) for z in (flow.x, flow.input_symbols)]
    step = ca.Function("step", [now, flow.x, flow.p, h], [end, *slopes])
    before = np.full((len(x), 1 + len(x) + len(places_of(flow))), np.inf)
    steps = FEWEST
    while steps <= MOST_STEPS:
        state, by_x, by_u = x, np.eye(len(x)), np.zeros((len(x), len(places_of(flow))))
        for i in range(steps):
            each = step(t + i * sampled.period / steps, state, p, sampled.period / steps)
            state, own, driven = np.array(each[0]).ravel(), np.array(each[1]), np.array(each[2])
            by_x, by_u = own @ by_x, own @ by_u + driven
        now_all = np.column_stack([state, by_x, by_u])
        if np.abs(now_all - before).max() <= CONVERGED * np.abs(now_all).max():
            return state, by_x, by_u
        before, steps = now_all, 2 * steps
    raise Refused(
        f"`{call}(...)`: the flow of '{flow.name}' over one period of {sampled.period:g} s does not converge within "
        f"{MOST_STEPS} Runge-Kutta steps; take a shorter period, or a state from which it does not escape."
    )
