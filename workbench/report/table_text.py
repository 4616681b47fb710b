"""Tables as CSV, as LaTeX, and as the grid of printed cells that page and PDF share."""

from __future__ import annotations

import csv
import io
import math
import re
from dataclasses import dataclass
from typing import Literal

from workbench.core.notation import latex, text
from workbench.report.number_text import NumberText, Padding, number_text, number_text_with_error, paddings
from workbench.study.document.phrases_and_tables import (
    BoldCell,
    Cell,
    Code,
    CrossReference,
    DivergedCell,
    MissingCell,
    Part,
    Phrase,
    ReportTable,
    Strong,
    TableColumn,
    Value,
    ValueWithError,
    bare,
    parts,
    superscript_powers,
)
from workbench.study.run_tables import spreadsheet_text

BRACKETS = (
    "A number in brackets is the error of the digits before it: 0.3532(2) is 0.3532 with an estimated error of "
    "0.0002. Without brackets, the error is below the last digit."
)

END = r"\\"  # of a row in LaTeX
ERROR, ENDS = ("error",), ("from", "to")  # heads of the fields of a CSV beside a value


@dataclass(frozen=True)
class CellText:
    """A cell as it is printed: a number in its column's frame, or a phrase."""

    content: NumberText | Phrase
    padding: Padding
    bold: bool


def grid(table: ReportTable) -> list[list[CellText]]:
    """The printed cells of a table, row by row; the numbers of a column are padded to one frame."""
    columns = [_printed_column([row[i] for row in table.rows], c) for i, c in enumerate(table.columns)]
    return [list(row) for row in zip(*columns, strict=True)]


def _printed_column(cells: list[Cell], column: TableColumn) -> list[CellText]:
    """The column with numbers in text aligned as numbers, unless there are words among them."""
    values = [bare(cell) for cell in cells]
    typed = all(_read(v) if isinstance(v, str) else v is None or isinstance(v, DivergedCell) for v in values)
    numeric = typed or any(isinstance(v, int | float | ValueWithError) and not isinstance(v, bool) for v in values)
    contents = [_printed_value(value, column.digits, numeric) for value in values]
    frames = iter(paddings(content for content in contents if isinstance(content, NumberText)))
    return [
        CellText(content, next(frames) if isinstance(content, NumberText) else Padding(), isinstance(cell, BoldCell))
        for content, cell in zip(contents, cells, strict=True)
    ]


def _printed_value(value: Value, digits: int | None, numeric: bool) -> NumberText | Phrase:
    match value:
        case None:
            return "—"
        case bool():
            return "yes" if value else "no"
        case int():
            return number_text(value)
        case float():
            return number_text(value, digits)
        case ValueWithError():
            return _by_ends(value) if value.wide else number_text_with_error(value.value, value.error)
        case DivergedCell():
            return f"diverged at {number_text(float(f'{value.at:.3g}'))} s"
        case MissingCell():
            return value.words
        case str() if numeric:
            return _read(value) or value
    return value


def _by_ends(value: ValueWithError) -> str:
    """A value with the ends of its interval: '4.73 (4.11 to 6.06)'."""
    low, high = (f"{end:.3g}" if math.isfinite(end) else "no bound" for end in value.interval)
    return f"{value.value:.3g} ({low} to {high})".replace("-", "−")


def _read(typed: str) -> NumberText | None:
    """A number that came as text, digit for digit: '0.2330', '+1.5'."""
    match = re.fullmatch(r"([+−-]?)(\d+)(\.\d+)?", typed)
    return NumberText(match[1].replace("-", "−"), match[2], match[3] or "") if match else None


def alignments(table: ReportTable) -> list[Literal["left", "center", "right"]]:
    """The alignment of each column: that of its `TableColumn`, else numbers centred and words to the left."""
    cells = grid(table)
    return [
        column.align if column.align != "auto" else "center" if _is_centred([row[i] for row in cells]) else "left"
        for i, column in enumerate(table.columns)
    ]


def _is_centred(column: list[CellText]) -> bool:
    return any(isinstance(shown.content, NumberText) or shown.content in ("yes", "no") for shown in column)


def short_columns(table: ReportTable) -> list[bool]:
    """For each column, True if all its cells are so short that none should be broken over lines."""
    cells = grid(table)
    return [all(length(row[i]) <= 18 for row in cells) for i in range(len(table.columns))]


def length(cell: CellText) -> int:
    """The approximate number of letters of a cell."""
    return len(str(cell.content)) if isinstance(cell.content, NumberText) else len(plain(cell.content))


def measures(table: ReportTable) -> bool:
    """True if a table holds values with errors, whose brackets must be explained once.

    The brackets of values with the ends of an interval have another meaning, which the notes of their table give.
    """
    values = (bare(cell) for row in table.rows for cell in row)
    return any(isinstance(value, ValueWithError) and value.ends is None for value in values)


def unit_of_column(column: TableColumn) -> str:
    """The unit as it is printed, in brackets: '[m/s²]'; empty for a number without one."""
    return "" if column.unit in ("", "1") else f"[{superscript_powers(column.unit)}]"


def plain(phrase: Phrase) -> str:
    """A phrase as plain text on one line."""
    return "".join(_plain_part(part) for part in parts(phrase))


