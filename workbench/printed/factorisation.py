"""Rows of a printed C by their torque C qd, which many matrices share: which entry of a wrong row is the misprint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.printed.comparison import EntryVerdict
from workbench.printed.sheet import Sheet
from workbench.printed.slips import RANKS, Editor, Slip
from workbench.printed.values import Values, varied_values
from workbench.proofs.properties import skew


@dataclass(frozen=True)
class Misprint:
    """The entry of a row of C, by its label, whose single edit makes that row of C qd right."""

    label: str
    slip: Slip


def is_in_full(sheet: Sheet, row: int, joints: int) -> bool:
    """Whether a sheet prints all of a row of C; else what the row makes of qd is open."""
    return all(("C", row, column) in sheet.entries for column in range(1, joints + 1))


def misprints(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived: Dynamics) -> dict[int, Misprint]:
    """The one misprint of each row of C that gives a wrong torque and has several entries unlike the derived ones.

    A row is not in the result if it is not printed in full, or if no edit of one entry repairs it.
    """
    torques = [v for v in verdicts if (v.matrix, v.kind, v.same_torque) == ("C", "differs", "refuted")]
    rows = {row: [v for v in torques if v.row == row] for row in range(1, derived.dof + 1)}
    rows = {row: wrong for row, wrong in rows.items() if len(wrong) > 1 and is_in_full(sheet, row, derived.dof)}
    values = varied_values(derived) if rows else None
    found = {row: _misprint(sheet, wrong, values) for row, wrong in rows.items() if values}
    return {row: misprint for row, misprint in found.items() if misprint is not None}


def _misprint(sheet: Sheet, wrong: Sequence[EntryVerdict], values: Values) -> Misprint | None:
    """The likeliest single edit among the wrong entries of a row that makes its torque right."""
    editor, row = Editor(values.symbols), wrong[0].row
    places = [("C", row, j) for j in range(1, len(values.velocities) + 1)]
    printed = [editor.value(sheet.entries[place]) for place in places]
    right = [values.entries[place] for place in places]
    lacking = np.sum((np.array(right) - np.array(printed)) * values.velocities, axis=0)
    edits = []
    for verdict in wrong:
        j = verdict.column - 1
        slip = editor.slip(sheet.entries[places[j]], printed[j] + lacking / values.velocities[j])
        if slip is not None:
            edits.append(Misprint(verdict.label, slip))
    return min(edits, key=lambda edit: RANKS.index(edit.slip.kind), default=None)


def of_factorisation(verdicts: Sequence[EntryVerdict], derived: Dynamics) -> list[str]:
    """Of another factorisation of the right torque C qd, whether M' - 2C is skew with it, in words."""
    printed = {(v.row, v.column): v for v in verdicts if v.matrix == "C"}
    torques = {v.same_torque for v in printed.values() if v.kind == "differs"}
    if torques != {"proved"}:
        return []
    C = ca.SX(derived.C)
    for (row, column), verdict in printed.items():
        C[row - 1, column - 1] = verdict.printed
    found = skew(replace(derived, C=C))
    said = {"proved": "is skew with it", "refuted": f"is not skew with it, as {found.evidence}"}
    return [f"C is another factorisation of the right torque; M' - 2C {said.get(found.kind, 'may be skew with it')}."]
