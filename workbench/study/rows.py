"""Results as tables, one row a run and time of a sample, or a metric of a case: CSV, Parquet, MAT."""

from __future__ import annotations

import csv
import io
import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from workbench.study.sample import Sample
from workbench.study.sweep import COLUMNS
from workbench.validation.refusals import Array

if TYPE_CHECKING:
    import pandas as pd

    from workbench.study.study import Results

FORMS = ("csv", "parquet", "mat")
CASES = "runs/cases.csv"  # below the folder of a report
BLOCK = 10_000  # rows of a table that are text at once


def to_frame(sample: Sample) -> pd.DataFrame:
    """Run, time, factors, values, errors where they are known, and when a run diverged."""
    import pandas as pd

    return pd.DataFrame(dict(_columns(sample)))


def to_csv(sample: Sample) -> bytes:
    """The table after RFC 4180, numbers with all their digits; what does not exist is empty, no head is a formula."""
    names, columns = zip(*_columns(sample), strict=True)
    head, out = io.StringIO(), io.BytesIO()
    csv.writer(head).writerow(map(spreadsheet_text, names))
    out.write(head.getvalue().encode(errors="replace"))
    for first in range(0, len(columns[0]), BLOCK):  # as text a number takes ten times its place in memory
        texts = ([_written(value) for value in column[first : first + BLOCK].tolist()] for column in columns)
        out.write("".join(",".join(row) + "\r\n" for row in zip(*texts, strict=True)).encode())
    return out.getvalue()


def cases_to_csv(results: Results) -> bytes:
    """The values of single cases after RFC 4180, one row a metric and number; what does not exist is empty."""
    rows, out = results.rows, io.StringIO()
    writer = csv.writer(out)
    writer.writerow(rows[0] if rows else ())
    writer.writerows([_cell(value) for value in row.values()] for row in rows)
    return out.getvalue().encode(errors="replace")


def _cell(value: object) -> str:
    if value is None or value != value:
        return ""
    return (
        spreadsheet_text(value)
        if isinstance(value, str)
        else repr(value.item() if isinstance(value, np.generic) else value)
    )


def spreadsheet_text(text: str) -> str:
    """A text as a cell or head of a CSV file, after an apostrophe where spreadsheets would run it as a formula.

    They run what begins with =, +, - or @, also in full width, and some of them look behind blanks and signs that
    are not seen; a tab or line break before anything else may end the cell before it. What is made of plain numbers
    alone stays as it is: "-1.5", "-10 to 10", "+9.4 % (+3.4 to +11.6)".
    """
    return f"'{text}" if _FORMULA.match(text) and not _is_of_numbers(text) else text


def _is_of_numbers(text: str) -> bool:
    return all(word in ("to", "±", "%") or _NUMBER.fullmatch(word.strip("()")) for word in text.split(" "))


_FORMULA = re.compile("[\t\r\n]|[\\s\x00-\x1f\x7f-\x9f\xad\u200b-\u200f\u2060\ufeff]*[=+@＝＋－＠-]")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def write(sample: Sample, folder: Path, form: str) -> Path:
    """Write the table to a file of the folder, which is there whole or not at all.

    Raises
    ------
    LookupError
        If there is no such form.
    ValueError
        If the form is Parquet and its library is not here.
    """
    if form not in FORMS:
        raise LookupError(f"A form of results is one of {', '.join(FORMS)}; got '{form}'.")
    folder.mkdir(parents=True, exist_ok=True)
    ways: dict[str, Callable[[Path], object]] = {
        "csv": lambda part: part.write_bytes(to_csv(sample)),
        "parquet": lambda part: _write_parquet(to_frame(sample), part),
        "mat": lambda part: _write_mat(sample, part),
    }
    return _whole(folder / f"{sample.name}.{form}", ways[form])


def write_cases(folder: Path, form: str) -> Path:
    """Write the table of the single cases of a report, which stands there as CSV, in another form."""
    file = (folder / CASES).with_suffix(f".{form}")
    if form == "csv":
        return file
    import pandas as pd
    from scipy.io import savemat

    frame = pd.read_csv(folder / CASES)
    if form == "parquet":
        return _whole(file, lambda part: _write_parquet(frame, part))
    held = {str(name): column.to_numpy() for name, column in frame.items()}
    return _whole(file, lambda part: savemat(str(part), held, appendmat=False, oned_as="column"))


def _whole(file: Path, write: Callable[[Path], object]) -> Path:
    """The file, whole or not at all."""
    part = file.with_name(f"{file.name}.part")
    try:
        write(part)
        with part.open("r+b") as stream:
            os.fsync(stream.fileno())
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)
    return file


def _write_parquet(frame: pd.DataFrame, file: Path) -> None:
    try:
        frame.to_parquet(file, engine="pyarrow", index=False)
    except ImportError as error:
        raise ValueError(
            "Parquet needs the extra `data`: install `control-workbench[data]`, or take CSV or MAT."
        ) from error


def _write_mat(sample: Sample, file: Path) -> None:
    """Arrays as `Sample` has them, and the names of their columns beside them."""
    from scipy.io import savemat

    labels = [f"{head} [{unit}]" for head, (_, _, unit) in zip(sample.heads, sample.columns, strict=True)]
    held = {
        "t": sample.t,
        "factors": sample.drawn,
        "factor_names": np.array(sample.factors, dtype=object),
        "metrics": sample.values,
        "metric_names": np.array(labels, dtype=object),
        "errors": sample.errors,
        "error_runs": sample.again,
        "limits": sample.limits,
        "diverged_at": sample.diverged_at,
        "seed": float(sample.seed),
        "h": sample.h,
        "fingerprint": sample.fingerprint,
    }
    savemat(str(file), held, appendmat=False, oned_as="column")


def _columns(sample: Sample) -> Iterator[tuple[str, Array]]:
    """The columns by name; rows are the times of run 0, then those of run 1."""
    runs, times = sample.values.shape[:2]
    run, time, lost = COLUMNS
    yield run, np.repeat(np.arange(runs), times)
    if times > 1:
        yield time, np.tile(sample.t, runs)
    for name, column in zip(sample.factors, sample.drawn.T, strict=True):
        yield name, np.repeat(column, times)
    errors = np.full(sample.values.shape, np.nan)
    errors[sample.again] = sample.errors
    for i, (head, (_, _, unit)) in enumerate(zip(sample.heads, sample.columns, strict=True)):
        measured = f" [{unit}]" if unit else ""
        yield f"{head}{measured}", sample.values[..., i].ravel()
        yield f"{head} (error){measured}", errors[..., i].ravel()
    yield lost, np.repeat(sample.diverged_at, times)


def _written(value: float) -> str:
    return "" if value != value else repr(value)
