"""What stands in a sentence or in a table, as data: words, formulas, and numbers with their errors."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real
from typing import Any, Literal, TypeAlias, cast, get_args

import numpy as np

from workbench.notation.formula import Formula
from workbench.validation.views import show

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
        value, error = _number(self.value), _number(self.error)
        if value is None or error is None or error < 0:
            raise ValueError(
                "`Measured(value, error)` must hold a finite value and a finite error >= 0, since the error says "
                f"which digits to print; got {described(self.value)} and {described(self.error)}. For a run that left "
                "all bounds use `Diverged(at)`, for a number that is not known None."
            )
        object.__setattr__(self, "value", value)
        object.__setattr__(self, "error", error)


@dataclass(frozen=True)
class Diverged:
    """In place of a number that does not exist: the run left all bounds `at` so many seconds."""

    at: float

    def __post_init__(self) -> None:
        if (at := _number(self.at)) is None:
            raise ValueError(f"`Diverged(at)` must be a finite number of seconds; got {described(self.at)}.")
        object.__setattr__(self, "at", at)


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
        check_choice("Column(align=...)", self.align, ("auto", "left", "center", "right"))
        if self.digits is not None:
            if not (is_whole(self.digits) and 1 <= self.digits <= MOST_DIGITS):
                raise ValueError(
                    f"`Column(digits=...)` counts significant digits, so it is 1 to {MOST_DIGITS}, or None for as many "
                    f"as are needed; got {described(self.digits)}."
                )
            object.__setattr__(self, "digits", int(self.digits))


@dataclass(frozen=True)
@show
class Table:
    """Rows of cells below named columns. The `name` becomes the stem of its files.

    Cells: text, formulas, integers, floats, `Measured`, `Diverged`, booleans (yes or no) and None
    (a dash); any of them in `Emphasis` is bold.

    Raises
    ------
    ValueError
        If the name is no file's, a row does not fit the columns, or a cell is NaN or none of the above.
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
        rows = tuple(several(f"{call}, rows=...)", row, object, "cell") for row in rows)
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
            check_phrase(f"Table('{self.name}')` in column {plain_words(column.header)!r}, row {row}, `cell", value)
        if isinstance(value, int) and abs(value) > sys.float_info.max:
            raise ValueError(
                f"`Table('{self.name}')` holds in column {plain_words(column.header)!r}, row {row}, a number beyond "
                "1.8e308, which no float holds: say it in words."
            )
        if isinstance(value, float) and math.isnan(value):
            raise ValueError(
                f"`Table('{self.name}')` has NaN in column {plain_words(column.header)!r}, row {row}: not a number, "
                "so it cannot be printed as one. Use `Diverged(at)` for a run that left all bounds, or None for a "
                "number that is not known."
            )


def check_name(kind: str, name: object) -> None:
    """Refuse a name that could not be that of a file or folder, or would lead out of its place."""
    if not (isinstance(name, str) and re.fullmatch(r"[a-z0-9_]{1,80}", name)):
        got = f"{name[:90]!r} of {len(name)} letters" if isinstance(name, str) else described(name)
        raise ValueError(
            f"`{kind}(name)` must be made of a-z, 0-9 and _, 1 to 80 of them, since it becomes the name of a file; "
            f"got {got}."
        )


def check_text(call: str, text: object) -> None:
    """Refuse what is no text: `call` names the argument."""
    if not isinstance(text, str):
        raise ValueError(f"`{call}` must be text; got {described(text)}.")


def check_choice(call: str, given: object, known: tuple[str, ...]) -> None:
    """Refuse what is none of the known words."""
    if not (isinstance(given, str) and given in known):
        words = ", ".join(map(repr, known[:-1]))
        raise ValueError(f"`{call}` must be {words} or {known[-1]!r}; got {described(given)}.")


