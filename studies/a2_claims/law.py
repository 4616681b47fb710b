"""The ledger's lines on the law: (30) to (34)."""

import numpy as np

from studies.a2_claims import statements as paper
from studies.a2_claims.checks import Check, identity, numbers, searched, sought, unequal
from studies.a2_claims.replay import (
    cost,
    cost_of_loop,
    gain_lost,
)
from studies.a2_claims.searches import worst_component
from studies.paper.card import CARD
from workbench.claims.falsify import Found
from workbench.claims.verdicts import Finding
from workbench.controllers.aosmc_rgs import SHAPES as READINGS
from workbench.core import Claim

PRINTED_WEIGHTS = numbers("Q as printed", "R as printed", "l")
SECOND_SCENARIO = numbers("SS: a1, a2", "SS: f")
WEIGHTS = numbers("Q", "R", "l")
FITTED = CARD["Q"][0, 0], CARD["R"][0, 0]
WEIGHTS_OF_COST = numbers("Q", "R")
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
        f"{ours / least:.4g} times the least J, which the algebraic Riccati equation gives; with {WEIGHTS_OF_COST}, "
        f"the weights of a1, it is {fitted / fitted_least:.4g} times the least. (34) runs forward from P(0), the "
        "Riccati equation of (32) backward from the horizon, and they agree only once P(0) is forgotten. Along the "
        "repaired runs, with the weights of a1, from the worst start and over the first 2.5 s, a3 finds 1.0 % (first "
        "scenario) and 2.1 % (second) above the least J.",
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
        f"loop itself over the same 10 s of the first scenario: {with_34:.0f} N m rad/s^2 with (34), {without:.0f} "
        f"with P(t) = P(0); halving the step changes them by {max(error, error_0):.1g}. It depends on the weights: "
        f"with Q = {SMALL[0]:g} I and R = {SMALL[1]:g} I the costs are {small_34:.0f} with (34) and "
        f"{small_0:.0f} with P(0) (changed by {small_error:.1g}). Over an infinite horizon (32) has no finite value "
        "in the loop where e2 does not tend to zero.",
        f'cost_of_loop("forward", {FITTED[0]:g}, {FITTED[1]:g}), cost_of_loop("frozen", {FITTED[0]:g}, {FITTED[1]:g})',
        under=f"{WEIGHTS_OF_COST}, the repaired law, 10 s of the first scenario",
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
)
