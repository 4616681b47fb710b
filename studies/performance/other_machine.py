"""The targets of an earlier print of this page on another machine, whose processor has vectors of eight numbers."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import workbench as wb
from studies.performance.measurements import Row

FILE = Path(__file__).parent / "machines" / "avx512.csv"  # the table of bars, as the page of that day holds it
WHERE = "the page of 25 November 2026, on an AMD EPYC with AVX-512"


@dataclass(frozen=True)
class PrintedRow:
    """A measured value with its unit, and the verdict."""

    value: str
    verdict: str


@cache
def printed_rows() -> dict[str, PrintedRow]:
    """The rows of that page by their names."""
    with FILE.open(encoding="utf-8", newline="") as lines:
        return {row["against, or what"]: PrintedRow(row["measured"], row["verdict"]) for row in csv.DictReader(lines)}


def count() -> str:
    """The number of targets reached on that machine."""
    verdicts = [one.verdict for one in printed_rows().values()]
    measured = [one for one in verdicts if one in ("reached", "MISSED")]
    return f"{measured.count('reached')} of {len(measured)}"


def machines(here: Sequence[tuple[Row, str]]) -> wb.document.ReportTable:
    """Each row as measured here, in words, and as measured on that machine."""
    rows = tuple(
        (row.name, words or None, there.value) for row, words in here if (there := printed_rows().get(row.name))
    )
    columns = (
        wb.document.TableColumn("against, or what"),
        *(wb.document.TableColumn(head, align="right") for head in ("this machine", "AVX-512")),
    )
    note = (
        f"AVX-512: {WHERE}, by an earlier version of this code. The vectors of that processor hold eight numbers. The "
        "last lines of this section name the machine of this page."
    )
    return wb.document.ReportTable("machines", "The same rows on two machines.", columns, rows, (note,))
