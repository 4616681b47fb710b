"""Laws side by side as pictures: tiles of statistics by law and scenario, and the probabilities of ranks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from workbench.core.validation.refusals import Array, known_name, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.report.pictures.captions import Note, number, picture
from workbench.study.document.figure import Bars, Figure, Panel, Tiles
from workbench.study.document.phrases_and_tables import Cell, Phrase, head_of
from workbench.study.evidence import Comparison, Intervals, Success

Text: TypeAlias = tuple[str, ...]
BEYOND = 4.0  # times the best level of a column: the end of the scale
WIDE = 6  # scenarios beyond which two panels fill the width
DIGITS = 3  # of a number in the panel that leads; one less in all others
LEAST, MOST = 1e-3, 1e5  # beyond these a number has a power of ten
POWERS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
HEADS = ("statistic", "scenario", "law", "level", "low", "high", "standing", "failed runs", "of")
ORDER = "The laws are in the order of their mean ranks."
ROUNDING = 1e-9  # by which probabilities may miss a sum of 1


@check_arguments
def standings_figure(
    name: str,
    caption: Phrase,
    comparisons: Mapping[str, Mapping[str, Comparison]],
    primary: str,
    others: Sequence[str] | None = None,
) -> Figure:
    """One panel per statistic, with a row per law and a column per scenario; `primary` leads, with its intervals.

    A tile is darker if the ratio of its level to the best of its column is larger. The best law of a column is framed
    if it is significantly better than every other law. If there is none, all laws that no other law beats significantly
    are marked as tied. A law with failed runs is hatched. `comparisons` are by scenario, then by the words of a
    statistic, as the `by` of a `LawJudgement`. `primary` names the statistic that was declared before the runs. The
    statistics in `others` have further panels, by default all; the numbers of the figure have all.

    Raises
    ------
    ValueError
        If there is no scenario, statistics or laws differ between scenarios, or a level is negative, so that ratios do
        not say which law is better.
    LookupError
        If `primary`, or one of `others`, is not one of the statistics.

    Examples
    --------
    >>> from workbench.report.pictures import standings_figure
    >>> from workbench.study.evidence import compare, pair_samples
    >>> draws = np.random.default_rng(1).random(40)
    >>> leads = compare(pair_samples({"PID": draws, "SMC": draws + 0.1}, metric="error", unit="rad"), resamples=100)
    >>> standings_figure("standings", "Two laws", {"paper": {"mean": leads}}, "mean").name
    'standings'
    """
    laws, statistics = _common(comparisons)
    known_name(primary, statistics, "statistics")
    order = (primary, *(words for words in statistics if words != primary))
    columns = {words: {s: held[words] for s, held in comparisons.items()} for words in order}
    seen = [
        known_name(words, statistics, "statistics")
        for words in (order[1:] if others is None else others)
        if words != primary
    ]
    panels = tuple(_panel(words, laws, columns[words], words == primary) for words in (primary, *seen))
    beside = min(max(1, len(seen)), 2 if len(comparisons) > WIDE else 3)
    first = next(iter(comparisons.values()))[primary]
    rows = tuple(row for words in order for s, one in columns[words].items() for row in _rows(words, s, one))
    note = _note(first, comparisons, "statistic" if seen else primary)
    return picture("standings_figure", name, caption, note, panels, HEADS, rows, columns=beside, lead=True)


def _common(comparisons: Mapping[str, Mapping[str, Comparison]]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The laws and the statistics, the same in each scenario."""
    found = {(tuple(held), tuple(one.samples.laws for one in held.values())) for held in comparisons.values()}
    laws = {each for _, held in found for each in held}
    if len(found) != 1 or len(laws) != 1:
        raise ValueError(
            "`standings_figure(comparisons)` must map one scenario or more to comparisons of the same laws by the same "
            f"statistics, in one order; got {len(comparisons)} scenarios with {len({s for s, _ in found})} lists of "
            f"statistics and {len(laws)} lists of laws."
        )
    return laws.pop(), found.pop()[0]


def standing(comparison: Comparison, law: str) -> str:
    """The standing of a law: 'best' if it is significantly better than every other, 'tied' if none is better than it.

    A law without a finite level 'fails'; all others are 'beaten'.
    """
    if not np.isfinite(comparison.level.value[comparison.samples.place(law)]):
        return "fails"
    if comparison.best == law:
        return "best"
    return "tied" if law in comparison.leaders else "beaten"


