"""What the observers promise, as claims over the signals of a run: data that `verify` holds against runs."""

from __future__ import annotations

from collections.abc import Mapping

import casadi as ca

from workbench.core.claim import Claim

Signals = Mapping[str, ca.SX]

ROUNDING = 1e-9  # of an estimate that is exact but for the last digits
SLACK = 1.01  # an inequality that is sharp on a boundary is asked for this far beyond it


def _true_state(y: Signals) -> ca.SX:
    return ROUNDING - ca.fabs(ca.vertcat(y["q_error"], y["qd_error"]))


def _follows(y: Signals) -> ca.SX:
    """-E_i E_i' where |E_i| is beyond |D_i'| / l: >= 0 if |E_i| falls there."""
    E = y["d_error"]
    beyond = ca.fabs(E) > SLACK * ca.fabs(y["d'"]) / y["l"] + ROUNDING
    return ca.if_else(beyond, -E * y["d_error'"], 0)


def _dissipates(y: Signals) -> ca.SX:
    """E^T (D' - E') = l E^T M^-1 E: >= 0, but for rounding."""
    E = y["d_error"]
    return ca.dot(E, y["d'"] - y["d_error'"]) + ROUNDING


TRUE_STATE = Claim("the true state", "q_hat = q and qd_hat = qd at all times.", "`FullState`", margin=_true_state)
PRINTED_FOLLOWS = Claim(
    "D_hat follows D",
    "|D_i - D_hat_i| falls wherever it is larger than |D_i'| / l, so that D_hat -> D where D settles.",
    "(24)",
    margin=_follows,
)
ORACLE_FOLLOWS = Claim(
    "D_hat = eta follows D",
    "|D_i - D_hat_i| falls wherever it is larger than |D_i'| / l.",
    "(24), repaired",
    margin=_follows,
)
MOMENTUM_FOLLOWS = Claim(
    "the momentum observer follows D",
    "With the right model, |D_i - D_hat_i| falls wherever it is larger than |D_i'| / l.",
    "De Luca and Mattone (2003)",
    (TRUE_STATE,),
    _follows,
)
CHEN_DISSIPATES = Claim(
    "the nonlinear disturbance observer dissipates",
    "With the right model, E = D - D_hat has E^T E' <= E^T D' at all times.",
    "Mohammadi et al. (2013), section 3",
    (TRUE_STATE,),
    _dissipates,
)
ANY_DEFINITE_GAINS = Claim(
    "gains of Theorem 1", "L1 and L2 are symmetric and positive definite, and nothing more.", "Theorem 1"
)
THEOREM_1 = Claim(
    "Theorem 1",
    "From every initial estimate the errors of the observer (10) tend to zero, exponentially.",
    "Theorem 1, (23)",
    (ANY_DEFINITE_GAINS,),
)
