"""Row: one line of the table, what was asked and what was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """One thing that was measured, beside its bar.

    Attributes
    ----------
    runs_per_s
        Of a peer: full runs of W in a second of one core; None where it was not measured.
    ratio
        How many times as fast we are.
    bar
        What ratio, or what value in its own `unit`, is to be reached.
    value, unit, at_most
        Where no ratio is asked for: what was measured, and whether less is better.
    error
        Of a peer: the relative error of its RMSE at its settings, the median over some runs.
    note
        How it was measured, or why it was not.
    """

    name: str
    bar: float
    runs_per_s: float | None = None
    ratio: float | None = None
    value: float | None = None
    unit: str = ""
    at_most: bool = False
    error: float | None = None
    note: str = ""

    @property
    def reached(self) -> bool | None:
        """Whether the bar is reached; None if nothing was measured."""
        measured = self.value if self.unit else self.ratio
        if measured is None:
            return None
        return measured <= self.bar if self.at_most else measured >= self.bar

    def as_json(self) -> dict[str, Any]:
        """The row in the names of JSON; `value` and `unit` where no ratio is asked for."""
        own = {"value": self.value, "unit": self.unit, "at_most": self.at_most} if self.unit else {}
        return {
            "name": self.name,
            "runs_per_s": self.runs_per_s,
            "ratio": self.ratio,
            "bar": self.bar,
            "reached": self.reached,
            **own,
            "error": self.error,
            "note": self.note,
        }

    def cells(self) -> tuple[str, ...]:
        """Name, rate, what was measured, its bar, the error and the verdict, as text."""
        unit = self.unit or "x"
        measured = self.value if self.unit else self.ratio
        sign = "\N{LESS-THAN OR EQUAL TO}" if self.at_most else "\N{GREATER-THAN OR EQUAL TO}"
        return (
            self.name,
            "" if self.runs_per_s is None else short(self.runs_per_s),
            "-" if measured is None else f"{short(measured)} {unit}",
            f"{sign} {short(self.bar)} {unit}",
            "" if self.error is None else f"{self.error:.1e}",
            {True: "reached", False: "MISSED", None: "not measured"}[self.reached],
        )


HEADS = ("", "runs/s/core", "measured", "bar", "error", "")


def lines(rows: Sequence[Row]) -> list[str]:
    """The table as text, its numbers flush right, and the notes below it."""
    cells = [HEADS, *(row.cells() for row in rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(HEADS))]
    table = (
        "  ".join(
            [f"{row[0]:{widths[0]}}", *(f"{c:>{w}}" for c, w in zip(row[1:-1], widths[1:-1], strict=True)), row[-1]]
        )
        for row in cells
    )
    notes = [f"{row.name}: {row.note}" for row in rows if row.note]
    return [*(line.rstrip() for line in table), *([""] if notes else []), *notes]


def short(value: float) -> str:
    """Three digits, or all of a larger whole part."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