def _panel(words: str, laws: tuple[str, ...], columns: Mapping[str, Comparison], leads: bool) -> Panel:
    standings = np.array([[standing(one, law) for one in columns.values()] for law in laws])
    failed = np.column_stack([one.samples.failures for one in columns.values()])
    levels = np.concatenate([_shown(one).value for one in columns.values()])
    usual = levels[np.isfinite(levels) & (levels > 0)]
    decimals = _decimals(float(np.median(usual)), DIGITS if leads else DIGITS - 1) if usual.size else DIGITS
    texts = tuple(tuple(_text(one, i, leads, decimals) for one in columns.values()) for i in range(len(laws)))
    hatched = (failed > 0) | (standings == "fails")
    marks = (standings == "best", standings == "tied", hatched)
    tiles = Tiles("", texts, _shades(list(columns.values())), *marks, keys=_keys(*(bool(mark.any()) for mark in marks)))
    words = words.replace("<=", "≤")
    unit = " [%]" if isinstance(next(iter(columns.values())).estimand, Success) else ""
    title = f"{words}{unit}, with its interval: the statistic that decides" if leads else f"{words}{unit}"
    return Panel("", (tiles,), xlabel="", title=title, xnames=tuple(columns), ynames=laws)


def _keys(best: bool, tied: bool, failed: bool) -> tuple[Tiles, ...]:
    one, none = (((),),), np.zeros((1, 1))
    scale = Tiles(f"1 to {BEYOND:g} times the best of its column, or more", (((),) * 5,), np.linspace(0, 1, 5)[None])
    marks = (
        (best, Tiles("significantly better than all others", one, none, has_frame=True)),
        (tied, Tiles("tied with the best", one, none, has_mark=True)),
        (failed, Tiles("some or all runs failed", one, none, has_hatch=True)),
    )
    return scale, *(key for there, key in marks if there)


def _text(one: Comparison, i: int, leads: bool, decimals: int) -> Text:
    """The level of a law; in the panel that leads, below it its interval and its failed runs."""
    shown = _shown(one)
    level, low, high = (float(part[i]) for part in (shown.value, shown.low, shown.high))
    digits = DIGITS if leads else DIGITS - 1
    lines = [_short(level, digits, decimals) if np.isfinite(level) else "–"]
    if leads and np.isfinite(level) and not (np.isnan(low) or np.isnan(high)):
        lines.append(f"{_short(low, digits, decimals)}–{_short(high, digits, decimals)}")
    if leads and one.samples.failures[i]:
        lines.append(f"{one.samples.failures[i]} failed")
    return tuple(lines)


def _short(value: float, digits: int, most: int) -> str:
    """A number with a count of digits, but at most a count of decimals."""
    if np.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    if not LEAST <= abs(value) < MOST:
        mantissa, power = f"{value:.1e}".split("e")
        text = f"{mantissa}·10{str(int(power)).translate(POWERS)}"
    else:
        text = f"{value:.{min(_decimals(value, digits), most)}f}"
    return text.replace("-", "−")


def _decimals(value: float, digits: int) -> int:
    """The decimals of so many digits of a number."""
    return max(0, digits - 1 - int(np.floor(np.log10(abs(value))))) if value else digits - 1


def _shades(columns: list[Comparison]) -> Array:
    """The ratio of each level to the best of its column as a part of the scale, (laws, scenarios); NaN without one."""
    levels = np.column_stack([_shown(one).value for one in columns])
    if (levels < 0).any():
        raise ValueError(
            "`standings_figure(comparisons)` shades tiles by the ratio of levels, which must not be negative; the "
            f"least is {np.nanmin(levels):g}. Take a metric such as a norm or a cost."
        )
    levels = np.where(np.isfinite(levels), levels, np.nan)
    if isinstance(columns[0].estimand, Success):  # the best has the largest share
        levels = np.divide(1.0, levels, where=levels != 0, out=np.full_like(levels, np.inf))
    best = np.array([np.nanmin(column, initial=np.inf) for column in levels.T])
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(levels == best, 1.0, levels / best)
        return np.asarray(np.clip(np.log(ratio) / np.log(BEYOND), 0, 1))


