"""Relays as a computer can run them: one backward Euler step of sign(s) over a period, solved for its torque."""

from __future__ import annotations

import casadi as ca

from workbench.core.dynamics import solve_definite

SWEEPS, GUESSES = 5, 4  # for three joints and more: enough for all of some thousand random matrices up to n = 7


def relay(s: ca.SX, M: ca.SX, K: ca.SX, period: float) -> ca.SX:
    """The torque v of a set-valued relay that acts on s for one period h, M s' = -v with v_i in K_i Sgn(s_i):

        s+ = s - h M^-1 v,        v_i in K_i Sgn(s_i+),        Sgn(0) = [-1, 1]

    There is one such v, the point of the box |v_i| <= K_i that is nearest to M s / h in the metric of M^-1.
    If M s / h is in the box it is that, and s+ = 0: what the relay does in sliding, without chattering.
    What moves s besides v in the period (C s, a disturbance, a wrong model) is left to the next period.

    For one joint and for two v has a closed form: the torque at which s_i+ = 0, within what the other
    joint can make of it, within the box. For more joints that is a start, which projected
    Gauss-Seidel brings near, and from which the saturated joints are guessed, by the rule of Newton's
    method, until the guess repeats. In sliding the start is exact already; elsewhere v is exact
    if `GUESSES` were enough, and in the box in any case.

    Parameters
    ----------
    s, M, K
        (n, 1) in rad/s, (n, n) symmetric and positive definite, (n, 1) in N m and not negative.
    period
        h, in s.

    References
    ----------
    Acary and Brogliato (2010), Implicit Euler numerical scheme and chattering-free implementation of
    sliding mode systems, Systems and Control Letters 59(5).
    Acary, Brogliato and Orlov (2012), Chattering-free digital sliding-mode control with state observer and
    disturbance rejection, IEEE Transactions on Automatic Control 57(5).
    Hintermueller, Ito and Kunisch (2003), The primal-dual active set strategy as a semismooth Newton
    method, SIAM Journal on Optimization 13(3).
    """
    n, K = s.numel(), ca.SX(K)
    A = period * solve_definite(M, ca.SX.eye(n))
    a = ca.diag(A)
    reach = ca.fabs(A) @ K - a * K  # how far all other joints together can move s_i
    v = clip(ca.fmin(ca.fmax(M @ s / period, (s - reach) / a), (s + reach) / a), K)
    if n > 2:
        for _ in range(SWEEPS):
            v = _swept(A, s, K, v)
        for _ in range(GUESSES):
            v = _guessed(A, s, K, v)
        v = _swept(A, s, K, v)  # which leaves a solution where it is, and anything else in the box
    return v


def _swept(A: ca.SX, s: ca.SX, K: ca.SX, v: ca.SX) -> ca.SX:
    """One sweep of projected Gauss-Seidel: joint by joint the exact v_i where all others are as they are."""
    v = ca.SX(v)
    for i in range(v.numel()):
        v[i] = clip(v[i] + (s[i] - A[i, :] @ v) / A[i, i], K[i])
    return v


def _guessed(A: ca.SX, s: ca.SX, K: ca.SX, v: ca.SX) -> ca.SX:
    """v with the joints saturated that v and s+ together suggest, and s_i+ = 0 at all others."""
    wanted = v + (s - A @ v) / ca.diag(A)
    free = ca.fabs(wanted) <= K
    fixed = ca.if_else(free, 0, ca.sign(wanted) * K)
    D, rest = ca.diag(free), ca.diag(1 - free)
    solution: ca.SX = solve_definite(D @ A @ D + rest, free * (s - A @ fixed) + fixed)
    return solution


def clip(x: ca.SX, limit: ca.SX) -> ca.SX:
    """x within -limit and limit, elementwise."""
    return ca.fmin(ca.fmax(x, -limit), limit)
