"""Proofs by intervals that a rest point is near a state, and that a box holds no others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.notation.program import Walk, walk
from workbench.core.validation.refusals import Array
from workbench.proofs.interval import Interval, NoBound, evaluate, jumps

# Half-widths of boxes about a point, the widest that serves, as shares of its size; and what stands for the rounding
# of a few sums and quotients of positive numbers, generously.
SHARES, ROUNDED = (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-5), 1 + 1e-9
AT_ONCE = 4096


def prove_equilibria(
    ode: Ode, p: Array, low: Array, high: Array, points: Sequence[Array], most: int
) -> tuple[list[float | None], bool, int]:
    """The proof of the zeros of f(x) in a box, of which some are known, by looking at no more than `most` boxes:

    a radius for each point, within which there is a zero, or None; if the box holds none but these; and the boxes.

    Near a point x the map N(x) = x - Y f(x) is a contraction: so there is one zero in that neighbourhood, and not two
    (Banach). The rest of the box is halved until in each part an entry of f has no zero. A state whose rate is another
    state, as that of an angle, fixes that one at zero.

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
    space = Space(
        tuple(x[k].name() for k in range(len(free))), dict(zip(map(str, ca.vertsplit(ode.p)), p.tolist(), strict=True))
    )
    try:
        smooth = not jumps(walk(f), space.names)  # else df/dx does not bound differences of f
        around = [_neighbourhood(f, x, ode.p, point[free], space) if smooth else None for point in points]
        complete, used = _swept(walk(f), space, low[free], high[free], [n for n in around if n], most)
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


@dataclass(frozen=True)
class Space:
    """The names of the states that are free, and the parameters by name."""

    names: tuple[str, ...]
    constants: Mapping[str, float]

    def boxes(self, low: Array, high: Array) -> dict[str, Interval]:
        """Boxes (N, k) of the states, and the parameters, by name."""
        held = {name: Interval(low[:, k], high[:, k]) for k, name in enumerate(self.names)}
        fixed = {name: np.full(len(low), value) for name, value in self.constants.items()}
        return held | {name: Interval(value, value) for name, value in fixed.items()}


def _rates_that_are_states(ode: Ode) -> list[int]:
    """The places of states that are the rate of another, so that they vanish at rest."""
    place = {ode.x[i].__hash__(): i for i in range(ode.states.size)}
    rates = (ode.rate[i] for i in range(ode.states.size))
    return sorted({place[rate.__hash__()] for rate in rates if rate.is_symbolic() and rate.__hash__() in place})


def _neighbourhood(f: ca.SX, x: ca.SX, p: ca.SX, point: Array, space: Space) -> Neighbourhood | None:
    """The widest box about a point, of those tried, in which N is proved to be a contraction with its zero inside."""
    slope = ca.densify(ca.jacobian(f, x))
    if slope.shape[0] != slope.shape[1]:
        return None
    A = np.array(ca.Function("slope", [x, p], [slope])(point, list(space.constants.values())))
    if not np.isfinite(A).all() or np.linalg.cond(A) > 1e12:
        return None
    Y = ca.DM(np.linalg.inv(A))
    moved = _largest(walk(Y @ f), space, point, point, f.shape).max()
    off = walk(ca.densify(ca.SX.eye(len(point)) - Y @ slope))
    for share in SHARES:
        reach = share * (1 + float(np.abs(point).max()))
        low, high = point - reach, point + reach
        contraction = ROUNDED * _largest(off, space, low, high, slope.shape).sum(axis=1).max()
        if contraction < 1 and (radius := ROUNDED * moved / (1 - contraction)) < reach:
            return Neighbourhood(low, high, float(radius))
    return None


def _largest(entries: Walk, space: Space, low: Array, high: Array, shape: tuple[int, int]) -> Array:
    """Bounds of the absolute values of entries over a box, in the shape of their matrix."""
    found = evaluate(entries, space.boxes(low[np.newaxis], high[np.newaxis]))
    return np.reshape([max(abs(e.low[0]), abs(e.high[0])) for e in found], shape, order="F")


def _swept(
    f: Walk, space: Space, low: Array, high: Array, around: Sequence[Neighbourhood], most: int
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
        entries = evaluate(f, space.boxes(a, b))
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
