"""Comparisons and ranks as tables: bold, and words, only where a difference is significant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from workbench.study.document import Cell, Column, Emphasis, Measured, Phrase, Table, Value
from workbench.study.evidence.bootstrap import Intervals
from workbench.study.evidence.comparison import Comparison
from workbench.study.evidence.ranks import Ranks
from workbench.validation.doors import door

HALF = "in brackets the half-width of its interval, in units of the last digits"
FAILS = "fails"
MANY = 1000  # percent, from which on a change is told in times


@door
def comparison_table(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], notes: tuple[Phrase, ...] = ()
) -> Table:
    """One row a law, one column a metric, and the failed runs; the significantly least of a column is bold.

    Raises
    ------
    ValueError
        If there is no comparison, or two are of other laws.
    """
    laws = _laws("comparison_table", comparisons)
    failed = np.max([one.paired.failed for one in comparisons], axis=0)
    rows: list[tuple[Cell, ...]] = []
    for i, law in enumerate(laws):
        cells: list[Cell] = []
        for one in comparisons:
            shown = _measured(one.level, (i,))
            cells.append(Emphasis(shown) if one.best == law else shown)
        rows.append((law, *cells, int(failed[i])))
    heads = (Column(one.paired.metric, one.paired.unit, "right") for one in comparisons)
    columns = (Column("law"), *heads, Column("failed runs", align="right"))
    bold = f"Bold: significantly less than for each other law. A number is a {_statistics(comparisons)}, {HALF}."
    return Table(name, caption, columns, tuple(rows), (bold, *_said(comparisons), *notes))


@door
def difference_table(name: str, caption: Phrase, comparison: Comparison, notes: tuple[Phrase, ...] = ()) -> Table:
    """The law of the row minus the law of the column, for all pairs; what is significant is bold.

    Raises
    ------
    ValueError
        If this is no comparison.
    """
    paired = comparison.paired
    rows: list[tuple[Cell, ...]] = []
    for i, law in enumerate(paired.laws):
        cells: list[Cell] = []
        for j, other in enumerate(paired.laws):
            shown = None if i == j else _measured(comparison.difference, (i, j))
            cells.append(Emphasis(shown) if comparison.order(law, other) != "undecided" else shown)
        rows.append((law, *cells))
    heads = (Column(f"- {law}", paired.unit, "right") for law in paired.laws)
    bold = f"Bold: significant. A number is a {comparison.statistic} of differences within a draw, {HALF}."
    return Table(name, caption, (Column("law"), *heads), tuple(rows), (bold, comparison.said, *notes))


@door
def rank_table(name: str, caption: Phrase, ranks: Ranks, notes: tuple[Phrase, ...] = ()) -> Table:
    """In how many of a hundred draws each law has each rank.

    Raises
    ------
    ValueError
        If these are no ranks.
    """
    laws = ranks.paired.laws
    places = range(len(laws))
    rows: list[tuple[Cell, ...]] = [(law, *(_percent(ranks.ranks, i, j) for j in places)) for i, law in enumerate(laws)]
    columns = (Column("law"), *(Column(f"rank {rank}", "%", "right") for rank in range(1, len(laws) + 1)))
    how = (
        f"Share of the draws, in brackets half of its own {100 * ranks.confidence:g} % interval (Clopper and Pearson). "
        "Equal laws share the worse rank; a failed run ranks last."
    )
    return Table(name, caption, columns, tuple(rows), (how, ranks.paired.said, *notes))


@door
def ablation_table(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], whole: str, notes: tuple[Phrase, ...] = ()
) -> Table:
    """What becomes of each metric as a block is taken out of the law `whole`: the change in percent of the whole law.

    Raises
    ------
    ValueError
        If there is no comparison, or two are of other laws.
    LookupError
        If `whole` is none of the laws.
    """
    laws = _laws("ablation_table", comparisons)
    at = comparisons[0].paired.place(whole)
    failed = np.max([one.paired.failed for one in comparisons], axis=0)
    rows: list[tuple[Cell, ...]] = [(whole, *(_measured(one.level, (at,)) for one in comparisons), int(failed[at]))]
    rows += [
        (f"without {law}", *(_change(one, i, at) for one in comparisons), int(failed[i]))
        for i, law in enumerate(laws)
        if i != at
    ]
    heads = (Column(one.paired.metric, one.paired.unit, "left") for one in comparisons)
    columns = (Column("law"), *heads, Column("failed runs", align="right"))
    how = (
        f"First row: the {_statistics(comparisons)} of the whole law, {HALF}. Below: how much more the law has without "
        "a block, in percent of the whole law's, with the interval; less is better. Bold: significant."
    )
    return Table(name, caption, columns, tuple(rows), (how, *_said(comparisons), *notes))


def _laws(call: str, comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    kinds = {one.paired.laws for one in comparisons}
    if len(kinds) != 1:
        raise ValueError(f"`{call}(comparisons=...)` needs comparisons of the same laws; got {sorted(kinds)}.")
    return kinds.pop()


def _statistics(comparisons: Sequence[Comparison]) -> str:
    return " or ".join(dict.fromkeys(one.statistic for one in comparisons))


def _said(comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    """What is to be said of each metric, and once what is to be said of all."""
    each = (one.paired.said for one in comparisons)
    alike = dict.fromkeys(one.said for one in comparisons)
    notes = dict.fromkeys(one.paired.note for one in comparisons if one.paired.note)
    often = any(np.isinf(one.level.value).any() for one in comparisons)
    fails = ("Fails: no median, as half of the runs or more failed.",) if often else ()
    return (*fails, *alike, *each, *notes)


def _measured(found: Intervals, place: tuple[int, ...]) -> Value:
    value, low, high = float(found.value[place]), float(found.low[place]), float(found.high[place])
    if np.isnan(value):
        return "no mean"
    if np.isinf(value):
        return FAILS
    half = max(high - value, value - low)
    return Measured(value, half) if np.isfinite(half) else f"{value:.3g}, not bounded"


def _change(one: Comparison, i: int, at: int) -> Cell:
    """The change from the whole law, in percent of it."""
    d = one.difference
    size = float(one.level.value[at])
    if not (size and np.isfinite(size)) or np.isnan(d.value[i, at]):  # nothing is so many percent of zero
        return "not known"
    value, low, high = (100 * float(part[i, at]) / size + 0.0 for part in (d.value, d.low, d.high))
    if np.isinf(value):
        return Emphasis(FAILS)
    many = value >= MANY
    text = _text((1 + end / 100 for end in (value, low, high)), "times") if many else _text((value, low, high), "%")
    laws = one.paired.laws
    return Emphasis(text) if one.order(laws[i], laws[at]) != "undecided" else text


def _text(numbers: Iterable[float], unit: str) -> str:
    """A value and its interval."""
    sign = "+" if unit == "%" else ""
    value, *ends = (_short(number, sign) if np.isfinite(number) else "not bounded" for number in numbers)
    return f"{value} {unit} ({' to '.join(ends)})"


def _short(number: float, sign: str) -> str:
    """Three digits, or all of them before the point."""
    return f"{number:{sign},.0f}" if abs(number) >= 1000 else f"{number:{sign}.3g}"


def _percent(found: Intervals, i: int, j: int) -> Measured:
    value, low, high = (100 * float(part[i, j]) for part in (found.value, found.low, found.high))
    return Measured(value, max(high - value, value - low))
