"""Comparisons and ranks as tables: bold, and words, only where a difference is significant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from workbench.core.validation.signatures import check_arguments
from workbench.study.document.document import Cell, MissingCell, Phrase, ReportTable, TableColumn, Value, ValueWithError
from workbench.study.document.source import Source
from workbench.study.document.words import join_names
from workbench.study.evidence.bold_cells import BOLD, bold_if_best, bold_if_decided
from workbench.study.evidence.estimands import Success, unit_of_estimand, words_of
from workbench.study.evidence.judgement import LawJudgement
from workbench.study.evidence.pairwise_comparison import Comparison

HALF = (
    "In brackets is the half-width of the interval, in units of the last digits, or both ends if the interval is wide."
)


@check_arguments
def comparison_table(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], notes: tuple[Phrase, ...] = ()
) -> ReportTable:
    """A table with one row per law, one column per metric, and the failed runs; a significantly least value is bold.

    All comparisons must be of the same laws, and there must be at least one.

    Examples
    --------
    >>> from workbench.study.evidence import compare, comparison_table, pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> leads = compare(pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad"), resamples=100)
    >>> comparison_table("laws", "Two laws", (leads,)).name
    'laws'
    """
    _check_laws("comparison_table", comparisons)
    several = len({one.estimand for one in comparisons}) > 1
    names = [words_of(one.estimand, one.samples.metric) if several else one.samples.metric for one in comparisons]
    bold = f"{BOLD} A number is {_statistics(comparisons)}. {HALF}"
    return _levels(name, caption, comparisons, names, (bold, *_said(comparisons), *notes))


@check_arguments
def statistics_table(
    name: str, caption: Phrase, judgement: LawJudgement, notes: tuple[Phrase, ...] = ()
) -> ReportTable:
    """A table with one row per law and one column per estimand; the notes have the verdict and its reversals.

    Examples
    --------
    >>> from workbench.study.evidence import Mean, judge, pair_samples, statistics_table
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad")
    >>> ruling = judge(errors, Mean(), resamples=100)
    >>> statistics_table("laws", "Two laws", ruling).name
    'laws'
    """
    paired, comparisons = judgement.samples, tuple(judgement.by.values())
    asked, *others = (words_of(one.estimand, paired.metric) for one in comparisons)
    verdict = f"{judgement.sentence[0].upper()}{judgement.sentence[1:]}."
    how = f"{BOLD} {HALF} In each column, {comparisons[0].holds}."
    said = (verdict, *_reversed(judgement), how, *_runs(comparisons), *notes)
    return _levels(name, caption, comparisons, [f"{asked}, which decides", *others], said)


def _levels(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], names: Sequence[str], notes: tuple[Phrase, ...]
) -> ReportTable:
    """One row a law, one column a comparison, under their names, and the failed runs."""
    units = (unit_of_estimand(one.estimand, one.samples.unit) for one in comparisons)
    heads = (TableColumn(head, unit, "right") for head, unit in zip(names, units, strict=True))
    failed = np.max([one.samples.failures for one in comparisons], axis=0)
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (law, *(level_of(one, law) for one in comparisons), int(lost))
        for law, lost in zip(comparisons[0].samples.laws, failed, strict=True)
    )
    return ReportTable(
        name, caption, (TableColumn("law"), *heads, TableColumn("failed runs", align="right")), rows, notes
    )


@check_arguments
def ablation_table(
    name: str, caption: Phrase, comparisons: Sequence[Comparison], whole: str, notes: tuple[Phrase, ...] = ()
) -> ReportTable:
    """A table with one row per part taken out of the law `whole`, and one column per metric: its change.

    `change_without` computes a change. All comparisons must be of the same laws. Comparisons by `Success` are refused,
    since a share changes by points and not by percent.

    Examples
    --------
    >>> from workbench.study.evidence import ablation_table, change_without, compare, level_of, pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> errors = pair_samples({"whole": draws, "without D": draws + 0.1}, metric="error", unit="rad")
    >>> parts = compare(errors, resamples=100)
    >>> ablation_table("parts", "What each part is worth", (parts,), "whole").name
    'parts'
    >>> change_without(parts, "without D", "whole"), level_of(parts, "whole")
    (BoldCell(cell=ValueWithError(...)), BoldCell(cell=ValueWithError(...)))
    """
    _check_laws("ablation_table", comparisons)
    paired = comparisons[0].samples
    at = paired.place(whole)
    failed = np.max([one.samples.failures for one in comparisons], axis=0)
    rows: list[tuple[Cell, ...]] = [
        (f"without {law}", *(change_without(one, law, whole) for one in comparisons), int(lost))
        for law, lost in zip(paired.laws, failed, strict=True)
        if law != whole
    ]
    heads = (TableColumn(one.samples.metric, "%", "right") for one in comparisons)
    columns = (TableColumn("law"), *heads, TableColumn("failed runs", align="right"))
    levels = ", ".join(f"{one.samples.metric} {_leveled(one, at)}" for one in comparisons)
    how = (
        f"A number is the change of {_statistics(comparisons)} when a part is taken out, in percent of the value of "
        f"the whole law. A positive number means that the part is useful. {HALF} Bold: significant. {whole} has: "
        f"{levels}."
    )
    return ReportTable(name, caption, columns, tuple(rows), (how, *_said(comparisons), *notes))


@check_arguments
def change_without(one: Comparison, law: str, whole: str) -> Cell:
    """The level of a law minus that of the law `whole`, in percent of the latter; in bold if it is significant.

    It is infinite if the law has failed runs, and missing if the level of `whole` is zero or not finite.

    Raises
    ------
    ValueError
        If the comparison is by `Success`, whose levels are shares of the draws.
    """
    if isinstance(one.estimand, Success):
        raise ValueError(
            "`change_without(one=...)` gives a change in percent of a level, which is not what a share of successes is "
            "compared by; got `Success`."
        )
    i, at, d = one.samples.place(law), one.samples.place(whole), one.difference
    size = float(one.level.value[at])
    if not (size and np.isfinite(size)) or np.isnan(d.value[i, at]):  # nothing is a number of percent of zero
        return MissingCell("not known")
    value, low, high = (100 * float(part[i, at]) / size + 0.0 for part in (d.value, d.low, d.high))
    shown: Value = float("inf") if np.isinf(value) else _measured(one.samples.source(law), value, low, high)
    return bold_if_decided(shown, one, law, whole)


def _check_laws(call: str, comparisons: Sequence[Comparison]) -> None:
    kinds = {one.samples.laws for one in comparisons}
    if len(kinds) != 1:
        raise ValueError(f"`{call}(comparisons=...)` needs comparisons of the same laws; got {sorted(kinds)}.")


def _statistics(comparisons: Sequence[Comparison]) -> str:
    return " or ".join(dict.fromkeys(f"the {one.estimand.words}" for one in comparisons))


def _said(comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    """The notes of a table: on the statistics, on each metric, and the common ones once."""
    return (*dict.fromkeys(one.footnote for one in comparisons), *_runs(comparisons))


def _runs(comparisons: Sequence[Comparison]) -> tuple[str, ...]:
    each = dict.fromkeys(one.samples.footnote for one in comparisons)
    return (*each, *dict.fromkeys(one.samples.note for one in comparisons if one.samples.note))


def _reversed(judgement: LawJudgement) -> Iterator[str]:
    """A sentence for each estimand that orders laws the other way round."""
    for words in judgement.by:
        pairs = [f"{a} is below {b}" for a, b, _, other in judgement.reversals if other == words]
        if pairs:
            yield f"By {judgement.primary.words} {join_names(pairs)}, but by {words} significantly above."


@check_arguments
def level_of(one: Comparison, law: str) -> Cell:
    """The level of a law with its interval, in bold if the law is significantly better than every other."""
    shown = _shown(one, one.samples.place(law))
    return bold_if_best(shown, one, law)


def _shown(one: Comparison, i: int) -> Value:
    value, low, high = (float(part[i]) for part in (one.level.value, one.level.low, one.level.high))
    if np.isinf(value):
        return value
    if isinstance(one.estimand, Success):
        value, low, high = (100 * (1 - end) + 0.0 for end in (value, high, low))
    return _measured(one.samples.source(one.samples.laws[i]), value, low, high)


def _leveled(one: Comparison, at: int) -> str:
    value, low, high = (float(part[at]) for part in (one.level.value, one.level.low, one.level.high))
    return f"{value:.3g} ({low:.3g} to {high:.3g}) {one.samples.unit}".strip()


def _measured(source: Source | None, value: float, low: float, high: float) -> ValueWithError:
    halves = [half for half in (high - value, value - low) if np.isfinite(half)]
    return ValueWithError(value, max(halves, default=0.0), source, (low, high))
