"""The ledger's lines on the law: (30) to (34), and what section 4 concludes in (39) to (42)."""

import claims_paper as paper
import numpy as np
from claims_checks import Check, identity, listed, numbers, searched, sought, unequal
from claims_hunts import worst_component
from claims_loops import CONSTANT_D, on_path, regulation
from claims_lyapunov import FLOOR, V2_AT_START
from claims_replay import (
    along_35,
    cost,
    cost_of_loop,
    drift,
    gain_lost,
    kept_by_drift,
    offset,
    v2_rate,
)
from paper_card import CARD

from workbench.controllers.aosmc_rgs import SHAPES as READINGS
from workbench.core import Claim
from workbench.core.claim import Declared
from workbench.verify.claims import Finding
from workbench.verify.counterexample import hypotheses_kept
from workbench.verify.falsify import Found

PRINTED_WEIGHTS = numbers("Q as printed", "R as printed", "l")
SECOND_SCENARIO = numbers("SS: a1, a2", "SS: f")
WEIGHTS = numbers("Q", "R", "l")
FITTED = CARD["Q"][0, 0], CARD["R"][0, 0]
WEIGHTS_OF_COST = numbers("Q", "R")
KEPT = (Declared(paper.ASSUMPTION_4), Declared(paper.ABOVE))
SMALL = (0.1, 10.0)  # Q and R, times I: weights with which (34) lowers the cost
UNITS = {1: "N m", 2: "N^2 m^2"}  # of a minor of K, by its order


def shapes() -> Finding:
    """(33) as a product of matrices."""
    P, s = np.ones((2, 2)), np.ones((2, 1))
    try:
        P @ s @ np.sign(s)
    except ValueError:
        return Finding(
            "ill-posed",
            "P is 2 x 2, s and sign(s) are 2 x 1: P s is 2 x 1, and cannot be multiplied by sign(s), so there is "
            f"nothing to be true or false. Four readings give (33) a shape: {', '.join(READINGS)}. Each line below "
            "names the reading that it takes.",
            "np.ones((2, 2)) @ np.ones((2, 1)) @ np.sign(np.ones((2, 1)))",
        )
    return Finding("proved", "the product has a shape")


def gains() -> Finding:
    """(33) as printed, in each reading."""
    least = {reading: gain_lost(reading) for reading in READINGS}
    kept = {reading: gain_lost(reading, 30, Q=0.01) for reading in READINGS}
    lost = [f"{value:.3f} {UNITS[k]} ({reading})" for reading, (value, error, k) in least.items() if value + error < 0]
    worst = max(error for _, error, _ in least.values())
    safe = [f"{value:.3f} {UNITS[k]} ({reading})" for reading, (value, error, k) in kept.items() if value - error > 0]
    if len(lost) < len(READINGS):
        return Finding("not refuted", f"it is lost in {lost} alone", samples=len(READINGS))
    return Finding(
        "refuted",
        f"With {PRINTED_WEIGHTS}, {SECOND_SCENARIO}, in the second scenario, the least "
        "leading minor of K's symmetric part falls within "
        f"4 s to {', '.join(lost)}; halving the step changes these by {worst:.0e} at most. Other weights differ: with "
        f"Q = diag(0.01, 0.01), all else equal, it stays for 30 s at or above {', '.join(safe) or 'nothing positive'}.",
        "[gain_lost(reading) for reading in ('outer', 'elementwise', 'diagonal', 'norm')]",
    )


def raised_gain(found: Found) -> str:
    """(33) with a plus."""
    assert found.worst is not None
    return (
        f"With {WEIGHTS}, its least leading minor reaches {-found.worst.value:,.0f} "
        f"{UNITS[worst_component('repaired_gain') + 1]} within {found.worst.until:g} s: the outer "
        "product of P s and sign(s) is not semidefinite where the signs of s differ. "
        f"Worst of {sought('repaired_gain')}."
    )


def riccati(found: Found) -> str:
    """(34) keeps P definite."""
    assert found.worst is not None
    unit = {1: "N m/rad", 2: "N^2 m^2/rad^2"}[worst_component("riccati") + 1]
    return (
        f"With {WEIGHTS}, the least leading minor of P seen is {-found.worst.value:.4g} {unit}, in {sought('riccati')}."
    )


def least_cost() -> Finding:
    """(34) as the minimiser of (32) for (31)."""
    (ours, least), (fitted, fitted_least) = cost(1, 1), cost(*FITTED)
    if ours <= least * (1 + 1e-6):
        return Finding("not refuted", f"J is {ours:.6g} by (34), and {least:.6g} at least", samples=1)
    return Finding(
        "refuted",
        "Cost, horizon and input are those of (32) and (31): infinite, u = -R^-1 B^T P s, with A and B of section 5 "
        "held at t = 0, from P(0) and s(0) of the first scenario. With Q = R = I, J is "
        f"{ours / least:.4g} times the least J, which the algebraic Riccati equation gives; with {WEIGHTS_OF_COST} it "
        f"is {fitted / fitted_least:.4g} times. (34) runs forward from P(0), the Riccati equation of (32) backward "
        "from the horizon, and they agree only once P(0) is forgotten. Along the repaired runs, with the weights of a1 "
        f"and over the first 2.5 s, a3 finds 1.0 % (first scenario) and 2.1 % (second) above the least J.",
        f"cost(1, 1), cost({FITTED[0]:g}, {FITTED[1]:g})",
    )


