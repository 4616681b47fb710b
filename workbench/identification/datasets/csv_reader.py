"""A CSV file of any length as columns of a log: streamed by pandas, and read cell by cell where something is odd."""

from __future__ import annotations

import csv
import gzip
import re
import warnings
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np

from workbench.core.csv_file import LONGEST_PATH, number_of, time_names
from workbench.core.validation.refusals import Array, describe
from workbench.identification.datasets.log_columns import TIME_WORDS, LogChoice, LogColumns, head_parts

ROWS = 2**16  # of a chunk
EMPTY = ("", "nan", "NaN", "NAN")
FIRST_LINES = 50  # of numbers, which tell the decimal mark
SEPARATOR = re.compile(r"sep=(.)")  # a first line as Excel reads it
COMMA = re.compile(r"[+-]?\d+,\d+(e[+-]?\d+)?", re.I)
DATE = re.compile(r"\d[-:./]\d")
DATES = "read dates by `Dataset.from_frame(pandas.read_csv(path, parse_dates=['{}']))`"
OTHERS = "mend the line, name the text of a lost sample by `absent`, or leave the column out by `signals`"
ADVICE = ", and begin a line above the names with #; commas, semicolons or tabs part the cells"
FEWER = "choose columns by `signals`, or take every n-th line by `every`"


class SheetHead(NamedTuple):
    """The mark between cells, the heads of the columns, the number of their last line, and the decimal mark."""

    separator: str
    heads: tuple[str, ...]
    skip: int
    decimal: str


@dataclass(frozen=True)
class _Sheet:
    """A file with its head, and the columns that are wanted."""

    choice: LogChoice
    path: Path
    separator: str
    decimal: str  # "." or ","
    heads: tuple[str, ...]
    skip: int  # lines up to the last of the head
    wanted: tuple[int, ...]
    empty: tuple[str, ...]  # texts of a cell without a sample
    every: int


def read_csv(path: str | Path, choice: LogChoice, absent: Sequence[str] = (), every: int = 1) -> LogColumns:
    """The columns of a CSV file, plain or gzipped; an empty cell and the texts in `absent` are no sample."""
    place = Path(path)
    if not place.is_file():
        raise LookupError(f"There is no file {choice.source}.")
    try:
        with _opened(place) as handle:
            separator, heads, skip, decimal = _head(choice, handle)
        time = choice.time_head(heads, ADVICE)
        picks = choice.pick(heads, [time] if time else [])
        used = [head for head in (time, *picks) if head]
        if repeats := [head for head in used if heads.count(head) > 1]:
            raise ValueError(
                f"`{choice.call}` must have different names of columns; {choice.source} has {heads.count(repeats[0])} "
                f"columns {repeats[0]!r}: rename one in the file, or leave it out by `signals`."
            )
        wanted = tuple(heads.index(head) for head in used)
        sheet = _Sheet(choice, place, separator, decimal, heads, skip, wanted, (*EMPTY, *absent), every)
        numbers = _streamed(sheet)
        numbers = _cell_by_cell(sheet) if numbers is None else numbers
    except (OSError, EOFError, zlib.error) as error:
        raise LookupError(f"{choice.source} cannot be read: {getattr(error, 'strerror', None) or error}.") from None
    except UnicodeDecodeError as error:
        raise ValueError(
            f"`{choice.call}` must be a text file in UTF-8; {choice.source} is none at byte {error.start}."
        ) from None
    first = 1 if time else 0
    t, notes = choice.seconds(time, numbers[:, 0] if time else None, len(numbers))
    if not time:
        t = t * every
    columns = {picks[head][0]: numbers[:, first + i] for i, head in enumerate(picks)}
    if every > 1:
        notes = (*notes, f"Every {every}th line of the file was read, without a filter.")
    empty = int(np.isnan(numbers[:, first:]).sum())
    if empty:
        notes = (*notes, f"{empty} of {numbers[:, first:].size} cells are empty or no sample, and are NaN.")
    return LogColumns(choice.source, t, columns, dict(picks.values()), notes)


