"""A paper's printed M, C and G against the derived ones, entry by entry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import casadi as ca

from workbench.core import Dynamics
from workbench.core.layout import nearest
from workbench.verify.identity import Kind, judge_zero
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
    ours = {"M": derived.M, "C": derived.C, "G": derived.G}
    return tuple(
        _entry(name, i, j, theirs[name], ours[name], derived)
        for name in ours
        for i in range(derived.dof)
        for j in range(ours[name].shape[1])
    )


def _entry(name: str, i: int, j: int, printed: ca.SX, right: ca.SX, dynamics: Dynamics) -> EntryVerdict:
    a, b = printed[i, j], right[i, j]
    judgement = judge_zero(a - b, ca.vertcat(a, b), dynamics)
    place = (name, i + 1, j + 1)
    found = judgement.search.witness if judgement.search else None
    if found is None:
        return EntryVerdict(*place, SAMENESS[judgement.kind], judgement.evidence, a, b, a - b)
    values = ca.Function("values", [dynamics.q, dynamics.qd, dynamics.symbols], [a, b])(found.q, found.qd, found.p)
    same_torque = None
    if name == "C":
        torques = [matrix[i, :] @ dynamics.qd for matrix in (printed, right)]
        same_torque = judge_zero(torques[0] - torques[1], ca.vertcat(*torques), dynamics).kind
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
        same_torque,
    )


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
