"""A paper's printed M, C and G against the derived ones, entry by entry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import casadi as ca

from workbench.core import Dynamics
from workbench.core.layout import nearest
from workbench.notation.parsing.evaluate import CASADI, evaluate
from workbench.verify.given import symbols_of
from workbench.verify.identity import Kind, judge_zero
from workbench.verify.sheet import Place, Sheet
from workbench.verify.witness import Witness

Sameness = Literal["same", "differs", "not refuted"]
SAMENESS: dict[Kind, Sameness] = {"proved": "same", "refuted": "differs", "not refuted": "not refuted"}


@dataclass(frozen=True, eq=False)
class EntryVerdict:
    """One printed entry beside the derived one.

    Attributes
    ----------
    matrix, row, column
        Where the entry stands, counted from 1 as a paper counts; a vector has column 1.
    kind
        `same` if the two are equal by normal form; `differs` if a witness shows it; `not refuted` if
        neither was possible.
    printed, right, difference
        Expressions in the derived arm's symbols; difference = printed - right.
    witness, printed_value, right_value
        A state at which they differ, and the two values there; None where they were not seen to.
    same_torque
        For an entry of C that differs: whether row i of (C_printed - C_right) qd is zero all the same.
        `proved`: another legal factorisation of the same torque; `refuted`: a wrong torque. Else None.
    """

    matrix: str
    row: int
    column: int
    kind: Sameness
    evidence: str
    printed: ca.SX
    right: ca.SX
    difference: ca.SX
    witness: Witness | None = None
    printed_value: float | None = None
    right_value: float | None = None
    same_torque: Kind | None = None

    @property
    def label(self) -> str:
        """The entry as a paper names it: `C[1,2]`, or `G[1]`."""
        return f"G[{self.row}]" if self.matrix == "G" else f"{self.matrix}[{self.row},{self.column}]"


def compare(printed: Dynamics, derived: Dynamics) -> tuple[EntryVerdict, ...]:
    """A verdict for each entry of M, C and G, row by row; parameters are matched by name.

    `same` holds in all states and for all parameters, not only the nominal ones.

    Raises
    ------
    ValueError
        If the two arms have different numbers of joints.
    LookupError
        If the printed matrices have a parameter that the derived ones lack.
    """
    theirs = _matrices_in_symbols_of(derived, printed)
    shapes = {name: matrix.shape for name, matrix in theirs.items()}
    places = [(name, i, j) for name, (rows, columns) in shapes.items() for i in range(rows) for j in range(columns)]
    return judged({(name, i + 1, j + 1): theirs[name][i, j] for name, i, j in places}, derived)


def compare_sheet(sheet: Sheet, derived: Dynamics) -> tuple[EntryVerdict, ...]:
    """A verdict for each entry that a sheet prints."""
    symbols = {symbol.name(): symbol for symbol in ca.vertsplit(ca.vertcat(derived.q, derived.qd, derived.symbols))}
    values = {letter: symbols[name] for letter, name in symbols_of(derived).items()}
    return judged({place: ca.SX(evaluate(f, values, CASADI)) for place, f in sheet.entries.items()}, derived)


def judged(printed: Mapping[Place, ca.SX], derived: Dynamics) -> tuple[EntryVerdict, ...]:
    """A verdict for each of the printed entries, which are expressions in the derived arm's symbols.

    Where a row of C is printed in part, its other entries are taken to be the derived ones.

    Raises
    ------
    ValueError
        If a printed entry is finite nowhere.
    """
    return tuple(_entry(place, printed, derived) for place in printed)


def _entry(place: Place, printed: Mapping[Place, ca.SX], dynamics: Dynamics) -> EntryVerdict:
    name, row, column = place
    right = {"M": dynamics.M, "C": dynamics.C, "G": dynamics.G}[name][row - 1, column - 1]
    a, b = printed[place], right
    judgement = judge_zero(a - b, ca.vertcat(a, b), dynamics)
    if judgement.search and not judgement.search.samples:
        raise ValueError(
            f"the printed {name}[{row},{column}] is a number at none of the states that were tried, so it cannot be "
            "compared; look for a division by zero, or the root of a negative number."
        )
    found = judgement.search.witness if judgement.search else None
    if found is None:
        return EntryVerdict(*place, SAMENESS[judgement.kind], judgement.evidence, a, b, a - b)
    values = ca.Function("values", [dynamics.q, dynamics.qd, dynamics.symbols], [a, b])(found.q, found.qd, found.p)
    return EntryVerdict(
        *place,
        SAMENESS[judgement.kind],
        judgement.evidence,
        a,
        b,
        a - b,
        found,
        float(values[0]),
        float(values[1]),
        _same_torque(row, printed, dynamics) if name == "C" else None,
    )


def _same_torque(row: int, printed: Mapping[Place, ca.SX], dynamics: Dynamics) -> Kind:
    """Whether a printed row of C gives the derived torque, by whatever entries."""
    right = [dynamics.C[row - 1, j] for j in range(dynamics.dof)]
    theirs = [printed.get(("C", row, j + 1), entry) for j, entry in enumerate(right)]
    torques = [ca.horzcat(*entries) @ dynamics.qd for entries in (theirs, right)]
    return judge_zero(torques[0] - torques[1], ca.vertcat(*torques), dynamics).kind


def _matrices_in_symbols_of(derived: Dynamics, printed: Dynamics) -> dict[str, ca.SX]:
    """The printed matrices with each of their symbols replaced by the derived arm's of the same name."""
    if printed.dof != derived.dof:
        raise ValueError(
            f"`compare(printed, derived)` needs arms of the same number of joints, for their matrices to have "
            f"the same entries; got {printed.dof} printed and {derived.dof} derived."
        )
    for label in printed.p.labels:
        if label not in derived.p.labels:
            raise LookupError(
                f"`compare(printed, derived)` matches parameters by name, and the derived arm has no '{label}'."
                + (nearest(label, derived.p.labels) or f" It has: {', '.join(derived.p.labels)}.")
            )
    places = [derived.p.labels.index(label) for label in printed.p.labels]
    old = ca.vertcat(printed.q, printed.qd, printed.symbols)
    new = ca.vertcat(derived.q, derived.qd, derived.symbols[places] if places else ca.SX(0, 1))
    matrices = ca.substitute([printed.M, printed.C, printed.G], [old], [new])
    return dict(zip("MCG", matrices, strict=True))
