"""What stands in a sentence or in a table, as data: words, formulas, and numbers with their errors."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal, TypeAlias, cast, get_args

import numpy as np

from workbench.notation.formula import Formula

MOST_DIGITS = 17  # a double has no more


@dataclass(frozen=True)
class Code:
    """Text that is typed as it stands: a command, a name, a fingerprint."""

    text: str

    def __post_init__(self) -> None:
        check_text("Code(text)", self.text)


@dataclass(frozen=True)
class Strong:
    """Text that is stressed."""

    text: str

    def __post_init__(self) -> None:
        check_text("Strong(text)", self.text)


@dataclass(frozen=True)
class Reference:
    """'Table 2', 'Figure 3' or 'Equation (4)': the number of the block of that name, found when it is printed."""

    name: str

    def __post_init__(self) -> None:
        check_text("Reference(name)", self.name)


Part: TypeAlias = str | Formula | Code | Strong | Reference
Phrase: TypeAlias = Part | tuple[Part, ...]


def parts(phrase: Phrase) -> tuple[Part, ...]:
    """A phrase as the tuple of its parts."""
    return phrase if isinstance(phrase, tuple) else (phrase,)


@dataclass(frozen=True)
class Measured:
    """A value with its own error estimate, in the same unit: only the digits that the error supports are printed."""

    value: float
    error: float

    def __post_init__(self) -> None:
        if not (_is_finite(self.value) and _is_finite(self.error) and self.error >= 0):
            raise ValueError(
                "`Measured(value, error)` must hold a finite value and a finite error >= 0, since the error says "
                f"which digits to print; got {self.value!r} and {self.error!r}. For a run that left all bounds use "
                "`Diverged(at)`, for a number that is not known None."
            )


@dataclass(frozen=True)
class Diverged:
    """In place of a number that does not exist: the run left all bounds `at` so many seconds."""

    at: float

    def __post_init__(self) -> None:
        if not _is_finite(self.at):
            raise ValueError(f"`Diverged(at)` must be a finite number of seconds; got {self.at!r}.")


Value: TypeAlias = Phrase | bool | int | float | Measured | Diverged | None


@dataclass(frozen=True)
class Emphasis:
    """A cell in bold; the notes of its table say why, for instance 'bold: the least of a row'."""

    cell: Value


Cell: TypeAlias = Value | Emphasis


@dataclass(frozen=True)
class Column:
    """The head of a column. `digits` is the number of significant digits of its floats.

    Without `digits` a float has four, or fewer if fewer are exact, as in a parameter of 0.5. A
    `Measured` cell has those that its error supports, whatever `digits` says.
    """

    header: Phrase
    unit: str = ""
    align: Literal["auto", "left", "center", "right"] = "auto"
    digits: int | None = None

    def __post_init__(self) -> None:
        check_phrase("Column(header)", self.header)
        check_text("Column(unit=...)", self.unit)
        if self.align not in ("auto", "left", "center", "right"):
            raise ValueError(f"`Column(align=...)` is 'auto', 'left', 'center' or 'right'; got {self.align!r}.")
        whole = isinstance(self.digits, int) and not isinstance(self.digits, bool)
        if self.digits is not None and not (whole and 1 <= self.digits <= MOST_DIGITS):
            raise ValueError(
                f"`Column(digits=...)` counts significant digits, so it is 1 to {MOST_DIGITS}, or None for as many as "
                f"are needed; got {self.digits!r}."
            )


@dataclass(frozen=True)
class Table:
    """Rows of cells below named columns. The `name` becomes the stem of its files.

    Cells: text, formulas, integers, floats, `Measured`, `Diverged`, booleans (yes or no) and None
    (a dash); any of them in `Emphasis` is bold.

    Raises
    ------
    ValueError
        If the name is no plain file stem, a row does not fit the columns, a number is NaN, or a cell is none of
        the above.
    """

    name: str
    caption: Phrase
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[Phrase, ...] = ()

    def __post_init__(self) -> None:
        check_name("Table", self.name)
        call = f"Table('{self.name}'"
        check_phrase(f"{call}, caption=...)", self.caption)
        object.__setattr__(self, "columns", several(f"{call}, columns=...)", self.columns, Column, "column"))
        rows = several(f"{call}, rows=...)", self.rows, (tuple, list), "row")
        object.__setattr__(self, "rows", tuple(tuple(_plain(cell) for cell in row) for row in rows))
        object.__setattr__(self, "notes", phrases(f"{call}, notes=...)", self.notes))
        if not self.columns:
            raise ValueError(f"`Table('{self.name}')` must have at least one column; got none.")
        for i, row in enumerate(self.rows, start=1):
            if len(row) != len(self.columns):
                raise ValueError(
                    f"`Table('{self.name}')` has {len(self.columns)} columns; its row {i} has {len(row)} cells."
                )
            for column, cell in zip(self.columns, row, strict=True):
                self._check_cell(column, cell, i)

    def _check_cell(self, column: Column, cell: Cell, row: int) -> None:
        value = cell.cell if isinstance(cell, Emphasis) else cell
        if value is not None and not isinstance(value, bool | int | float | Measured | Diverged):
            check_phrase(f"Table('{self.name}')` in column {_name_of(column.header)!r}, row {row}, `cell", value)
        if isinstance(value, float) and math.isnan(value):
            raise ValueError(
                f"`Table('{self.name}')` has NaN in column {_name_of(column.header)!r}, row {row}: not a number, "
                "so it cannot be printed as one. Use `Diverged(at)` for a run that left all bounds, or None for a "
                "number that is not known."
            )


def check_name(kind: str, name: str) -> None:
    """Refuse a name that could not be the stem of a file, or would lead out of its folder."""
    if not re.fullmatch(r"[a-z0-9_]+", name):
        raise ValueError(
            f"`{kind}(name)` must be made of a-z, 0-9 and _, since it becomes the name of a file; got {name!r}."
        )


def check_text(call: str, text: object) -> None:
    """Refuse what is no text: `call` names the argument."""
    if not isinstance(text, str):
        raise ValueError(f"`{call}` must be text; got {_described(text)}.")


def check_phrase(call: str, phrase: object, *, label: bool = False) -> None:
    """Refuse what cannot be printed in a line; the `label` of a curve is made of text and formulas alone."""
    for part in phrase if isinstance(phrase, tuple) else (phrase,):
        if not isinstance(part, get_args(Formula) + ((str,) if label else (str, Code, Strong, Reference))):
            kinds = "text or a formula" if label else "text, a formula, `Code`, `Strong` or `Reference`"
            raise ValueError(f"`{call}` must be {kinds}, or a tuple of these; got {_described(part)}.")


def several(call: str, given: object, kind: Any, word: str) -> tuple[Any, ...]:
    """A tuple or list of one kind as a tuple; one alone, or anything else among them, is refused."""
    if not isinstance(given, tuple | list):
        hint = f": one {word} alone is written `({word},)`, with its comma" if isinstance(given, kind) else ""
        raise ValueError(f"`{call}` must be a tuple of {word}s; got {_described(given)}{hint}.")
    for i, item in enumerate(given, start=1):
        if not isinstance(item, kind):
            raise ValueError(f"`{call}` must be a tuple of {word}s; number {i} is {_described(item)}.")
    return tuple(given)


def phrases(call: str, given: object) -> tuple[Phrase, ...]:
    """A tuple or list of phrases as a tuple; a text alone, which would be taken letter by letter, is refused."""
    if not isinstance(given, tuple | list):
        raise ValueError(
            f"`{call}` must be a tuple of texts; got {_described(given)}: one alone is written `('...',)`, with its "
            "comma."
        )
    for item in given:
        check_phrase(call, item)
    return tuple(given)


def texts(call: str, given: Iterable[object]) -> tuple[str, ...]:
    """The texts of an iterable; a text alone, which would be taken letter by letter, is refused."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ValueError(f"`{call}` must be a list of texts; got {_described(given)}: write `['...']`.")
    found = tuple(given)
    for item in found:
        check_text(call, item)
    return cast(tuple[str, ...], found)


