"""Proofs by intervals that a rest point is near a state, and that a box holds no others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.notation.program import Walk, walk
from workbench.core.validation.refusals import Array
from workbench.proofs.interval import NoBound, evaluate
from workbench.proofs.newton_operator import NewtonOperator, Unknowns

SHARES = (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-5)  # half-widths of boxes about a point, as shares of its size
AT_ONCE = 4096


def prove_equilibria(
    ode: Ode, p: Array, low: Array, high: Array, points: Sequence[Array], most: int
) -> tuple[list[float | None], bool, int]:
    """The proof of the zeros of f(x) in a box, of which some are known, by looking at no more than `most` boxes:

    a radius for each point, within which there is a zero, or None; if the box holds none but these; and the boxes.

    The interval Newton operator proves that a box about each point holds one zero. The rest of the box is halved until
    in each part an entry of f has no zero. A state whose rate is another state, as that of an angle, fixes that one at
    zero.

    References
    ----------
    Moore, Kearfott and Cloud (2009), Introduction to Interval Analysis, chapter 8.
    """
    nothing: list[float | None] = [None] * len(points)
    at_zero = _rates_that_are_states(ode)
    free = [i for i in range(ode.states.size) if i not in at_zero]
    if most <= 0 or not free:
        return nothing, False, 0
    if any(low[i] > 0 or high[i] < 0 for i in at_zero):
        return nothing, True, 1
    x, zeros = ode.x[free], ode.x[at_zero]
    f = ca.densify(ca.substitute(ode.rate, zeros, ca.DM.zeros(zeros.shape)))
    f = f[[i for i in range(f.numel()) if not f[i].is_zero()]]
    # parameters stay symbols, within intervals of no width: what is folded to a constant would be rounded
    numbers = dict(zip(map(str, ca.vertsplit(ode.p)), p.tolist(), strict=True))
    unknowns = Unknowns(tuple(x[k].name() for k in range(len(free))), numbers)
    around = [_neighbourhood(f, x, point[free], numbers) for point in points]
    try:
        complete, used = _sweep_boxes(walk(f), unknowns, low[free], high[free], [n for n in around if n], most)
    except NoBound:
        return nothing, False, 0
    # the states that are fixed at zero may be off by rounding in a point
    off = (float(np.abs(point[at_zero]).max(initial=0.0)) for point in points)
    return [max(n.radius, o) if n else None for n, o in zip(around, off, strict=True)], complete, used


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """A box with exactly one zero in it, and the largest distance of the zero from its middle."""

    low: Array
    high: Array
    radius: float


def _rates_that_are_states(ode: Ode) -> list[int]:
    """The places of states that are the rate of another, so that they vanish at rest."""
    place = {ode.x[i].__hash__(): i for i in range(ode.states.size)}
    rates = (ode.rate[i] for i in range(ode.states.size))
    return sorted({place[rate.__hash__()] for rate in rates if rate.is_symbolic() and rate.__hash__() in place})


def _neighbourhood(f: ca.SX, x: ca.SX, point: Array, numbers: Mapping[str, float]) -> Neighbourhood | None:
    """The widest box about a point, of those tried, with one zero in it; None if none is proved to be so."""
    try:
        operator = NewtonOperator.of(f, x, point, numbers)
    except NoBound:
        return None
    for share in SHARES:
        reach = share * (1 + float(np.abs(point).max()))
        if (radius := operator.radius(reach)) is not None:
            return Neighbourhood(point - reach, point + reach, radius)
    return None


def _sweep_boxes(
    f: Walk, unknowns: Unknowns, low: Array, high: Array, around: Sequence[Neighbourhood], most: int
) -> tuple[bool, int]:
    """Halve boxes (N, k) until each is done with, or so many have been looked at."""
    lows, highs = low[np.newaxis], high[np.newaxis]
    used = 0
    while len(lows):
        if used >= most:
            return False, used
        now = slice(0, AT_ONCE)
        a, b = lows[now], highs[now]
        used += len(a)
        entries = evaluate(f, unknowns.boxes(a, b))
        open_ = np.all([(e.low <= 0) & (e.high >= 0) for e in entries], axis=0)
        for near in around:
            open_ &= ~((a >= near.low) & (b <= near.high)).all(axis=1)
        a, b = a[open_], b[open_]
        widest = np.argmax((b - a) / (high - low), axis=1)
        rows = np.arange(len(a))
        middle = (a[rows, widest] + b[rows, widest]) / 2
        left, right = b.copy(), a.copy()
        left[rows, widest] = right[rows, widest] = middle
        lows = np.concatenate([lows[AT_ONCE:], a, right])
        highs = np.concatenate([highs[AT_ONCE:], left, b])
    return True, used
