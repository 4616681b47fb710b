"""What is wrong with the entries that differ: the likely slip, the units, and what several have in common."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.notation import text
from workbench.notation.formula import Sum
from workbench.notation.normal_form import NormalForm, NotInClass
from workbench.notation.reader import formula_of
from workbench.printed.comparison import EntryVerdict
from workbench.printed.digits import agrees_to_its_digits
from workbench.printed.factorisation import misprints
from workbench.printed.sheet import Place, Sheet
from workbench.printed.slips import Editor, Slip
from workbench.printed.units import units_of
from workbench.printed.values import nominal_values, varied_values
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

LONGEST_TO_EXPAND = 300  # operations of an entry; to multiply out a longer one takes seconds
ROUNDED = Slip("rounded", "agrees with the right value to the digits printed, at the nominal parameters")


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """An entry that differs, with the likely slip (None if no single edit repairs it) and what its units say.

    `instead` is the label of the entry of the same row of C that is the misprint, where this one is as legal as
    the derived one; else empty.
    """

    verdict: EntryVerdict
    slip: Slip | None
    units: str
    instead: str = ""


@door
def diagnose(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived: Dynamics) -> dict[str, Diagnosis]:
    """A diagnosis for each verdict that an entry differs, by its label."""
    wrong = [verdict for verdict in verdicts if verdict.kind == "differs"]
    if not wrong:
        return {}
    varied, nominal = varied_values(derived), nominal_values(derived)
    editor, editor_there, right = Editor(varied.symbols), Editor(nominal.symbols), varied.entries
    units, rows = units_of(derived), misprints(sheet, verdicts, derived)
    diagnoses = {}
    for verdict in wrong:
        place = (verdict.matrix, verdict.row, verdict.column)
        printed = sheet.entries[place]
        said = units.mismatch(place, printed) if units else ""
        misprint = rows.get(verdict.row) if verdict.matrix == "C" else None
        if misprint is not None:
            is_this = misprint.label == verdict.label
            slip, instead = (misprint.slip, "") if is_this else (None, misprint.label)
            diagnoses[verdict.label] = Diagnosis(verdict, slip, said, instead)
        else:
            slip = editor.slip(printed, right[place]) or _misplaced(editor.value(printed), place, right)
            if slip is None or slip.kind == "scale":
                rounded = agrees_to_its_digits(printed, nominal.entries[place], editor_there)
                slip = ROUNDED if rounded else slip or _missing(verdict, derived)
            diagnoses[verdict.label] = Diagnosis(verdict, slip, said)
    return diagnoses


@door
def first_wrong(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived: Dynamics) -> EntryVerdict | None:
    """The first misprint: no entry of C that is as legal as the derived one, in its row or once that is corrected."""
    serious = [v for v in verdicts if v.kind == "differs" and v.same_torque != "proved"]
    rows = misprints(sheet, serious, derived)
    return next((v for v in serious if v.matrix != "C" or v.row not in rows or rows[v.row].label == v.label), None)


@door
def in_common(verdicts: Sequence[EntryVerdict], diagnoses: Mapping[str, Diagnosis]) -> list[str]:
    """What the wrong entries of a matrix share, in words: a sign of the whole matrix, say."""
    said = []
    for matrix in "MCG":
        wrong = [diagnoses[v.label] for v in verdicts if v.matrix == matrix and v.label in diagnoses]
        entries = [v for v in verdicts if v.matrix == matrix and not _is_zero(v)]
        slips = [
            found.slip
            for found in wrong
            if found.slip and found.slip == Slip("sign", "the whole entry has the wrong sign")
        ]
        if len(entries) > 1 and len(slips) == len(wrong) == len(entries):
            said.append(f"{matrix} as a whole has the wrong sign.")
    return said


def _is_zero(verdict: EntryVerdict) -> bool:
    return bool(ca.SX(verdict.right).is_zero())


def _misplaced(printed: Array, place: Place, right: Mapping[Place, Array]) -> Slip | None:
    """Whether another entry of the derived matrices stands here."""
    for other, values in sorted(right.items()):
        if other != place and np.allclose(printed, values, rtol=1e-9, atol=0) and np.any(values != 0):
            label = f"G[{other[1]}]" if other[0] == "G" else f"{other[0]}[{other[1]},{other[2]}]"
            return Slip("term", f"this is {label}, printed in another place")
    return None


def _missing(verdict: EntryVerdict, derived: Dynamics) -> Slip | None:
    """The term that an entry lacks, if it is one, or shorter than the entry."""
    if ca.SX(verdict.printed).is_zero():
        return Slip("term", "the whole entry is missing")
    if ca.SX(verdict.right).is_zero():
        return Slip("extra", "it does not belong here: 0 is right")
    if ca.n_nodes(ca.vertcat(verdict.printed, verdict.right)) > LONGEST_TO_EXPAND:
        return None
    try:
        lacking, whole = (len(NormalForm.of(entry).terms) for entry in (verdict.difference, verdict.right))
    except NotInClass:
        return None
    if lacking > 1 and lacking >= whole:
        return None
    term = formula_of(-verdict.difference, derived.names())
    return None if isinstance(term, Sum) else Slip("term", f"the term {text.emit(term)} is missing")