def _shown(one: Comparison) -> Intervals:
    """The levels as they are shown: successes, which are kept as the share of the other draws, in percent."""
    held = one.level
    if not isinstance(one.estimand, Success):
        return held
    return Intervals(*(100 * (1 - part) for part in (held.value, held.high, held.low)))


def _note(one: Comparison, comparisons: Mapping[str, Mapping[str, Comparison]], words: str) -> str:
    """The note below the tiles: the statistic, the number of draws, the confidence, and the key of the marks."""
    sizes = sorted({len(each.samples) for held in comparisons.values() for each in held.values()})
    draws = f"{sizes[0]:,}" if len(sizes) == 1 else f"{sizes[0]:,} to {sizes[-1]:,}"
    unit = f" in {one.samples.unit}" if one.samples.unit not in ("", "1") else ""
    return (
        f"Each tile has the {words} of {one.samples.metric}{unit} over {draws} draws; the intervals of a column hold "
        f"at once with a confidence of {100 * one.confidence:g} %. A darker tile has a larger ratio to the best of its "
        "column, on a logarithmic scale. Frame: the one law that is significantly better than all others. Corner "
        "mark, black or white: tied with the best, as no law is significantly better. Stripes: failed runs; a dash: "
        "they leave no finite statistic."
    )


def _rows(words: str, scenario: str, one: Comparison) -> list[tuple[Cell, ...]]:
    shown = _shown(one)
    return [
        (
            *(words, scenario, law),
            *(number(float(part[i])) for part in (shown.value, shown.low, shown.high)),
            *(standing(one, law), int(one.samples.failures[i])),
            None if (source := one.samples.source(law)) is None else head_of(source),
        )
        for i, law in enumerate(one.samples.laws)
    ]


@check_arguments
def rank_figure(name: str, caption: Phrase, ranks: Mapping[str, Array], note: Note) -> Figure:
    """One bar per law, divided into the probabilities of its ranks, the first the darkest; the least mean rank on top.

    `ranks` has by law the probabilities (L,) of each rank from the first on, which add up to 1.

    Raises
    ------
    ValueError
        If the note is empty, or `ranks` does not hold probabilities.

    Examples
    --------
    >>> from workbench.report.pictures import rank_figure
    >>> rank_figure("ranks", "Two laws", {"PID": [0.6, 0.4], "SMC": [0.4, 0.6]}, "100 draws").name
    'ranks'
    """
    if not ranks:
        raise refusal("rank_figure(ranks=...)", "the probabilities of each law's ranks", ranks)
    held = np.array([_checked(law, row, ranks) for law, row in ranks.items()])
    order = np.argsort(held @ np.arange(1, held.shape[1] + 1), kind="stable")
    laws, held = [list(ranks)[i] for i in order], held[order]
    ends = np.minimum(held.cumsum(axis=1), 1.0)
    bars = tuple(
        Bars(
            f"rank {place + 1}",
            np.arange(len(laws), dtype=float),
            ends[:, place],
            ends[:, place] - held[:, place],
            shade=1.0 - 0.94 * place / max(1, held.shape[1] - 1),
            texts=tuple(f"{100 * part:.0f} %" for part in held[:, place]),
        )
        for place in range(held.shape[1])
    )
    panel = Panel("", bars, xlabel="probability", xlim=(0.0, 1.0), ynames=tuple(laws))
    rows = tuple((law, *map(float, row)) for law, row in zip(laws, held, strict=True))
    heads = ("law", *(f"rank {place + 1}" for place in range(held.shape[1])))
    return picture("rank_figure", name, caption, note, (panel,), heads, rows, (ORDER,), names=tuple(ranks))


def _checked(law: str, row: Array, ranks: Mapping[str, Array]) -> Array:
    shapes = {other.shape for other in ranks.values()}
    if len(shapes) > 1 or row.ndim != 1 or not (row >= 0).all() or not abs(row.sum() - 1) <= ROUNDING:
        must = "the probability of each rank from the first, as many for each law, which add up to 1"
        raise refusal(f"rank_figure(ranks={{'{law}': ...}})", must, row.tolist())
    return row
