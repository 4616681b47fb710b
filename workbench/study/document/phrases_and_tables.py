"""Phrases, and the tables made of them, as data: words, formulas, and numbers with their errors."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from workbench.core.notation.formula import Formula
from workbench.core.validation.refusals import describe, finite, refusal, whole
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.source import Source, clean_text

MOST_DIGITS = 17  # a double has no more
MOST_LETTERS = 80  # of a line of a column: a page has no room for more
WIDE = 0.25  # of a value: an interval that reaches farther is printed by its ends


@dataclass(frozen=True)
@check_arguments
class Code:
    """Text that is typed as it stands: a command, a name, a fingerprint.

    Examples
    --------
    >>> wb.document.Code("make paper").text
    'make paper'
    """

    text: str


@dataclass(frozen=True)
@check_arguments
class Strong:
    """Text that is stressed.

    Examples
    --------
    >>> wb.document.Strong("fails").text
    'fails'
    """

    text: str


@dataclass(frozen=True)
@check_arguments
class CrossReference:
    """A reference to the block of that name, printed as 'Table 2', 'Figure 3' or 'Equation (4)'.

    Examples
    --------
    >>> wb.document.CrossReference("speed").name
    'speed'
    """

    name: str


Part: TypeAlias = str | Formula | Code | Strong | CrossReference
Phrase: TypeAlias = Part | tuple[Part, ...]


def parts(phrase: Phrase) -> tuple[Part, ...]:
    """A phrase as the tuple of its parts."""
    return phrase if isinstance(phrase, tuple) else (phrase,)


@dataclass(frozen=True)
@check_arguments
class ValueWithError:
    """A value with its error, in the same unit: only the digits that the error supports are printed.

    `source` is the result that the value shows, None for a number of another origin. `ends` are the ends of an interval
    that is not symmetric about the value; an end without a bound is infinite. A wide interval is printed in place of
    the error.

    Examples
    --------
    >>> wb.document.ValueWithError(1.25, 0.03).error
    0.03
    """

    value: float
    error: float
    source: Source | None = field(default=None, compare=False, repr=False)
    ends: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        advice = ": for a run that left all bounds use `DivergedCell(at)`, for a number that is not known None"
        if not math.isfinite(self.value):
            raise refusal("ValueWithError(value)", "a finite value", self.value, advice)
        finite("ValueWithError(error)", self.error, ", which says which digits to print", low=0)
        if self.ends is not None and not self.ends[0] <= self.value <= self.ends[1]:
            raise refusal("ValueWithError(ends)", f"the two ends of an interval around {self.value:g}", self.ends)

    @property
    def interval(self) -> tuple[float, float]:
        """The ends of the interval: `ends`, or the value less and plus its error."""
        return self.ends or (self.value - self.error, self.value + self.error)

    @property
    def wide(self) -> bool:
        """True if the ends are so far from the value that an error in brackets would leave no digit of it."""
        return self.ends is not None and max(abs(end - self.value) for end in self.ends) > WIDE * abs(self.value)


@dataclass(frozen=True)
@check_arguments
class DivergedCell:
    """A cell in place of a number that does not exist, as the run diverged `at` so many seconds."""

    at: float
    source: Source | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        finite("DivergedCell(at)", self.at, " of seconds")


@dataclass(frozen=True)
@check_arguments
class MissingCell:
    """A cell in place of a number that does not exist, with the reason in words, as 'never'."""

    words: str
    source: Source | None = field(default=None, compare=False, repr=False)


# the kinds that a cell has most often come first, as they are tried one by one
Value: TypeAlias = bool | int | float | Phrase | ValueWithError | DivergedCell | MissingCell | None


@dataclass(frozen=True)
@check_arguments
class BoldCell:
    """A cell in bold; the notes of its table say why, for instance 'bold: the least of a row'."""

    cell: Value


Cell: TypeAlias = Value | BoldCell


@dataclass(frozen=True)
@check_arguments
class TableColumn:
    """The header of a column; its floats have `digits` significant digits, by default four, or fewer if exact.

    A `ValueWithError` cell has the digits that its error supports, whatever `digits` is. If a page is too narrow, texts
    are broken into lines of at least `width` letters.

    Examples
    --------
    >>> wb.document.TableColumn("error", "rad", align="right", digits=3).unit
    'rad'
    """

    header: Phrase
    unit: str = ""
    align: Literal["auto", "left", "center", "right"] = "auto"
    digits: int | None = None
    width: int | None = None

    def __post_init__(self) -> None:
        if self.digits is not None:
            whole("TableColumn(digits=...)", self.digits, 1, MOST_DIGITS, " of significant digits")
        if self.width is not None:
            whole("TableColumn(width=...)", self.width, 1, MOST_LETTERS, " of letters in a line")


@dataclass(frozen=True)
@check_arguments
class ReportTable:
    """Rows of cells below named columns. The `name` becomes the stem of its files.

    Cells: text, formulas, numbers, `ValueWithError`, `DivergedCell`, `MissingCell`, booleans (yes or no), None (a
    dash); a `BoldCell` is bold. The notes of the results that its cells show are added to `notes`.

    Raises
    ------
    ValueError
        If `name` cannot name a file, a row does not fit the columns, or a cell is NaN or not one of these.

    Examples
    --------
    >>> columns = wb.document.TableColumn("law"), wb.document.TableColumn("error", "rad", "right")
    >>> wb.document.ReportTable("errors", "The error of each law.", columns, (("PID", 0.1), ("SMC", 0.05))).rows[1]
    ('SMC', 0.05)
    """

    name: str
    caption: Phrase
    columns: tuple[TableColumn, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[Phrase, ...] = ()

    def __post_init__(self) -> None:
        check_name("ReportTable", self.name)
        if not self.columns:
            raise ValueError(f"`ReportTable('{self.name}')` must have at least one column; got none.")
        for i, row in enumerate(self.rows, start=1):
            if len(row) != len(self.columns):
                raise ValueError(
                    f"`ReportTable('{self.name}')` has {len(self.columns)} columns; its row {i} has {len(row)} cells."
                )
            for column, cell in zip(self.columns, row, strict=True):
                self._check_number(column, bare(cell), i)
        remarks = (remark for remark in self._remarks() if remark not in self.notes)
        object.__setattr__(self, "notes", (*self.notes, *remarks))

    def _remarks(self) -> tuple[str, ...]:
        """The notes of the results that its cells show, each once, with the laws that it concerns.

        A law with other notes in another scenario is named with its scenario. If all laws have notes, those that most
        of the laws share are last, for "all rows" or "all other rows".
        """
        sources = [source for row in self.rows for cell in row if (source := source_of(cell))]
        said = {(one.title or one.law, one.scenario): "; ".join(one.notes) for one in sources}
        laws: dict[str, dict[str, None]] = {}
        for (law, scenario), words in said.items():
            alike = {other for (name, _), other in said.items() if name == law} == {words}
            laws.setdefault(words, {})[law if alike else f"{law} ({scenario})"] = None
        labels = {words: _listed(names) for words, names in laws.items() if words}
        common, total = max(laws, key=lambda words: len(laws[words]), default=""), sum(map(len, laws.values()))
        if "" not in laws and 2 < total < 2 * len(laws.get(common, ())):
            del labels[common]
            rows = "rows" if all(any(map(source_of, row)) for row in self.rows) else "rows with runs"
            labels[common] = f"All other {rows}" if labels else f"All {rows}"
        return tuple(clean_text(f"{label}: {words}.") for words, label in labels.items())

    def _check_number(self, column: TableColumn, value: Value, row: int) -> None:
        """Refuse NaN, and a whole number that no float holds."""
        beyond = isinstance(value, int) and abs(value) > sys.float_info.max
        if beyond or (isinstance(value, float) and math.isnan(value)):
            raise ValueError(
                f"`ReportTable('{self.name}')` has {'a number beyond 1.8e308' if beyond else 'NaN'} in column "
                f"{describe(column.header)}, row {row}, which cannot be printed: use `DivergedCell(at)` for a run that "
                "left all bounds, or None for a number that is not known."
            )


def _listed(names: Iterable[str]) -> str:
    """Names in a row, between semicolons where a name has a comma."""
    held = list(names)
    return ("; " if any(", " in name for name in held) else ", ").join(held)


def bare(cell: Cell) -> Value:
    """The value of a cell, without its emphasis."""
    return cell.cell if isinstance(cell, BoldCell) else cell


def source_of(cell: Cell) -> Source | None:
    """The result that a cell shows; None for a number of another origin, and for text."""
    value = bare(cell)
    return value.source if isinstance(value, ValueWithError | DivergedCell | MissingCell) else None


def head_of(source: Source) -> str:
    """A source as the head of a column: law, scenario, signal or metric with its unit, and run."""
    unit = f" [{superscript_powers(source.unit)}]" if source.unit not in ("", "1") else ""
    parts = (source.law, source.scenario, f"{source.words}{unit}", f"run {source.run[:16]}")
    return clean_text(" | ".join(part for part in parts if part))


def check_name(kind: str, name: str) -> None:
    """Refuse a name that could not be that of a file or folder, or would lead out of its place."""
    if not (isinstance(name, str) and re.fullmatch(r"[a-z0-9_]{1,80}", name)):
        got = f"{name[:90]!r} of {len(name)} letters" if isinstance(name, str) else describe(name)
        raise ValueError(
            f"`{kind}(name)` must be made of a-z, 0-9 and _, 1 to 80 of them, since it becomes the name of a file; "
            f"got {got}."
        )


@check_arguments
def superscript_powers(unit: str) -> str:
    """A unit as it is printed, with its whole powers raised: m/s^2 as m/s\N{SUPERSCRIPT TWO}; a root stays as typed.

    Examples
    --------
    >>> wb.document.superscript_powers("kg m^2")
    'kg m²'
    """
    powers = r"\^(?:\((-?\d+)\)|(-?\d+)(?![\d.]))"
    return re.sub(powers, lambda m: (m[1] or m[2]).translate(_RAISED), unit).replace("*", "·")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
