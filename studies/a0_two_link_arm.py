"""Are the printed equations of the two-link arm right?

Runs in: one second.
"""

from typing import Literal

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.citation import introduction
from studies.paper.two_link_arm import (
    DEFINITE,
    DERIVED_DYNAMICS,
    ENTRIES,
    PRINTED_DYNAMICS,
    REPAIRED_DYNAMICS,
    SKEW,
    SYMMETRIC,
    WRONG,
    proved_bounds,
)

EQUATION = {"M": "(2)", "C": "(3)", "G": "(4)"}
OUTCOME: dict[str, Literal["holds", "fails", "open"]] = {"proved": "holds", "refuted": "fails", "not refuted": "open"}
TORQUE = {"proved": "right all the same", "refuted": "wrong as well", "not refuted": "open"}


def formula(expression: ca.SX) -> wb.notation.Formula:
    """An expression in the derived arm's symbols, with the letters of the paper."""
    return wb.notation.formula_of(expression, DERIVED_DYNAMICS.names())


def wrong_entry(entry: wb.arms.paper_equations.EntryVerdict) -> tuple[wb.document.Verdict, wb.document.Equation]:
    """The witness against an entry, and the right one."""
    statement = f"The paper's equation {EQUATION[entry.matrix]} is right in its entry {entry.label}."
    evidence = (
        f"At {entry.witness}, the printed entry is {entry.printed_value:.6g}, and the right value is "
        f"{entry.right_value:.6g}. The torque with the printed entry is {TORQUE[entry.same_torque or 'not refuted']}. "
        "To replay: ",
        wb.document.Code(entry.witness.replay if entry.witness else ""),
    )
    place = f"{entry.row}" if entry.matrix == "G" else f"{entry.row}{entry.column}"
    right = wb.notation.Relation(
        wb.notation.entry_symbol(wb.notation.symbol(entry.matrix), place), "=", formula(entry.right)
    )
    equation = wb.document.Equation(right, name=f"right_{entry.matrix.lower()}{place}", note="The right entry.")
    return wb.document.Verdict("fails", statement, evidence), equation


def verdict(property_verdict: wb.arms.properties.PropertyVerdict, statement: str) -> wb.document.Verdict:
    """A judgement of `proofs` on the page; where M' - 2C is not skew, with the power that comes from nowhere."""
    evidence = property_verdict.evidence
    if property_verdict.residual is not None and property_verdict.witness is not None:
        qd = property_verdict.witness.qd
        evidence += (
            ". The kinetic energy changes at a rate of half of qd' (M' - 2C) qd, which no torque supplies: "
            f"{float(qd @ property_verdict.residual @ qd) / 4:.4g} W"
        )
    return wb.document.Verdict(
        OUTCOME[property_verdict.kind], statement, f"{evidence[:1].upper()}{evidence[1:]}.".replace("m^2", "m²")
    )


def eigenvalues() -> tuple[wb.document.Figure, wb.document.Verdict]:
    """The eigenvalues of M over the second joint angle, and the bounds of Assumption 2."""
    angles = np.linspace(-np.pi, np.pi, 361)
    least, greatest = wb.arms.properties.eigenvalues_along(DERIVED_DYNAMICS, 2, angles).T
    panel = wb.document.Panel(
        "eigenvalues of M [kg m²]",
        (
            wb.document.Series("greatest", angles, greatest, style=0),
            wb.document.Series("least", angles, least, style=1),
        ),
        xlabel="second joint angle [rad]",
        xlim=(-np.pi, np.pi),
        hlines=(DEFINITE.alpha1, DEFINITE.alpha2),
    )
    caption = (
        "Eigenvalues of M over the second joint angle; M does not depend on the first. Thin lines: the least and the "
        "greatest eigenvalue."
    )
    statement = "Assumption 2: M, as printed and as derived, is positive definite for all q at nominal parameters."
    low, high = proved_bounds()
    bounds = (
        f"alpha_1 = {DEFINITE.alpha1:.6f} and alpha_2 = {DEFINITE.alpha2:.6f} kg m², both with the arm stretched. "
        f"Intervals on {DEFINITE.boxes} boxes prove that no eigenvalue lies below {wb.proofs.bound_text(low, 1)} or "
        f"above {wb.proofs.bound_text(high, -1)} anywhere on the torus, so {min(DEFINITE.digits)} digits of both are "
        "right. The proof takes sines and cosines as right within four units in the last place, or has them from ball "
        "arithmetic if the extra 'rigorous' is installed."
    )
    return wb.document.Figure("eigenvalues_of_m", caption, (panel,)), wb.document.Verdict(
        OUTCOME[DEFINITE.kind], statement, bounds
    )


