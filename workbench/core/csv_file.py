"""A CSV file as columns of numbers, with the names and units of its first line; errors name line and column."""

from __future__ import annotations

import csv
import gzip
import io
import re
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import count, takewhile
from pathlib import Path

import numpy as np

from workbench.core.units import checked_unit, join_units, read
from workbench.core.validation.refusals import Array, Integers, describe, known_name, seconds

LARGEST = 2**26  # bytes of a file
LONGEST_PATH = 300  # characters of a path that a message shows
HEAD = re.compile(r"(.*\S)(\s*)\[([^\[\]]+)\]", re.S)  # a name, and its unit in brackets
COLON = re.compile(r"([^:]*[^:\s][^:]*):([^:]*)", re.S)  # a name, and its unit behind the only colon
TIMES = ("t", "time")


@dataclass(frozen=True, eq=False)
class CsvFile:
    """The cells of a file as text: the names and units of its first line, and the other lines by their numbers."""

    call: str  # that reads it, for messages
    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]  # empty where the first line has none
    lines: tuple[tuple[int, Sequence[str]], ...]

    @staticmethod
    def read(call: str, path: str | Path) -> CsvFile:
        """The cells of a CSV file, plain or gzipped; blank lines and lines that begin with # are skipped."""
        name, text = describe(str(path), LONGEST_PATH), _text(call, path)
        first = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
        separator = next((mark for mark in "\t;" if mark in first), ",")
        lines: list[tuple[int, list[str]]] = []
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True, strict=True)
        try:
            for cells in reader:
                if any(map(str.strip, cells)) and not cells[0].lstrip().startswith("#"):
                    lines.append((reader.line_num, cells))
        except csv.Error as error:
            raise ValueError(
                f"`{call}` must be a CSV file; {name} is none at line {reader.line_num}: {error}."
            ) from None
        head, *rows = lines or [(0, [])]
        if not head[1] or all(number_of(cell) is not None for cell in head[1] if cell.strip()):
            raise ValueError(
                f"`{call}` must have a first line with the names of its columns, as 't [s],omega [rad/s]' is; {name} "
                f"{'begins with numbers' if head[1] else 'is empty'}."
            )
        if not rows:
            raise ValueError(f"`{call}` must have lines of numbers; {name} has none below its first.")
        for number, cells in rows:
            if len(cells) != len(head[1]):
                raise ValueError(
                    f"`{call}` must have a cell for each of its {len(head[1])} columns in each line; line {number} of "
                    f"{name} has {len(cells)}."
                )
        names, units = zip(*map(name_and_unit, head[1]), strict=True)
        return CsvFile(call, name, names, units, tuple(rows))

    def place(self, column: str) -> int:
        """The place of the column with a name, which must be in the first line exactly once."""
        known_name(column, dict.fromkeys(filter(None, self.names)), f"columns of {self.name}")
        if (times := self.names.count(column)) > 1:
            raise ValueError(f"`{self.call}` must have one column '{column}'; {self.name} has {times} of them.")
        return self.names.index(column)

    def numbers(self, column: str) -> Array:
        """The numbers of a column, (m,), all of them finite."""
        place, values = self.place(column), []
        for line, row in self.lines:
            value = number_of(row[place])
            if value is None or not np.isfinite(value):
                got = describe(row[place].strip()) if row[place].strip() else "nothing"
                raise ValueError(
                    f"`{self.call}` must have a finite number in each cell that is used, as no value can be guessed; "
                    f"line {line} of {self.name} has {got} for '{column}': leave the line out."
                )
            values.append(value)
        return np.array(values)

    def columns_of(self, signal: str) -> tuple[str, ...]:
        """The names of the columns of a signal: the name of the signal, or `q[0]`, `q[1]`, ... for a signal q."""
        several = tuple(takewhile(lambda name: name in self.names, (f"{signal}[{i}]" for i in count())))
        return several if several and signal not in self.names else (signal,)

    def times(self, column: str | float | None) -> Array:
        """The times of the lines in s, (m,), from a column, by default `t` or `time`, or from a period in s."""
        if column is not None and not isinstance(column, str):
            return np.arange(float(len(self.lines))) * seconds("Table.from_csv(time=...)", column)
        if column is None and (own := time_names(self.names)):
            column = own[0]
        if column is None:
            raise ValueError(
                f"`{self.call}` must have a column of time called 't' or 'time'; {self.name} has "
                f"{', '.join(map(repr, filter(None, self.names)))}: name it by `time`, or give the period there."
            )
        if (unit := self.units[self.place(column)]) not in ("", "s"):
            raise ValueError(f"`{self.call}` must have its times in s; '{column}' of {self.name} is in [{unit}].")
        return self.numbers(column)

    def rising_lines(self, times: Array, duplicates: str) -> Integers:
        """The places of lines whose times rise; of several lines with one time, only the "first" or the "last"."""
        changes = np.diff(times)
        if len(back := np.flatnonzero(~(changes >= 0) if duplicates in ("first", "last") else ~(changes > 0))):
            i = int(back[0])
            way = ": say which of the two is meant by `repeated`" if changes[i] == 0 else ""
            raise ValueError(
                f"`{self.call}` must have times that rise from line to line, as a signal has one value at a time; line "
                f"{self.lines[i + 1][0]} of {self.name} has {times[i + 1]:.9g} s after {times[i]:.9g} s{way}."
            )
        ends = np.flatnonzero(changes > 0)
        return np.append(0, ends + 1) if duplicates == "first" else np.append(ends, len(times) - 1)

    def unit(self, columns: Sequence[str], unit_text: str | None) -> str:
        """The unit of a signal, or one for each of its numbers; the first line and the given unit must agree."""
        said = [checked_unit(f"{column} [...]", self.units[self.place(column)]) for column in columns]
        own = [None] if unit_text is None else checked_unit("Table.from_csv(unit=...)", unit_text).split(", ")
        own = own * len(said) if len(own) == 1 else own
        if len(own) != len(said):
            raise ValueError(
                f"`Table.from_csv(unit=...)` must be one unit, or one a column, {len(said)}; got {unit_text!r}."
            )
        for column, unit, other in zip(columns, said, own, strict=True):
            if not unit and other is None:
                raise ValueError(
                    f"`{self.call}` must say the unit of '{column}', as '{column} [rad/s]' does, and {self.name} does "
                    "not: give it by `unit`."
                )
            if unit and other is not None and read(unit) != read(other):
                raise ValueError(
                    f"`Table.from_csv(unit=...)` must be the unit of the file, in which nothing is converted; "
                    f"'{column}' of {self.name} is in [{unit}], and got {other!r}."
                )
        units = [unit or str(other) for unit, other in zip(said, own, strict=True)]
        return join_units(units)