def check_phrase(call: str, phrase: object, *, label: bool = False) -> None:
    """Refuse what cannot be printed in a line; the `label` of a curve is made of text and formulas alone."""
    for part in phrase if isinstance(phrase, tuple) else (phrase,):
        if not isinstance(part, get_args(Formula) + ((str,) if label else (str, Code, Strong, Reference))):
            kinds = "text or a formula" if label else "text, a formula, `Code`, `Strong` or `Reference`"
            raise ValueError(f"`{call}` must be {kinds}, or a tuple of these; got {described(part)}.")


def several(call: str, given: object, kind: Any, word: str) -> tuple[Any, ...]:
    """A tuple or list of one kind as a tuple; one alone, or anything else among them, is refused."""
    if not isinstance(given, tuple | list):
        hint = f": one {word} alone is written `({word},)`, with its comma" if isinstance(given, kind) else ""
        raise ValueError(f"`{call}` must be a tuple of {word}s; got {described(given)}{hint}.")
    found = _gone_through(call, given)
    for i, item in enumerate(found, start=1):
        if not isinstance(item, kind):
            raise ValueError(f"`{call}` must be a tuple of {word}s; number {i} is {described(item)}.")
    return found


def phrases(call: str, given: object) -> tuple[Phrase, ...]:
    """A tuple or list of phrases as a tuple; a text alone, which would be taken letter by letter, is refused."""
    found = several(call, given, object, "text")
    for item in found:
        check_phrase(call, item)
    return found


def texts(call: str, given: Iterable[object]) -> tuple[str, ...]:
    """The texts of an iterable; a text alone, which would be taken letter by letter, is refused."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ValueError(f"`{call}` must be a list of texts; got {described(given)}: write `['...']`.")
    found = _gone_through(call, given)
    for item in found:
        check_text(call, item)
    return found


def _gone_through(call: str, given: Iterable[Any]) -> tuple[Any, ...]:
    try:
        return tuple(given)
    except Exception as error:
        raise ValueError(f"`{call}` could not be gone through: {type(error).__name__}: {error}.") from error


def raised(unit: str) -> str:
    """A unit as it is printed, its whole powers raised: m/s^2 as m/s\N{SUPERSCRIPT TWO}; a root stays as typed."""
    powers = r"\^(?:\((-?\d+)\)|(-?\d+)(?![\d.]))"
    return re.sub(powers, lambda m: (m[1] or m[2]).translate(_RAISED), unit).replace("*", "·")


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def _number(value: object) -> float | None:
    """A finite number as Python's own; None for anything else."""
    try:
        number = math.inf if isinstance(value, bool) or not isinstance(value, Real) else float(value)
    except (OverflowError, ValueError, TypeError):
        return None
    return number if math.isfinite(number) else None


def is_whole(value: object) -> bool:
    """Whether it is a whole number, of Python or NumPy."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def described(value: object) -> str:
    """The kind of a value, and the value itself where it is short."""
    kind = type(value).__name__
    try:
        shown = repr(value)
    except Exception:  # of a kind whose author never printed it
        return kind
    if value is None:
        return shown
    return kind if len(shown) > 40 or "\n" in shown or kind in shown else f"{kind} {shown}"


def _plain(cell: Cell) -> Cell:
    """A cell whose numbers are Python's own, as those of NumPy and of enumerations are not."""
    if isinstance(cell, Emphasis):
        return Emphasis(cast(Value, cell.cell if isinstance(cell.cell, Emphasis) else _plain(cell.cell)))
    found = cell.item() if isinstance(cell, np.generic) else cell
    return cast(Cell, next((kind(found) for kind in (bool, int, float) if isinstance(found, kind)), found))


def plain_words(phrase: Phrase) -> str:
    """The beginning of a phrase, for messages."""
    words = "".join(p if isinstance(p, str) else getattr(p, "text", str(p)) for p in parts(phrase))
    return words if len(words) <= 80 else f"{words[:80]}…"
