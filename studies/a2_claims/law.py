"""The ledger's lines on the law and its equations: (30) to (35)."""

import numpy as np

import workbench as wb
from studies.a2_claims import replay
from studies.a2_claims.checks import (
    both,
    identity,
    inequality,
    judges,
    numbers,
    row,
    unbroken_claim,
)
from studies.paper.card import CARD

PRINTED_WEIGHTS = numbers("Q as printed", "R as printed", "l")
SECOND_SCENARIO = numbers("SS: a1, a2", "SS: f")
WEIGHTS, WEIGHTS_OF_COST = numbers("Q", "R", "l"), numbers("Q", "R")
FITTED_WEIGHTS = CARD["Q"][0, 0], CARD["R"][0, 0]
UNITS = "N m", "N^2 m^2"  # of a leading minor of K, by its order

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
layer_rate = identity(
    "(31)",
    "With sat(s / phi) replaced by s and D_hat = D, the second line of (30) is A s + B u with A = -M^-1 K, B = Lambda "
    "and u = e2.",
    "(30), (31)",
)
replacement = inequality(
    "(31), replacement",
    "Within the boundary layer sat(s / phi) may be replaced by s.",
    "the words above (31)",
    "In the layer sat(s / phi) is s / phi, not s: for K = I and s = (0.005, 0) rad/s, -K s is {0} N m and "
    "-K sat(s / phi) is {1}. A lacks the factor 1 / phi = 100.",
    K=(1, 0, 0, 1),
    s=(0.005, 0),
)


@judges(
    "(34), input",
    "u = e2 is the input with which the Riccati equation minimises (32).",
    "(31)-(34)",
)
def optimal_input() -> wb.proofs.Ruling:
    surface, minimiser = both("(34), input", q_hat=(1, 0))
    if np.allclose(surface, minimiser):
        return unbroken_claim()
    return wb.proofs.Ruling(
        "does not hold under",
        "On the surface s = 0 the minimiser needs u = 0, but the surface itself has e2 = -Lambda e1: "
        f"{row(surface)} rad/s at e1 = (1, 0) rad, not {row(minimiser)}. e2 is a state, not an input.",
        'both("(34), input", q_hat=(1, 0))',
        under="the minimiser u = -R^-1 B^T P s of the textbooks, as the paper prints none",
    )


@judges("(33), shapes", "-P s sign(s) is a matrix, as K' is.", "(33)")
def shapes() -> wb.proofs.Ruling:
    P, s = np.ones((2, 2)), np.ones((2, 1))
    try:
        P @ s @ np.sign(s)
    except ValueError:
        return wb.proofs.Ruling(
            "ill-posed",
            "P is 2 x 2, s and sign(s) are 2 x 1: P s is 2 x 1, and cannot be multiplied by sign(s). Four readings "
            f"give (33) a shape: {', '.join(wb.arms.laws.SHAPES)}. Each row below names the reading that it uses.",
            "np.ones((2, 2)) @ np.ones((2, 1)) @ np.sign(np.ones((2, 1)))",
        )
    return wb.proofs.Ruling("proved", "the product has a shape")


@judges("(33), gain", "K(t) of (33) stays positive definite, as (29) requires.", "(29), (33)", shapes.claim)
def gains() -> wb.proofs.Ruling:
    lost = {reading: replay.gain_lost(reading) for reading in wb.arms.laws.SHAPES}
    safe = {reading: replay.gain_lost(reading, 30, Q=0.01) for reading in wb.arms.laws.SHAPES}
    minors, others = (
        ", ".join(f"{value:.3f} {UNITS[order - 1]} ({reading})" for reading, (value, _, order) in found.items())
        for found in (lost, safe)
    )
    if not all(value + error < 0 for value, error, _ in lost.values()):
        return unbroken_claim()
    return wb.proofs.Ruling(
        "depends on",
        f"With {PRINTED_WEIGHTS}, {SECOND_SCENARIO}, in the second scenario, the least leading minor of the symmetric "
        f"part of K falls within 4 s to {minors}; the errors of the step are at most "
        f"{max(error for _, error, _ in lost.values()):.0e}. With Q = diag(0.01, 0.01) and all else equal, K stays "
        f"positive definite for 30 s: the least leading minor is {others}.",
        "[gain_lost(reading) for reading in ('outer', 'elementwise', 'diagonal', 'norm')]",
        on="Q and R, which the paper does not state",
    )


@judges(
    "(34), cost",
    "u = -R^-1 B^T P s with P(t) of (34) makes (32) least for (31).",
    "(31), (32), (34)",
)
def least_cost() -> wb.proofs.Ruling:
    (ours, least), (fitted, fitted_least) = replay.cost(1, 1), replay.cost(*FITTED_WEIGHTS)
    if ours <= least * (1 + 1e-6):
        return unbroken_claim()
    return wb.proofs.Ruling(
        "depends on",
        "Cost, horizon and input are those of (32) and (31): infinite, u = -R^-1 B^T P s, with A and B of section 5 "
        "held at t = 0, from P(0) and s(0) of the first scenario. With Q = R = I, J is "
        f"{ours / least:.4g} times the least J, which the algebraic Riccati equation gives; with {WEIGHTS_OF_COST}, "
        f"the weights of a1, it is {fitted / fitted_least:.4g} times the least. (34) runs forward from P(0), the "
        "Riccati equation of (32) runs backward from the horizon. So J exceeds the least J unless P(0) solves the "
        "algebraic equation; by how much depends on Q and R. Along the repaired runs, from the worst start and over "
        "the first 2.5 s, report a3 finds J 1.0 % (first scenario) and 2.1 % (second scenario) above the least J.",
        f"cost(1, 1), cost{row(FITTED_WEIGHTS)}",
        on="Q and R, which the paper does not state",
    )


estimate_rate = inequality(
    "(35)",
    "The estimates of (10) obey (35), M(q_hat) qd_hat' + C qd_hat + G + D = tau, where x1~ = 0.",
    "(10), (35)",
    "(10) has no D. At D = (1, 0) N m, all else zero, M times the acceleration of the estimate is {0} N m by (10), and "
    "{1} by (35).",
    D=(1, 0),
)


CHECKS = (
    *(rate_along_10, rate_along_35, second_line, rate_with_qd_r, layer_rate, replacement, shapes, gains),
    *(optimal_input, least_cost, estimate_rate),
)
