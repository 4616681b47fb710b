"""Export of results: tables with a row a run and time, or a metric of a case, as CSV, Parquet and MAT; and records."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.engine.metrics import Measurement
from workbench.engine.metrics.score import MetricColumn
from workbench.engine.step_choice import StepChoice
from workbench.study.document.phrases_and_tables import check_name
from workbench.study.ledger.chunk import Chunk, chunk_of
from workbench.study.ledger.durability import write_durably
from workbench.study.ledger.ownership import LedgerError, refuse_links
from workbench.study.ledger.store import TABLE
from workbench.study.run_and_sweep import COLUMNS
from workbench.study.sample import ARRAYS, Sample

if TYPE_CHECKING:
    import pandas as pd

    from workbench.study.study import Results

CASES = "runs/cases.csv"  # below the folder of a report
BLOCK = 10_000  # rows of a table that are text at once
WORDS = ("name", "factors", "seed", "fingerprint", "arithmetic")  # of a record


def tables(results: Results) -> dict[str, bytes]:
    """The tables of all results as CSV, by their places below the folder of a report."""
    files = {f"runs/{sample.name}.csv": to_csv(sample) for sample in results.all_samples}
    return files | ({CASES: cases_to_csv(results.rows)} if results.rows else {})


def to_csv(sample: Sample) -> bytes:
    """The table after RFC 4180, numbers with all their digits; missing values are empty, no head is a formula."""
    names, columns = zip(*_columns(sample), strict=True)
    head, out = io.StringIO(), io.BytesIO()
    csv.writer(head).writerow(map(spreadsheet_text, names))
    out.write(head.getvalue().encode(errors="replace"))
    for first in range(0, len(columns[0]), BLOCK):  # as text a number takes ten times its place in memory
        texts = ([_written(value) for value in column[first : first + BLOCK].tolist()] for column in columns)
        out.write("".join(",".join(row) + "\r\n" for row in zip(*texts, strict=True)).encode())
    return out.getvalue()


def cases_to_csv(rows: Sequence[Mapping[str, object]]) -> bytes:
    """The values of single cases after RFC 4180, one row a metric and signal; missing values are empty."""
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(rows[0] if rows else ())
    writer.writerows([_cell(value) for value in row.values()] for row in rows)
    return out.getvalue().encode(errors="replace")


def _cell(value: object) -> str:
    if value is None or value != value:
        return ""
    if isinstance(value, str):
        return spreadsheet_text(value)
    return repr(value.item() if isinstance(value, np.generic) else value)


def spreadsheet_text(text: str) -> str:
    """A text as a cell or head of a CSV file, after an apostrophe where spreadsheets would run it as a formula.

    They run what begins with =, +, - or @, also in full width, some of them behind blanks and signs that are not seen,
    or behind a tab or line break. Plain numbers alone stay: "-1.5", "-10 to 10", "+9.4 % (+3.4 to +11.6)".
    """
    return f"'{text}" if _FORMULA.match(text) and not _is_of_numbers(text) else text


def _is_of_numbers(text: str) -> bool:
    return all(word in ("to", "±", "%") or _NUMBER.fullmatch(word.strip("()")) for word in text.split(" "))


_FORMULA = re.compile("[\t\r\n]|[\\s\x00-\x1f\x7f-\x9f\xad\u200b-\u200f\u2060\ufeff]*[=+@＝＋－＠-]")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


def write(sample: Sample, folder: Path, form: str) -> Path:
    """Write the table to a file of the folder, which is there whole or not at all."""
    import pandas as pd

    refuse_links(folder.parent, f"{folder.name}/{sample.name}.{form}")
    folder.mkdir(parents=True, exist_ok=True)
    ways = {
        "csv": lambda: to_csv(sample),
        "parquet": lambda: _to_parquet(pd.DataFrame(dict(_columns(sample)))),
        "mat": lambda: _to_mat(_arrays(sample)),
    }
    file = folder / f"{sample.name}.{form}"
    write_durably(file, ways[form]())
    return file


def case_table_of(results: Results) -> Chunk:
    """The values of single cases as a record, which can be read without their study."""
    return chunk_of(f"{TABLE}/cases", {}, {"rows": results.rows})


def write_cases(folder: Path, form: str, table: Chunk | None = None) -> Path:
    """Write the table of the single cases, from its record or else from the CSV of a report, in a form."""
    file = (folder / CASES).with_suffix(f".{form}")
    if table is not None:
        refuse_links(folder, CASES)
        (folder / CASES).parent.mkdir(parents=True, exist_ok=True)
        write_durably(folder / CASES, cases_to_csv(_rows_of(table)))
    if form == "csv":
        return file
    refuse_links(folder, str(file.relative_to(folder)))
    import pandas as pd

    frame = pd.read_csv(folder / CASES)
    held = {str(name): column.to_numpy() for name, column in frame.items()}
    write_durably(file, _to_parquet(frame) if form == "parquet" else _to_mat(held))
    return file


def _rows_of(table: Chunk) -> list[dict[str, object]]:
    rows = table.content.get("rows")
    if not (isinstance(rows, list) and all(isinstance(row, dict) and row.keys() == rows[0].keys() for row in rows)):
        raise LedgerError(f"The record '{table.name}' is no table of cases: `workbench run` writes it again.")
    return rows


def _to_parquet(frame: pd.DataFrame) -> bytes:
    try:
        return frame.to_parquet(engine="pyarrow", index=False)
    except ImportError as error:
        raise ValueError(
            "Parquet needs the extra `data`: install `control-workbench[data]`, or take CSV or MAT."
        ) from error


def _to_mat(held: Mapping[str, object]) -> bytes:
    from scipy.io import savemat

    out = io.BytesIO()
    savemat(out, dict(held), oned_as="column")  # type: ignore[arg-type]  # its stubs know paths alone
    return bytes(out.getvalue())


def _arrays(sample: Sample) -> dict[str, object]:
    """Arrays as `Measurement` has them, and the names of their columns beside them."""
    found = sample.measurement
    labels = [f"{head} [{one.unit}]" for head, one in zip(found.column_headers, found.columns, strict=True)]
    return {
        "t": found.t,
        "factors": sample.factor_values,
        "factor_names": np.array(sample.factors, dtype=object),
        "metrics": found.values,
        "metric_names": np.array(labels, dtype=object),
        "errors": found.errors,
        "error_runs": found.looked_at,
        "limits": found.limits,
        "diverged_at": found.diverged_at,
        "seed": float(sample.seed),
        "h": found.h,
        "fingerprint": sample.fingerprint,
    }


def _columns(sample: Sample) -> Iterator[tuple[str, Array]]:
    found = sample.measurement
    runs, times = found.values.shape[:2]
    run, time, lost = COLUMNS
    yield run, np.repeat(np.arange(runs), times)
    if times > 1:
        yield time, np.tile(found.t, runs)
    for name, column in zip(sample.factors, sample.factor_values.T, strict=True):
        yield name, np.repeat(column, times)
    errors = np.full(found.values.shape, np.nan)
    errors[found.looked_at] = found.errors
    for i, (head, one) in enumerate(zip(found.column_headers, found.columns, strict=True)):
        measured = f" [{one.unit}]" if one.unit else ""
        yield f"{head}{measured}", found.values[..., i].ravel()
        yield f"{head} (error){measured}", errors[..., i].ravel()
    yield lost, np.repeat(found.diverged_at, times)


def _written(value: float) -> str:
    return "" if value != value else repr(value)


def table_of(sample: Sample) -> Chunk:
    """The sample as a record, which can be read without its study."""
    found = sample.measurement
    words: dict[str, object] = {name: getattr(sample, name) for name in WORDS}
    words |= {"columns": found.columns, "h": found.h, "tolerance": found.tolerance}
    words |= {"choice": None if found.choice is None else found.choice.record}
    words |= {"unseen": found.pulse_warnings}
    arrays = {name: getattr(found, name).astype(float) for name in ARRAYS}
    return chunk_of(f"{TABLE}/{sample.name}", {"drawn": sample.factor_values, **arrays}, words)


def sample_of(table: Chunk) -> Sample:
    """The sample of such a record."""
    try:
        words, arrays = table.content, table.arrays()
        check_name("Sample", words["name"])
        columns = tuple(
            MetricColumn(str(m), int(number), str(unit), str(label)) for m, number, unit, label in words["columns"]
        )
        factors, drawn = tuple(map(str, words["factors"])), arrays.pop("drawn")
        runs, times, m = (arrays[name].size for name in ("diverged_at", "t", "looked_at"))
        shapes = ((times,), (runs, times, len(columns)), (runs,), (m,), (m, times, len(columns)), (m,), (m,))
        if tuple(arrays[name].shape for name in ARRAYS) != shapes or drawn.shape != (runs, len(factors)):
            raise ValueError(table.name)
        looked_at = arrays["looked_at"]
        if not ((looked_at >= 0) & (looked_at < runs)).all():
            raise ValueError(table.name)
        found = Measurement(
            columns,
            h=float(words["h"]),
            looked_at=looked_at.astype(int),
            tolerance=None if words["tolerance"] is None else float(words["tolerance"]),
            choice=None if words["choice"] is None else StepChoice.from_record(words["choice"]),
            pulse_warnings=tuple(map(str, words["unseen"])),
            t=arrays["t"],
            values=arrays["values"],
            diverged_at=arrays["diverged_at"],
            errors=arrays["errors"],
            half_diverged_at=arrays["half_diverged_at"],
            limits=arrays["limits"],
        )
        rounding = str(words["arithmetic"])
        return Sample(
            words["name"], factors, drawn, found, int(words["seed"]), str(words["fingerprint"]), arithmetic=rounding
        )
    except (LookupError, TypeError, ValueError, OverflowError):
        raise LedgerError(f"The record '{table.name}' is no table of runs: `workbench run` writes it again.") from None
