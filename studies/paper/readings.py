"""The choices that the paper leaves open, and those that are readings of what it prints."""

from __future__ import annotations

from dataclasses import dataclass

from studies.paper.card import PROPOSED_LAW

RIVAL = ("section 5", "the name of the law")


@dataclass(frozen=True)
class Choice:
    """A number or a reading that the paper leaves open, with its options and with what a1 assumes.

    `law` is the law that it belongs to, "rivals", or empty for the experiment; `scenario` is empty for both. `factors`
    are the names under which a6 varies it; `is_fitted` is true where a1 chose it for its fit to printed numbers.
    """

    name: str
    where: str  # the equation or the section that leaves it open
    states: str  # what the paper states there
    options: str  # the readings, or the range, in words
    assumption: str
    why: str
    law: str = ""
    scenario: str = ""
    readings: tuple[str, ...] = ()
    factors: tuple[str, ...] = ()
    is_fitted: bool = False

    def __str__(self) -> str:
        return f"{self.name}: {self.assumption}"


def _reading(
    name: str, where: str, states: str, readings: tuple[str, ...], assumed: str, why: str, law: str = PROPOSED_LAW
) -> Choice:
    return Choice(name, where, states, " / ".join(readings), assumed, why, law, readings=readings, factors=(name,))


# Readings of what is printed. The first option of each is the print where the print can be run.
OF_LAW = (
    _reading(
        "sign of (33)",
        "(33)",
        "a minus, with which K of (29) need not stay positive definite",
        ("minus", "plus"),
        "plus with four repairs; minus in the law as printed and with (3) and (28) repaired",
        "with the plus K grows with the error",
    ),
    _reading(
        "velocity in (28)",
        "(28)",
        "qd_d and qdd_d, from which (30) does not follow",
        ("printed", "reference"),
        "reference with four repairs and with (3) and (28) repaired; printed in the law as printed",
        "(30) follows with qd_r = qd_d - Lambda e",
    ),
    _reading(
        "D_hat of (24)",
        "(24)",
        "the integral of eta, which follows D; it must know D",
        ("none", "eta", "its integral"),
        "eta with four repairs; its integral in the law as printed and with (3) and (28) repaired",
        "D_hat follows D, as the text says",
    ),
    _reading(
        "C of (3)",
        "(3)",
        "an entry C[1,2] without velocity",
        ("right", "printed"),
        "right with four repairs and with (3) and (28) repaired; printed in the law as printed",
        "Assumption 3 holds with it (a0)",
    ),
    _reading(
        "observer (10)",
        "(10), (25)",
        "the law gets estimates, and (43) the measured positions",
        ("out", "in"),
        "in",
        "as printed",
    ),
    _reading(
        "D_hat in (10)",
        "(9), (10)",
        "no disturbance, though (1) has one",
        ("left out", "given"),
        "left out",
        "as printed; given in one run of a1",
    ),
    _reading(
        "1/phi in A of (31)",
        "(31)",
        "A = -M^-1 K, though (29) has K sat(s/phi)",
        ("left out", "kept"),
        "left out",
        "as printed",
    ),
    _reading(
        "Q and R as matrices",
        "(32), (34)",
        "two by two",
        ("a number times I", "any positive definite matrix"),
        "a number times I",
        "the plainest choice",
    ),
    _reading(
        "sat of (29)",
        "(29)",
        "a 'continuous approximation of sign'",
        ("clipped at 1", "another, as tanh"),
        "clipped at 1",
        "the usual meaning of sat",
    ),
    _reading(
        "start of (24)",
        "(24)",
        "nothing on eta(0)",
        ("zero", "another value"),
        "zero",
        "as the observer (10) starts",
    ),
    _reading(
        "C of the simulated arm",
        "(1), (3)",
        "(3), with the entry C[1,2] without velocity",
        ("derived", "printed"),
        "derived",
        "an arm obeys its energies, whatever the paper prints",
    ),
    _reading(
        "direction of (34)",
        "(34)",
        "P(0) and a quadratic cost without a horizon",
        ("forward from P(0)", "backward"),
        "forward from P(0)",
        "as P(0) is stated",
    ),
    _reading(
        "sign(0) in (33)",
        "(33)",
        "sign(s), for s that may be zero",
        ("0", "1 or -1"),
        "0",
        "the usual meaning of sign",
    ),
    _reading(
        "starts in the second scenario",
        "section 5",
        "K(0), P(0) and the observer's start, before both scenarios",
        ("as stated", "others"),
        "as stated",
        "nothing else is stated",
    ),
)
OF_RIVALS = (
    _reading(
        "rivals' measurements",
        "section 5",
        "nothing; (10) serves AOSMC-RGS",
        ("exact", "by (10)"),
        "exact",
        "the best that a rival can have",
        "rivals",
    ),
    _reading(
        "rivals' Lambda and phi",
        *RIVAL,
        ("those of AOSMC-RGS", "others"),
        "those of AOSMC-RGS",
        "the rivals share what section 5 states",
        "rivals",
    ),
    _reading(
        "rivals' equations",
        *RIVAL,
        ("standard forms", "other forms"),
        "standard forms",
        "as in textbooks",
        "rivals",
    ),
    _reading(
        "derivative and start of PID",
        *RIVAL,
        ("exact velocity, integral from zero", "a filter, another start"),
        "exact velocity, integral from zero",
        "the plainest PID",
        "PID",
    ),
    _reading("G in PID", *RIVAL, ("without", "with"), "without", "the plain PID has no model", "PID"),
)
OF_EXPERIMENT = (
    _reading(
        "error in (43)",
        "(43), section 5",
        "q - q_d in (43), q_hat - q_d as the tracking error of section 5",
        ("of q", "of q_hat"),
        "of q",
        "(43) prints it; a1 has both",
        "",
    ),
    _reading(
        "first sample of (43)",
        "(43)",
        "k = 1 to N",
        ("at t = 0", "one sample later"),
        "at t = 0",
        "arrays begin with the start",
        "",
    ),
    _reading(
        "square wave of the second scenario",
        "section 5",
        "square(pi f t)",
        ("half high and half low, high first", "another duty or phase"),
        "half high and half low, high first",
        "the usual meaning of square",
        "",
    ),
    _reading("torque limit", "section 5", "nothing", ("none", "some limit"), "none", "none is mentioned", ""),
    _reading("noise", "section 5", "nothing", ("none", "some noise"), "none", "none is mentioned", ""),
    _reading(
        "solver and sampling",
        "section 5",
        "nothing",
        ("continuous time", "a period or a solver's step"),
        "continuous time",
        "(9) to (34) are differential equations; a9 varies the period",
        "",
    ),
)
