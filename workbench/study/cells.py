"""What stands in a sentence or in a table, as data: words, formulas, and numbers with their errors."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal, TypeAlias, cast

import numpy as np

from workbench.notation.formula import Formula


@dataclass(frozen=True)
class Code:
    """Text that is typed as it stands: a command, a name, a fingerprint."""

    text: str


@dataclass(frozen=True)
class Strong:
    """Text that is stressed."""

    text: str


@dataclass(frozen=True)
class Reference:
    """'Table 2', 'Figure 3' or 'Equation (4)': the number of the block of that name, found when it is printed."""

    name: str


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
        if not (math.isfinite(self.value) and 0 <= self.error < math.inf):
            raise ValueError(
                "`Measured(value, error)` must hold a finite value and a finite error >= 0, since the error says "
                f"which digits to print; got {self.value!r} and {self.error!r}. For a run that left all bounds use "
                "`Diverged(at)`, for a number that is not known None."
            )


@dataclass(frozen=True)
class Diverged:
    """In place of a number that does not exist: the run left all bounds `at` so many seconds."""

    at: float


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


@dataclass(frozen=True)
class Table:
    """Rows of cells below named columns. The `name` becomes the stem of its files.

    Cells: text, formulas, integers, floats, `Measured`, `Diverged`, booleans (yes or no) and None
    (a dash); any of them in `Emphasis` is bold.

    Raises
    ------
    ValueError
        If the name is no plain file stem, a row does not fit the columns, or a number is NaN.
    """

    name: str
    caption: Phrase
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[Phrase, ...] = ()

    def __post_init__(self) -> None:
        check_name("Table", self.name)
        rows = tuple(tuple(_plain(cell) for cell in row) for row in self.rows)
        object.__setattr__(self, "rows", rows)
        if not self.columns:
            raise ValueError(f"`Table('{self.name}')` must have at least one column; got none.")
        for i, row in enumerate(rows, start=1):
            if len(row) != len(self.columns):
                raise ValueError(
                    f"`Table('{self.name}')` has {len(self.columns)} columns; its row {i} has {len(row)} cells."
                )
            for column, cell in zip(self.columns, row, strict=True):
                self._check_number(column, cell, i)

    def _check_number(self, column: Column, cell: Cell, row: int) -> None:
        value = cell.cell if isinstance(cell, Emphasis) else cell
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


def _plain(cell: Cell) -> Cell:
    """A cell whose NumPy numbers are Python's."""
    if isinstance(cell, Emphasis):
        return Emphasis(cast(Value, _plain(cell.cell)))
    return cast(Cell, cell.item()) if isinstance(cell, np.generic) else cell


def _name_of(header: Phrase) -> str:
    return "".join(p if isinstance(p, str) else getattr(p, "text", str(p)) for p in parts(header))
