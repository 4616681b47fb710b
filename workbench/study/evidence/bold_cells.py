"""Cells in bold: the rules by which a table of laws sets a cell in bold."""

from __future__ import annotations

from collections.abc import Sequence

from workbench.study.document.document import BoldCell, Cell, Value, ValueWithError
from workbench.study.evidence.pairwise_comparison import Comparison
from workbench.study.evidence.value_order import order
from workbench.study.study import Outcome

BOLD = "Bold: significantly better than each other law."


def bold_if_best(value: Value, one: Comparison, law: str) -> Cell:
    """The cell of a law, in bold if the comparison finds the law significantly better than every other."""
    return BoldCell(value) if one.best == law else value


def bold_if_decided(value: Value, one: Comparison, law: str, other: str) -> Cell:
    """The cell of a law, in bold if the comparison finds a significant difference from the other law."""
    return BoldCell(value) if one.order(law, other) != "undecided" else value


def bold_if(condition: bool, cell: Cell) -> Cell:
    """The cell, in bold if the condition holds and the cell shows a value that was measured."""
    return BoldCell(cell) if condition and isinstance(cell, ValueWithError) else cell


def outcome_below_all(outcomes: Sequence[Outcome], metric: str, signal: int | str, margin: float) -> Outcome | None:
    """The outcome whose metric lies below all others by more than both errors and the margin, or None if none does.

    Outcomes that diverged are left out.
    """
    ran = [o for o in outcomes if o.diverged_at is None and metric in o.measurement.names]
    scores = [(o, o.score(metric, signal).pair) for o in ran]
    finite = [(o, score) for o, score in scores if score[0] < float("inf")]
    for outcome, a in finite:
        if all(other is outcome or order(a, b, margin) == "below" for other, b in finite):
            return outcome
    return None
