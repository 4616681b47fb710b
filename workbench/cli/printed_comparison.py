"""The comparison of a file of printed equations with those of an arm: a finding for each entry."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import casadi as ca

from workbench.arms.code.arm_equations import as_text
from workbench.arms.dynamics import Dynamics
from workbench.arms.paper_equations.arm_letters import fix_parameters
from workbench.arms.paper_equations.entry_comparison import EntryVerdict, Sameness, compare_sheet
from workbench.arms.paper_equations.entry_diagnosis import (
    Diagnosis,
    diagnose,
    distinct_texts,
    in_common,
    is_in_full,
    of_factorisation,
)
from workbench.arms.paper_equations.printed_equations import Sheet, read_sheet
from workbench.arms.paper_equations.statements import Language
from workbench.arms.paper_equations.tokens import MOST_CHARACTERS
from workbench.core.notation import text
from workbench.core.notation.loop_recursions import formula_of
from workbench.core.validation.signatures import check_arguments

TORQUE = {
    "proved": "C qd is right all the same: another factorisation of it",
    "refuted": "C qd is wrong as well",
    "not refuted": "whether C qd is right all the same is open",
}
IN_PART = "this row of C is not printed in full, so whether C qd is right is open"
INDENT = 11
MOST_ZEROS = 8  # that are told by name
MOST_LINES, MOST_OPERATIONS = 12, 300  # of a right side: more is no line to be compared by eye
LONGER = "longer than can be compared by eye; see `workbench derive`"


class VerdictText(NamedTuple):
    """The verdict on one entry, or on the whole sheet, as lines of text: the verdict, then the details."""

    kind: Sameness | None
    lines: list[str]


@check_arguments
def findings(file: Path, robot: Dynamics) -> list[VerdictText]:
    """A finding for each entry that a file prints, and one at the end for all of them.

    A sheet that is too long to be judged is compared with the one that `workbench derive` prints, sign by sign.

    Raises
    ------
    LookupError
        If there is no such file.
    ValueError
        If it is no text, or no sheet of equations; the message begins with its name.
    """
    content = _content(file)
    try:
        sheet = read_sheet(content, robot, _language(file, content))
        derived = fix_parameters(robot, sheet.fixed_values)
        verdicts = compare_sheet(sheet, derived)
    except ValueError as error:
        if _plain(content) == _plain(as_text(robot)):
            return _as_printed(robot)
        raise ValueError(f"{file}: {error}") from None
    diagnoses = diagnose(sheet, verdicts, derived)
    entries = [_finding(verdict, diagnoses.get(verdict.label), sheet, derived) for verdict in verdicts]
    shared = [*in_common(verdicts, diagnoses), *of_factorisation(verdicts, derived)]
    return [*entries, VerdictText(None, [*_summary(verdicts, robot, sheet), *shared])]


def _content(file: Path) -> str:
    if not file.is_file():
        raise LookupError(f"There is no file '{file}'; name a file of equations, .txt or .tex.")
    most = 4 * MOST_CHARACTERS  # bytes
    with file.open("rb") as handle:  # what is no file of a disk may have a size of 0, and no end
        content = handle.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{file}: equations take at most {MOST_CHARACTERS} characters; this file has more.")
    try:  # editors may put a mark before the text
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        raise ValueError(f"{file}: it is no text in UTF-8 (byte {error.start}); save the equations as text.") from None


def _plain(content: str) -> str:
    return "".join(re.sub("#.*", "", content).split())


def _as_printed(robot: Dynamics) -> list[VerdictText]:
    """The findings for a sheet too long to be judged that is, sign for sign, the one derived for the robot."""
    n = range(1, robot.dof + 1)
    labels = [f"{letter}[{i},{j}]" for letter in "MC" for i in n for j in n] + [f"G[{i}]" for i in n]
    summary = f"All {len(labels)} entries are those that `workbench derive` prints, sign for sign."
    return [*(VerdictText("same", [f"{label:8} same"]) for label in labels), VerdictText(None, [summary])]


def _language(file: Path, content: str) -> Language:
    """LaTeX if the file says so by its ending, or by a sign that text has no use for outside of comments."""
    said = re.sub("[#%].*", "", content)
    return "latex" if file.suffix.lower() == ".tex" or re.search(r"[\\{]", said) else "text"


def _finding(verdict: EntryVerdict, diagnosis: Diagnosis | None, sheet: Sheet, derived: Dynamics) -> VerdictText:
    if diagnosis is None:
        said = "same" if verdict.kind == "same" else f"same as far as is seen: {verdict.evidence}"
        return VerdictText(verdict.kind, [f"{verdict.label:8} {said}"])
    place = (verdict.matrix, verdict.row, verdict.column)
    assert verdict.printed_value is not None
    assert verdict.right_value is not None
    seen = " for ".join(distinct_texts(verdict.printed_value, verdict.right_value))
    details = {
        "printed": _shortened(text.emit(sheet.entries[place])),
        "right": _right(verdict, derived),
        "seen": f"{seen} at {verdict.witness}",
        "replay": verdict.witness.replay if verdict.witness else "",
        "units": diagnosis.units,
        "torque": _torque(verdict, diagnosis, sheet, derived),
        "slip": diagnosis.slip.description if diagnosis.slip else "no single edit of it gives the right entry",
    }
    if verdict.same_torque == "proved" or diagnosis.instead:
        details["slip"] = ""
    return VerdictText(verdict.kind, [f"{verdict.label:8} differs", *_indented(details)])


def _torque(verdict: EntryVerdict, diagnosis: Diagnosis, sheet: Sheet, derived: Dynamics) -> str:
    """The verdict on the row of C qd that an entry of C belongs to; empty for an entry of M or G."""
    if verdict.same_torque is None:
        return ""
    if diagnosis.instead:
        return f"this entry is right in another factorisation of C qd, once {diagnosis.instead} is corrected"
    if verdict.same_torque != "proved" and not is_in_full(sheet, verdict.row, derived.dof):
        return IN_PART
    return TORQUE[verdict.same_torque]


def _right(verdict: EntryVerdict, derived: Dynamics) -> str:
    if ca.n_nodes(verdict.right) > MOST_OPERATIONS:
        return LONGER
    try:
        return _shortened(text.emit(formula_of(verdict.right, derived.names())))
    except ValueError:
        return LONGER


def _shortened(said: str) -> str:
    return said if len(said.splitlines()) <= MOST_LINES else LONGER


def _indented(details: dict[str, str]) -> Iterator[str]:
    for word, said in details.items():
        for i, line in enumerate(said.splitlines()):
            yield f"  {word if i == 0 else '':{INDENT - 2}}{line}"


def _summary(verdicts: tuple[EntryVerdict, ...], robot: Dynamics, sheet: Sheet) -> Iterator[str]:
    """The number of entries that differ, the number that the sheet omits, and the parameters it fixes."""
    kinds = [verdict.kind for verdict in verdicts]
    total = robot.dof * (2 * robot.dof + 1)
    proved = kinds.count("same")
    wrong = kinds.count("differs")
    yield f"{proved} of {len(verdicts)} printed entries are proved right, {wrong} differ{'s' if wrong == 1 else ''}."
    if "not refuted" in kinds:
        yield f"{kinds.count('not refuted')} could be neither proved nor refuted."
    if len(verdicts) < total:
        yield f"{total - len(verdicts)} of the {total} entries of M, C and G are not printed, and not judged."
    if sheet.fixed_values:
        yield f"Taken as given: {', '.join(_given(sheet))}."


def _given(sheet: Sheet) -> list[str]:
    """The numbers that a sheet fixes; many zeros of a robot in space are only counted."""
    many = len(sheet.zeros) > MOST_ZEROS
    said = [
        f"{label} = {value:g}" for label, value in sheet.fixed_values.items() if not (many and label in sheet.zeros)
    ]
    return [*said, f"{len(sheet.zeros)} numbers that are 0 in the robot"] if many else said
