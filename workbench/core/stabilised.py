"""The stabilised Runge-Kutta-Chebyshev step: long steps through fast decay, without a Jacobian."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial

import casadi as ca
import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from workbench.core.ode import Ode
from workbench.core.step import Rule, Step, checked, rk4
from workbench.validation.refusals import Array, described, whole

DAMPING = 2 / 13
MOST_STAGES = 12  # beyond, the powers of z in R(z) cancel more digits than a stability limit may lose


def rkc(ode: Ode, h: float, stages: int) -> Step:
    """The second-order Runge-Kutta-Chebyshev step of length h [s] for `ode`, with s = `stages` evaluations of f.

        Y_1     = x + mu~_1 h f(t, x)
        Y_j     = (1 - mu_j - nu_j) x + mu_j Y_(j-1) + nu_j Y_(j-2)
                    + mu~_j h f(t + c_(j-1) h, Y_(j-1)) + gamma~_j h f(t, x),         j = 2, ..., s

    and x+ = Y_s. A real mode lambda decays while h lambda > -0.653 (s^2 - 1); one that oscillates
    without decay grows at any h, slowly.

    Raises
    ------
    ValueError
        If `ode` is no `Ode`, h is not a positive finite number, or `stages` is no whole number from 2 to 12.

    References
    ----------
    Sommeijer, Shampine and Verwer (1998), RKC: an explicit solver for parabolic PDEs, Journal of
    Computational and Applied Mathematics 88, section 2.
    """
    ode, h = checked("rkc", ode, h)
    why = "as the second order needs two, and rounding spoils the stability polynomial of more"
    stages = whole("rkc(stages=...)", stages, 2, MOST_STAGES, why=why)
    return replace(rk4(ode, h), rule=_rkc(ode, stages), amplification=amplification(stages))


@lru_cache(maxsize=64)
def _rkc(ode: Ode, stages: int) -> Rule:
    """The rule of the steps of any length for one equation."""
    rule = rk4(ode, 1.0).rule
    mu, nu, mu_f, gamma, c = coefficients(stages)
    f = ca.Function("f", [ode.t, ode.x, ode.p], [ode.rate])
    h, x, p = rule.h, rule.x, rule.p
    t = rule.k * h
    f0 = f(t, x, p)
    before, now = x, x + mu_f[1] * h * f0
    for j in range(2, stages + 1):
        pull = mu_f[j] * f(t + c[j - 1] * h, now, p) + gamma[j] * f0
        before, now = now, (1 - mu[j] - nu[j]) * x + mu[j] * now + nu[j] * before + h * pull
    return replace(rule, rate=ca.SX(0, 1), update=now)


def stepper(method: str) -> Callable[[Ode, float], Step]:
    """The maker of steps by a method's name: "rk4", or "rkc" and its number of stages, as in "rkc5".

    Raises
    ------
    LookupError
        If there is no such method.
    """
    if not isinstance(method, str):
        raise LookupError(f"A method goes by its name, which is text: 'rk4', or 'rkc5'; got {described(method)}.")
    if method == "rk4":
        return rk4
    stages = method.removeprefix("rkc")
    if stages in map(str, range(2, MOST_STAGES + 1)) and stages != method:
        return partial(rkc, stages=int(stages))
    raise LookupError(f"There is no method {described(method)}: it is 'rk4', or 'rkc2' to 'rkc{MOST_STAGES}'.")


def coefficients(stages: int) -> tuple[Array, Array, Array, Array, Array]:
    """mu, nu, mu~, gamma~ and the nodes c of the stages, each (s + 1,) with its entry j at place j."""
    w0 = 1 + DAMPING / stages**2
    T, dT, ddT = (np.array([Chebyshev.basis(j).deriv(order)(w0) for j in range(stages + 1)]) for order in (0, 1, 2))
    w1 = dT[stages] / ddT[stages]
    b = np.append(np.full(2, ddT[2] / dT[2] ** 2), ddT[2:] / dT[2:] ** 2)
    a = 1 - b * T
    mu, nu, mu_f, gamma, c = np.zeros((5, stages + 1))
    mu_f[1] = b[1] * w1
    mu[2:], nu[2:] = 2 * b[2:] * w0 / b[1:-1], -b[2:] / b[:-2]
    mu_f[2:] = 2 * b[2:] * w1 / b[1:-1]
    gamma[2:] = -a[1:-1] * mu_f[2:]
    c[1], c[2:] = mu_f[1], w1 * ddT[2:] / dT[2:]
    return mu, nu, mu_f, gamma, c


def amplification(stages: int) -> tuple[float, ...]:
    """R(z) of the step on x' = lambda x with z = h lambda, all coefficients, highest power first."""
    mu, nu, mu_f, gamma, _ = coefficients(stages)
    z = Polynomial([0, 1])
    before, now = Polynomial([1]), 1 + mu_f[1] * z
    for j in range(2, stages + 1):
        before, now = now, (1 - mu[j] - nu[j]) + mu[j] * now + nu[j] * before + mu_f[j] * z * now + gamma[j] * z
    return tuple(float(a) for a in now.coef[::-1])