def spreadsheet_text(text: str) -> str:
    """A text as a cell or head of a CSV file, after an apostrophe where spreadsheets would run it as a formula.

    They run what begins with =, +, - or @, also in full width, and some of them look behind blanks and signs that
    are not seen; a tab or line break before anything else may end the cell before it. A plain number stays one.
    """
    return f"'{text}" if _FORMULA.match(text) and not _NUMBER.fullmatch(text) else text


_FORMULA = re.compile("[\t\r\n]|[\\s\x00-\x1f\x7f-\x9f\xad\u200b-\u200f\u2060\ufeff]*[=+@＝＋－＠-]")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def raised(unit: str) -> str:
    """A unit as it is printed, its whole powers raised: m/s^2 as m/s\N{SUPERSCRIPT TWO}; a root stays as typed."""
    powers = r"\^(?:\((-?\d+)\)|(-?\d+)(?![\d.]))"
    return re.sub(powers, lambda m: (m[1] or m[2]).translate(_RAISED), unit).replace("*", "·")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and math.isfinite(value)


def _described(value: object) -> str:
    """The kind of a value, and the value itself where it is short."""
    shown, kind = repr(value), type(value).__name__
    if value is None:
        return shown
    return kind if len(shown) > 40 or "\n" in shown or kind in shown else f"{kind} {shown}"


def _plain(cell: Cell) -> Cell:
    """A cell whose NumPy numbers are Python's."""
    if isinstance(cell, Emphasis):
        return Emphasis(cast(Value, _plain(cell.cell)))
    return cast(Cell, cell.item()) if isinstance(cell, np.generic) else cell


def _name_of(header: Phrase) -> str:
    return "".join(p if isinstance(p, str) else getattr(p, "text", str(p)) for p in parts(header))