def _opened(path: Path) -> TextIO:
    if path.suffix == ".gz":
        return gzip.open(path, "rt", encoding="utf-8-sig", newline="")
    return path.open(encoding="utf-8-sig", newline="")


def _head(choice: LogChoice, handle: TextIO) -> SheetHead:
    """The head of a file: the first line that is not blank and no comment, and a line of units below it."""
    numbered = ((number, line) for number, line in enumerate(handle, 1) if line.strip() and line.lstrip()[0] != "#")
    number, line = next(numbered, (0, ""))
    separator = ""
    if said := SEPARATOR.fullmatch(line.strip().lower()):
        separator = said[1]
        number, line = next(numbered, (0, ""))
    if not number:
        raise ValueError(
            f"`{choice.call}` must have a first line with the names of its columns; {choice.source} is empty."
        )
    separator = separator or next((mark for mark in "\t;" if mark in line), ",")
    cells = _cells(line, separator)
    if all(number_of(cell) is not None for cell in cells if cell):
        raise ValueError(
            f"`{choice.call}` must have a first line with the names of its columns, as 't [s],omega [rad/s]' or "
            f"'t:s,omega:rad/s' is; {choice.source} begins with numbers."
        )
    below = [(place, _cells(text, separator)) for place, text in islice(numbered, FIRST_LINES)]
    if below and (units := _heads_with_units(cells, below[0][1])):
        number, cells = below.pop(0)[0], units
    return SheetHead(separator, cells, number, _decimal(separator, [texts for _, texts in below]))


def _cells(line: str, separator: str) -> tuple[str, ...]:
    return tuple(cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True)))


def _heads_with_units(heads: tuple[str, ...], cells: tuple[str, ...]) -> tuple[str, ...]:
    """The heads with the units of the line below; nothing if that is no line of units, that of the time among them."""
    pairs = list(zip(heads, (cell.strip("[]()") for cell in cells), strict=False))
    times = time_names(heads)
    is_units = len(heads) == len(cells) and not any(head_parts(head)[1] for head in heads)
    if not is_units or not any(head in times and (unit in TIME_WORDS or unit in ("s", "ms")) for head, unit in pairs):
        return ()
    if any(number_of(cell) is not None for cell in cells):
        return ()
    return tuple(f"{head} [{unit}]" if head and unit else head for head, unit in pairs)


def _decimal(separator: str, lines: Sequence[Sequence[str]]) -> str:
    """The decimal mark of the first lines: a comma if cells have one, none a point, and another mark parts them."""
    cells = [cell for line in lines for cell in line]
    has_comma = any(COMMA.fullmatch(cell) for cell in cells)
    has_point = any("." in cell and number_of(cell) is not None for cell in cells)
    return "," if separator != "," and has_comma and not has_point else "."


def _streamed(sheet: _Sheet) -> Array | None:
    """The numbers (rows, wanted) by the C reader of pandas, or None if a cell or a line is odd."""
    parts, seen = [np.zeros((0, len(sheet.wanted)))], 0
    for numbers in _chunks(sheet):
        if numbers is None:
            return None
        if not seen and len(numbers) == ROWS:
            _refuse_long(sheet)
        parts.append(numbers[-seen % sheet.every :: sheet.every].copy())  # a view would keep the whole chunk
        seen += len(numbers)
        sheet.choice.refuse_size(seen / sheet.every, len(sheet.wanted), FEWER)
    return np.concatenate(parts)


def _refuse_long(sheet: _Sheet) -> None:
    """Refuse a file of too many numbers by its size and the length of its first lines."""
    size = sheet.path.stat().st_size
    if sheet.path.suffix != ".gz":
        rows = ROWS * size / _bytes_of_rows(sheet) / sheet.every
        sheet.choice.refuse_size(rows, len(sheet.wanted), f"the file has {size / 1e6:.0f} MB; {FEWER}")


