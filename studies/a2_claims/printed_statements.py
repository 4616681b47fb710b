"""The printed equations one by one: their words, the claims that judge them, and who chose the ranges of these."""

from collections.abc import Mapping
from typing import NamedTuple

import workbench as wb


class PrintedStatement(NamedTuple):
    """An equation, assumption or theorem of the paper, its words, and the claims on it, the decisive one first."""

    name: str
    quote: str
    claims: tuple[str, ...]


PRINTED_STATEMENTS = (
    PrintedStatement("(2)", "Inertia matrix M(q) = ...", ("(2)",)),
    PrintedStatement("(3)", "Coriolis and centrifugal matrix C(q, qd) = ...", ("(3)",)),
    PrintedStatement("(4)", "Gravity vector G(q) = ...", ("(4)",)),
    PrintedStatement(
        "(6) with Assumption 1", "the initial states of the system satisfy (q(0), qd(0)) in X0", ("Assumption 1",)
    ),
    PrintedStatement("(7) with Assumption 2", "M(q) is symmetric and uniformly positive definite", ("Assumption 2",)),
    PrintedStatement(
        "Assumption 3",
        "The Coriolis matrix satisfies M'(q) - 2C(q, qd) is skew-symmetric.",
        ("Assumption 3", "Assumption 3, derived C"),
    ),
    PrintedStatement("(8) with Assumption 4", "The disturbance is bounded and differentiable", ("Assumption 4",)),
    PrintedStatement("(12)", "Then, we have: x1~' = ... = x2~ - L1 x1~", ("(12)",)),
    PrintedStatement("(13)", "To derive the error dynamics for x2~, we write: ...", ("(13)",)),
    PrintedStatement(
        "(15)",
        "Under smoothness (Lipschitz continuity) assumptions, there exists a constant |Delta| <= rho (|x1~| + |x2~|)",
        ("(15)", "(15), everywhere"),
    ),
    PrintedStatement("(16)", "Therefore: x2~' = -L2 x1~ + Delta", ("(16)",)),
    PrintedStatement("(18)", "Compute its derivative: V1' = x1~^T P1 x1~' + x2~^T P2 x2~'", ("(18)",)),
    PrintedStatement("(20)", "Then: V1' = ...", ("(20)",)),
    PrintedStatement(
        "(21)", "Thus: V1' <= -lambda1 |x1~|^2 - lambda2 |x1~| |x2~| + c1 |x1~|^2 + c2 |x2~|^2", ("(21)",)
    ),
    PrintedStatement(
        "(22)", "Choosing L1, L2 sufficiently large ensures: V1' <= -alpha V1 for some alpha > 0", ("(22)",)
    ),
    PrintedStatement(
        "(23) with Theorem 1",
        "L1, L2 are positive definite matrices. Then, the observer error ... converges exponentially to zero. ... The "
        "observer error dynamics are globally exponentially stable.",
        ("Theorem 1", "Theorem 1, gains of section 5", "Theorem 1, swinging arm", "Theorem 1, small errors at rest"),
    ),
    PrintedStatement("(24)", "This ensures D_hat(t) -> D(t) exponentially fast under Assumption 4.", ("(24)",)),
    PrintedStatement("(29)", "where K(t) is an adaptive gain matrix (positive-definite)", ("(33), gain",)),
    PrintedStatement(
        "(30)",
        "The derivative of the sliding surface is: s' = ... = ...",
        ("(30), along (35)", "(30), along (10)", "(30), second line", "(30), repaired"),
    ),
    PrintedStatement(
        "(31)",
        "Neglecting the disturbance estimation error and replacing sat(s / phi) by s in boundary layers: "
        "s' is about A s + B u",
        ("(31)", "(31), replacement"),
    ),
    PrintedStatement("(33)", "We define the adaptive gain as: K' = -P s sign(s)", ("(33), shapes",)),
    PrintedStatement(
        "(34)",
        "The solution of the Riccati equation guarantees J(t) -> min so that s(t) and e2(t) -> min.",
        ("(34), cost", "(34), input"),
    ),
    PrintedStatement(
        "(35)",
        "Using the outputs of the state observer, the equation of the 2-DOF robotic manipulator is rewritten as: ...",
        ("(35)",),
    ),
    PrintedStatement("(37)", "The derivative of V2' = ... = ...", ("(37)",)),
    PrintedStatement("(38)", "tr(P') = tr(A^T P + P A) - tr(P B R^-1 B^T P) + tr(Q)", ("(38)",)),
    PrintedStatement(
        "(39)",
        "If |D - D_hat| <= delta, then: V2' <= -lambda_min(K) |s| + |s| delta + bounded term",
        ("(39)",),
    ),
    PrintedStatement(
        "(40)",
        "Choose K(t) such that lambda_min(K) > delta. Then: V2' <= -c |s|",
        ("(40)",),
    ),
    PrintedStatement(
        "(41)",
        "therefore: lim s(t) = 0 implies lim e1(t) = 0",
        ("(41), along (35)", "(41), along (10)", "(41), implication"),
    ),
    PrintedStatement(
        "(42)",
        "s(t) converges to zero in finite time, with the settling time bounded by: T <= V2(0) / (c sigma)",
        ("(42)",),
    ),
    PrintedStatement(
        "Theorem 2",
        "Under Assumptions 1-4, the AOSMC-RGS control law ensures: ... Boundedness of all closed-loop signals.",
        ("Theorem 2, bounded signals",),
    ),
)
# Numbered equations that assert nothing: models, definitions, and (19), which repeats (12) and (16).
DEFINITIONS = (1, 5, 9, 10, 11, 14, 17, 19, 25, 26, 27, 28, 32, 36, 43)

