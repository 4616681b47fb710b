"""The march through CasADi's own machine, for steps with operations that no graph knows, and on every platform."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TypeVar

import casadi as ca
import numpy as np

from workbench.core import StepMap
from workbench.core.methods import runge_kutta
from workbench.core.step import held_at
from workbench.core.validation.refusals import Array
from workbench.engine.job import Job, Progress

RUNS_AT_ONCE = 1024  # side by side in one call, each of which holds all its steps
LONGEST = 512  # steps of a marcher to one time: to build it takes as long as to run it ten times
LEVELS, AT_ONCE = 3, 16  # of loops in loops, each of so many rounds, for the segments of a step
STEPS_PER_CALL = 20_000  # of all runs, between two looks at progress and divergence: about a tenth of a second
Symbol = TypeVar("Symbol", ca.SX, ca.MX)


def march(job: Job, x: Array, tell: Progress) -> None:
    """Fill x (B, 1 + kept, nx) behind x[:, 0] with the states every `stride` steps."""
    job.check(x)
    for first in range(0, len(x), RUNS_AT_ONCE):
        lot = np.arange(first, min(first + RUNS_AT_ONCE, len(x)))
        _march(job.part(lot, job.stride, job.begin), x[lot[0] : lot[-1] + 1], tell, first / len(x), len(lot) / len(x))


def _march(job: Job, x: Array, tell: Progress, done_before: float, part: float) -> None:
    runs, kept, stride = len(x), x.shape[1] - 1, job.stride
    now = np.vstack([np.full((1, runs), job.begin, dtype=float), x[:, 0].T])
    most = max(1, STEPS_PER_CALL // runs)
    chunk = max(1, most // stride)
    pieces = [stride] if kept > 1 and stride <= most else _pieces(stride, most)
    done, k = 0, job.begin
    while done < kept:
        size = min(chunk, kept - done)
        for piece in pieces:
            # (B, steps, nw) to CasADi's (nw, B steps), run by run
            steps = np.arange(k, k + piece * size)
            noise = job.noise(steps).reshape(runs * piece * size, -1).T
            if job.step.rule.d.numel():
                noise = np.vstack([noise, np.tile(job.record[steps].T, runs)])
            out = np.array(_marcher(job.step, piece, size, runs, job.has_switches)(np.vstack([now, job.p.T]), noise))
            out = out.reshape(len(now), runs, size)
            now, k = out[:, :, -1], k + piece * size
            tell(min(done_before + part * (k - job.begin) / (kept * stride), 1.0))
        x[:, 1 + done : 1 + done + size] = out[1:].transpose(1, 2, 0)
        done += size
        if not np.isfinite(now).all(axis=0).any():  # nothing is left to simulate
            x[:, 1 + done :] = np.nan
            done = kept
            tell(min(done_before + part, 1.0))


def _pieces(stride: int, most: int) -> list[int]:
    """The steps to the only kept time, or to one beyond a call, in powers of two: so that few marchers serve all."""
    whole = min(LONGEST, 1 << most.bit_length() - 1)
    return [whole] * (stride // whole) + [1 << i for i in range(whole.bit_length()) if stride % whole >> i & 1]


@lru_cache(maxsize=64)
def _marcher(step: StepMap, stride: int, kept_rows: int, runs: int, has_switches: bool = False) -> ca.Function:
    """[k; x; p] and the noise to [k; x] at `kept_rows` times, `stride` steps apart, all side by side, for each run."""
    size = 1 + step.states.size + step.parameters.size
    often = stride * kept_rows > 1  # what is shared gains more than it costs to find
    one = _one(step, ca.MX, _segmented_step(step, often), often) if has_switches else _one(step, ca.SX, step.F, often)
    rows = sum(symbols.numel() for symbols in step.rule.drives)
    start, noise = ca.MX.sym("start", size), ca.MX.sym("noise", rows, stride * kept_rows)
    states = one.fold(stride).mapaccum(kept_rows)(start, noise)[: 1 + step.states.size, :]
    march = ca.Function("workbench_march", [start, noise], [states])
    return march if runs == 1 else march.map(runs, "thread", min(runs, 8))


def _one(step: StepMap, symbols: type[Symbol], after: ca.Function, shares_expressions: bool) -> ca.Function:
    """[k; x; p] and [w; d] to [k; x; p] a step later, of a function x+ (k, x, p, w), or (k, x, p, w, d)."""
    size = 1 + step.states.size + step.parameters.size
    sizes: list[int] = [each.numel() for each in step.rule.drives]
    z, w = symbols.sym("z", size), symbols.sym("w", sum(sizes))
    k, x, p = ca.vertsplit(z, [0, 1, 1 + step.states.size, size])
    drives = ca.vertsplit(w, [0, sizes[0], *([sum(sizes)] if len(sizes) > 1 else [])])
    later = after(k, x, p, *drives)
    return ca.Function("workbench_one", [z, w], [ca.vertcat(k + 1, later, p)], {"cse": shares_expressions})


def _segmented_step(step: StepMap, shares_expressions: bool) -> ca.Function:
    """x+ (k, x, p, w) of a step from switch to switch; not a number where there are more than 4096."""
    rule, parts, options = step.rule, step.rule.segments, {"cse": shares_expressions}
    assert parts is not None
    n, number = parts.start.numel(), [rule.t, rule.h]
    k, p, x = rule.k, rule.p, rule.x[: parts.start.numel()]

    def at_begin(value: ca.SX) -> ca.SX:
        return ca.substitute(rule.without_crossings(value), ca.vertcat(*number), ca.vertcat(k * step.h, step.h))

    end, length, passed = at_begin(parts.end), at_begin(parts.length), parts.first
    if parts.e is not None:
        passed = ca.substitute(passed, parts.e, rule.next[: parts.e.numel()])
    begin, span = k * step.h + parts.s, end - parts.s
    f = held_at(begin + span / 2, rule.m, rule.t, x, p, parts.rate)
    held = ca.vertcat(k, p, parts.s, x)
    moved = ca.vertcat(k, p, end, runge_kutta(f, begin, x, p, span, rule.method))
    segment, wait = (ca.Function("segment", [held], [made], options) for made in (moved, held))
    v, place = ca.MX.sym("v", held.numel()), 1 + p.numel()
    many = segment
    for _ in range(LEVELS):  # each asks once whether all is done, so that a step of few segments takes few questions
        goes_on = ca.Function.if_else("goes_on", many, wait)(v[place] < step.h, v)
        many = ca.Function("segments", [v], [goes_on]).fold(AT_ONCE)
    symbols = [k, rule.x, p, rule.w]
    first = ca.Function("first", symbols, [ca.vertcat(at_begin(passed) < length)], options)
    start = ca.Function("start", symbols, [ca.vertcat(k, p, 0, at_begin(parts.start))], options)
    arguments = [ca.MX.sym(symbol, like.numel()) for symbol, like in zip("kxpw", symbols, strict=True)]
    last = many(start(*arguments))
    late = last[place] < step.h
    ends = ca.vertcat(ca.if_else(late, math.nan, last[place + 1 :]), step.F(*arguments)[n:, :])
    split, whole = (ca.Function("step", arguments, [made]) for made in (ends, step.F(*arguments)))
    chosen = ca.Function.if_else("segments", split, whole)(first(*arguments), *arguments)
    return ca.Function("workbench_segments", arguments, [chosen])