def _chunks(sheet: _Sheet) -> Iterator[Array | None]:
    """The numbers of each 65536 lines, or None where a cell or a line is odd."""
    import pandas as pd

    wanted = list(sheet.wanted)
    try:
        with pd.read_csv(
            sheet.path,
            sep=sheet.separator,
            decimal=sheet.decimal,
            header=None,
            names=list(range(len(sheet.heads))),
            index_col=False,
            skiprows=sheet.skip,
            dtype={i: "float64" if i in wanted else "object" for i in range(len(sheet.heads))},
            na_values=list(sheet.empty),
            keep_default_na=False,
            skipinitialspace=True,
            chunksize=ROWS,
            encoding="utf-8",
        ) as frames:
            while True:
                with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):
                    frame = next(frames, None)
                if frame is None:
                    return
                numbers = frame[wanted].to_numpy(dtype=float)
                if frame[len(sheet.heads) - 1].isna().any() or np.isinf(numbers).any():
                    break  # a line may have too few cells, which pandas fills
                yield numbers
    except pd.errors.EmptyDataError:
        return
    except (ValueError, pd.errors.ParserWarning):
        pass
    yield None


def _bytes_of_rows(sheet: _Sheet) -> int:
    """The bytes of the lines of one chunk."""
    with sheet.path.open("rb") as handle:
        lines = (len(line) for _, line in zip(range(sheet.skip + ROWS), handle, strict=False))
        return sum(lines)


def _lines(sheet: _Sheet) -> Iterator[tuple[int, list[str]]]:
    """The lines below the head with their numbers."""
    with _opened(sheet.path) as handle:
        for _ in range(sheet.skip):
            handle.readline()
        reader = csv.reader(handle, delimiter=sheet.separator, skipinitialspace=True, strict=True)
        try:
            for cells in reader:
                if any(map(str.strip, cells)) and not cells[0].lstrip().startswith("#"):
                    yield reader.line_num + sheet.skip, cells
        except csv.Error as error:
            raise ValueError(
                f"`{sheet.choice.call}` must be a CSV file; {sheet.choice.source} is none at line "
                f"{reader.line_num + sheet.skip}: {error}."
            ) from None


def _cell_by_cell(sheet: _Sheet) -> Array:
    """The numbers (rows, wanted), each cell looked at; an odd one is refused by line and column."""
    parts, rows = [np.zeros((0, len(sheet.wanted)))], list[list[float]]()
    for count, (line, cells) in enumerate(_lines(sheet)):
        if len(cells) != len(sheet.heads):
            raise ValueError(
                f"`{sheet.choice.call}` must have a cell for each of its {len(sheet.heads)} columns in each line; line "
                f"{line} of {sheet.choice.source} has {len(cells)}."
            )
        if count % sheet.every:
            continue
        rows.append([_cell(sheet, line, place, cells[place].strip()) for place in sheet.wanted])
        if len(rows) == ROWS:
            if len(parts) == 1:
                _refuse_long(sheet)
            parts, rows = [*parts, np.array(rows)], []
            sheet.choice.refuse_size(len(parts) * ROWS, len(sheet.wanted), FEWER)
    return np.concatenate([*parts, np.array(rows).reshape(-1, len(sheet.wanted))])


def _cell(sheet: _Sheet, line: int, place: int, cell: str) -> float:
    if cell in sheet.empty:
        return np.nan
    value = number_of(cell.replace(",", ".") if sheet.decimal == "," else cell)
    if value is None or np.isinf(value):
        head = sheet.heads[place]
        is_date = DATE.search(cell) and place == sheet.wanted[0]
        raise ValueError(
            f"`{sheet.choice.call}` must have a finite number or nothing in each cell that is used; line {line} of "
            f"{sheet.choice.source} has {describe(cell)} for '{head}': {DATES.format(head) if is_date else OTHERS}."
        )
    return value


def source_name(path: str | Path) -> str:
    """The name of a file in messages and reports."""
    return describe(Path(path).name, LONGEST_PATH)
