"""What is wrong with the entries that differ: the likely slip, the units, and what several have in common."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Dynamics
from workbench.core.layout import Array
from workbench.core.show import formula_of
from workbench.notation import text
from workbench.notation.formula import Sum, Symbol
from workbench.notation.normal_form import NormalForm, NotInClass
from workbench.verify.given import symbols_of
from workbench.verify.printed import EntryVerdict
from workbench.verify.properties import skew
from workbench.verify.sheet import Place, Sheet
from workbench.verify.slips import Editor, Slip
from workbench.verify.units import units_of
from workbench.verify.witness import candidates

STATES = 8  # at which an edit must give the right value: two equations agree by chance at one, not at so many


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """An entry that differs, with the likely slip (None if no single edit repairs it) and what its units say."""

    verdict: EntryVerdict
    slip: Slip | None
    units: str


def diagnose(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived: Dynamics) -> dict[str, Diagnosis]:
    """A diagnosis for each verdict that an entry differs, by its label."""
    wrong = [verdict for verdict in verdicts if verdict.kind == "differs"]
    if not wrong:
        return {}
    values, right = _at_states(derived)
    editor, units = Editor(values), units_of(derived)
    diagnoses = {}
    for verdict in wrong:
        place = (verdict.matrix, verdict.row, verdict.column)
        printed = sheet.entries[place]
        slip = editor.slip(printed, right[place]) or _misplaced(editor.value(printed), place, right)
        said = units.mismatch(place, printed) if units else ""
        diagnoses[verdict.label] = Diagnosis(verdict, slip or _missing(verdict, derived), said)
    return diagnoses


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


def _is_zero(verdict: EntryVerdict) -> bool:
    return bool(ca.SX(verdict.right).is_zero())


def _at_states(derived: Dynamics) -> tuple[dict[Symbol, Array], dict[Place, Array]]:
    """The values of all symbols and of all derived entries at some states and parameters, each (K,)."""
    states = candidates(derived)[-STATES:]
    q, qd, p = (np.stack([getattr(state, name) for state in states], axis=1) for name in ("q", "qd", "p"))
    off = 0.01 * np.sqrt(np.arange(2.0, 2.0 + q.size)).reshape(q.shape)  # sums of round numbers vanish
    q, qd = q + off, qd + off
    names = [s.name() for s in ca.vertsplit(ca.vertcat(derived.q, derived.qd, derived.symbols))]
    rows = dict(zip(names, np.vstack([q, qd, p]), strict=True))
    values = {letter: rows[name] for letter, name in symbols_of(derived).items()}
    right: dict[Place, Array] = {}
    for name, matrix in (("M", derived.M), ("C", derived.C), ("G", derived.G)):
        numbers = np.array(ca.Function("entries", [derived.q, derived.qd, derived.symbols], [ca.vec(matrix)])(q, qd, p))
        for k, row in enumerate(numbers):
            right[name, k % matrix.shape[0] + 1, k // matrix.shape[0] + 1] = row
    return values, right


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
    try:
        lacking, whole = (len(NormalForm.of(entry).terms) for entry in (verdict.difference, verdict.right))
    except NotInClass:
        return None
    if lacking > 1 and lacking >= whole:
        return None
    term = formula_of(-verdict.difference, derived.names())
    return None if isinstance(term, Sum) else Slip("term", f"the term {text.emit(term)} is missing")