ALL_STATES = wb.proofs.Quantifier("all states", "source")
ALL_ERRORS = wb.proofs.Quantifier("all initial errors ('globally')", "source")
ANY_D = wb.proofs.Quantifier("all D of Assumption 4", "source")
DERIVED_C = wb.proofs.Quantifier("C as derived, which favours the paper", "reader", within=True)
ANY_WEIGHTS = wb.proofs.Quantifier("every Q, R > 0, as the paper names none", "source")
SEARCH_RANGE = wb.proofs.Quantifier("starts and sines within the numbers of the search", "reader", within=True)
NUMBERS_OF_Q_R = wb.proofs.Quantifier("Q, R, and the reading of (33)", "reader")
# By claim: the ranges over which it is judged; a claim that is not named has no range to choose.
QUANTIFIERS: Mapping[str, tuple[wb.proofs.Quantifier, ...]] = {
    "(3)": (ALL_STATES,),
    "Assumption 2": (ALL_STATES,),
    "Assumption 3": (ALL_STATES,),
    "Assumption 3, derived C": (ALL_STATES, wb.proofs.Quantifier("C as derived", "reader")),
    "Assumption 4": (wb.proofs.Quantifier("the two scenarios of section 5", "source"),),
    "(15)": (
        wb.proofs.Quantifier("where the right-hand side is Lipschitz continuous", "source"),
        wb.proofs.Quantifier("|qd_i| <= 5 rad/s and |tau_i| <= 30 N m, for the numbers", "reader", within=True),
    ),
    "(15), everywhere": (wb.proofs.Quantifier("all velocities and torques at once", "reader"),),
    "(22)": (wb.proofs.Quantifier("some P1, P2, L1, L2 and alpha", "source"), ALL_ERRORS),
    "Theorem 1": (wb.proofs.Quantifier("all positive definite L1, L2", "source"), ALL_ERRORS),
    "Theorem 1, gains of section 5": (wb.proofs.Quantifier("L1 = 30 I, L2 = 50 I", "source"), ALL_ERRORS),
    "Theorem 1, swinging arm": (wb.proofs.Quantifier("a bound of 5 rad from 1.5 s on", "reader"),),
    "Theorem 1, small errors at rest": (wb.proofs.Quantifier("an arm at rest and small errors", "reader"),),
    "(24)": (ANY_D, wb.proofs.Quantifier("any l", "source")),
    "(30), along (10)": (ALL_STATES, wb.proofs.Quantifier("the estimates obey (10)", "reader", within=True)),
    "(30), along (35)": (ALL_STATES, wb.proofs.Quantifier("the estimates obey (35)", "reader", within=True)),
    "(31), replacement": (wb.proofs.Quantifier("all s within the boundary layer", "source"),),
    "(33), gain": (NUMBERS_OF_Q_R, wb.proofs.Quantifier("the second scenario, up to 30 s", "reader")),
    "(34), cost": (
        wb.proofs.Quantifier("Q, R", "reader"),
        wb.proofs.Quantifier("A and B held at t = 0, and the input of the textbooks", "reader"),
    ),
    "(34), input": (wb.proofs.Quantifier("the input of the textbooks", "reader"),),
    "(35)": (ALL_STATES, ANY_D),
    "(40)": (ANY_WEIGHTS, DERIVED_C, wb.proofs.Quantifier("nine pairs of Q and R for the runs", "reader", within=True)),
    "(41), along (35)": (ANY_D, ANY_WEIGHTS, DERIVED_C),
    "(41), along (10)": (ANY_D, ANY_WEIGHTS, DERIVED_C),
    "(42)": (ANY_D, ANY_WEIGHTS, wb.proofs.Quantifier("every precision sigma", "source"), DERIVED_C, SEARCH_RANGE),
    "Theorem 2, bounded signals": (ANY_D, ANY_WEIGHTS, DERIVED_C),
}
QUOTES = {claim: item.quote for item in PRINTED_STATEMENTS for claim in item.claims}


def line_of(claim: wb.core.Claim, ruling: wb.proofs.Ruling) -> wb.proofs.ClaimEntry:
    """The line of a claim with its ruling, its words in the paper and its ranges."""
    return wb.proofs.ClaimEntry(claim, ruling, QUOTES.get(claim.name, ""), QUANTIFIERS.get(claim.name, ()))


def decisive(ledger: wb.proofs.ClaimLedger, item: PrintedStatement) -> wb.proofs.ClaimEntry:
    """The line whose ruling is the verdict on a printed equation."""
    return ledger[item.claims[0]]


def chosen_by(line: wb.proofs.ClaimEntry) -> str:
    """The ranges of a claim, those of the paper first, each with who chose it."""
    words = {"source": "paper", "reader": "ours"}
    return "; ".join(f"{words[one.chosen_by]}: {one.words}" for one in line.quantifiers) or "none"
