"""The ledger's lines on the law, (30) to (34), and on section 4: (35), and what it concludes in (39) to (42)."""

from collections.abc import Callable

import numpy as np

from studies.a2_claims import arm, replay
from studies.a2_claims.checks import identity, identity_finding, inequality, judges, numbers, refutation, row
from studies.a2_claims.searches import (
    ABOVE,
    ASSUMPTION_4,
    CONSTANT_D,
    FLOOR,
    KEPT,
    V2_AT_START,
    on_path,
    regulation,
)
from studies.paper.card import CARD
from workbench.claims.claim_ledger import Finding
from workbench.claims.counterexample import hypotheses_kept
from workbench.claims.falsify import Found
from workbench.controllers.aosmc_rgs import SHAPES as READINGS
from workbench.core import Claim
from workbench.loop import ClosedLoop

PRINTED_WEIGHTS = numbers("Q as printed", "R as printed", "l")
SECOND_SCENARIO = numbers("SS: a1, a2", "SS: f")
WEIGHTS, WEIGHTS_OF_COST = numbers("Q", "R", "l"), numbers("Q", "R")
FITTED = CARD["Q"][0, 0], CARD["R"][0, 0]
UNITS = "N m", "N^2 m^2"  # of a leading minor of K, by its order
ANY_WEIGHTS = "For all Q, R > 0, of which the paper states none,"

rate_along_10 = inequality(
    "(30), along (10)",
    "The first line of (30) is ds/dt along the observer (10).",
    "(10), (30)",
    "D enters (30) and not (10): at D = (1, 0) N m, all else zero, M times the first line is {0} N m, and M ds/dt is "
    "{1}. The terms in L1 x1~ and L2 x1~ are missing as well.",
    D=(1, 0),
)
rate_along_35 = inequality(
    "(30), along (35)",
    "The first line of (30) is ds/dt where the estimates obey (35), x1~ = 0.",
    "(30), (35)",
    "(30) has C qd_d where (35) has C qd_hat: at q_hat = (0, 1), qd_hat = (1, 0), all else zero, M times the first "
    "line is {0} N m, and M ds/dt is {1}.",
    q_hat=(0, 1),
    qd_hat=(1, 0),
)
second_line = identity("(30), second line", "The second line of (30) follows from the first by (27)-(29).", "(27)-(30)")
rate_with_qd_r = identity(
    "(30), repaired",
    "With qd_r = qd_d - Lambda e1 in (28) for qd_d, M s' + C s = -K sat(s / phi) + D_hat - D along (35).",
    "(28), (35), repaired",
)
layer_rate = inequality(
    "(31)",
    "Within the layer, with sat(s / phi) replaced by s, s' is approximately -M^-1 K s + Lambda e2 where D_hat = D.",
    "(31)",
    "In the layer sat(s / phi) is s / phi, not s: for K = I and s = (0.005, 0) rad/s, -K s is {0} N m and "
    "-K sat(s / phi) is {1}. A lacks the factor 1 / phi = 100.",
    rate_along_10.claim,
    second_line.claim,
    K=(1, 0, 0, 1),
    s=(0.005, 0),
)
optimal_input = inequality(
    "(34), input",
    "u = e2 is the input -R^-1 B^T P s with which the Riccati equation minimises (32).",
    "(31)-(34)",
    "On the surface s = 0 the minimiser asks for u = 0, and the surface itself for e2 = -Lambda e1: {0} rad/s at "
    "e1 = (1, 0) rad, not {1}. e2 is a state, and no input.",
    q_hat=(1, 0),
)


@judges("(33), shapes", "-P s sign(s) is a matrix, as K' is.", "(33)")
def shapes() -> Finding:
    P, s = np.ones((2, 2)), np.ones((2, 1))
    try:
        P @ s @ np.sign(s)
    except ValueError:
        return Finding(
            "ill-posed",
            "P is 2 x 2, s and sign(s) are 2 x 1: P s is 2 x 1, and cannot be multiplied by sign(s). Four readings "
            f"give (33) a shape: {', '.join(READINGS)}. Each line below names the reading that it takes.",
            "np.ones((2, 2)) @ np.ones((2, 1)) @ np.sign(np.ones((2, 1)))",
        )
    return Finding("proved", "the product has a shape")