def entry_finding() -> wb.Finding:
    """The wrong entries of (2) to (4), each judged by itself and by the torque that it gives."""
    wrong = tuple(_place(entry) for entry in WRONG)
    by_torque = tuple(_place(entry) for entry in ENTRIES if entry in WRONG and entry.same_torque != "proved")
    return wb.Finding(
        "wrong_entry",
        f"Of the {len(ENTRIES)} printed entries of (2) to (4), {len(ENTRIES) - len(WRONG)} are right; "
        f"{' and '.join(wrong)} {'is' if len(wrong) == 1 else 'are'} wrong.",
        "Each right entry is proved equal to the derived entry for all states and parameters, by exact rational "
        "arithmetic. A wrong entry is shown below at a state that anyone can replay.",
        statistic="The difference between a printed and a derived entry, as an identity.",
        sample="All entries of M, C and G.",
        information="Point masses at the ends of massless links, and the angles of the paper.",
        assumptions="C is derived by Christoffel symbols.",
        answer=", ".join(wrong),
        variations=(wb.Variation("entries of C judged by the torque C qd", ", ".join(by_torque) or "none"),),
    )


def _place(entry: wb.arms.paper_equations.EntryVerdict) -> str:
    return f"{entry.label} of {EQUATION[entry.matrix]}"


def skewness_finding() -> wb.Finding:
    """Assumption 3 for the printed arm, the repaired one and the derived one."""
    answers = {arm: "true" if judged.kind == "proved" else "false" for arm, judged in SKEW.items()}
    return wb.Finding(
        "assumption_3",
        f"Assumption 3, that M' - 2C is skew-symmetric, is {answers[PRINTED_DYNAMICS.name]} for (3) as printed and "
        f"{answers[REPAIRED_DYNAMICS.name]} with the right C[1,2].",
        verdict(SKEW[PRINTED_DYNAMICS.name], "").evidence,
        statistic="The symmetric part of M' - 2C.",
        sample="Proved for all states and parameters, or refuted at one state.",
        information="M as printed, which is right.",
        answer=answers[PRINTED_DYNAMICS.name],
    )


def answer_line() -> str:
    """The answer of the page in one line."""
    right = len(ENTRIES) - len(WRONG)
    skew = {arm: "holds" if judged.kind == "proved" else "fails" for arm, judged in SKEW.items()}
    return (
        f"Of the {len(ENTRIES)} printed entries of (2) to (4), {right} are right. "
        f"{' and '.join(map(_place, WRONG))} {'is' if len(WRONG) == 1 else 'are'} wrong: as printed, Assumption 3 "
        f"{skew[PRINTED_DYNAMICS.name]}; with the right entry, Assumption 3 {skew[REPAIRED_DYNAMICS.name]}."
    )


def page(results: wb.Results) -> wb.Page:
    """The findings, the entries behind them, and the derived matrices."""
    del results
    skewness = (verdict(judged, f"Assumption 3: M' - 2C is skew-symmetric ({arm}).") for arm, judged in SKEW.items())
    symmetry = (verdict(judged, f"Assumption 2: M is symmetric ({arm}).") for arm, judged in SYMMETRIC.items())
    wrong = (block for entry in WRONG for block in wrong_entry(entry))
    picture, bounds = eigenvalues()
    rows = tuple(
        (e.label, EQUATION[e.matrix], formula(e.printed_entry), wb.document.Strong("differs") if e in WRONG else e.kind)
        for e in ENTRIES
    )
    entries = wb.document.ReportTable(
        "printed_entries",
        "Each printed entry of the equations (2) to (4), compared with the derived entry.",
        (
            wb.document.TableColumn("entry"),
            wb.document.TableColumn("paper"),
            wb.document.TableColumn("printed"),
            wb.document.TableColumn("verdict"),
        ),
        rows,
        ("'same' is proved: an identity in all states and all parameters.",),
    )
    about = wb.Paragraph(
        "The arm has point masses at the ends of massless links. The first angle is measured from the downward "
        "vertical, the second from the line of the first link. All simulations of this arm use the expressions from "
        "which these equations are printed."
    )
    matrices = (
        wb.document.Equation(
            wb.notation.Relation(wb.notation.symbol(letter), "=", formula(getattr(DERIVED_DYNAMICS, letter))),
            name=f"derived_{letter.lower()}",
        )
        for letter in "MCG"
    )
    sections = (
        wb.Section("The claims", (picture, *wrong, bounds, *symmetry, *skewness)),
        wb.Section("The printed matrices, entry by entry", (entries,)),
        wb.Section("The derived arm", (about, *matrices)),
    )
    return wb.Page(answer_line(), (entry_finding(), skewness_finding()), sections)


study = wb.Study(
    name="a0_two_link_arm",
    title="The two-link arm: are the printed equations right?",
    question="Which entries of the equations (2) to (4) are right? Which entries should replace the wrong ones? Do "
    "Assumptions 2 and 3 hold?",
    method=f"{introduction(2, 3, 4, rivals=False)} The arm is derived from its energies. Each printed entry is "
    "compared with the derived entry by exact rational arithmetic on trigonometric polynomials, which proves an "
    "identity in all states and all parameters. A difference is shown at a state that anyone can replay. The "
    "eigenvalues of M are bounded over the whole torus.",
    sections=page,
)
