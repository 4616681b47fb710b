"""Are the printed equations of the two-link arm right?

Question: the paper prints M, C and G of its arm in equations (2) to (4), and builds its proofs on
Assumption 2 (M is symmetric and positive definite between fixed bounds) and Assumption 3 (M' - 2C is
skew-symmetric). Which entries are right, what should the wrong ones be, and which assumptions hold?

Method: the arm is derived from its energies. Each printed entry is compared with the derived one by
exact rational arithmetic on trigonometric polynomials, which proves an identity in all states and all
parameters; where an entry differs, a state is given at which anyone can see it. The assumptions are
proved or refuted in the same way; the eigenvalues of M are sought over the whole torus.

Runs in: one second.
"""

from __future__ import annotations

from fractions import Fraction

import casadi as ca
import numpy as np

from studies.paper.printed_arm import PrintedArm
from workbench.core import Dynamics
from workbench.notation import text
from workbench.notation.formula import Formula, Number, Power, Product, Relation, Sum, Symbol, entry_symbol, symbol
from workbench.notation.reader import formula_of
from workbench.printed.entry_comparison import EntryVerdict, compare
from workbench.proofs.bounds import shown
from workbench.proofs.properties import (
    DefinitenessVerdict,
    PropertyVerdict,
    eigenvalues_along,
    positive_definite,
    skew,
    symmetric,
)
from workbench.robots import paper_arm
from workbench.study.document.document import (
    Code,
    Column,
    Equation,
    Figure,
    Panel,
    Paragraph,
    Phrase,
    Section,
    Series,
    Strong,
    Table,
    Verdict,
)
from workbench.study.study import Results, Study

DERIVED = Dynamics.of(paper_arm(), "derived from the energies")
PRINTED = Dynamics.of(PrintedArm(), "as printed")
REPAIRED = Dynamics.of(PrintedArm(coriolis="repaired"), "printed, with C[1,2] repaired")

EQUATION = {"M": "(2)", "C": "(3)", "G": "(4)"}
OUTCOME = {"proved": "holds", "refuted": "fails", "not refuted": "open"}
SAME_TORQUE = {
    "proved": "The torque is right all the same: this is another factorisation of it",
    "refuted": "With it the torque is wrong as well",
    "not refuted": "Whether the torque is right all the same is open",
}

ENTRIES = compare(PRINTED, DERIVED)
WRONG = tuple(entry for entry in ENTRIES if entry.kind == "differs")
SKEW = {arm.name: skew(arm) for arm in (PRINTED, REPAIRED, DERIVED)}
SYMMETRIC = {arm.name: symmetric(arm) for arm in (PRINTED, DERIVED)}
DEFINITE = positive_definite(DERIVED)


def formula(expression: ca.SX) -> Formula:
    """An expression in the derived arm's symbols, with the letters of the paper."""
    return formula_of(expression, DERIVED.names())


def sections(results: Results) -> list[Section]:
    """What the report says."""
    del results
    return [derived_equations(), entry_by_entry(), assumptions(), eigenvalues_of_m()]


def derived_equations() -> Section:
    """M, C and G from the CasADi expressions."""
    matrices = {"M": DERIVED.M, "C": DERIVED.C, "G": DERIVED.G}
    return Section(
        "The arm, derived",
        (
            Paragraph(
                "Point masses at the ends of massless links; the first angle is measured from the downward vertical, "
                "the second from the line of the first link. M is the Hessian of the kinetic energy in the "
                "velocities, C the matrix of its Christoffel symbols, G the gradient of the potential energy. These "
                "equations are printed from the expressions that every simulation of this arm runs."
            ),
            *(
                Equation(Relation(symbol(letter), "=", formula(matrix)), name=f"derived_{letter.lower()}")
                for letter, matrix in matrices.items()
            ),
        ),
    )


def entry_by_entry() -> Section:
    """The printed matrices against the derived ones."""
    rows = tuple(
        (
            entry.label,
            EQUATION[entry.matrix],
            formula(entry.printed),
            Strong("differs") if entry in WRONG else entry.kind,
        )
        for entry in ENTRIES
    )
    table = Table(
        "printed_entries",
        "Each entry of the paper's equations (2) to (4), judged against the derived one.",
        (Column("entry"), Column("paper"), Column("printed"), Column("verdict")),
        rows,
        ("same: proved, an identity in all states and all parameters.",),
    )
    blocks = [block for entry in WRONG for block in wrong_entry(entry)]
    return Section("The printed matrices, entry by entry", (table, *blocks))


def wrong_entry(entry: EntryVerdict) -> tuple[Verdict, Equation]:
    """What is wrong with an entry, and the right one."""
    torque = f" {SAME_TORQUE[entry.same_torque]}." if entry.same_torque else ""
    evidence = (
        f"At {entry.witness}, it is {entry.printed_value:.6g} where {entry.right_value:.6g} is right.{torque} ",
        "To replay: ",
        Code(entry.witness.replay if entry.witness else ""),
    )
    place = f"{entry.row}" if entry.matrix == "G" else f"{entry.row}{entry.column}"
    right = Relation(entry_symbol(symbol(entry.matrix), place), "=", formula(entry.right))
    return (
        Verdict(
            "fails", f"The paper's equation {EQUATION[entry.matrix]} is right in its entry {entry.label}.", evidence
        ),
        Equation(right, name=f"right_{entry.matrix.lower()}{place}", note="The right entry."),
    )


