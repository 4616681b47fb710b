"""The linear model of one period of a computer: its jump, and the exact flow that follows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from workbench.core import Layout, Ode, SampledSystem
from workbench.core.methods import runge_kutta
from workbench.core.notation.program import walk
from workbench.core.validation.refusals import MOST, Array
from workbench.design.linear.operating_point import LATEST, jacobians, places_of, refuse_jump_at
from workbench.design.linear.switching_functions import (
    FARTHER,
    CornerSide,
    Mask,
    Sides,
    SwitchingFunctions,
    UsedEntries,
    all_entries,
    anywhere,
    chosen_pieces,
    corner_entries,
    refuse_corner,
    rows_of,
    side_direction,
)
from workbench.design.matrices import DesignError
from workbench.proofs.interval import jumps

STEP_TOLERANCE = 1e-12  # between a number of steps and twice as many, relative
FEWEST, MOST_STEPS = 8, 2**14
STAIRS = {"FLOOR", "CEIL", "FMOD", "REMAINDER"}
Matrices = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class Period:
    """The state (nx,) after a period, the outputs (ny,) that follow its jump, and A, B, Cy, D from start to both.

    `odd` (ny,) marks the outputs whose row of Cy or D differs between the pieces that meet at the state.
    """

    end: Array
    output: Array
    matrices: Matrices
    odd: Mask


def one_period(
    call: str,
    system: SampledSystem,
    t: float,
    x: Array,
    p: Array,
    side: Sides = None,
    used_entries: UsedEntries = all_entries,
    *,
    substeps: int | None = None,
    is_lifted: bool = False,
) -> Period:
    """The jump at t and the flow that follows it; a corner on which the answer depends is refused, or a side taken.

    The flow is exact, or that of so many `substeps` of a run. A block with a period of its own is refused unless the
    period is one of several in a lifted model, as `is_lifted` says.
    """
    k = t / system.period
    if not 0 <= k <= MOST or abs(k - round(k)) > 1e-6:
        raise ValueError(f"`{call}(t=...)` must be a multiple of the period {system.period:g} s; got {t:g} s.")
    k, flow, jump, n = float(round(k)), system.flow, jump_of(system), len(x)
    _refuse_stairs(call, jump, k, p, is_lifted)
    refuse_jump_at(call, jump, k, x, p, _used_states(system, used_entries))
    after = jump.rate_at(k, x, p)
    refuse_jump_at(call, flow, t, after, p)
    output = np.array(flow.h(t, after, p)).ravel()
    first, then = SwitchingFunctions.of(jump).at(k, x, p), SwitchingFunctions.of(flow).at(t, after, p)
    jumped, moved = first.pieces(k, x, p), then.pieces(t, after, p)
    odd = np.zeros(len(output), dtype=bool)
    if not jumped and not moved:
        A, B, _, _ = jacobians(call, jump, k, x, p)
        end, J = _after(call, system, t, after, p, np.hstack([A, B]), substeps)
    else:
        end = flow_over(call, system, t, after, p, substeps)[0]
        jumped = jumped or [CornerSide((), np.zeros(0), *2 * (np.hstack(jacobians(call, jump, k, x, p)[:2]),))]
        step = side_direction(call, first, side, x, p[places_of(flow)])
        if step is not None:
            jumped = chosen_pieces(first, jumped, step, (k, x, p))
            moved = chosen_pieces(then, moved, np.concatenate([jumped[0].near @ step, step[n:]]), (t, after, p))
        flows: list[CornerSide | None] = [*moved] or [None]
        ways = [_way(call, system, t, after, p, a, b, substeps) for a in jumped for b in flows]
        apart = corner_entries(ways)
        if (apart & used_entries(anywhere(ways))).any():
            _refuse_period(call, first, jumped, then, moved)
        J, odd = ways[0].near, np.asarray(apart[n:].any(axis=1))
    return Period(end, output, (J[:n, :n], J[:n, n:], J[n:, :n], J[n:, n:]), odd)


def _used_states(system: SampledSystem, used_entries: UsedEntries) -> Mask:
    """True for the states (nx,) after a jump on which the answer depends, as others are computed and never read."""
    flow, jump, n = system.flow, jump_of(system), system.states.size
    jumped, rate, output = (
        np.array(ca.DM(ca.jacobian_sparsity(ca.densify(values), ca.vertcat(each.x, each.input_symbols)), 1)) > 0
        for values, each in ((jump.rate, jump), (flow.rate, flow), (flow.output, flow))
    )
    reach = np.eye(jumped.shape[1], dtype=bool)
    reach[:n] |= rate
    for _ in range(len(reach).bit_length()):
        reach = reach.astype(float) @ reach > 0
    after = np.vstack([reach[:n], output])  # of the ends of a period and the outputs, by what is there after the jump
    pattern = after.astype(float) @ np.vstack([jumped, np.eye(len(reach))[n:]]) > 0
    used = (used_entries(pattern) & pattern).any(axis=1)
    return np.asarray(after[used, :n].any(axis=0))


def _after(
    call: str, system: SampledSystem, t: float, x: Array, p: Array, jump: Array, substeps: int | None
) -> tuple[Array, Array]:
    """The state at the end of a flow, and the derivatives (nx + ny, nx + nu) of it and of the outputs, past a jump."""
    n = len(x)
    end, by_x, by_u = flow_over(call, system, t, x, p, substeps)
    _, _, Cy, D = jacobians(call, system.flow, t, x, p)
    A, B = jump[:, :n], jump[:, n:]
    return end, np.block([[by_x @ A, by_x @ B + by_u], [Cy @ A, Cy @ B + D]])


def _way(
    call: str,
    system: SampledSystem,
    t: float,
    x: Array,
    p: Array,
    jump: CornerSide,
    flow: CornerSide | None,
    substeps: int | None,
) -> CornerSide:
    """The derivatives of a whole period through one piece of the jump and one of the flow, near and farther off."""
    corners, ends = SwitchingFunctions(system.flow, (), ca.SX(0, 1)), []
    for scale, own in ((1.0, jump.near), (FARTHER, jump.far)):
        at = corners.shift_arguments(t, x, p, None if flow is None else scale * flow.direction)
        ends.append(_after(call, system, *at, own, substeps)[1])
    return CornerSide(jump.signs, jump.direction, *ends)


def _refuse_period(
    call: str,
    jump: SwitchingFunctions,
    jump_sides: list[CornerSide],
    flow: SwitchingFunctions,
    flow_sides: list[CornerSide],
) -> None:
    """Refuse a period whose jump, or else whose flow, starts on a corner."""
    odd, names = corner_entries(jump_sides), jump.ode.states.labels
    if odd.any():
        refuse_corner(call, jump, jump_sides, odd, [f"'{name}' after the instant" for name in names])
    refuse_corner(call, flow, flow_sides, corner_entries(flow_sides), rows_of(flow.ode))


@lru_cache(maxsize=LATEST)
def jump_of(system: SampledSystem) -> Ode:
    """The jump without noise, as an equation whose rate is the state after it and whose time is k."""
    flow = system.flow
    rest = flow.x[system.jump.numel() :, 0]
    rate = ca.substitute(ca.vertcat(system.jump, rest), system.w, ca.SX.zeros(system.w.shape))
    return replace(flow, t=system.k, rate=rate, outputs=Layout(), output=ca.SX(0, 1))


def _refuse_stairs(call: str, jump: Ode, k: float, p: Array, is_lifted: bool) -> None:
    """Refuse a jump that is constant between its steps, or that differs at the next instant unless that is lifted."""
    fixed = [place for place in range(len(p)) if place not in places_of(jump)]
    rate = ca.densify(ca.substitute(jump.rate, jump.p[fixed], ca.SX(p[fixed])))
    steps = walk(rate)
    if odd := STAIRS & set(jumps(steps, [symbol.name() for symbol in ca.vertsplit(jump.x)])):
        raise ValueError(
            f"`{call}(...)`: the computer of '{jump.name}' reads in steps ({odd.pop().lower()}), between which its "
            "slope is zero: a linear model would see no feedback. Set `quantum` to zero for it."
        )
    in_time = jumps(steps, [jump.t.name()])
    if ("FMOD" in in_time and not is_lifted) or (in_time and k == 0):
        when = "every few periods" if "FMOD" in in_time else "from the second instant on: take t of one period"
        raise ValueError(
            f"`{call}(...)` must have one jump that is the same at each instant; a block of '{jump.name}' runs {when}."
        )


def flow_over(
    call: str, system: SampledSystem, t: float, x: Array, p: Array, substeps: int | None = None
) -> tuple[Array, Array, Array]:
    """The state after a period, and its derivatives by state and inputs, in `substeps` steps of Runge and Kutta.

    Without a number the steps are halved until nothing changes.
    """
    flow, (step, moving, used) = system.flow, _step_of(system.flow)
    before = np.full((len(x), 1 + len(x) + len(places_of(flow))), np.inf)
    steps = substeps or FEWEST
    while steps <= MOST_STEPS:
        state, by_x, by_u = x.copy(), np.eye(len(x)), np.zeros((len(x), len(places_of(flow))))
        for i in range(steps):
            each = step(t + i * system.period / steps, state, p, system.period / steps)
            end, own, driven = (np.array(part) for part in each)
            state[moving] = end.ravel()
            by_x[moving], by_u[moving] = own @ by_x[used], own @ by_u[used] + driven
        now_all = np.column_stack([state, by_x, by_u])
        if substeps or np.abs(now_all - before).max() <= STEP_TOLERANCE * np.abs(now_all).max():
            return state, by_x, by_u
        before, steps = now_all, 2 * steps
    raise DesignError(
        f"`{call}(...)`: the flow of '{flow.name}' over one period of {system.period:g} s does not converge within "
        f"{MOST_STEPS} Runge-Kutta steps; take a shorter period, or a state from which it does not escape."
    )


@lru_cache(maxsize=LATEST)
def _step_of(flow: Ode) -> tuple[ca.Function, list[int], list[int]]:
    """A Runge-Kutta step (t, x, p, h) of the states that move, with its derivatives by those it uses and by inputs.

    Beside it stand the places of both. The many memories of a computer neither move between two instants nor act.
    """
    h, now = ca.SX.sym("h"), ca.SX.sym("now")
    moving = [i for i, rate in enumerate(ca.vertsplit(ca.densify(flow.rate))) if not rate.is_zero()]
    f = ca.Function("f", [flow.t, flow.x, flow.p], [flow.rate])
    end = runge_kutta(f, now, flow.x, flow.p, h)[moving]
    by_x, by_u = (ca.jacobian(end, z) for z in (flow.x, flow.input_symbols))
    used = sorted(set(by_x.sparsity().get_col()))
    values = [ca.densify(part) for part in (end, by_x[:, used], by_u)]
    return ca.Function("step", [now, flow.x, flow.p, h], values), moving, used
