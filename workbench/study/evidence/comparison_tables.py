"""Comparisons and ranks as tables: bold, and words, only where a difference is significant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from workbench.study.document.document import Cell, Column, Emphasis, Measured, Phrase, Table, Value
from workbench.study.document.source import Source
from workbench.study.evidence.estimands import Success, unit_of, words_of
from workbench.study.evidence.judgement import Judgement, listed
from workbench.study.evidence.pairwise_comparison import Comparison
from workbench.validation.signatures import door

BOLD = "Bold: significantly better than each other law."
HALF = "in brackets the half-width of its interval, in units of the last digits"
WIDE = 0.25  # of a value: an interval beyond that is told by its ends
MANY = 1000  # percent, from which on a change is told in times


@door
def comparison_table(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], notes: tuple[Phrase, ...] = ()
) -> Table:
    """One row a law, one column a metric, and the failed runs; the significantly least of a column is bold.

    Comparisons of other laws than the first are refused, and none at all.
    """
    _check_laws("comparison_table", comparisons)
    several = len({one.estimand for one in comparisons}) > 1
    names = [words_of(one.estimand, one.paired.metric) if several else one.paired.metric for one in comparisons]
    bold = f"{BOLD} A number is {_statistics(comparisons)}, {HALF}."
    return _levels(name, caption, comparisons, names, (bold, *_said(comparisons), *notes))


@door
def statistics_table(name: str, caption: Phrase, judgement: Judgement, notes: tuple[Phrase, ...] = ()) -> Table:
    """One row a law, one column an estimand, the asked one first; the notes have the verdict and its reversals."""
    paired, comparisons = judgement.paired, tuple(judgement.by.values())
    asked, *others = (words_of(one.estimand, paired.metric) for one in comparisons)
    verdict = f"{judgement.sentence[0].upper()}{judgement.sentence[1:]}."
    how = f"{BOLD} Behind each number, {HALF}; of a column {comparisons[0].holds}."
    said = (verdict, *_reversed(judgement), how, *_runs(comparisons), *notes)
    return _levels(name, caption, comparisons, [f"{asked}, asked", *others], said)


def _levels(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], names: Sequence[str], notes: tuple[Phrase, ...]
) -> Table:
    """One row a law, one column a comparison, under their names, and the failed runs."""
    units = (unit_of(one.estimand, one.paired.unit) for one in comparisons)
    heads = (Column(head, unit, "right") for head, unit in zip(names, units, strict=True))
    failed = np.max([one.paired.failed for one in comparisons], axis=0)
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (law, *(_level(one, law) for one in comparisons), int(lost))
        for law, lost in zip(comparisons[0].paired.laws, failed, strict=True)
    )
    return Table(name, caption, (Column("law"), *heads, Column("failed runs", align="right")), rows, notes)


@door
def ablation_table(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], whole: str, notes: tuple[Phrase, ...] = ()
) -> Table:
    """The change of each metric, in percent of the law `whole`, as a block is taken out of it.

    Comparisons of other laws than the first are refused, and of `Success`, a share in points and not percent.
    """
    _check_laws("ablation_table", comparisons)
    paired = comparisons[0].paired
    at = paired.place(whole)
    if any(isinstance(one.estimand, Success) for one in comparisons):
        raise ValueError(
            "`ablation_table(comparisons=...)` tells changes in percent of a level, which is not what a "
            "share of successes is compared by; got `Success`."
        )
    failed = np.max([one.paired.failed for one in comparisons], axis=0)
    rows: list[tuple[Cell, ...]] = [(whole, *(_shown(one, at) for one in comparisons), int(failed[at]))]
    rows += [
        (f"without {law}", *(_change(one, i, at) for one in comparisons), int(failed[i]))
        for i, law in enumerate(paired.laws)
        if i != at
    ]
    heads = (Column(one.paired.metric, one.paired.unit, "left") for one in comparisons)
    columns = (Column("law"), *heads, Column("failed runs", align="right"))
    how = (
        f"First row: {_statistics(comparisons)} of the whole law, {HALF}. Below: how much more the law has without "
        "a block, in percent of the whole law's, with the interval; less is better. Bold: significant."
    )
    return Table(name, caption, columns, tuple(rows), (how, *_said(comparisons), *notes))


def _check_laws(call: str, comparisons: Sequence[Comparison]) -> None:
    kinds = {one.paired.laws for one in comparisons}
    if len(kinds) != 1:
        raise ValueError(f"`{call}(comparisons=...)` needs comparisons of the same laws; got {sorted(kinds)}.")


def _statistics(comparisons: Sequence[Comparison]) -> str:
    return " or ".join(dict.fromkeys(f"the {one.estimand.words}" for one in comparisons))


def _said(comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    """The notes of a table: on the statistics, on each metric, and the common ones once."""
    return (*dict.fromkeys(one.said for one in comparisons), *_runs(comparisons))


def _runs(comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    each = dict.fromkeys(one.paired.said for one in comparisons)
    return (*each, *dict.fromkeys(one.paired.note for one in comparisons if one.paired.note))


def _reversed(judgement: Judgement) -> Iterator[str]:
    """A sentence for each estimand that orders laws the other way round."""
    for words in judgement.by:
        pairs = [f"{a} is below {b}" for a, b, _, other in judgement.reversals if other == words]
        if pairs:
            yield f"By {judgement.asked.words} {listed(pairs)}, and by {words} significantly above."


def _level(one: Comparison, law: str) -> Cell:
    shown = _shown(one, one.paired.place(law))
    return Emphasis(shown) if one.best == law else shown


def _shown(one: Comparison, i: int) -> Value:
    value, low, high = (float(part[i]) for part in (one.level.value, one.level.low, one.level.high))
    source = one.paired.source(one.paired.laws[i])
    if np.isinf(value):
        return f"infinite: {np.isinf(one.paired.values[:, i]).sum()} of {len(one.paired)} runs failed"
    if isinstance(one.estimand, Success):
        return _measured(source, *(100 * (1 - end) + 0.0 for end in (value, high, low)))
    wide = WIDE * abs(value) < max(high - value, value - low) < np.inf  # brackets would leave no digit of the value
    return f"{value:.3g} ({low:.3g} to {high:.3g})" if wide else _measured(source, value, low, high)


def _measured(source: Source | None, value: float, low: float, high: float) -> Value:
    half = max(high - value, value - low)
    return Measured(value, half, source) if np.isfinite(half) else f"{value:.3g}, not bounded"


def _change(one: Comparison, i: int, at: int) -> Cell:
    d = one.difference
    size = float(one.level.value[at])
    if not (size and np.isfinite(size)) or np.isnan(d.value[i, at]):  # nothing is so many percent of zero
        return "not known"
    value, low, high = (100 * float(part[i, at]) / size + 0.0 for part in (d.value, d.low, d.high))
    if np.isinf(value):
        return Emphasis("infinite")
    many = value >= MANY
    text = _text((1 + end / 100 for end in (value, low, high)), "times") if many else _text((value, low, high), "%")
    laws = one.paired.laws
    return Emphasis(text) if one.order(laws[i], laws[at]) != "undecided" else text


def _text(numbers: Iterable[float], unit: str) -> str:
    sign = "+" if unit == "%" else ""
    value, *ends = (_short(number, sign) if np.isfinite(number) else "not bounded" for number in numbers)
    return f"{value} {unit} ({' to '.join(ends)})"


def _short(number: float, sign: str) -> str:
    return f"{number:{sign},.0f}" if abs(number) >= 1000 else f"{number:{sign}.3g}"
