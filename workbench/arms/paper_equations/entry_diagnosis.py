"""The likely cause of each entry that differs: a slip, its units, or another factorisation of the torque C qd."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import casadi as ca
import numpy as np

from workbench.arms.dynamics import Dynamics
from workbench.arms.identity_proofs import Witness, candidates
from workbench.arms.paper_equations.entry_comparison import EntryVerdict
from workbench.arms.paper_equations.entry_units import units_of
from workbench.arms.paper_equations.misprint_edits import LONGEST, RANKS, Editor, Slip
from workbench.arms.paper_equations.printed_equations import Place, Sheet
from workbench.arms.properties import skew
from workbench.core.notation import text
from workbench.core.notation.build import parts, rebuilt
from workbench.core.notation.formula import Formula, Number, Power, Sum, children
from workbench.core.notation.loop_recursions import formula_of
from workbench.core.notation.normal_form import NormalForm, NotInClass
from workbench.core.validation.refusals import Array

STATES = 8  # two equations agree by chance at one, not at so many
LONGEST_TO_EXPAND = 300  # operations of an entry; to multiply out a longer one takes seconds
ROUNDED_VALUE = Slip("rounded", "agrees with the right value to the digits printed, at the nominal parameters")
SHORT, FULL = 6, 17  # significant digits: what one reads at a glance, and what tells any two doubles apart
MOST_DECIMALS = 15
ROUNDING = 1e-12  # of the room that the digits leave, for that of doubles


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """An entry that differs, with the likely slip (None if no single edit repairs it) and the fault in its units.

    `instead` is the label of the entry of the same row of C that is the misprint, where this one is as legal as
    the derived one; else empty.
    """

    verdict: EntryVerdict
    slip: Slip | None
    units: str
    instead: str = ""


def diagnose(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived_dynamics: Dynamics) -> dict[str, Diagnosis]:
    """A diagnosis for each verdict that an entry differs, by its label."""
    wrong = [verdict for verdict in verdicts if verdict.kind == "differs"]
    if not wrong:
        return {}
    varied, nominal = (
        Editor.near(_varied_states(derived_dynamics), derived_dynamics),
        Editor.near(candidates(derived_dynamics)[:STATES], derived_dynamics),
    )
    units, rows = units_of(derived_dynamics), misprints(sheet, verdicts, derived_dynamics)
    diagnoses = {}
    for verdict in wrong:
        place = (verdict.matrix, verdict.row, verdict.column)
        printed = sheet.entries[place]
        mismatch = units.mismatch(place, printed) if units else ""
        misprint = rows.get(verdict.row) if verdict.matrix == "C" else None
        if misprint is not None:
            is_this = misprint.label == verdict.label
            slip, instead = (misprint.slip, "") if is_this else (None, misprint.label)
            diagnoses[verdict.label] = Diagnosis(verdict, slip, mismatch, instead)
        else:
            slip = varied.slip(printed, varied.entries[place])
            slip = slip or _misplaced_entry(varied.value(printed), place, varied.entries)
            if slip is None or slip.kind == "scale":
                rounded = _agrees_to_its_digits(printed, nominal.entries[place], nominal)
                slip = ROUNDED_VALUE if rounded else slip or _missing_term(verdict, derived_dynamics)
            diagnoses[verdict.label] = Diagnosis(verdict, slip, mismatch)
    return diagnoses


def first_wrong(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived_dynamics: Dynamics) -> EntryVerdict | None:
    """The first misprint: an entry that differs, not counting those of C that are right once another is corrected."""
    serious = [v for v in verdicts if v.kind == "differs" and v.same_torque != "proved"]
    rows = misprints(sheet, serious, derived_dynamics)
    return next((v for v in serious if v.matrix != "C" or v.row not in rows or rows[v.row].label == v.label), None)


def in_common(verdicts: Sequence[EntryVerdict], diagnoses: Mapping[str, Diagnosis]) -> list[str]:
    """The matrices of which each entry that is not zero has the wrong sign, in words."""
    turned = Slip("sign", "the whole entry has the wrong sign")
    shared = []
    for matrix in "MCG":
        wrong = [diagnoses[v.label].slip for v in verdicts if v.matrix == matrix and v.label in diagnoses]
        entries = [v for v in verdicts if v.matrix == matrix and not ca.SX(v.right).is_zero()]
        if len(entries) > 1 and len(wrong) == len(entries) and all(slip == turned for slip in wrong):
            shared.append(f"{matrix} as a whole has the wrong sign.")
    return shared


def distinct_texts(one: float, other: float) -> tuple[str, str]:
    """Two numbers as text, with enough digits to show that they differ, six at least."""
    for digits in range(SHORT, FULL + 1):
        pair = f"{one:.{digits}g}", f"{other:.{digits}g}"
        if pair[0] != pair[1]:
            break
    return pair


@dataclass(frozen=True)
class Misprint:
    """The entry of a row of C, by its label, whose single edit makes that row of C qd right."""

    label: str
    slip: Slip


def is_in_full(sheet: Sheet, row: int, joints: int) -> bool:
    """True if a sheet prints all entries of a row of C, so that its product with qd is known."""
    return all(("C", row, column) in sheet.entries for column in range(1, joints + 1))


def misprints(sheet: Sheet, verdicts: Sequence[EntryVerdict], derived_dynamics: Dynamics) -> dict[int, Misprint]:
    """The misprint of each row of C in full, with a wrong torque and several wrong entries, that one edit repairs."""
    torques = [v for v in verdicts if (v.matrix, v.kind, v.same_torque) == ("C", "differs", "refuted")]
    rows = {row: [v for v in torques if v.row == row] for row in range(1, derived_dynamics.dof + 1)}
    rows = {
        row: wrong for row, wrong in rows.items() if len(wrong) > 1 and is_in_full(sheet, row, derived_dynamics.dof)
    }
    editor = Editor.near(_varied_states(derived_dynamics), derived_dynamics) if rows else None
    found = {row: _misprint(sheet, wrong, editor) for row, wrong in rows.items() if editor}
    return {row: misprint for row, misprint in found.items() if misprint is not None}


def _varied_states(derived_dynamics: Dynamics) -> Sequence[Witness]:
    """Some states with parameters of their own."""
    return candidates(derived_dynamics)[-STATES:]


def _misprint(sheet: Sheet, wrong: Sequence[EntryVerdict], editor: Editor) -> Misprint | None:
    places = [("C", wrong[0].row, j) for j in range(1, len(editor.velocities) + 1)]
    printed = [editor.value(sheet.entries[place]) for place in places]
    right = [editor.entries[place] for place in places]
    lacking = np.sum((np.array(right) - np.array(printed)) * editor.velocities, axis=0)
    edits = []
    for verdict in wrong:
        j = verdict.column - 1
        slip = editor.slip(sheet.entries[places[j]], printed[j] + lacking / editor.velocities[j])
        if slip is not None:
            edits.append(Misprint(verdict.label, slip))
    return min(edits, key=lambda edit: RANKS.index(edit.slip.kind), default=None)


def of_factorisation(verdicts: Sequence[EntryVerdict], derived_dynamics: Dynamics) -> list[str]:
    """The skewness of M' - 2C with another factorisation of the right torque C qd, in words."""
    printed = {(v.row, v.column): v for v in verdicts if v.matrix == "C"}
    torques = {v.same_torque for v in printed.values() if v.kind == "differs"}
    if torques != {"proved"}:
        return []
    C = ca.SX(derived_dynamics.C)
    for (row, column), verdict in printed.items():
        C[row - 1, column - 1] = verdict.printed_entry
    found = skew(replace(derived_dynamics, C=C))
    words = {"proved": "is skew with it", "refuted": f"is not skew with it, as {found.evidence}"}
    return [f"C is another factorisation of the right torque; M' - 2C {words.get(found.kind, 'may be skew with it')}."]