def loop_cost() -> Finding:
    """(34) beside P' = 0 in the loop."""
    (with_34, error), (without, error_0) = cost_of_loop("forward", *FITTED), cost_of_loop("frozen", *FITTED)
    (small_34, small_error), (small_0, _) = cost_of_loop("forward", *SMALL), cost_of_loop("frozen", *SMALL)
    if without + error_0 >= with_34 - error:
        return Finding("not refuted", f"J is {with_34:.6g} with (34) and {without:.6g} with P' = 0", samples=2)
    return Finding(
        "does not hold under",
        "Both loops are repaired and alike but for P(t), and both costs are integrals of s^T Q s + e2^T R e2 of the "
        f"loop itself over the same 10 s of the first scenario: {with_34:.0f} N m rad/s^2 with (34), {without:.0f} with "
        f"P(t) = P(0); halving the step changes them by {max(error, error_0):.1g}. It depends on the weights: with "
        f"Q = {SMALL[0]:g} I and R = {SMALL[1]:g} I the costs are {small_34:.0f} with (34) and "
        f"{small_0:.0f} with P(0) (changed by {small_error:.1g}). Over an infinite horizon (32) has no finite value "
        "in the loop where e2 does not tend to zero.",
        f'cost_of_loop("forward", {FITTED[0]:g}, {FITTED[1]:g}), cost_of_loop("frozen", {FITTED[0]:g}, {FITTED[1]:g})',
        under=f"{WEIGHTS_OF_COST}, the repaired law, 10 s of the first scenario",
    )


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
        f"{rate:.0f} W at t = 0, where |s| = {size:g} and lambda_min(K) - |D - D_hat| = {left:.3g} N m: (40) leaves out "
        "tr(Q). The estimates are exact there, so (10) and (35) give the same s.",
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
        "Where s = 0 and e1 = 0, (35) gives M e2' = D_hat - D, whatever Q, R and K are (proved by normal form). So s and "
        "e1 tend to zero only if D - D_hat does, and for a sine D it does not: not for (24) as printed, "
        f"and not for D_hat = eta, which lags. As printed but for C, with {PRINTED_WEIGHTS}, reading 'outer', first "
        f"scenario, started on the desired path: |e1| still reaches {e:.2e} rad and |s| {s:.2e} rad/s from 15 s to 20 s "
        f"(changed by {max(e_change, s_change):.0e} as the step is halved). It is the residual of a boundary "
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
        f"of (33) are. For D = {listed(CONSTANT_D)} N m, D_hat is {listed(run, 6)} N m s after 10 s. The theorem asks for "
        "Assumptions 1 to 4 alone; the lambda_min(K) > delta of its proof, which such a D breaks in time, is the next "
        "line.",
        "drift()",
        kept=kept_by_drift(),
    )


def slow(found: Found) -> str:
    """Velocities under the gain of the proof."""
    assert found.worst is not None
    return (
        "As printed but for C, first scenario, reading 'outer', any start and disturbance of the assumptions: "
        f"in {sought('bounded')}, no velocity comes near 10^6 rad/s. Other weights, a longer horizon or another "
        "reading may give another answer."
    )


RAISED = Claim(
    "(33), repaired",
    f"{paper.ANY_WEIGHTS} with a plus in (33), reading 'outer', K(t) stays positive definite.",
    "(33), repaired",
)
DEFINITE_P = Claim("(34), P", "P(t) of (34) stays positive definite.", "(34)")
CHECKS: tuple[tuple[Claim, Check], ...] = (
    (
        paper.RATE_ALONG_10,
        unequal(
            "(30), along (10)",
            "D enters (30) and not (10): at D = (1, 0) N m, all else zero, M times the first "
            "line is {0} N m, and M ds/dt is {1}. The terms in L1 x1~ and L2 x1~ are missing as well.",
            D=(1, 0),
        ),
    ),
    (
        paper.RATE_ALONG_35,
        unequal(
            "(30), along (35)",
            "(30) has C qd_d where (35) has C qd_hat: at q_hat = (0, 1), qd_hat = (1, 0), all "
            "else zero, M times the first line is {0} N m, and M ds/dt is {1}.",
            q_hat=(0, 1),
            qd_hat=(1, 0),
        ),
    ),
    (paper.SUBSTITUTED, identity("(30), second line")),
    (paper.REPAIRED_RATE, identity("(30), repaired")),
    (
        paper.LINEARISED,
        unequal(
            "(31)",
            "(31) is printed as an approximation, by 'replacing sat(s / phi) by s in boundary layers'. There "
            "sat(s / phi) is s / phi, not s, which is no small error: for K = I and s = (0.005, 0) rad/s, -K s is "
            "{0} N m and -K sat(s / phi) is {1}. A lacks the factor 1 / phi = 100.",
            K=(1, 0, 0, 1),
            s=(0.005, 0),
        ),
    ),
    (paper.SHAPES, shapes),
    (paper.GAIN, gains),
    (RAISED, searched("repaired_gain", raised_gain)),
    (DEFINITE_P, searched("riccati", riccati)),
    (
        paper.OPTIMAL_INPUT,
        unequal(
            "(34), input",
            "On the surface s = 0 the minimiser asks for u = 0, and the surface itself for e2 = "
            "-Lambda e1: {0} rad/s at e1 = (1, 0) rad, not {1}. e2 is a state, and no input.",
            q_hat=(1, 0),
        ),
    ),
    (paper.OPTIMAL, least_cost),
    (paper.OPTIMAL_LOOP, loop_cost),
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