def assumptions() -> Section:
    """Assumptions 2 and 3, for the printed and the derived matrices."""
    lines = [verdict(SYMMETRIC[name], f"Assumption 2: M is symmetric ({name}).") for name in SYMMETRIC]
    lines += [
        verdict(
            DEFINITE,
            "Assumption 2: M, as printed and as derived, is positive definite for all q at nominal parameters.",
        )
    ]
    lines += [verdict(SKEW[name], f"Assumption 3: M' - 2C is skew-symmetric ({name}).") for name in SKEW]
    return Section("Assumptions 2 and 3", (*lines, Paragraph(false_power())))


def verdict(found: PropertyVerdict | DefinitenessVerdict, statement: Phrase) -> Verdict:
    """A judgement of `verify` as a line of the report."""
    evidence = found.evidence
    if isinstance(found, PropertyVerdict) and found.residual is not None:
        rows = ", ".join(f"({', '.join(f'{x:.4g}' for x in row)})" for row in found.residual)
        evidence += f", the sum of M' - 2C and its transpose has the rows {rows}"
    return Verdict(OUTCOME[found.kind], statement, f"{evidence[:1].upper()}{evidence[1:]}.".replace("m^2", "m²"))


def false_power() -> Phrase:
    """What a matrix C that is not skew does to the energy balance."""
    found = SKEW[PRINTED.name]
    if found.witness is None or found.residual is None:
        return "The energy balance holds as printed."
    qd = found.witness.qd
    power = float(qd @ found.residual @ qd) / 4
    qd_, M, C = symbol("qd"), Symbol("M", dots=1), symbol("C")
    work = Product((Power(qd_, symbol("T")), Sum((M, Product((Number(Fraction(-2)), C)))), qd_))
    return (
        "Skewness is the energy balance: where it fails, the kinetic energy changes by half of ",
        work,
        f", which no torque has supplied. At {found.witness}, the printed arm is fed {power:.4g} W out of nothing.",
    )


def eigenvalues_of_m() -> Section:
    """The figure, and the bounds of Assumption 2."""
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
    words = (
        "At the nominal parameters ",
        symbol("alpha_1"),
        f" = {DEFINITE.alpha1:.6f} and ",
        symbol("alpha_2"),
        f" = {DEFINITE.alpha2:.6f} (kg m²), both with the arm stretched. Interval "
        f"arithmetic on {DEFINITE.boxes} boxes proves that no eigenvalue lies below {shown(DEFINITE.beyond[0], 1)} or "
        f"above {shown(DEFINITE.beyond[1], -1)} anywhere on the torus, so that {min(DEFINITE.digits)} digits of both "
        "are right. (It takes sines and cosines as right within four units in the last place, or from ball "
        "arithmetic where the extra 'rigorous' is installed.) Where the arm is stretched M has the condition number "
        f"{DEFINITE.alpha2 / DEFINITE.alpha1:.2f}.",
    )
    return Section("The bounds of M", (Figure("eigenvalues_of_m", caption, (panel,)), Paragraph(words)))


def headlines(results: Results) -> list[str]:
    """The findings, one a line."""
    del results
    found = [
        f"Equation {EQUATION[e.matrix]} is wrong in {e.label}: printed {text.emit(formula(e.printed))}, "
        f"right {text.emit(formula(e.right))} (witness: {e.witness}; {e.printed_value:.6g} for {e.right_value:.6g})"
        for e in WRONG
    ]
    same = sum(entry.kind == "same" for entry in ENTRIES)
    return [
        *found,
        f"{same} of {len(ENTRIES)} entries of (2), (3), (4) are proved right in all states and for all parameters",
        *(f"Assumption 3 ({name}): {judged(property_)}" for name, property_ in SKEW.items()),
        f"Assumption 2 (nominal parameters): {DEFINITE.kind}, {DEFINITE.evidence}; greatest {DEFINITE.alpha2:.6g}",
    ]


def judged(found: PropertyVerdict) -> str:
    """A property in a few words."""
    if found.residual is None:
        return f"{found.kind}, {found.evidence}"
    return f"{found.kind} {found.evidence}, where M' - 2C plus its transpose reaches {np.abs(found.residual).max():.4g}"


study = Study(
    name="a0_two_link_arm",
    title="The two-link arm: are the printed equations right?",
    question="Which entries of the paper's equations (2) to (4) are right, what should the wrong ones be, and do "
    "Assumptions 2 and 3 hold?",
    method="The arm is derived from its energies; each printed entry is compared with the derived one by exact "
    "normal forms, and each difference shown at a state that anyone can replay.",
    cases=(),
    sections=sections,
    headlines=headlines,
)