def _misplaced_entry(printed_values: Array, place: Place, right: Mapping[Place, Array]) -> Slip | None:
    for other, values in sorted(right.items()):
        if other != place and np.allclose(printed_values, values, rtol=1e-9, atol=0) and np.any(values != 0):
            label = f"G[{other[1]}]" if other[0] == "G" else f"{other[0]}[{other[1]},{other[2]}]"
            return Slip("term", f"this is {label}, printed in another place")
    return None


def _missing_term(verdict: EntryVerdict, derived_dynamics: Dynamics) -> Slip | None:
    """The slip of an entry that lacks one term, or is missing or superfluous as a whole; None for any other."""
    if ca.SX(verdict.printed_entry).is_zero():
        return Slip("term", "the whole entry is missing")
    if ca.SX(verdict.right).is_zero():
        return Slip("extra", "it does not belong here: 0 is right")
    if ca.n_nodes(ca.vertcat(verdict.printed_entry, verdict.right)) > LONGEST_TO_EXPAND:
        return None
    try:
        lacking, whole = (len(NormalForm.of(entry).terms) for entry in (verdict.difference, verdict.right))
    except NotInClass:
        return None
    if lacking > 1 and lacking >= whole:
        return None
    term = formula_of(-verdict.difference, derived_dynamics.names())
    return None if isinstance(term, Sum) else Slip("term", f"the term {text.emit(term)} is missing")


def _agrees_to_its_digits(formula: Formula, right: Array, editor: Editor) -> bool:
    """True if a formula is right (K,) once each of its decimals of two digits may be off by half a unit of the last."""
    if sum(1 for _ in parts(formula)) > LONGEST:
        return False
    value = editor.value(formula)
    room = sum((np.abs(editor.value(moved) - value) for moved in _move_decimals(formula)), np.zeros_like(value))
    return bool(np.all(np.isfinite(value) & (room > 0) & (np.abs(value - right) <= room * (1 + ROUNDING))))


def _move_decimals(formula: Formula) -> Iterator[Formula]:
    """The formula with one of its decimal numbers half a unit of the last digit larger, for each of them."""
    match formula:
        case Number(Fraction() as value):
            if (half := _half_a_unit(value)) is not None:
                yield Number(value + half)
        case Power(base, exponent):
            for moved in _move_decimals(base):
                yield rebuilt(formula, [moved, exponent])
        case _:
            among = list(children(formula))
            for i, part in enumerate(among):
                for moved in _move_decimals(part):
                    yield rebuilt(formula, [*among[:i], moved, *among[i + 1 :]])


def _half_a_unit(value: Fraction) -> Fraction | None:
    """Half a unit of the last decimal of a number of two digits or more; None for a number taken as exact."""
    for decimals in range(1, MOST_DECIMALS + 1):
        scaled = value * 10**decimals
        if scaled.denominator == 1:
            return Fraction(1, 2 * 10**decimals) if value.denominator > 1 and abs(scaled) >= 10 else None
    return None
