"""The quasi-Newton descent of a nonsmooth function, with a line search that asks for little."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.structured_tuning.nonsmooth_search import Descent, PieceValues

ARMIJO, WOLFE = 1e-4, 0.5
HALVINGS, SHORTEST = 30, 1e-13
WINDOW, STALLED = 40, 1e-6  # iterations, and the decrease over them, at which a search has settled


def quasi_newton(
    evaluate: Callable[[Array], PieceValues],
    start: Array,
    low: Array,
    high: Array,
    *,
    iterations: int,
    penalty: float,
) -> Descent:
    """A point near a local minimum of the merit, from a start at which the figures exist.

    The method of Broyden, Fletcher, Goldfarb and Shanno learns from the gradients of both sides of a kink how steep it
    is. Bounds are kept by x = (low + high) / 2 + (high - low) / 2 sin(v).

    References
    ----------
    Lewis and Overton (2013), Nonsmooth optimization via quasi-Newton methods, Mathematical Programming 141.
    """
    curve = _Curve.of(low, high)
    v, values = curve.inside(start), evaluate(start)
    merit, gradient = values.merit(penalty), curve.slope(curve.inside(start)) * _gradient(values, penalty)
    H, evaluations, merits = np.eye(len(v)), 1, [merit]
    for k in range(1, iterations + 1):
        step = -H @ gradient
        if k == 1:
            step /= max(1.0, float(np.linalg.norm(step)))
        slope = float(gradient @ step)
        if not slope < 0:
            break
        found, tried = _line_search(evaluate, curve, v, step, (merit, slope), penalty)
        evaluations += tried
        if found is None:
            break
        length, values, merit, new = found
        H = _updated(H, length * step, new - gradient, k == 1)
        v, gradient = v + length * step, new
        merits.append(merit)
        if len(merits) > WINDOW and merits[-WINDOW] - merit < STALLED:
            break
    return Descent(curve.point(v), values, evaluations)


def _line_search(
    evaluate: Callable[[Array], PieceValues],
    curve: _Curve,
    v: Array,
    step: Array,
    line: tuple[float, float],
    penalty: float,
) -> tuple[tuple[float, PieceValues, float, Array] | None, int]:
    """The length of a step that brings enough, with the values, merit and gradient there, and the points tried."""
    (merit, slope), length, short, long, found, tried = line, 1.0, 0.0, np.inf, None, 0
    while tried < HALVINGS:
        tried += 1
        w = v + length * step
        trial = evaluate(curve.point(w))
        height = trial.merit(penalty)
        if not height < merit + ARMIJO * length * slope:
            long = length
        else:
            gradient = curve.slope(w) * _gradient(trial, penalty)
            found = (length, trial, height, gradient)
            if float(gradient @ step) >= WOLFE * slope:
                break
            short = length
        length = (short + long) / 2 if long < np.inf else 2 * short
        if length * float(np.abs(step).max()) < SHORTEST * (1 + float(np.abs(v).max())):
            break
    return found, tried


def _gradient(values: PieceValues, penalty: float) -> Array:
    """The gradient of the piece with the largest value, and of the limit that is broken by most."""
    gradient = max(values.soft, key=lambda one: one.value).gradient if values.soft else 0.0
    if values.violation > 0:
        gradient = gradient + penalty * max(values.hard, key=lambda one: one.value).gradient
    elif not values.soft:
        gradient = 0.0 * values.hard[0].gradient
    return np.asarray(gradient)


def _updated(H: Array, step: Array, change: Array, first: bool) -> Array:
    product = float(step @ change)
    if not product > 0:
        return H
    if first:
        H = H * product / float(change @ change)
    V = np.eye(len(step)) - np.outer(step, change) / product
    new = V @ H @ V.T + np.outer(step, step) / product
    return np.asarray(new if np.isfinite(new).all() else H)


class _Curve:
    """The curve by which numbers without bounds become numbers within them; those without bounds stay."""

    def __init__(self, middle: Array, half: Array) -> None:
        self.middle, self.half, self.bounded = middle, half, np.isfinite(half)

    @staticmethod
    def of(low: Array, high: Array) -> _Curve:
        with np.errstate(invalid="ignore"):
            middle, half = (low + high) / 2, (high - low) / 2
        half = np.where(np.isfinite(low) & np.isfinite(high), half, np.inf)
        return _Curve(np.where(np.isfinite(half), middle, 0.0), half)

    def inside(self, x: Array) -> Array:
        share = np.clip((x - self.middle) / np.where(self.bounded, self.half, 1.0), -0.99, 0.99)
        return np.where(self.bounded, np.arcsin(np.where(self.bounded, share, 0.0)), x)

    def point(self, v: Array) -> Array:
        half = np.where(self.bounded, self.half, 0.0)
        return np.where(self.bounded, self.middle + half * np.sin(v), v)

    def slope(self, v: Array) -> Array:
        half = np.where(self.bounded, self.half, 0.0)
        return np.where(self.bounded, half * np.cos(v), 1.0)
