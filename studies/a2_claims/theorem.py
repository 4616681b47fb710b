"""The ledger's lines on section 4: (35), and what it concludes in (39) to (42) and Theorem 2."""

import numpy as np

from studies.a2_claims import statements as paper
from studies.a2_claims.checks import Check, identity, listed, numbers, searched, sought, unequal
from studies.a2_claims.law import PRINTED_WEIGHTS, WEIGHTS
from studies.a2_claims.loops import CONSTANT_D, on_path, regulation
from studies.a2_claims.lyapunov import FLOOR, V2_AT_START
from studies.a2_claims.replay import along_35, drift, kept_by_drift, offset, v2_rate
from workbench.claims.counterexample import hypotheses_kept
from workbench.claims.falsify import Found
from workbench.claims.verdicts import Finding
from workbench.core import Claim
from workbench.core.claim import Declared

KEPT = (Declared(paper.ASSUMPTION_4), Declared(paper.ABOVE))


def unstated() -> Finding:
    """(39)."""
    return Finding(
        "not checkable as published",
        "With a 'bounded term' that is large enough any V2' obeys (39). The terms that the proof collects in it hold "
        "tr(Q), which does not tend to zero.",
        unstated="the 'bounded term'",
    )


def no_decrease() -> Finding:
    """(40) where s = 0."""
    rate, size, left = v2_rate(1000, 1000)
    if rate <= 0 or left <= 0:
        return Finding("not refuted", f"V2' is {rate:.4g} W where lambda_min(K) - delta is {left:.4g} N m", samples=1)
    return Finding(
        "refuted",
        "Where s = 0, (36) gives V2' = tr(P') / 2, and (40) asks for V2' <= 0 there. With Q = R = 1000 I, "
        "K(0) and P(0) of section 5, the arm and its estimate on the desired path of the first scenario, V2' is "
        f"{rate:.0f} W at t = 0, where |s| = {size:g} and lambda_min(K) - |D - D_hat| = {left:.3g} N m: (40) leaves "
        "out tr(Q). The estimates are exact there, so (10) and (35) give the same s.",
        "v2_rate(1000, 1000)",
        kept=(paper.ABOVE.name,),
    )


def unsettled() -> Finding:
    """(41) where the estimates obey (35)."""
    exact, found = identity("(41), along (35)")(), along_35()
    (e, e_change), (s, s_change) = found["late error"], found["late s"]
    if exact.kind != "proved" or e <= 2 * e_change:
        return Finding("not refuted", f"|e1| is {e:.3g} rad after 15 s, {exact.evidence}", samples=1)
    return Finding(
        "refuted",
        "Where s = 0 and e1 = 0, (35) gives M e2' = D_hat - D, whatever Q, R and K are (proved by normal form). So, "
        "with K bounded, s and e1 tend to zero only if D - D_hat does, and for a sine D it does not: not for (24) as "
        f"printed, and not for D_hat = eta, which lags. As printed but for C, with {PRINTED_WEIGHTS}, reading 'outer', "
        f"first scenario, started on the desired path: |e1| still reaches {e:.2e} rad and |s| {s:.2e} rad/s from 15 s "
        f"to 20 s (changed by {max(e_change, s_change):.0e} as the step is halved). It is the residual of a boundary "
        "layer, small and not zero. (42), for every sigma, falls with it.",
        "along_35()",
        kept=hypotheses_kept(on_path().ode(), KEPT, 20.0, 1e-4),
    )


def convergence() -> Finding:
    """(41) under a constant disturbance, where the estimates obey (10)."""
    exact = identity("(41), along (10)")()
    if exact.kind != "proved":
        return exact
    error, change = offset()
    if np.linalg.norm(error) <= np.linalg.norm(change):
        return Finding("not refuted", f"q - q_d is {listed(error)} rad after 20 s, no more than its error", samples=1)
    return Finding(
        "refuted",
        "Let D and q_d be constant, D not zero, and all signals bounded, as Theorem 2 has them. If s and e1 tended to "
        "zero, the estimates and then the arm would come to rest at q_d, but there M times the accelerations of arm "
        "and estimate differ by D for any torque (proved, whatever Q and R are). "
        f"Repaired, with {WEIGHTS}, under D = {listed(CONSTANT_D)} N m, q - q_d is {listed(error)} rad after 20 s "
        f"(changed by {np.max(change):.0e} as the step is halved).",
        "offset()",
        kept=hypotheses_kept(regulation().ode(), KEPT, 20.0, 1e-3 / 12),
    )


def finite_time(found: Found) -> str:
    """(42) along the law as printed but for C."""
    worst = found.worst
    assert worst is not None
    return (
        f"(42) for all sigma at once is t |s(t)| <= V2(0) / c. As printed but for C, with {PRINTED_WEIGHTS}, reading "
        f"'outer', first scenario, V2(0) = {V2_AT_START:.3f} J and c >= {FLOOR:g} N m throughout, t |s(t)| exceeds it "
        f"by {worst.value:.3f} rad within {worst.until:g} s (halving the step changes it by {worst.error:.0e}). Worst "
        f"of {sought('finite_time')}."
    )


def unbounded() -> Finding:
    """D_hat of (24) under a constant disturbance."""
    closed, run = drift()
    if not np.allclose(closed, run, rtol=1e-6) or (np.abs(run) < 2 * np.abs(CONSTANT_D)).any():
        return Finding("not refuted", f"D_hat is {listed(run)} after 10 s, not far beyond D", samples=1)
    return Finding(
        "refuted",
        "D_hat is a signal of the loop, and (24) knows D alone. For a constant D, which Assumption 4 allows, its "
        "closed form D (t - (1 - exp(-l t)) / l) grows beyond all bounds, whatever Q, R, K and the reading "
        f"of (33) are. For D = {listed(CONSTANT_D)} N m, D_hat is {listed(run, 6)} N m s after 10 s. The theorem asks "
        "for Assumptions 1 to 4 alone. Its proof chooses lambda_min(K) > delta, which such a D breaks in time: what "
        "holds with it is the line 'Theorem 2, bounded velocities'.",
        "drift()",
        kept=kept_by_drift(),
    )


def slow(found: Found) -> str:
    """Velocities under the gain of the proof."""
    assert found.worst is not None
    return (
        "As printed but for C, first scenario, reading 'outer', any start and disturbance of the assumptions: "
        f"in {sought('bounded')}, no velocity comes near 1e6 rad/s. Other weights, a longer horizon or another "
        "reading may give another answer."
    )


CHECKS: tuple[tuple[Claim, Check], ...] = (
    (
        paper.REWRITTEN,
        unequal(
            "(35)",
            "(10) has no D. At D = (1, 0) N m, all else zero, M times the acceleration of the estimate is {0} N m by "
            "(10), and {1} by (35).",
            D=(1, 0),
        ),
    ),
    (paper.DECREASE, unstated),
    (paper.DECREASE_STRICT, no_decrease),
    (paper.CONVERGENCE_35, unsettled),
    (paper.CONVERGENCE_10, convergence),
    (paper.FINITE_TIME, searched("finite_time", finite_time)),
    (paper.BOUNDED, unbounded),
    (paper.BOUNDED_ABOVE, searched("bounded", slow, f"Q = 0.01 I, R = I, {numbers('l')}, 4 s")),
)