def name_and_unit(cell: str) -> tuple[str, str]:
    """The name and the unit in a head such as `omega [rad/s]` or `omega:rad/s`; the unit is empty if there is none.

    The number in `q[0]` is a part of the name, and so are two colons in a row. The unit of `ratio:` is '1'.
    """
    cell = cell.strip()
    found = HEAD.fullmatch(cell)
    if found is None and (colon := COLON.fullmatch(cell)):
        return colon[1].strip(), colon[2].strip() or "1"
    if found is None or (not found[2] and found[3].isdigit()):
        return cell, ""
    unit = found[3].strip()
    return found[1], "1" if unit == "-" else unit


def time_names(names: Iterable[str]) -> list[str]:
    """The names `t` and `time` among some names; if there is none, those that differ from them in capitals.

    `T` beside `t` is a temperature or a torque, and `T` alone may be the time.
    """
    own = list(names)
    return [name for name in own if name in TIMES] or [name for name in own if name.lower() in TIMES]


def number_of(cell: str) -> float | None:
    """The number in a cell, or None if it is no number."""
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        return None


def _text(call: str, path: str | Path) -> str:
    name = describe(str(path), LONGEST_PATH)
    try:
        if not Path(path).is_file():  # a folder, a pipe, which would wait for a writer, or nothing
            raise LookupError(f"There is no file {name}.")
        with gzip.open(path, "rb") if str(path).endswith(".gz") else Path(path).open("rb") as handle:
            raw = handle.read(LARGEST + 1)
    except (
        OSError,
        EOFError,
        ValueError,
        zlib.error,
    ) as error:  # of a path with a null character, or a broken archive, say
        raise LookupError(f"{name} cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    if len(raw) > LARGEST:
        raise ValueError(f"`{call}` must be a file of at most {LARGEST >> 20} MB; {name} has more: split it.")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"`{call}` must be a text file in UTF-8; {name} is none at byte {error.start}.") from None
