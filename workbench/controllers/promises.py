"""What the laws promise, as claims over the signals of a run: data that `verify` holds against runs."""

from __future__ import annotations

import math

import casadi as ca

from workbench.core.claim import Claim, Signals

ROUNDING = 1e-7  # of rates that are exact but for the last digits
SLACK = 1.01  # an inequality that is sharp on a boundary is asked for this far beyond it


def _exact(y: Signals) -> ca.SX:
    return ROUNDING - ca.fabs(ca.vertcat(y["q_error"], y["qd_error"]))


def _pulled_by_the_surface(y: Signals) -> ca.SX:
    """|e_i| |s_i| - Lambda_i e_i^2 - e_i e_i': >= 0, but for rounding, where e' = s - Lambda e."""
    e, s = y["e"], y["s"]
    return ca.fabs(e) * ca.fabs(s) - y["Lambda"] * e**2 - e * y["e'"] + ROUNDING


def _linear(y: Signals) -> ca.SX:
    return ROUNDING - ca.fabs(y["ed'"] + y["Kd"] * y["ed"] + y["Kp"] * y["e"])


def _moved_by_the_terminal_surface(y: Signals) -> ca.SX:
    power = ca.sign(y["e'"]) * ca.fabs(y["e'"]) ** y["gamma"]
    return ROUNDING - ca.fabs(power - y["beta"] * (y["surface"] - y["e"]))


def _leading_minors(X: ca.SX) -> ca.SX:
    """The leading principal minors (n, 1) of the symmetric part: all positive if and only if it is definite.

    X is (n, n), or its columns in one: a matrix that is no state but an output comes so.
    """
    n = math.isqrt(X.numel())
    X = ca.reshape(X, n, n)
    S = (X + X.T) / 2
    return ca.vertcat(*(ca.det(S[: k + 1, : k + 1]) for k in range(S.shape[0])))


EXACT_ESTIMATES = Claim(
    "exact estimates", "q_hat = q and qd_hat = qd at all times, to 1e-7 rad and rad/s.", "`FullState`", margin=_exact
)
SURFACE_PULLS_THE_ERROR = Claim(
    "the surface pulls the error",
    "e_i e_i' <= |e_i| |s_i| - Lambda_i e_i^2 + 1e-7 rad^2/s: within a layer |s_i| <= phi, |e_i| falls to "
    "phi / Lambda_i.",
    "Slotine and Li (1991), chapter 7",
    (EXACT_ESTIMATES,),
    _pulled_by_the_surface,
)
EXACT_DISTURBANCE = Claim(
    "the exact disturbance",
    "D_hat = D at all times, to 1e-9 N m.",
    "`OracleFilter`, or no disturbance",
    margin=lambda y: 1e-9 - ca.fabs(y["d_error"]),
)
ERROR_IS_LINEAR = Claim(
    "the error is linear",
    "With the right model e'' + Kd e' + Kp e = 0, to 1e-7 rad/s^2.",
    "Siciliano et al. (2009), section 8.5.2",
    (EXACT_ESTIMATES, EXACT_DISTURBANCE),
    _linear,
)
TERMINAL_SURFACE_MOVES_THE_ERROR = Claim(
    "the terminal surface moves the error",
    "|e_i'|^gamma sign(e_i') = beta_i (s_i - e_i), to 1e-7 in units of beta_i e_i: while |s_i| <= phi, |e_i| falls to "
    "phi in finite time.",
    "Feng, Yu and Man (2002)",
    (EXACT_ESTIMATES,),
    _moved_by_the_terminal_surface,
)
GAINS_STAY_POSITIVE = Claim(
    "no gain turns negative",
    "K_i >= 0 at all times, from K_i(0) >= 0.",
    "Plestan et al. (2010)",
    margin=lambda y: y["K"],
)
SWITCHED_RATE_IS_BOUNDED = Claim(
    "the integral part has a bounded rate",
    "|w_i'| <= 1.01 k2_i at all times, k2_i with a slack of 1 %, so that the torque is continuous.",
    "Levant (1993)",
    margin=lambda y: SLACK * y["k2"] - ca.fabs(y["w'"]),
)
K_STAYS_DEFINITE = Claim(
    "K stays positive definite",
    "The symmetric part of the gain K(t) is positive definite at all times, as (29) asks.",
    "(29), (33)",
    margin=lambda y: _leading_minors(y["K"]),
)
P_STAYS_DEFINITE = Claim(
    "P stays positive definite",
    "P(t) of (34) is positive definite at all times, from such a P(0).",
    "(34)",
    margin=lambda y: _leading_minors(y["P"]),
)