def _plain_part(part: Part) -> str:
    match part:
        case str():
            return part
        case Code() | Strong():
            return part.text
        case CrossReference():
            return part.name
    return text.emit(part)


def to_csv(table: ReportTable) -> str:
    """The table after RFC 4180: numbers with all their digits, values and errors in columns of their own.

    Where a column has a value with the ends of its interval, all its values have their ends in place of the error. A
    cell that does not exist is empty, one of a diverged run says so in words. No text is run as a formula.
    """
    out = io.StringIO()
    writer = csv.writer(out)
    parts_of = [_fields_of([bare(row[i]) for row in table.rows]) for i in range(len(table.columns))]
    head: list[str] = []
    for column, names in zip(table.columns, parts_of, strict=True):
        name, unit = plain(column.header), f" {unit_of_column(column)}".rstrip()
        head += [f"{name}{unit}", *(f"{name} ({part}){unit}" for part in names)]
    writer.writerow(map(spreadsheet_text, head))
    for row in table.rows:
        writer.writerow([field for cell, names in zip(row, parts_of, strict=True) for field in _fields(cell, names)])
    return out.getvalue()


def _fields_of(values: list[Value]) -> tuple[str, ...]:
    """The fields of a CSV beside that of a column's values: errors, or the ends of intervals."""
    taken = [value for value in values if isinstance(value, ValueWithError)]
    return ENDS if any(one.ends for one in taken) else ERROR if taken else ()


def _fields(cell: Cell, names: tuple[str, ...]) -> list[str]:
    """The field of a cell in a CSV, and those beside it; empty ones for a cell without an error."""
    value = bare(cell)
    beside = [""] * len(names)
    match value:
        case None:
            field = ""
        case bool():
            field = "yes" if value else "no"
        case int() | float():
            field = repr(value)
        case ValueWithError():
            field = repr(float(value.value))
            beside = [repr(float(part)) for part in (value.interval if names == ENDS else (value.error,))]
        case DivergedCell():
            field = f"diverged at {float(value.at)!r} s"
        case MissingCell():
            field = spreadsheet_text(value.words)
        case _:
            field = spreadsheet_text(plain(value))
    return [field, *beside]


def to_latex(table: ReportTable) -> str:
    r"""The table as a LaTeX float in the style of booktabs, with its name as label.

    It needs `\usepackage{booktabs}`, and `\usepackage{amsmath}` if a cell holds a matrix.
    """
    notes = (BRACKETS, *table.notes) if measures(table) else table.notes
    letters = "".join({"left": "l", "center": "c", "right": "r"}[a] for a in alignments(table))
    heads = [
        _latex(column.header) + (f" {_escaped(unit)}" if (unit := unit_of_column(column)) else "")
        for column in table.columns
    ]
    lines = [
        r"\begin{table}",
        r"  \centering",
        rf"  \caption{{{_latex(table.caption)}}}",
        rf"  \label{{{table.name}}}",
        rf"  \begin{{tabular}}{{{letters}}}",
        r"    \toprule",
        f"    {' & '.join(heads)} {END}",
        r"    \midrule",
        *(f"    {' & '.join(map(_latex_cell, row))} {END}" for row in grid(table)),
        r"    \bottomrule",
        r"  \end{tabular}",
        *(rf"  \par\smallskip{{\footnotesize {_latex(note)}}}" for note in notes),
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _latex_cell(shown: CellText) -> str:
    if not isinstance(shown.content, NumberText):
        written = _latex(shown.content)
        # A row that begins with a bracket would be read as an argument of the row above.
        written = f"{{}}{written}" if written.startswith("[") else written
        return rf"\textbf{{{written}}}" if shown.bold else written
    number, frame = shown.content, shown.padding
    times = rf"{{}}\times10^{{{_in_math(number.power or frame.power)}}}"
    body = f"{_in_math(number.sign + number.whole + number.tail)}{times if number.power else ''}"
    missing = times if frame.power and not number.power else ""
    body = rf"\mathbf{{{body}}}" if shown.bold else body
    return f"${_phantom(frame.before)}{body}{_phantom(frame.behind + missing)}$"


def _phantom(unseen: str) -> str:
    return rf"\phantom{{{_in_math(unseen)}}}" if unseen else ""


def _in_math(written: str) -> str:
    return written.replace("−", "-").replace("\u2009", r"\,").replace("∞", r"\infty ")


def _latex(phrase: Phrase) -> str:
    return "".join(_latex_part(part) for part in parts(phrase))


def _latex_part(part: Part) -> str:
    match part:
        case str():
            return _escaped(part)
        case Code():
            return rf"\texttt{{{_escaped(part.text)}}}"
        case Strong():
            return rf"\textbf{{{_escaped(part.text)}}}"
        case CrossReference():
            return rf"\ref{{{part.name}}}"
    return f"${latex.emit(part, width=math.inf)}$"


_SPECIAL = {
    **{c: f"\\{c}" for c in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "—": "---",
    "–": "--",
    "−": "$-$",
    "\u2009": r"\,",
    "\n": " ",
    **{c: f"\\textsuperscript{{{d}}}" for c, d in zip("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789", strict=True)},
}


def _escaped(plain_text: str) -> str:
    return "".join(_SPECIAL.get(c, c) for c in plain_text)
