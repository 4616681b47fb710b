"""What the observers promise, as claims over the signals of a run: data that `verify` holds against runs."""

from __future__ import annotations

import casadi as ca

from workbench.core.claim import Claim, Signals

ROUNDING = 1e-7  # of rates that are exact but for the last digits


def _true_state(y: Signals) -> ca.SX:
    return ROUNDING - ca.fabs(ca.vertcat(y["q_error"], y["qd_error"]))


def _follows(y: Signals) -> ca.SX:
    """|E_i| |D_i'| - l E_i^2 - E_i E_i': >= 0, but for rounding, where E' = D' - l E."""
    E = y["d_error"]
    return ca.fabs(E) * ca.fabs(y["d'"]) - y["l"] * E**2 - E * y["d_error'"] + ROUNDING


def _filtered(y: Signals) -> ca.SX:
    """|E_i| |qdd_i| - omega E_i^2 - E_i E_i': >= 0, but for rounding, where E' = qdd - omega E."""
    E = y["qd_error"]
    return ca.fabs(E) * ca.fabs(y["qd'"]) - y["omega"] * E**2 - E * y["qd_error'"] + ROUNDING


def _dissipates(y: Signals) -> ca.SX:
    """E^T (D' - E') = l E^T M^-1 E: >= 0, but for rounding."""
    E = y["d_error"]
    return ca.dot(E, y["d'"] - y["d_error'"]) + ROUNDING


TRUE_STATE = Claim(
    "the true state",
    "q_hat = q and qd_hat = qd at all times, to 1e-7 rad and rad/s.",
    "`FullState`",
    margin=_true_state,
)
FILTER_FOLLOWS = Claim(
    "the filter follows qd",
    "E = qd - qd_hat has E_i E_i' <= |E_i| |qdd_i| - omega E_i^2 + 1e-7 rad^2/s^3: |E_i| falls to |qdd_i| / omega.",
    "the equation of a low-pass filter of first order",
    margin=_filtered,
)
PRINTED_FOLLOWS = Claim(
    "D_hat follows D",
    "E = D - D_hat has E_i E_i' <= |E_i| |D_i'| - l E_i^2 + 1e-7 N^2 m^2/s, so that D_hat -> D where D settles.",
    "(24)",
    margin=_follows,
)
ORACLE_FOLLOWS = Claim(
    "D_hat = eta follows D",
    "E = D - D_hat has E_i E_i' <= |E_i| |D_i'| - l E_i^2 + 1e-7 N^2 m^2/s: |E_i| falls to |D_i'| / l.",
    "(24), repaired",
    margin=_follows,
)
MOMENTUM_FOLLOWS = Claim(
    "the momentum observer follows D",
    "With the right model, E = D - D_hat has E_i E_i' <= |E_i| |D_i'| - l E_i^2 + 1e-7 N^2 m^2/s.",
    "De Luca and Mattone (2003)",
    (TRUE_STATE,),
    _follows,
)
CHEN_DISSIPATES = Claim(
    "the nonlinear disturbance observer dissipates",
    "With the right model, E = D - D_hat has E^T E' <= E^T D' + 1e-7 N^2 m^2/s at all times.",
    "Mohammadi et al. (2013)",
    (TRUE_STATE,),
    _dissipates,
)
ANY_DEFINITE_GAINS = Claim(
    "gains of Theorem 1", "L1 and L2 are symmetric and positive definite, and nothing more.", "Theorem 1"
)
THEOREM_1 = Claim(
    "Theorem 1",
    "Whatever positive definite L1, L2, zero is a globally exponentially stable error of the observer (10).",
    "Theorem 1, (23)",
    (ANY_DEFINITE_GAINS,),
)
