"""The ledger's lines on section 4: (35), and what it concludes in (39) to (42) and Theorem 2."""

from collections.abc import Callable
from functools import cache

import numpy as np

from studies.a2_claims import arm, law, replay
from studies.a2_claims.checks import by_search, identity_finding, inequality, judges, numbers, refutation, row
from studies.a2_claims.law import ANY_WEIGHTS, PRINTED_WEIGHTS, WEIGHTS
from studies.a2_claims.searches import ABOVE, ASSUMPTION_4, CONSTANT_D, FLOOR, KEPT, V2_AT_START, on_path, regulation
from workbench.claims.counterexample import hypotheses_kept
from workbench.claims.verdicts import Finding
from workbench.core import Claim
from workbench.loop import ClosedLoop

estimate_rate = inequality(
    "(35)",
    "The estimates of (10) obey (35), M(q_hat) qd_hat' + C qd_hat + G + D = tau, where x1~ = 0.",
    "(10), (35)",
    "(10) has no D. At D = (1, 0) N m, all else zero, M times the acceleration of the estimate is {0} N m by (10), and "
    "{1} by (35).",
    D=(1, 0),
)


@judges("(39)", "V2' <= -lambda_min(K) |s| + |s| delta + 'bounded term'.", "(39)", arm.SKEW_PRINTED, law.gains.claim)
def decrease() -> Finding:
    return Finding(
        "not checkable as published",
        "With a 'bounded term' that is large enough any V2' obeys (39).",
        unstated="the 'bounded term'",
    )


@judges(
    "(40)",
    f"{ANY_WEIGHTS} V2' <= -c |s| with c = lambda_min(K) - delta > 0.",
    "(40)",
    ABOVE,
    decrease.claim,
    law.least_cost.claim,
)
def strict_decrease() -> Finding:
    rate, size, left = replay.v2_rate(1000, 1000)
    return refutation(
        rate > 0 and left > 0,
        "Where s = 0, (36) gives V2' = tr(P') / 2, and (40) asks for V2' <= 0 there. With Q = R = 1000 I, "
        "K(0) and P(0) of section 5, the arm and its estimate on the desired path of the first scenario, V2' is "
        f"{rate:.0f} W at t = 0, where |s| = {size:g} and lambda_min(K) - |D - D_hat| = {left:.3g} N m.",
        "v2_rate(1000, 1000)",
        kept=(ABOVE.name,),
    )


@cache
def kept_by(loop: Callable[[], ClosedLoop], h: float) -> tuple[str, ...]:
    """The hypotheses of Theorem 2 that a run of 20 s keeps at every step."""
    return hypotheses_kept(loop().ode(), KEPT, 20.0, h)


@judges(
    "(41), along (35)",
    f"{ANY_WEIGHTS} s and e1 tend to zero under every disturbance of Assumption 4 where the estimates obey (35).",
    "(35), (41)",
    ASSUMPTION_4,
    ABOVE,
    strict_decrease.claim,
)
def convergence_35() -> Finding:
    exact, ((e, e_change), (s, s_change)) = identity_finding("(41), along (35)"), replay.along_35().values()
    return refutation(
        exact.kind == "proved" and e > 2 * e_change,
        "Where s = 0 and e1 = 0, (35) gives M e2' = D_hat - D, whatever Q, R and K are (proved by normal form). So, "
        "with K bounded, s and e1 tend to zero only if D - D_hat does, and for a sine D it does not: not for (24) as "
        f"printed, and not for D_hat = eta, which lags. As printed but for C, with {PRINTED_WEIGHTS}, reading 'outer', "
        f"first scenario, started on the desired path: |e1| still reaches {e:.2e} rad and |s| {s:.2e} rad/s from 15 s "
        f"to 20 s (changed by {max(e_change, s_change):.0e} as the step is halved), small and not zero.",
        "along_35()",
        kept=kept_by(on_path, 1e-4),
    )


@judges(
    "(41), along (10)",
    f"{ANY_WEIGHTS} s and e1 tend to zero under every disturbance of Assumption 4 where the estimates obey (10).",
    "(10), (41)",
    ASSUMPTION_4,
    ABOVE,
    estimate_rate.claim,
    strict_decrease.claim,
)
def convergence_10() -> Finding:
    exact, (error, change) = identity_finding("(41), along (10)"), replay.offset()
    return refutation(
        exact.kind == "proved" and np.linalg.norm(error) > np.linalg.norm(change),
        "Let D and q_d be constant, D not zero, and all signals bounded, as Theorem 2 has them. If s and e1 tended to "
        "zero, the estimates and then the arm would come to rest at q_d, but there M times the accelerations of arm "
        "and estimate differ by D for any torque (proved, whatever Q and R are). "
        f"Repaired, with {WEIGHTS}, under D = {row(CONSTANT_D)} N m, q - q_d is {row(error)} rad after 20 s "
        f"(changed by {np.max(change):.0e} as the step is halved).",
        "offset()",
        kept=kept_by(regulation, 1e-3 / 12),
    )


finite_time = by_search(
    "finite_time",
    Claim(
        "(42)",
        f"{ANY_WEIGHTS} |s(t)| <= sigma from t = V2(0) / (c sigma) on, for every precision sigma; C is derived.",
        "(42)",
        (ASSUMPTION_4, ABOVE, strict_decrease.claim),
    ),
    f"(42) for all sigma at once is t |s(t)| <= V2(0) / c. As printed but for C, with {PRINTED_WEIGHTS}, reading "
    f"'outer', first scenario, V2(0) = {V2_AT_START:.3f} J and c >= {FLOOR:g} N m throughout, t |s(t)| exceeds it by "
    "{value:.3f} rad within 2 s (halving the step changes it by {error:.0e}). Worst of {sought}.",
)


@judges(
    "Theorem 2, bounded signals",
    f"{ANY_WEIGHTS} all signals of the loop stay bounded, as printed but for C, which is derived.",
    "Theorem 2",
    *arm.ASSUMPTIONS,
)
def bounded_signals() -> Finding:
    closed, run = replay.drift()
    return refutation(
        np.allclose(closed, run, rtol=1e-6) and bool((np.abs(run) > 2 * np.abs(CONSTANT_D)).all()),
        "D_hat is a signal of the loop, and (24) knows D alone. For a constant D, which Assumption 4 allows, its "
        "closed form D (t - (1 - exp(-l t)) / l) grows beyond all bounds, whatever Q, R, K and the reading "
        f"of (33) are. For D = {row(CONSTANT_D)} N m, D_hat is {row(run, 6)} N m s after 10 s. The theorem asks "
        "for Assumptions 1 to 4 alone; its proof chooses lambda_min(K) > delta, which such a D breaks in time.",
        "drift()",
        kept=replay.kept_by_drift(),
    )


bounded_velocities = by_search(
    "bounded",
    Claim(
        "Theorem 2, bounded velocities",
        "With the gain of its proof, lambda_min(K) > delta, |qd| and |qd_hat| stay below 1e6 rad/s; C is derived.",
        "Theorem 2, as read here",
        (*arm.ASSUMPTIONS, ABOVE),
    ),
    "As printed but for C, first scenario, reading 'outer', any start and disturbance of the assumptions: in {sought}, "
    "no velocity comes near 1e6 rad/s.",
    under=f"Q = 0.01 I, R = I, {numbers('l')}, 4 s",
)
CHECKS = (
    *(estimate_rate, decrease, strict_decrease, convergence_35, convergence_10),
    *(finite_time, bounded_signals, bounded_velocities),
)
