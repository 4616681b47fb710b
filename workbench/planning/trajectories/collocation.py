"""Radau collocation and Runge-Kutta shooting of one interval, as CasADi functions of scaled values."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

from workbench.core.validation.refusals import Array
from workbench.planning.trajectories.plan_problem import PhaseProblem, Scales

STAGES = 3  # of Radau IIA: order 5
Answer = tuple[ca.SX, ca.SX, list[tuple[float, ca.SX]]]  # defects, cost, and states by their share of the interval
SUBSTEPS = 6  # of classical Runge-Kutta in an interval of shooting


def radau_points() -> Array:
    """The points (d,) of Radau IIA in (0, 1], the last of them 1."""
    return np.array(ca.collocation_points(STAGES, "radau"))


def radau_matrices() -> tuple[Array, Array]:
    """The matrix C (d + 1, d), by which values at 0 and the points have their slopes there, and the weights (d,)."""
    C, _, B = ca.collocation_coeff(list(radau_points()))
    return np.array(C), np.array(B).ravel()


def interval_function(phase: PhaseProblem, scales: Scales, method: str) -> ca.Function:
    """The defects, cost and limited signals of an interval.

    It maps (t0, h, z0, zc, z1, va, vb), scaled states at the begin, inside and the end and scaled inputs at the begin
    and the end, to the defects (scaled), the integral of the cost, and the signals at the begin and at each point.
    """
    nx, nu = len(scales.x), len(scales.u)
    inner = nx * (STAGES - 1) if method == "collocation" else 0
    t0, h = ca.SX.sym("t0"), ca.SX.sym("h")
    z0, zc, z1 = ca.SX.sym("z0", nx), ca.SX.sym("zc", inner), ca.SX.sym("z1", nx)
    va, vb = ca.SX.sym("va", nu), ca.SX.sym("vb", nu)
    sx, su = ca.DM(scales.x), ca.DM(scales.u)

    def input_at(share: float) -> ca.SX:
        return su * (va + share * (vb - va))

    if method == "collocation":
        defects, cost, points = _collocate(phase, sx, t0, h, z0, ca.vertcat(zc, z1), input_at)
    else:
        defects, cost, points = _shoot(phase, sx, t0, h, z0, z1, input_at)
    begin = phase.path(t0, sx * z0, input_at(0.0))
    signals = [phase.path(t0 + share * h, x, input_at(share)) for share, x in points]
    arguments = [t0, h, z0, zc, z1, va, vb]
    return ca.Function("interval", arguments, [defects, cost, begin, ca.vertcat(*signals)])


def _collocate(
    phase: PhaseProblem, sx: ca.DM, t0: ca.SX, h: ca.SX, z0: ca.SX, inner: ca.SX, input_at: Callable[[float], ca.SX]
) -> Answer:
    """Radau IIA: the slope of the polynomial through all values is the rate at each point."""
    shares, (C, weights) = radau_points(), radau_matrices()
    nx = z0.numel()
    Z = ca.horzcat(z0, ca.reshape(inner, nx, STAGES))
    slopes, defects, cost, points = Z @ ca.DM(C), [], ca.SX(0), []
    for j, share in enumerate(shares):
        x = sx * Z[:, j + 1]
        rate, cost_rate = phase.rate(t0 + share * h, x, input_at(float(share)))
        defects.append(slopes[:, j] - h * rate / sx)
        cost += h * weights[j] * cost_rate
        points.append((float(share), x))
    return ca.vertcat(*defects), cost, points


def _shoot(
    phase: PhaseProblem, sx: ca.DM, t0: ca.SX, h: ca.SX, z0: ca.SX, z1: ca.SX, input_at: Callable[[float], ca.SX]
) -> Answer:
    """Classical Runge-Kutta steps from the begin, which must end at the next node."""
    x, cost, d = sx * z0, ca.SX(0), h / SUBSTEPS

    def rate(place: float, x: ca.SX) -> tuple[ca.SX, ca.SX]:
        slope, cost_rate = phase.rate(t0 + place * d, x, input_at(place / SUBSTEPS))
        return slope, cost_rate

    for i in range(SUBSTEPS):
        k1, q1 = rate(i, x)
        k2, q2 = rate(i + 0.5, x + d / 2 * k1)
        k3, q3 = rate(i + 0.5, x + d / 2 * k2)
        k4, q4 = rate(i + 1, x + d * k3)
        x = x + d / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        cost += d / 6 * (q1 + 2 * q2 + 2 * q3 + q4)
    return z1 - x / sx, cost, [(1.0, sx * z1)]
