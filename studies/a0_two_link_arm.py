"""Are the printed equations of the two-link arm right?

Runs in: one second.
"""

import casadi as ca
import numpy as np

from studies.paper.printed_arm import PrintedArm
from workbench.core import Dynamics
from workbench.notation import text
from workbench.notation.formula import Formula, Relation, entry_symbol, symbol
from workbench.notation.reader import formula_of
from workbench.printed.entry_comparison import EntryVerdict, compare
from workbench.proofs.bounds import shown
from workbench.proofs.properties import PropertyVerdict, eigenvalues_along, positive_definite, skew, symmetric
from workbench.robots import paper_arm
from workbench.study.document.document import Equation, Figure, Panel, Paragraph, Section, Series, Verdict
from workbench.study.document.phrases import Code, Column, Strong, Table
from workbench.study.study import Results, Study

DERIVED = Dynamics.of(paper_arm(), "derived from the energies")
PRINTED = Dynamics.of(PrintedArm(), "as printed")
REPAIRED = Dynamics.of(PrintedArm(coriolis="repaired"), "printed, with C[1,2] repaired")

EQUATION = {"M": "(2)", "C": "(3)", "G": "(4)"}
OUTCOME = {"proved": "holds", "refuted": "fails", "not refuted": "open"}
TORQUE = {"proved": "right all the same", "refuted": "wrong as well", "not refuted": "open"}

ENTRIES = compare(PRINTED, DERIVED)
WRONG = tuple(entry for entry in ENTRIES if entry.kind == "differs")
SKEW = {arm.name: skew(arm) for arm in (PRINTED, REPAIRED, DERIVED)}
SYMMETRIC = {arm.name: symmetric(arm) for arm in (PRINTED, DERIVED)}
DEFINITE = positive_definite(DERIVED)


def formula(expression: ca.SX) -> Formula:
    """An expression in the derived arm's symbols, with the letters of the paper."""
    return formula_of(expression, DERIVED.names())


def wrong_entry(entry: EntryVerdict) -> tuple[Verdict, Equation]:
    """The witness against an entry, and the right one."""
    statement = f"The paper's equation {EQUATION[entry.matrix]} is right in its entry {entry.label}."
    evidence = (
        f"At {entry.witness}, it is {entry.printed_value:.6g} where {entry.right_value:.6g} is right. The torque with "
        f"it is {TORQUE[entry.same_torque or 'not refuted']}. To replay: ",
        Code(entry.witness.replay if entry.witness else ""),
    )
    place = f"{entry.row}" if entry.matrix == "G" else f"{entry.row}{entry.column}"
    right = Relation(entry_symbol(symbol(entry.matrix), place), "=", formula(entry.right))
    equation = Equation(right, name=f"right_{entry.matrix.lower()}{place}", note="The right entry.")
    return Verdict("fails", statement, evidence), equation


def verdict(judged: PropertyVerdict, statement: str) -> Verdict:
    """A judgement of `proofs` on the page; where M' - 2C is not skew, with the power that comes from nowhere."""
    evidence = judged.evidence
    if judged.residual is not None and judged.witness is not None:
        qd = judged.witness.qd
        evidence += (
            f". The kinetic energy changes by half of qd' (M' - 2C) qd, which no torque has supplied: "
            f"{float(qd @ judged.residual @ qd) / 4:.4g} W"
        )
    return Verdict(OUTCOME[judged.kind], statement, f"{evidence[:1].upper()}{evidence[1:]}.".replace("m^2", "m²"))


