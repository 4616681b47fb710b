"""Linear models at a point, in continuous time and of one period of a computer, as systems of python-control."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, Sampled
from workbench.core.step import runge_kutta
from workbench.design.linear.operating_point import (
    AT_REST,
    jacobians,
    names_of,
    places_of,
    rate_terms,
    refuse_jump_at,
    row_of,
    time_of,
    vector_of,
)
from workbench.design.matrices import Refused
from workbench.notation.program import walk
from workbench.proofs.interval import jumps
from workbench.validation.refusals import MOST, Array
from workbench.validation.signatures import door

if TYPE_CHECKING:
    import control

CONVERGED = 1e-12  # between a number of steps and twice as many, relative
FEWEST, MOST_STEPS = 8, 2**14
STAIRS = {"FLOOR", "CEIL", "FMOD", "REMAINDER"}


@door
def linearize(
    ode: Ode | Sampled, t: float, x: Any, p: Any = None, u: Any = None, *, at_rest: bool = False
) -> control.StateSpace:
    """The linear system dx' = A dx + B du, dy = Cy dx + D du about a state, with the names of `ode`.

    Of a `Sampled` it is dx+ = A dx + B du over one period from the instant t on: the jump, and the exact flow. The
    matrices are exact Jacobians; on the corner of a saturation or of |s| those of one of the pieces that meet there.

    Parameters
    ----------
    t, x
        Time in s, and the state (nx,), each number in its unit.
    p, u
        The parameters (np,), and the inputs (nu,), which overwrite theirs in p.
    at_rest
        True if the state must be a rest point; it is not asked otherwise.

    Raises
    ------
    ValueError
        If t, x, p or u is not of its size or not finite, if `ode` declares no inputs or has no outputs, if a Jacobian
        is not finite, if the rate jumps at the state, or if the state must be a rest point and is none.

    Examples
    --------
    >>> linear = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=[0.0, 0.0, np.pi, 0.0], at_rest=True)
    >>> linear.A[3, 2].round(2), linear.input_labels
    (np.float64(-31.18), ['F'])
    """
    import control

    flow = ode.flow if isinstance(ode, Sampled) else ode
    for what, size in (("input", len(flow.inputs)), ("output", ode.outputs.size)):
        if size == 0:
            alone = "" if isinstance(ode, Sampled) else " Take `ode.A(t, x, p)` for the matrix A alone."
            way = "ClosedLoop.ode(" if isinstance(ode, Ode) else "ClosedLoop.digital(period, "
            more = f" A loop has as inputs what comes from outside by `{way}inputs=True)`." if what == "input" else ""
            raise ValueError(
                f"`linearize(ode)` needs at least one {what}, as python-control's `StateSpace` does; "
                f"'{ode.name}' has none.{alone}{more}"
            )
    row, state, time = row_of(flow, p, u), vector_of("x", x, ode.states), time_of(t)
    if isinstance(ode, Sampled):
        end, matrices = _one_period("linearize", ode, time, state, row)
        dt = ode.period
        if at_rest:
            _refuse_step(ode, state, end, matrices[0])
    else:
        refuse_jump_at("linearize", ode, time, state, row)
        matrices, dt = jacobians("linearize", ode, time, state, row), 0
        if at_rest:
            _refuse_motion(ode, time, state, row, matrices[0])
    return control.ss(*matrices, dt, name=ode.name, **names_of(flow))


def _refuse_motion(ode: Ode, t: float, x: Array, p: Array, A: Array) -> None:
    """Refuse a state that is not at rest, with the rate that remains."""
    rate = ode.rate_at(t, x, p)
    worst = int(np.argmax(np.abs(rate) / rate_terms(A, x)))
    if not abs(rate[worst]) <= AT_REST * rate_terms(A, x)[worst]:
        raise ValueError(
            f"`linearize(x=...)` must be a rest point of '{ode.name}', where every rate is zero; at t = {t:g} the rate "
            f"of '{ode.states.labels[worst]}' is {rate[worst]:.3g}. Take a point of `equilibria(...)`, or the inputs "
            "of `operating_point(...)`."
        )


def _refuse_step(sampled: Sampled, x: Array, end: Array, A: Array) -> None:
    """Refuse a state that changes over a period, in the parts on which the next period depends."""
    change = np.abs(end - x) / (1 + np.abs(x)) * A.any(axis=0)
    worst = int(change.argmax())
    if not change[worst] <= AT_REST:
        raise ValueError(
            f"`linearize(x=...)` must be a state at which '{sampled.name}' rests, the same after a period; "
            f"'{sampled.states.labels[worst]}' changes from {x[worst]:.3g} to {end[worst]:.3g}."
        )


def _one_period(call: str, sampled: Sampled, t: float, x: Array, p: Array) -> tuple[Array, tuple[Array, ...]]:
    """The state after the jump at t and the flow that follows it, and A, B, Cy, D of both; outputs follow the jump."""
    k = t / sampled.period
    if not 0 <= k <= MOST or abs(k - round(k)) > 1e-6:
        raise ValueError(f"`{call}(t=...)` must be a multiple of the period {sampled.period:g} s; got {t:g} s.")
    k = float(round(k))
    jump = _jump(sampled)
    _refuse_stairs(call, jump, k, p)
    refuse_jump_at(call, jump, k, x, p)
    A, B, _, _ = jacobians(call, jump, k, x, p)
    after = jump.rate_at(k, x, p)
    refuse_jump_at(call, sampled.flow, t, after, p)
    _, _, Cy, D = jacobians(call, sampled.flow, t, after, p)
    end, by_x, by_u = _flow(call, sampled, t, after, p)
    return end, (by_x @ A, by_x @ B + by_u, Cy @ A, Cy @ B + D)


def _jump(sampled: Sampled) -> Ode:
    """The jump without noise, as an equation whose rate is the state after it and whose time is k."""
    flow = sampled.flow
    rest = flow.x[sampled.jump.numel() :, 0]
    rate = ca.substitute(ca.vertcat(sampled.jump, rest), sampled.w, ca.SX.zeros(sampled.w.shape))
    return replace(flow, t=sampled.k, rate=rate, outputs=Layout(), output=ca.SX(0, 1))


def _refuse_stairs(call: str, jump: Ode, k: float, p: Array) -> None:
    """Refuse a jump that is constant between its steps, or that differs at the next instant."""
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
    """The state after a period, and its derivatives by state and inputs, by steps halved until nothing changes."""
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


@door
def to_control(ode: Ode, p: Any = None, name: str | None = None) -> control.NonlinearIOSystem:
    """The system x' = f(t, x, u), y = h(t, x, u) of python-control, with the names of `ode` and its CasADi functions.

    States, inputs and outputs are named number by number, as in `q[0]`; the inputs are the declared ones, which
    overwrite theirs in the parameters p (np,).

    Raises
    ------
    ValueError
        If p does not hold np finite numbers within their bounds.
    """
    import control

    row = row_of(ode, p)
    driven = places_of(ode)

    def with_input(u: Array) -> Array:
        values = row.copy()
        values[driven] = u
        return values

    def update(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.f(t, x, with_input(u))).ravel()

    def output(t: float, x: Array, u: Array, params: object) -> Array:
        return np.array(ode.h(t, x, with_input(u))).ravel()

    return control.nlsys(update, output, name=name or ode.name, **names_of(ode))


@door
def forward_differences(ode: Ode, t: float, x: Any, p: Any = None, u: Any = None) -> control.StateSpace:
    """The linear model that python-control's own `linearize` gives, by forward differences: to be held beside ours."""
    import control

    row = row_of(ode, p, u)
    state = vector_of("x", x, ode.states)
    return control.linearize(to_control(ode, row), state, row[places_of(ode)], t=time_of(t))
