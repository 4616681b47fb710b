"""A file of printed equations held against an arm: what is said of each entry."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from workbench.core import Dynamics
from workbench.core.show import formula_of
from workbench.notation import text
from workbench.notation.parsing.statements import Language
from workbench.notation.parsing.tokens import MOST_CHARACTERS
from workbench.verify.diagnosis import Diagnosis, diagnose, in_common, of_factorisation
from workbench.verify.given import narrowed
from workbench.verify.printed import EntryVerdict, Sameness, compare_sheet
from workbench.verify.sheet import Sheet, read_sheet

TORQUE = {
    "proved": "C qd is right all the same: another factorisation of it",
    "refuted": "C qd is wrong as well",
    "not refuted": "whether C qd is right all the same is open",
}
INDENT = 11


class Finding(NamedTuple):
    """What is said of one entry, or of all: the verdict in a line, then the details."""

    kind: Sameness | None
    lines: list[str]


def findings(file: Path, robot: Dynamics) -> list[Finding]:
    """A finding for each entry that a file prints, and one at the end for all of them.

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
        derived = narrowed(robot, sheet.fixed)
        verdicts = compare_sheet(sheet, derived)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from None
    diagnoses = diagnose(sheet, verdicts, derived)
    entries = [_finding(verdict, diagnoses.get(verdict.label), sheet, derived) for verdict in verdicts]
    shared = [*in_common(verdicts, diagnoses), *of_factorisation(verdicts, derived)]
    return [*entries, Finding(None, [*_summary(verdicts, robot, sheet), *shared])]


def _content(file: Path) -> str:
    if not file.is_file():
        raise LookupError(f"There is no file '{file}'; name a file of equations, .txt or .tex.")
    if file.stat().st_size > 4 * MOST_CHARACTERS:
        raise ValueError(f"{file}: equations take at most {MOST_CHARACTERS} characters; this file has more.")
    try:
        return file.read_text(encoding="utf-8-sig")  # editors may put a mark before the text
    except UnicodeDecodeError as error:
        raise ValueError(f"{file}: it is no text in UTF-8 (byte {error.start}); save the equations as text.") from None


def _language(file: Path, content: str) -> Language:
    """LaTeX if the file says so by its ending, or by a sign that text has no use for outside of comments."""
    said = re.sub("[#%].*", "", content)
    return "latex" if file.suffix.lower() == ".tex" or re.search(r"[\\{]", said) else "text"


def _finding(verdict: EntryVerdict, diagnosis: Diagnosis | None, sheet: Sheet, derived: Dynamics) -> Finding:
    if diagnosis is None:
        said = "same" if verdict.kind == "same" else f"same as far as is seen: {verdict.evidence}"
        return Finding(verdict.kind, [f"{verdict.label:8} {said}"])
    place = (verdict.matrix, verdict.row, verdict.column)
    details = {
        "printed": text.emit(sheet.entries[place]),
        "right": _right(verdict, derived),
        "seen": f"{verdict.printed_value:.6g} for {verdict.right_value:.6g} at {verdict.witness}",
        "replay": verdict.witness.replay if verdict.witness else "",
        "units": diagnosis.units,
        "torque": TORQUE[verdict.same_torque] if verdict.same_torque else "",
        "slip": diagnosis.slip.said if diagnosis.slip else "no single edit of it gives the right entry",
    }
    if verdict.same_torque == "proved":
        details["slip"] = ""
    return Finding(verdict.kind, [f"{verdict.label:8} differs", *_indented(details)])


def _right(verdict: EntryVerdict, derived: Dynamics) -> str:
    try:
        return text.emit(formula_of(verdict.right, derived.names()))
    except ValueError:
        return "longer than any page; see `workbench derive`"


def _indented(details: dict[str, str]) -> Iterator[str]:
    for word, said in details.items():
        for i, line in enumerate(said.splitlines()):
            yield f"  {word if i == 0 else '':{INDENT - 2}}{line}"


def _summary(verdicts: tuple[EntryVerdict, ...], robot: Dynamics, sheet: Sheet) -> Iterator[str]:
    """How many entries differ, what the sheet leaves out, and the numbers it fixes."""
    kinds = [verdict.kind for verdict in verdicts]
    total = robot.dof * (2 * robot.dof + 1)
    proved = kinds.count("same")
    wrong = kinds.count("differs")
    yield f"{proved} of {len(verdicts)} printed entries are proved right, {wrong} differ{'s' if wrong == 1 else ''}."
    if "not refuted" in kinds:
        yield f"{kinds.count('not refuted')} could be neither proved nor refuted."
    if len(verdicts) < total:
        yield f"{total - len(verdicts)} of the {total} entries of M, C and G are not printed, and not judged."
    if sheet.fixed:
        yield f"Taken as given: {', '.join(f'{label} = {value:g}' for label, value in sheet.fixed.items())}."
