"""The state at which a loop rests: a rate that is zero, or a period after which all is as it was; row by row."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import casadi as ca
import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.point import AT_REST, rate_terms
from workbench.core.validation.refusals import Array
from workbench.design.linear.linear_period import flow_over, jump_of
from workbench.design.linear.loop_cuts import closure, entries_of
from workbench.design.linear_loop.loop_equations import Equations, flow_of, labels_of
from workbench.design.linear_loop.point_model import Instant

ROUNDS, SMALL, LEAST = 100, 1e-7, 1e-14  # evaluations; relative steps taken whole, and those that are rounding
SETTLING_PERIODS = 10_000  # periods after which the memories of a computer should not change any more
PATIENCE, SHORTER = 25, 0.9  # evaluations in which the step must become so much shorter, or the search stalls
WAY = (4, 12, 24, 48, 96)  # implicit steps in time, after which Newton's method tries again
Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
Motion = Callable[[Array, Array], tuple[Array, Array]]  # (N, nx) and (N, np) to the change (N, nx) and (N, nx, nx)


def motion_of(call: str, equations: Equations, at: Instant, substeps: int | None = None) -> Motion:
    """The rate of a loop, or its change over the periods that recur, with the derivatives by the states."""
    if isinstance(equations, Ode):
        f, A = equations.f, equations.A
        return lambda x, p: _stack([(f(at.t, *row), A(at.t, *row)) for row in zip(x, p, strict=True)])

    jump, period = jump_of(equations), equations.period

    def over_periods(state: Array, p: Array) -> tuple[Array, Array]:
        start, slope = state, np.eye(len(state))
        for k in range(at.count):
            t = at.t + k * period
            after, by_state = (np.array(part(round(t / period), state, p)) for part in (jump.f, jump.A))
            state, by_after, _ = flow_over(call, equations, t, after.ravel(), p, substeps)
            slope = by_after @ by_state @ slope
        return state - start, slope - np.eye(len(state))

    return lambda x, p: _stack([over_periods(*row) for row in zip(x, p, strict=True)])


def _stack(pairs: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    first, second = zip(*pairs, strict=True)
    return np.array([np.array(part).ravel() for part in first]), np.array([np.array(part) for part in second])


def resting_states(closed_loop: Equations, ports: tuple[str, ...]) -> Mask:
    """True for the states (nx,) that must rest, as a Jacobian depends on them; none of a linear loop."""
    n, flow = closed_loop.states.size, flow_of(closed_loop)
    seen = [i for name in ports for i in range(flow.outputs.size)[flow.outputs.slice(name)]]
    steps, bends = np.eye(n, dtype=bool), np.zeros(n, dtype=bool)
    for each in (flow, jump_of(closed_loop)) if isinstance(closed_loop, SampledSystem) else (flow,):
        steps |= entries_of(ca.jacobian_sparsity(ca.densify(each.rate), each.x))
        every = list(range(n))  # A is kept by the equations, as one of 200 states takes seconds
        for J, rows in ((each.A, every), (each.B, every), (each.Cy, seen), (each.D, seen)):
            used = np.isin(np.arange(J.numel_out(0)) % max(J.size1_out(0), 1), rows)
            bends |= entries_of(J.jac_sparsity(0, 1))[used].any(axis=0)
    return np.asarray(closure(steps)[bends].any(axis=0))


def start_of(closed_loop: Equations, at: Instant, x: Array, p: Array, fixed_states: list[int]) -> Array:
    """The states (N, nx) from which a rest is sought: in a computer with its queue filled by what its law commands.

    At an instant such a state follows from others, and not from itself by way of any.
    """
    if not isinstance(closed_loop, SampledSystem):
        return x
    jump = jump_of(closed_loop)
    by = entries_of(ca.jacobian_sparsity(ca.densify(jump.rate), jump.x))
    returns = (by & closure(by | np.eye(len(by), dtype=bool)).T).any(axis=1)
    follows = np.setdiff1d(np.flatnonzero(~returns), fixed_states)
    after = ca.Function("after", [jump.t, jump.x, jump.p], [ca.densify(jump.rate)])
    state = x.copy()
    for _ in follows:
        state[:, follows] = np.array(after(round(at.t / closed_loop.period), state.T, p.T)).T[:, follows]
    start = np.where(np.isfinite(state).all(axis=1, keepdims=True), state, x)
    return _settled_memories(after, round(at.t / closed_loop.period), start, p, fixed_states) if fixed_states else start


def _settled_memories(after: ca.Function, k: int, x: Array, p: Array, fixed_states: list[int]) -> Array:
    """The states (N, nx) after so many jumps that none changes, while those that are named stay; else as they were.

    A filter that has not settled may saturate the command, and Newton's method finds no way out of that.
    """
    state, free = x.copy(), np.setdiff1d(np.arange(x.shape[1]), fixed_states)
    if not free.size:
        return x
    for step in range(SETTLING_PERIODS):
        new = np.array(after(k + step, state.T, p.T)).T[:, free]
        change = (np.abs(new - state[:, free]) / (1 + np.abs(new))).max(axis=1)
        state[:, free] = new
        if not change.max() > LEAST:
            break
    settled = np.isfinite(state).all(axis=1) & (change <= SMALL)
    return np.where(settled[:, np.newaxis], state, x)


def find_rest(
    motion: Motion, x: Array, p: Array, must: Mask, fixed_states: list[int], discrete: bool
) -> tuple[Array, Array]:
    """States (N, nx) at rest by Gauss-Newton, and how far from rest they are: the shares (N, nx) of what moves.

    States at rest from the start, to rounding, stay as they are; those at the places `fixed_states`, and those that
    nothing moves, do so always. A step that would make the next one longer is halved. A row whose steps become no
    shorter, as it has no rest, is given up before the others end.
    """
    x = x.copy()
    change, slope = motion(x, p)
    idle = (change == 0).all(axis=0) & (slope == 0).all(axis=(0, 2))  # as an integral with a gain of zero
    free = np.setdiff1d(np.flatnonzero(must & ~idle), fixed_states)
    share = _shares(change, slope, x, must, discrete)
    seeking = ~(share.max(axis=1, initial=0.0) <= AT_REST) & np.isfinite(change).all(axis=1)
    if not free.size:
        return x, share
    step, factor = _towards_rest(change, slope, must, free), np.ones(len(x))
    size = _sizes(step, x[:, free])
    mark, since = size.copy(), np.zeros(len(x), dtype=int)
    for _ in range(ROUNDS):
        seeking &= (size > LEAST) & np.isfinite(size)
        rows = np.flatnonzero(seeking)
        if not rows.size:
            break
        ahead = x[rows]
        ahead[:, free] += factor[rows, np.newaxis] * step[rows]
        change, slope = motion(ahead, p[rows])
        new = _towards_rest(change, slope, must, free)
        left = _sizes(new, ahead[:, free])
        good = (left < size[rows]) | ((size[rows] < SMALL) & np.isfinite(left))
        taken = rows[good]
        stalls = (left >= size[rows] / 2) & (size[rows] < SMALL)
        x[taken], step[taken] = ahead[good], new[good]
        size[taken], factor[taken] = left[good], 1.0
        share[taken] = _shares(change[good], slope[good], ahead[good], must, discrete)
        factor[rows[~good]] /= 2
        shorter = size[rows] < SHORTER * mark[rows]
        mark[rows], since[rows] = np.where(shorter, size[rows], mark[rows]), np.where(shorter, 0, since[rows] + 1)
        seeking[rows] &= ~stalls & (factor[rows] > 1e-9) & (since[rows] < PATIENCE)
    return x, share


def seek_rest(
    motion: Motion, x: Array, p: Array, must: Mask, fixed_states: list[int], discrete: bool
) -> tuple[Array, Array]:
    """The state (1, nx) at rest, as `find_rest` has it; if Newton's method fails, from states to which the loop moves.

    A law that saturates where the loop starts gives Newton's method no direction. The loop itself leaves that state.
    """
    found, share = find_rest(motion, x, p, must, fixed_states, discrete)
    if share.max(initial=0.0) <= AT_REST:
        return found, share
    for state in _on_the_way(motion, x, p, must, fixed_states, discrete):
        ahead, left = find_rest(motion, state, p, must, fixed_states, discrete)
        if left.max(initial=0.0) <= AT_REST:
            return ahead, left
    return found, share


def _on_the_way(
    motion: Motion, x: Array, p: Array, must: Mask, fixed_states: list[int], discrete: bool
) -> Iterator[Array]:
    """States (1, nx) after some implicit steps in time, which grow as the motion ends and shrink as it begins again.

    References
    ----------
    Kelley and Keyes (1998), Convergence Analysis of Pseudo-Transient Continuation, SIAM J. Numer. Anal. 35.
    """
    x, eye = x.copy(), np.eye(x.shape[1])
    change, slope = motion(x, p)
    idle = (change == 0).all(axis=0) & (slope == 0).all(axis=(0, 2))
    free = np.setdiff1d(np.flatnonzero(must & ~idle), fixed_states)
    if not (free.size and np.isfinite(change).all() and np.isfinite(slope).all()):
        return
    rate = 1.0 if discrete else float(np.abs(slope).sum(axis=2).max())  # of a period, or 1/s
    size = float(np.linalg.norm(_shares(change, slope, x, must, discrete)))
    for count in range(1, WAY[-1] + 1):
        x[:, free] += _towards_rest(change, slope - rate * eye, must, free)
        change, slope = motion(x, p)
        left = float(np.linalg.norm(_shares(change, slope, x, must, discrete)))
        if not (math.isfinite(left) and left > 0 and size > 0):
            return
        rate, size = rate * min(max(left / size, 0.5), 5.0), left
        if count in WAY:
            yield x.copy()


def _shares(change: Array, slope: Array, x: Array, must: Mask, discrete: bool) -> Array:
    """The motion of each state, as a share of what could have moved it; infinite where that is no number."""
    with np.errstate(all="ignore"):
        if discrete:
            read = (slope + np.eye(x.shape[1]) != 0).any(axis=1)
            share = np.abs(change) / (1 + np.abs(x)) * read
        else:
            share = np.abs(change)
            for own, J, one in zip(share, slope, x, strict=True):
                own /= rate_terms(J, one)
    return np.where(np.isnan(share), np.inf, share) * must


def _towards_rest(change: Array, slope: Array, must: Mask, free: Array) -> Array:
    """The least change of the free states that stops the others to first order, row by row, (N, nfree)."""
    J, r = slope[:, must][:, :, free], change[:, must]
    step = np.full((len(r), len(free)), np.nan)
    sound = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(r).all(axis=1)
    steepest = np.abs(J[sound]).max(axis=2, initial=0.0)
    size = np.where(steepest > 0, steepest, 1.0)
    inverse = np.linalg.pinv(J[sound] / size[:, :, np.newaxis], rcond=1e-12)
    step[sound] = -(inverse @ (r[sound] / size)[:, :, np.newaxis])[:, :, 0]
    return step


def _sizes(step: Array, x: Array) -> Array:
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(step) / (1 + np.abs(x))).max(axis=1, initial=0.0))


def motion_sentences(
    call: str, closed_loop: Equations, at: Instant, x: Array, p: Array, share: Array, must: Mask
) -> list[str]:
    """For each row of states (N, nx) the sentence that says what moves there, or would in time; empty at rest."""
    labels, sentences, driven = labels_of(closed_loop.states), [], _driven_states(closed_loop, at, x, p, must)
    for own, moved in zip(share, driven, strict=True):
        worst = int(np.argmax(own)) if own.size else 0
        if moved >= 0:
            sentences.append(
                f"`{call}(...)` must have a loop that rests; at t = {at.t:g} s '{labels[moved]}' is driven by a signal "
                "that moves in time. Give the loop a constant reference and disturbance, another `t`, or "
                "`at_rest=False`."
            )
        elif own.size and not own[worst] <= AT_REST:
            sentences.append(
                f"`{call}(...)` must have a state at which the loop rests, and Newton's method found none: "
                f"'{labels[worst]}' still moves at t = {at.t:g} s. Start nearer to a rest point, or ask for the loop "
                "frozen where it starts: `at_rest=False`."
            )
        else:
            sentences.append("")
    return sentences


def _driven_states(closed_loop: Equations, at: Instant, x: Array, p: Array, must: Mask) -> list[int]:
    """For each row the place of the state whose motion changes with time itself, or -1."""
    found = np.full(len(x), -1)
    both = [(closed_loop, at.t)]
    if isinstance(closed_loop, SampledSystem):
        both = [(jump_of(closed_loop), at.t / closed_loop.period), (closed_loop.flow, at.t)]
    for ode, t in both:
        assert isinstance(ode, Ode)
        if not ca.depends_on(ode.rate, ode.t):
            continue
        first = ca.sparsify(ca.jacobian(ode.rate, ode.t))  # a step in time leaves zeros
        driven = first.sparsity().row()
        if not driven:
            continue
        terms = ca.fabs(ca.jacobian(ode.rate[driven], ode.x)) @ (1 + ca.fabs(ode.x)) + 1
        values = [ca.densify(part) for part in (first[driven], ca.jacobian(first[driven], ode.t), terms)]
        by_time = ca.Function("by_time", [ode.t, ode.x, ode.p], values)
        one, two, scale = (np.array(part).T for part in by_time(t, x.T, p.T))
        share = np.zeros(x.shape)
        share[:, driven] = np.maximum(np.abs(one), np.abs(two)) / scale * must[driven]
        moved = share.max(axis=1, initial=0.0) > AT_REST
        found[moved] = share[moved].argmax(axis=1)
    return [int(place) for place in found]
