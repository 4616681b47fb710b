"""The descent of a nonsmooth function by a bundle of its smooth pieces, with a model of their curvature."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.structured_tuning.figure_pieces import FigurePiece
from workbench.design.structured_tuning.quadratic_program import BundleStep, bundle_step

ENOUGH = 1e-4  # share of the promised decrease that a step must bring
SHORTEST = 1e-9  # relative, of a step
NULL_STEPS = 12  # steps without progress, after which a search ends
FLAT = 1e-9  # a promised decrease that is none
STALLED = 1e-8  # a decrease over a window of iterations that is none
WINDOW = 12
WIDEST = 1e6  # radius of a step
TRIALS = 6  # points on the line of a step
MOST_EXTRA = 40  # pieces of other points
SLIGHT = 1e-8  # a multiplier that counts for nothing
CURVED = 0.5  # by how much a piece of another point is lowered, per squared distance
ACTIVE = 1e-5  # below the largest value, at which a piece counts as active
AT_BOUND = 1e-7  # of a range, up to which a number is at its bound


@dataclass(frozen=True, eq=False)
class PieceValues:
    """The pieces at a point: soft ones, whose largest value is made small, and hard ones, which must not be positive.

    `exists` is False where the figures do not exist, as of an unstable loop; the merit is infinite there.
    """

    soft: tuple[FigurePiece, ...] = ()
    hard: tuple[FigurePiece, ...] = ()
    exists: bool = True

    @property
    def objective(self) -> float:
        """The largest value of a soft piece."""
        return max((one.value for one in self.soft), default=0.0) if self.exists else math.inf

    @property
    def violation(self) -> float:
        """The largest value of a hard piece; negative if all limits hold."""
        return max((one.value for one in self.hard), default=-math.inf) if self.exists else math.inf

    def merit(self, penalty: float) -> float:
        """The objective with the penalty of its violation."""
        return self.objective + penalty * max(0.0, self.violation) if self.exists else math.inf


Evaluate = Callable[[Array], PieceValues]


@dataclass(frozen=True, eq=False)
class Descent:
    """The end of a search: the point (nd,), its pieces, and how many points were tried."""

    x: Array
    values: PieceValues
    evaluations: int


@dataclass(frozen=True, eq=False)
class _Walk:
    """A point of a descent, its pieces, the curvature and radius of its model, and the pieces of points nearby."""

    x: Array
    values: PieceValues
    H: Array
    radius: float
    penalty: float
    evaluations: int = 1
    extra: PieceValues = PieceValues()
    nulls: int = 0
    fresh: bool = False  # True if the curvature was begun anew, and brought nothing since

    @property
    def merit(self) -> float:
        return self.values.merit(self.penalty)

    def refresh(self) -> _Walk:
        """The curvature begun anew, as a matrix that has gone wrong looks like a minimum."""
        radius = 0.1 * (1 + float(np.abs(self.x).max()))
        return replace(self, fresh=True, nulls=0, radius=radius, H=_first_curvature(self.values, radius, len(self.x)))


def descend(
    evaluate: Evaluate,
    start: Array,
    low: Array,
    high: Array,
    *,
    iterations: int,
    penalty: float = 10.0,
    enough: Callable[[PieceValues], bool] = lambda values: False,
    radius: float = 1.0,
) -> Descent:
    """A local minimum of the merit, from a start at which the figures exist.

    Each iteration solves a quadratic program over the pieces at the point, and over those of trial points that
    disappointed. The quasi-Newton matrix H is that of the pieces weighted by their multipliers.

    References
    ----------
    Apkarian and Noll (2006), Nonsmooth H-infinity synthesis, IEEE Trans. Autom. Control 51. Kiwiel (1985), Methods of
    descent for nondifferentiable optimization.
    """
    values = evaluate(start)
    walk = _Walk(start, values, _first_curvature(values, radius, len(start)), radius, penalty)
    merits = [walk.merit]
    for _ in range(iterations):
        if enough(walk.values) or not walk.values.exists:
            break
        step = _step(walk, low, high)
        if step.decrease <= FLAT * max(1.0, abs(merits[-1])):
            limited = np.abs(step.step).max() >= 0.99 * walk.radius
            if not limited or walk.radius > WIDEST:
                break
            walk = replace(walk, radius=10 * walk.radius)
            continue
        walk = _line_search(evaluate, walk, step)
        merits.append(walk.merit)
        settled = len(merits) > WINDOW and merits[-WINDOW] - merits[-1] <= STALLED * max(1.0, abs(merits[-1]))
        if settled or walk.nulls > NULL_STEPS:
            if walk.fresh:
                break
            walk, merits = walk.refresh(), merits[-1:]
    return Descent(walk.x, walk.values, walk.evaluations)


def _first_curvature(values: PieceValues, radius: float, d: int) -> Array:
    gradients = [float(np.linalg.norm(one.gradient)) for one in (*values.soft, *values.hard)]
    return np.asarray((max(gradients, default=1.0) / radius or 1.0) * np.eye(d))


def _step(walk: _Walk, low: Array, high: Array) -> BundleStep:
    near, far = np.maximum(low - walk.x, -walk.radius), np.minimum(high - walk.x, walk.radius)
    soft, hard = (*walk.values.soft, *walk.extra.soft), (*walk.values.hard, *walk.extra.hard)
    return bundle_step(soft, hard, walk.penalty, walk.H, near, far)


def _line_search(evaluate: Evaluate, walk: _Walk, step: BundleStep) -> _Walk:
    """The walk at a point that is better by enough; else where it was, with the pieces of the points tried."""
    length, size = 1.0, float(np.abs(step.step).max())
    tried: list[tuple[Array, PieceValues]] = []
    while length * size > SHORTEST * (1 + float(np.abs(walk.x).max())) and len(tried) < TRIALS:
        y = walk.x + length * step.step
        values = evaluate(y)
        walk = replace(walk, evaluations=walk.evaluations + 1)
        if values.merit(walk.penalty) <= walk.merit - ENOUGH * length * step.decrease:
            return _moved(walk, y, values, step, length)
        tried.append((y, values))
        length *= 0.4 if values.exists else 0.25
    soft, hard = walk.extra.soft, walk.extra.hard
    for y, values in tried[:4]:
        if values.exists:
            soft = (*soft, *_lowered(values.soft, y, walk.x, walk.values.objective))[-MOST_EXTRA:]
            hard = (*hard, *_lowered(values.hard, y, walk.x, max(0.0, walk.values.violation)))[-MOST_EXTRA:]
    return replace(walk, nulls=walk.nulls + 1, radius=max(0.25 * size, 1e-12), extra=PieceValues(soft, hard))


def _lowered(pieces: Sequence[FigurePiece], y: Array, x: Array, top: float) -> list[FigurePiece]:
    """The pieces of another point as linear functions at x, none of them above the value there."""
    gap = x - y
    curve = CURVED * float(gap @ gap)
    return [
        replace(one, value=min(one.value + float(one.gradient @ gap), top - curve), place=math.nan) for one in pieces
    ]


def _moved(walk: _Walk, y: Array, values: PieceValues, step: BundleStep, length: float) -> _Walk:
    """The walk at a better point, with the radius and curvature that the step has taught."""
    size, gain = float(np.abs(y - walk.x).max()), walk.merit - values.merit(walk.penalty)
    radius = max(walk.radius, 2.5 * size) if length == 1.0 else max(2 * size, 0.3 * walk.radius)
    return replace(
        walk,
        x=y,
        values=values,
        H=_curvature(walk, y, values, step),
        radius=radius,
        extra=PieceValues(),
        nulls=0,
        fresh=walk.fresh and gain <= STALLED * WINDOW * max(1.0, abs(walk.merit)),
    )


def _curvature(walk: _Walk, y: Array, values: PieceValues, step: BundleStep) -> Array:
    """The damped update of Broyden, Fletcher, Goldfarb and Shanno, with the pieces weighted by their multipliers."""
    change, weights = np.zeros(len(y)), 0.0
    for old, new, multipliers in (
        (walk.values.soft, values.soft, step.soft),
        (walk.values.hard, values.hard, step.hard),
    ):
        for piece, weight in zip(old, multipliers, strict=False):  # behind them are those of other points
            partner = next((one for one in new if piece.same_as(one)), None)
            if weight > SLIGHT and partner is not None:
                change += weight * (partner.gradient - piece.gradient)
                weights += weight
    s = y - walk.x
    Hs = walk.H @ s
    curve, own = float(s @ Hs), float(s @ change)
    if weights < 0.5 or curve <= 0:
        return walk.H
    share = 1.0 if own >= 0.2 * curve else 0.8 * curve / (curve - own)
    blend = share * change + (1 - share) * Hs
    H = walk.H - np.outer(Hs, Hs) / curve + np.outer(blend, blend) / float(s @ blend)
    return np.asarray((H + H.T) / 2 if np.isfinite(H).all() else walk.H)


def stationarity(
    values: PieceValues, x: Array, low: Array, high: Array, penalty: float, width: float = ACTIVE
) -> float:
    """The norm of the smallest convex combination of the active gradients, where bounds of x take what they can."""
    d = len(x)
    soft = [one for one in values.soft if one.value >= values.objective - width]
    hard = [one for one in values.hard if one.value >= max(0.0, values.violation) - width]
    level = [replace(one, value=0.0) for one in soft], [replace(one, value=0.0) for one in hard]
    edge = np.where(np.isfinite(high - low), AT_BOUND * (high - low), 0.0)
    near, far = np.where(x <= low + edge, 0.0, -1e6), np.where(x >= high - edge, 0.0, 1e6)
    step = bundle_step(*level, penalty, np.eye(d), near, far)
    return float(np.linalg.norm(step.step))
