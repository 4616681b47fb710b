"""A fit of an arm with friction by SciPy alone, as one who knows it writes it: LSODA, and differences of whole runs.

The right-hand side is in scalars of Python, which here is faster than small arrays. The torques are interpolated along
straight lines, and a run is one call: the torques are smooth, so that no restart at a sample is worth its cost.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin, tanh
from typing import Literal, NamedTuple

import numpy as np

import workbench as wb

LENGTH, GRAVITY = 0.5, 9.81  # of the first link in m; in m/s^2
DIFFERENCE = 1e-3  # of a parameter, relative: the best of 1e-4, 1e-3 and 1e-2
Differences = Literal["2-point", "3-point"]
Rate = Callable[[float, wb.Array], tuple[float, ...]]


class ScipyEnd(NamedTuple):
    """The estimates of a search, and the runs that it took."""

    theta: wb.Array
    runs: int


def arm_rate(theta: wb.Array, t: wb.Array, u: wb.Array) -> Rate:
    """(t, x) to x' (4,) for base parameters (10,) and torques u (N, 2) at even times t (N,)."""
    J1, J2, s1, s2, b1, b2, f1, f2, w1, w2 = theta.tolist()
    first, second, per_s, last = u[:, 0].tolist(), u[:, 1].tolist(), 1 / float(t[1] - t[0]), len(t) - 2

    def rate(now: float, x: wb.Array) -> tuple[float, ...]:
        q1, q2, v1, v2 = x.tolist()
        place = now * per_s
        k = min(int(place), last)
        share = place - k
        c, s = LENGTH * s2 * cos(q2), LENGTH * s2 * sin(q2)
        M11, M12, low = J1 + J2 + 2 * c, J2 + c, GRAVITY * s2 * sin(q1 + q2)
        r1 = first[k] + share * (first[k + 1] - first[k]) + s * (2 * v1 * v2 + v2 * v2)
        r1 -= GRAVITY * s1 * sin(q1) + low + b1 * v1 + f1 * tanh(v1 / w1)
        r2 = second[k] + share * (second[k + 1] - second[k]) - s * v1 * v1 - low - b2 * v2 - f2 * tanh(v2 / w2)
        det = M11 * J2 - M12 * M12
        return v1, v2, (J2 * r1 - M12 * r2) / det, (M11 * r2 - M12 * r1) / det

    return rate


def run_arm(theta: wb.Array, t: wb.Array, u: wb.Array, tolerance: float) -> wb.Array:
    """The angles (N, 2) of the arm from rest at q = 0, at times t (N,)."""
    from scipy.integrate import solve_ivp

    rate, span = arm_rate(theta, t, u), (float(t[0]), float(t[-1]))
    run = solve_ivp(rate, span, np.zeros(4), "LSODA", t_eval=t, rtol=tolerance, atol=tolerance)
    return np.asarray(run.y[:2].T)


def scipy_estimate(
    t: wb.Array, u: wb.Array, q: wb.Array, start: wb.Array, tolerance: float, differences: Differences
) -> ScipyEnd:
    """The least squares of the errors of the angles q (N, 2) from a start (10,), with all parameters positive."""
    from scipy.optimize import least_squares

    runs = 0

    def errors(theta: wb.Array) -> wb.Array:
        nonlocal runs
        runs += 1
        return (run_arm(theta, t, u, tolerance) - q).ravel()

    relative = np.full(start.shape, DIFFERENCE)
    end = least_squares(errors, start, differences, bounds=(0.0, np.inf), x_scale="jac", diff_step=relative, ftol=1e-10)
    return ScipyEnd(np.asarray(end.x), runs)
