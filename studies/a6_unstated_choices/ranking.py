"""The findings on who is first and who is below whom over all that is open, with their tables and figure."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import combinations

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.draws import DESIGNS, LIMIT, LIMITED_DESIGN, OF_CARD, PRIORS, RANDOM, part, rmse_by_law
from studies.a6_unstated_choices.loops import MEASUREMENT_READING, NAMES, PID, PROPOSED_LAW, factors_of, slug
from studies.a6_unstated_choices.scope import ASSUMPTIONS, INFORMATION, LIMITATIONS
from studies.a6_unstated_choices.shares import (
    COLUMNS,
    RIVALS,
    SHARES,
    TOGETHER,
    UNDECIDED,
    YES,
    Cell,
    Cells,
    Draws,
    Rerun,
    answer_of,
    answer_of_all,
    share_of_draws,
    subsets,
)
from studies.paper.card import LAWS, PUBLISHED_COLUMNS

LIMITS = f"torques limited to {LIMIT[0]:g} and {LIMIT[1]:g} N m"
SAMPLE = (
    f"{RANDOM.runs} independent draws for each of four priors, and {LIMITED_DESIGN.runs} with {LIMITS}. All have the "
    f"same points of the unit cube (seed {RANDOM.seed}). The intervals are those of Clopper and Pearson; for the "
    f"{SHARES} shares of one question they hold together with a confidence of 95 %."
)
NONE = "no rival"


percent = partial(wb.document.percent, decimals=0)


def share_words(one: wb.uncertainty.Share) -> str:
    return f"{100 * one.value:.0f} % ({100 * one.low:.0f} to {100 * one.high:.0f})"


def ends(shares: Sequence[wb.uncertainty.Share]) -> str:
    """The least and the largest of some shares."""
    low, high = min(one.value for one in shares), max(one.value for one in shares)
    return percent(low) if percent(low) == percent(high) else f"{100 * low:.0f} to {percent(high)}"


def cell_words(cell: Cell) -> str:
    prior, column = cell
    return f"prior '{prior}', {COLUMNS[column]}"


def groups(every: Cells, again: Mapping[Cell, Rerun]) -> Iterator[tuple[str, Cells]]:
    """Draws of every prior and column, varied together: each reading alone, and the error of the step either way."""
    yield from subsets(every)
    for side, words in ((1, "added to"), (-1, "subtracted from")):
        moved = {cell: one.shifted_draws(side) for cell, one in again.items()}
        yield f"the error of the step {words} the RMSE of {PROPOSED_LAW}, in the draws that were repeated", moved


def first_finding(every: Cells, limited_cells: Cells, again: Mapping[Cell, Rerun]) -> wb.Finding:
    """The share of draws in which the proposed law is first."""
    shares = {cell: share_of_draws(draws, Draws.first) for cell, draws in every.items()}
    top = max(shares, key=lambda cell: shares[cell].value)
    answer = answer_of_all(list(shares.values()))
    return wb.Finding(
        name="first",
        statement=f"{PROPOSED_LAW} has the smallest RMSE in {ends(list(shares.values()))} of draws of unstated "
        "numbers, depending on prior and the paper's column.",
        evidence=f"In the paper {PROPOSED_LAW} is first in all four columns. Half of the draws have the minus of (33); "
        f"with the plus alone the share is {ends(_first_with_plus(every))}. "
        f"The largest share is {share_words(shares[top])}, under the {cell_words(top)}. {step_words(again)}",
        statistic="Share of the draws in which the sampled RMSE, (43), of the law is below that of each rival. "
        "The answer is 'yes' if the share and its interval are above one half in all columns under all priors. It is "
        "'no' if they are below one half.",
        sample=SAMPLE,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=answer,
        variations=tuple(first_variations(every, limited_cells, again)),
        limitations=LIMITATIONS,
        is_decided=answer != UNDECIDED,
    )


def _first_with_plus(every: Cells) -> list[wb.uncertainty.Share]:
    """The shares of the draws with the plus of (33) in which the proposed law is first."""
    return [share_of_draws(draws.reading("sign of (33)", "plus"), Draws.first) for draws in every.values()]


def first_variations(every: Cells, limited_cells: Cells, again: Mapping[Cell, Rerun]) -> Iterator[wb.Variation]:
    """The answer in each column under each prior, with limited torques, without a rival, and of each group."""
    for words, some in (("", every), (f", {LIMITS}", limited_cells)):
        for cell, draws in some.items():
            one = share_of_draws(draws, Draws.first)
            yield wb.Variation(cell_words(cell) + words, answer_of(one), share_words(one))
    parts: list[tuple[str, Cells, Callable[[Draws], np.ndarray]]] = [
        (f"without {rival}", every, partial(Draws.first, without=rival)) for rival in RIVALS
    ]
    parts += [(words, some, Draws.first) for words, some in groups(every, again)]
    for words, some, flags in parts:
        shares = [share_of_draws(draws, flags) for draws in some.values()]
        yield wb.Variation(words, answer_of_all(shares), ends(shares))


def beaten(some: Mapping[Cell, Draws]) -> str:
    """The rivals below which the proposed law is in most draws in at least one of these cells."""
    sure = [
        rival
        for rival in RIVALS
        if any(answer_of(share_of_draws(draws, partial(Draws.below, rival=rival))) == YES for draws in some.values())
    ]
    return ", ".join(sure) or NONE


def below_finding(results: wb.Results, every: Cells, limited_cells: Cells, again: Mapping[Cell, Rerun]) -> wb.Finding:
    """The rivals below which the proposed law is in most draws, by column and prior."""
    answer = beaten(every)
    of_plus, of_minus = (
        {cell: draws.reading("sign of (33)", sign) for cell, draws in every.items()} for sign in ("plus", "minus")
    )
    most_of_minus = max(share.value for rival in RIVALS for share in shares_of(of_minus, rival))
    return wb.Finding(
        name="below_rivals",
        statement=f"{'No rival' if answer == NONE else 'Only ' + answer} has a larger RMSE than {PROPOSED_LAW} in "
        f"most draws, in any column or under any prior{_with_plus(beaten(of_plus))}.",
        evidence=f"Half of the draws have the minus of (33): in these {PROPOSED_LAW} has a smaller RMSE than a rival "
        f"in at most {percent(most_of_minus)}. {pid_words(results)}",
        statistic=f"Rivals with a larger RMSE than {PROPOSED_LAW} in more than half of the draws, in at least one "
        "column under one prior. The whole interval of the share must lie above one half.",
        sample=SAMPLE,
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=answer,
        variations=tuple(below_variations(every, limited_cells, again)),
        limitations=LIMITATIONS,
    )


def below_variations(every: Cells, limited_cells: Cells, again: Mapping[Cell, Rerun]) -> Iterator[wb.Variation]:
    """The rivals below which the law is in most draws in each column under each prior, and of each group."""
    for words, some in (("", every), (f", {LIMITS}", limited_cells)):
        for cell, draws in some.items():
            yield wb.Variation(cell_words(cell) + words, beaten({cell: draws}))
    for words, some in groups(every, again):
        yield wb.Variation(words, beaten(some))


def shares_of(some: Cells, rival: str | None, column: tuple[str, int] | None = None) -> list[wb.uncertainty.Share]:
    """The shares of draws with the law below a rival, or first, under each prior, in one column or in all."""
    flags = Draws.first if rival is None else partial(Draws.below, rival=rival)
    return [share_of_draws(draws, flags) for (_, at), draws in some.items() if column in (None, at)]


def most(some: Cells, rival: str | None, column: tuple[str, int] | None = None) -> str:
    return answer_of_all(shares_of(some, rival, column))


def _with_plus(rivals: str) -> str:
    """The rivals that have a larger RMSE somewhere if the minus of (33) is left out."""
    return "" if rivals == NONE else f"; with only the plus of (33), {rivals} in some column and prior"


def pid_words(results: wb.Results) -> str:
    """The median peak torque of PID, and its median RMSE without and with a limit: exact readings, prior of the card.

    A peak that is not finite belongs to a run that diverged, and counts as larger than any other.
    """
    places = part("random", factors_of(PID, "FS"))[1]
    readings = DESIGNS["random"].points()[:, NAMES.index(MEASUREMENT_READING.name)]
    exact = readings < 1 / 2  # the first of two readings
    peak = results.sample(slug("peaks", "FS")).values[places, -1].max(axis=1)[exact]
    few = exact[: LIMITED_DESIGN.runs]
    rmse = [
        rmse_by_law(results, kind, "FS", OF_CARD)[PID][: LIMITED_DESIGN.runs, 0][few] for kind in ("random", "limited")
    ]
    top, without, with_limit = (float(np.median(np.where(np.isnan(each), np.inf, each))) for each in (peak, *rmse))
    return (
        f"With exact readings the median peak torque of {PID} is {top:,.0f} N m. With {LIMITS}, the median RMSE of "
        f"{PID} at joint 1 in the first scenario changes from {without:.3f} to {with_limit:.3f} rad."
    )


def step_words(again: Mapping[Cell, Rerun]) -> str:
    """The effect of the step on the RMSE and on the rank of the proposed law."""
    runs = sum(len(one.errors) for one in again.values())
    beyond, unknown = (
        sum(int(getattr(one, part).sum()) for one in again.values()) for part in ("is_inaccurate", "is_undecided")
    )
    return (
        f"{runs:,} draws were repeated at half of the step. In {beyond} of these the step changes the RMSE of "
        f"{PROPOSED_LAW} by more than 1 %. In {unknown} the error reaches a rival, so the rank is not known."
    )


def ranks_by_column(every: Cells) -> dict[tuple[str, int], wb.evidence.Ranks]:
    """The ranks of the laws in all columns under the prior of the card."""
    name = next(iter(PRIORS))
    found = {}
    for column in COLUMNS:
        rmse = every[name, column].rmse
        values = {law: np.where(np.isinf(rmse[:, i]), np.nan, rmse[:, i]) for i, law in enumerate(LAWS)}
        found[column] = wb.evidence.ranks(wb.evidence.pair_samples(values, metric="sampled RMSE", unit="rad"), TOGETHER)
    return found


def printed_words(columns: Mapping[tuple[str, int], wb.evidence.Ranks]) -> str:
    """The share of draws in which laws come in their printed order, two at a time and all six."""
    likely, whole = 0, 0.0
    for column, one in columns.items():
        order = sorted(range(len(LAWS)), key=lambda i: PUBLISHED_COLUMNS[column].values[LAWS[i]])
        likely += sum(bool(one.below.value[pair] > 0.5) for pair in combinations(order, 2))
        values = one.samples.values[:, order]
        whole = max(whole, float((values[:, :-1] < values[:, 1:]).all(axis=1).mean()))
    pairs = len(columns) * len(LAWS) * (len(LAWS) - 1) // 2
    return (
        f"Under the prior of the card {likely} of the {pairs} pairs of laws have their printed order in most draws. "
        f"All six laws of a column have it in at most {100 * whole:.1f} % of the draws."
    )