def eigenvalues() -> tuple[Figure, Verdict]:
    """The eigenvalues of M over the second joint angle, and the bounds of Assumption 2."""
    angles = np.linspace(-np.pi, np.pi, 361)
    least, greatest = eigenvalues_along(DERIVED, 2, angles).T
    panel = Panel(
        "eigenvalues of M [kg m²]",
        (Series("greatest", angles, greatest, style=0), Series("least", angles, least, style=1)),
        xlabel="second joint angle [rad]",
        xlim=(-np.pi, np.pi),
        hlines=(DEFINITE.alpha1, DEFINITE.alpha2),
    )
    caption = "Eigenvalues of M over the second joint angle, the only one M depends on; thin lines: their extremes."
    statement = "Assumption 2: M, as printed and as derived, is positive definite for all q at nominal parameters."
    bounds = (
        f"alpha_1 = {DEFINITE.alpha1:.6f} and alpha_2 = {DEFINITE.alpha2:.6f} kg m², both with the arm stretched. "
        f"Intervals on {DEFINITE.boxes} boxes prove that no eigenvalue lies below {shown(DEFINITE.beyond[0], 1)} or "
        f"above {shown(DEFINITE.beyond[1], -1)} anywhere on the torus, so that {min(DEFINITE.digits)} digits of both "
        "are right (sines and cosines within four units in the last place, or from ball arithmetic where the extra "
        "'rigorous' is installed)."
    )
    return Figure("eigenvalues_of_m", caption, (panel,)), Verdict(OUTCOME[DEFINITE.kind], statement, bounds)


def sections(results: Results) -> list[Section]:
    """The findings, the entries behind them, and the derived matrices."""
    del results
    skewness = (verdict(judged, f"Assumption 3: M' - 2C is skew-symmetric ({arm}).") for arm, judged in SKEW.items())
    symmetry = (verdict(judged, f"Assumption 2: M is symmetric ({arm}).") for arm, judged in SYMMETRIC.items())
    wrong = (block for entry in WRONG for block in wrong_entry(entry))
    picture, bounds = eigenvalues()
    rows = tuple(
        (e.label, EQUATION[e.matrix], formula(e.printed), Strong("differs") if e in WRONG else e.kind) for e in ENTRIES
    )
    entries = Table(
        "printed_entries",
        "Each entry of the paper's equations (2) to (4), judged against the derived one.",
        (Column("entry"), Column("paper"), Column("printed"), Column("verdict")),
        rows,
        ("same: proved, an identity in all states and all parameters.",),
    )
    about = Paragraph(
        "Point masses at the ends of massless links; the first angle is measured from the downward vertical, the "
        "second from the line of the first link. These equations are printed from the expressions that every "
        "simulation of this arm runs."
    )
    matrices = (
        Equation(Relation(symbol(letter), "=", formula(getattr(DERIVED, letter))), name=f"derived_{letter.lower()}")
        for letter in "MCG"
    )
    return [
        Section("Findings", (picture, *wrong, bounds, *symmetry, *skewness)),
        Section("The printed matrices, entry by entry", (entries,)),
        Section("The arm, derived", (about, *matrices)),
    ]


def headlines(results: Results) -> list[str]:
    """The findings, one a line."""
    del results
    wrong = [
        f"Equation {EQUATION[e.matrix]} is wrong in {e.label}: printed {text.emit(formula(e.printed))}, "
        f"right {text.emit(formula(e.right))} (witness: {e.witness}; {e.printed_value:.6g} for {e.right_value:.6g})"
        for e in WRONG
    ]
    same = sum(entry.kind == "same" for entry in ENTRIES)
    return [
        *wrong,
        f"{same} of {len(ENTRIES)} entries of (2), (3), (4) are proved right in all states and for all parameters",
        *(f"Assumption 3 ({arm}): {judged.kind}: {judged.evidence}" for arm, judged in SKEW.items()),
        f"Assumption 2 (nominal parameters): {DEFINITE.kind}, {DEFINITE.evidence}; greatest {DEFINITE.alpha2:.6g}",
    ]


study = Study(
    name="a0_two_link_arm",
    title="The two-link arm: are the printed equations right?",
    question="Which entries of the paper's equations (2) to (4) are right, what should the wrong ones be, and do "
    "Assumptions 2 and 3 hold?",
    method="The arm is derived from its energies; each printed entry is compared with the derived one by exact "
    "rational arithmetic on trigonometric polynomials, which proves an identity in all states and all parameters, and "
    "each difference shown at a state that anyone can replay. The eigenvalues of M are sought over the whole torus.",
    sections=sections,
    headlines=headlines,
)