@judges("(33), gain", f"{ANY_WEIGHTS} K(t) of (33) stays positive definite, as (29) asks.", "(29), (33)", shapes.claim)
def gains() -> Finding:
    lost = {reading: replay.gain_lost(reading) for reading in READINGS}
    safe = {reading: replay.gain_lost(reading, 30, Q=0.01) for reading in READINGS}
    minors, others = (
        ", ".join(f"{value:.3f} {UNITS[order - 1]} ({reading})" for reading, (value, _, order) in found.items())
        for found in (lost, safe)
    )
    return refutation(
        all(value + error < 0 for value, error, _ in lost.values()),
        f"With {PRINTED_WEIGHTS}, {SECOND_SCENARIO}, in the second scenario, the least leading minor of K's symmetric "
        f"part falls within 4 s to {minors}; the errors of the step are "
        f"{max(error for _, error, _ in lost.values()):.0e} at most. Other weights differ: with Q = diag(0.01, 0.01), "
        f"all else equal, the least within 30 s is {others}.",
        "[gain_lost(reading) for reading in ('outer', 'elementwise', 'diagonal', 'norm')]",
    )


@judges(
    "(34), cost",
    f"{ANY_WEIGHTS} u = -R^-1 B^T P s with P(t) of (34) makes (32) least for (31).",
    "(31), (32), (34)",
)
def least_cost() -> Finding:
    (ours, least), (fitted, fitted_least) = replay.cost(1, 1), replay.cost(*FITTED)
    return refutation(
        ours > least * (1 + 1e-6),
        "Cost, horizon and input are those of (32) and (31): infinite, u = -R^-1 B^T P s, with A and B of section 5 "
        "held at t = 0, from P(0) and s(0) of the first scenario. With Q = R = I, J is "
        f"{ours / least:.4g} times the least J, which the algebraic Riccati equation gives; with {WEIGHTS_OF_COST}, "
        f"the weights of a1, it is {fitted / fitted_least:.4g} times the least. (34) runs forward from P(0), the "
        "Riccati equation of (32) backward from the horizon. Along the repaired runs, from the worst start and over "
        "the first 2.5 s, a3 finds 1.0 % (first scenario) and 2.1 % (second) above the least J.",
        f"cost(1, 1), cost{row(FITTED)}",
    )


estimate_rate = inequality(
    "(35)",
    "The estimates of (10) obey (35), M(q_hat) qd_hat' + C qd_hat + G + D = tau, where x1~ = 0.",
    "(10), (35)",
    "(10) has no D. At D = (1, 0) N m, all else zero, M times the acceleration of the estimate is {0} N m by (10), and "
    "{1} by (35).",
    D=(1, 0),
)


@judges("(39)", "V2' <= -lambda_min(K) |s| + |s| delta + 'bounded term'.", "(39)", arm.SKEW_PRINTED, gains.claim)
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
    least_cost.claim,
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
    exact, ((e, e_error), (s, s_error)) = identity_finding("(41), along (35)"), replay.along_35().values()
    return refutation(
        exact.kind == "proved" and e > e_error,
        "Where s = 0 and e1 = 0, (35) gives M e2' = D_hat - D, whatever Q, R and K are (proved by normal form). So, "
        "with K bounded, s and e1 tend to zero only if D - D_hat does, and for a sine D it does not: not for (24) as "
        f"printed, and not for D_hat = eta, which lags. As printed but for C, with {PRINTED_WEIGHTS}, reading 'outer', "
        f"first scenario, started on the desired path: |e1| still reaches {e:.2e} rad and |s| {s:.2e} rad/s from 15 s "
        f"to 20 s (error of the step at most {max(e_error, s_error):.0e}), small and not zero.",
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


FINITE_TIME = Claim(
    "(42)",
    f"{ANY_WEIGHTS} |s(t)| <= sigma from t = V2(0) / (c sigma) on, for every precision sigma; C is derived.",
    "(42)",
    (ASSUMPTION_4, ABOVE, strict_decrease.claim),
)


def finite_time(found: Found) -> Finding:
    """The finding on (42) from the worst run of its search."""
    sought: dict[str, list[float]] = {}
    for label, number in found.worst.sought.items():
        sought.setdefault(label.split("[")[0], []).append(number)
    return refutation(
        found.kind == "refuted",
        f"(42) for all sigma at once is t |s(t)| <= V2(0) / c. As printed but for C, with {PRINTED_WEIGHTS}, reading "
        f"'outer', first scenario, V2(0) = {V2_AT_START:.3f} J and c >= {FLOOR:g} N m throughout, t |s(t)| exceeds it "
        f"by {found.worst.value:.3f} rad within 2 s (error of the step {found.worst.error:.0e}). Worst of "
        f"{found.runs:,} runs of 2 s, {found.kept:,} of which kept the hypotheses.",
        f"rerun({sought})",
        kept=tuple(hypothesis.claim.name for hypothesis in KEPT),
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


CHECKS = (
    *(rate_along_10, rate_along_35, second_line, rate_with_qd_r, layer_rate, shapes, gains),
    *(optimal_input, least_cost, estimate_rate, decrease, strict_decrease, convergence_35, convergence_10),
    bounded_signals,
)
CLAIMS = (*(one.claim for one in CHECKS[:-1]), FINITE_TIME, bounded_signals.claim)
