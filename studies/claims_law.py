"""The ledger's lines on the law: (30) to (34), and what section 4 concludes in (39) to (42)."""

import claims_paper as paper
import numpy as np
from claims_checks import Check, identity, listed, numbers, searched, sought, unequal
from claims_hunts import worst_component
from claims_loops import CONSTANT_D
from claims_lyapunov import ENOUGH, FLOOR, V2_AT_START
from claims_replay import cost, escape, gain_lost, offset
from paper_card import CARD

from workbench.controllers.aosmc_rgs import SHAPES as READINGS
from workbench.core import Claim
from workbench.verify.claims import Finding
from workbench.verify.falsify import Found

PRINTED_WEIGHTS = numbers("Q as printed", "R as printed", "l")
SECOND_SCENARIO = numbers("SS: a1, a2", "SS: f")
WEIGHTS = numbers("Q", "R", "l")
FITTED = CARD["Q"][0, 0], CARD["R"][0, 0]
SMALL = (0.1, 10.0)  # Q and R, times I: weights with which (34) lowers the cost
UNITS = {1: "N m", 2: "N^2 m^2"}  # of a minor of K, by its order


def shapes() -> Finding:
    """(33) as a product of matrices."""
    P, s = np.ones((2, 2)), np.ones((2, 1))
    try:
        P @ s @ np.sign(s)
    except ValueError:
        return Finding(
            "refuted",
            "P is 2 x 2, s and sign(s) are 2 x 1: P s is 2 x 1, and cannot be multiplied by sign(s). Four readings "
            f"give (33) a shape: {', '.join(READINGS)}.",
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
    """(34) beside P' = 0."""
    (with_34, error), (without, error_0) = cost("forward", *FITTED), cost("frozen", *FITTED)
    (small_34, small_error), (small_0, _) = cost("forward", *SMALL), cost("frozen", *SMALL)
    if without + error_0 >= with_34 - error:
        return Finding("not refuted", f"J is {with_34:.6g} with (34) and {without:.6g} with P' = 0", samples=2)
    return Finding(
        "refuted",
        f"With {WEIGHTS}, over 10 s of the first scenario, repaired, J is {with_34:.0f} N m rad/s^2 with (34) and "
        f"{without:.0f} with P' = 0, all else equal; halving the step changes them by {max(error, error_0):.1g}. Other "
        f"weights differ: with Q = {SMALL[0]:g} I and R = {SMALL[1]:g} I J is {small_34:.0f} with (34) and "
        f"{small_0:.0f} with P' = 0 (changed by {small_error:.1g}). (34) runs forward from P(0), the "
        "Riccati equation of (32) backward from the horizon.",
        f'cost("forward", {FITTED[0]:g}, {FITTED[1]:g}), cost("frozen", {FITTED[0]:g}, {FITTED[1]:g})',
    )


def unstated() -> Finding:
    """(39)."""
    return Finding(
        "not checkable",
        "The 'bounded term' is not stated, and with one that is large enough any V2' obeys (39). It holds tr(Q), which "
        "does not tend to zero.",
    )


def no_decrease(found: Found) -> str:
    """(40) along the repaired law."""
    assert found.worst is not None
    return (
        f"Even repaired, with {WEIGHTS}, V2' reaches {found.worst.value:,.0f} W where lambda_min(K) >= "
        f"{ENOUGH:g} N m, more than delta can be (halving the step changes it by {found.worst.error:.0e}): "
        "(40) leaves out tr(P') and the "
        f"observer's L2 x1~. Worst of {sought('decrease')}."
    )


def convergence() -> Finding:
    """(41) under a constant disturbance."""
    exact = identity("(41)")()
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
    )


def finite_time(found: Found) -> str:
    """(42) along the repaired law."""
    worst = found.worst
    assert worst is not None
    return (
        f"(42) for all sigma at once is t |s(t)| <= V2(0) / c. Repaired, with {WEIGHTS}, V2(0) = "
        f"{V2_AT_START:.3f} J and c >= {FLOOR:g} N m throughout, t |s(t)| exceeds it by {worst.value:.3f} rad "
        f"(halving the step changes it by {worst.error:.0e}). Worst of {sought('finite_time')}."
    )


def unbounded() -> Finding:
    """The law as printed but for C, first scenario."""
    fine, coarse, turned = escape()
    if not np.isfinite([fine, coarse]).all():
        return Finding("not refuted", "the loop stays finite for 5 s", samples=2)
    before = f"K has ceased to be positive definite by {turned:.2f} s. " if turned < fine else ""
    return Finding(
        "refuted",
        f"With {PRINTED_WEIGHTS} and C as derived, first scenario, reading 'outer' of (33): the states leave all "
        f"floating-point numbers at {fine:.3f} s, with twice the step at {coarse:.3f} s. "
        f"{before}Shown by two runs, not proved.",
        "escape()",
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
    (paper.DECREASE, unstated),
    (paper.DECREASE_STRICT, searched("decrease", no_decrease)),
    (paper.CONVERGENCE, convergence),
    (paper.FINITE_TIME, searched("finite_time", finite_time)),
    (paper.BOUNDED, unbounded),
)
