"""What turns with the prior: the rankings with every unstated number drawn evenly on one scale or on another."""

from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np

from studies.a6_unstated_choices.draws import NAMES, PRIORS, RANDOM, Prior, drawn, factors_of
from studies.a6_unstated_choices.loops import PROPOSED, Reading
from studies.a6_unstated_choices.ranking import COLUMNS, INTERVALS, Rankings, rankings, title
from studies.paper.card import LAWS
from workbench.study.document.document import Cell, Column, Paragraph, Section, Table, Verdict
from workbench.study.study import Results
from workbench.study.uncertainty import Share, share

Ranked = Mapping[str, Mapping[tuple[str, int], Rankings]]  # by the name of the prior
Triple = tuple[float, float, float]  # a share and the ends of its interval

NO, YES, TURNS, OPEN = "no, under each", "yes, under each", "depends on the prior", "open"  # in most draws
KINDS: Mapping[str, Literal["found", "depends", "open"]] = {NO: "found", YES: "found", TURNS: "depends", OPEN: "open"}
MOSTLY = {
    NO: f"Better than {PROPOSED} in most draws, under each prior and in each column",
    YES: f"Worse than {PROPOSED} in most draws, under each prior and in each column",
    TURNS: "Better in most draws under some prior and in some column, and worse in another",
    OPEN: "Open, as an interval reaches one half",
}
MOST = 50  # draws, without which a share given a reading says nothing
SAMPLE = (
    f"Shares of {RANDOM.runs} independent draws for each prior, the same points of the unit cube for all of them, "
    f"with {INTERVALS}."
)
GIVEN = (
    "All readings alike; the same square wave, horizon and kind of measurement for the rivals in a draw, while the "
    "proposed law draws its own between exact measurement and observer (10); K(0) and gamma the same for all that "
    "adapt."
)


def of_all_priors(results: Results) -> Ranked:
    """The rankings of all four columns under each prior."""
    return {name: rankings(results, prior) for name, prior in PRIORS.items()}


def first_verdict(ranked: Ranked, most: Share, step: str) -> Verdict:
    """How often the proposed law is first, under each prior and in each column, and by how much the step moves it."""
    parts = {name: [one.first for one in columns.values()] for name, columns in ranked.items()}
    every = [part for held in parts.values() for part in held]
    said = "; ".join(f"{name} {_one(min(held))} to {_one(max(held))}" for name, held in parts.items())
    return Verdict(
        KINDS[majority(every)],
        f"{PROPOSED} has the smallest RMSE of the six laws in {_percent(min(every))} to {_percent(max(every))} of the "
        "choices drawn of what is not stated, by column of the tables and prior; the paper prints it first in all four "
        "columns.",
        f"From the least to the largest of the four columns: {said}. Given the reading, the prior and the column that "
        f"favour it most, it is first in {_one((most.value, most.low, most.high))}, the largest of many shares, its "
        "interval by itself, and so an optimistic one.",
        f"{SAMPLE} {step}",
        GIVEN,
        "Ranges about a few of the choices that meet the tables: there it is first by construction.",
    )


def pairs_verdict(ranked: Ranked, step: str) -> Verdict:
    """How often the proposed law is below each rival, and how far that turns with priors.

    It is one sentence for all rivals, so that none is picked because its number moves most.
    """
    ours = {rival: [one.pairs[PROPOSED, rival] for by in ranked.values() for one in by.values()] for rival in LAWS[1:]}
    shares = ", ".join(f"{rival} in {_percent(min(held))} to {_percent(max(held))}" for rival, held in ours.items())
    said = "; ".join(f"{rival} {_one(min(held))} to {_one(max(held))}" for rival, held in ours.items())
    stands = {asked: ", ".join(r for r, held in ours.items() if majority(held) == asked) for asked in MOSTLY}
    words = [f"{MOSTLY[asked]}: {rivals}" for asked, rivals in stands.items() if rivals]
    columns = next(iter(ranked.values()))
    apart = any(_apart([by[c].pairs[PROPOSED, rival] for by in ranked.values()]) for rival in ours for c in columns)
    return Verdict(
        "depends" if apart else "found",
        f"{PROPOSED} has a smaller RMSE than {shares} of the draws, by {'prior and ' * apart}column.",
        f"{'; '.join(words)}. Least and largest share over four priors and four columns: {said}.",
        f"{SAMPLE} {step}",
        GIVEN,
        "Another prior: these four are the corners of two scales, and a range twice as wide is a prior too.",
    )


def _apart(parts: Sequence[Triple]) -> bool:
    """Whether some two of these intervals have nothing in common."""
    return max(low for _, low, _ in parts) > min(high for _, _, high in parts)


def _percent(part: Triple) -> str:
    return f"{100 * part[0]:.0f} %"


def _one(part: Triple) -> str:
    return f"{100 * part[0]:.0f} % ({100 * part[1]:.0f} to {100 * part[2]:.0f})"


def favoured(results: Results) -> Share:
    """The largest share of draws, over priors and columns, in which the proposed law is first given one reading."""
    shares = [
        part
        for prior in PRIORS.values()
        for scenario, joint in COLUMNS
        for part in _by_reading(results, prior, scenario, joint)
    ]
    return max(shares, key=lambda one: one.value)


def _by_reading(results: Results, prior: Prior, scenario: str, joint: int) -> list[Share]:
    first = drawn(results, "random", scenario, prior).margin[:, joint - 1] < 0.5
    points, found = RANDOM.points(), []
    for factor in factors_of(PROPOSED, "FS"):
        if isinstance(factor.distribution, Reading):
            reading = factor.distribution.quantile(points[:, NAMES.index(factor.name)])
            found += [share(first[reading == place]) for place in np.unique(reading)]
    return [one for one in found if one.runs >= MOST]


def priors_section(ranked: Ranked) -> Section:
    """The four priors, and the shares under each beside one another."""
    return Section(
        "What turns with the prior",
        (
            Paragraph(
                "A range is no prior: within it a number can be drawn evenly, or evenly on a logarithmic scale. The "
                f"prior of the card does the second with Q, R and l of {PROPOSED} alone, which are known by their "
                "order of magnitude, and the first with all other numbers. Both ways are tried for the numbers of "
                f"{PROPOSED} and for all others, those of the experiment among them; 'exchanged' draws Q, R and l "
                "evenly and the others on logarithmic scales. (sigma of RBF-ASMC, whose range begins at 0, is always "
                "drawn evenly.) New runs are made for each prior: weights on the runs of another would leave a few "
                "draws with all the weight."
            ),
            priors_table(ranked),
        ),
    )


def priors_table(ranked: Ranked) -> Table:
    """Of a hundred draws how many have the proposed law below each rival, and first, by column and prior."""
    asked: list[tuple[str, Callable[[Rankings], Triple]]] = [
        *((f"below {rival}", lambda one, rival=rival: one.pairs[PROPOSED, rival]) for rival in LAWS[1:]),
        ("first", lambda one: one.first),
    ]
    rows: list[tuple[Cell, ...]] = []
    for words, part in asked:
        for column in COLUMNS:
            parts = [part(columns[column]) for columns in ranked.values()]
            cells = (f"{100 * value:.0f} ({100 * low:.0f} to {100 * high:.0f})" for value, low, high in parts)
            rows.append((f"{PROPOSED} {words}", title(*column), *cells, majority(parts)))
    return Table(
        "priors",
        f"Of a hundred draws how many have {PROPOSED} below a rival, or first, under four priors.",
        (Column("is"), Column("column"), *(Column(name, "%", "right") for name in ranked), Column("in most draws")),
        tuple(rows),
        (
            f"In brackets {INTERVALS}; one question has four lines.",
            f"{RANDOM.runs} draws for each prior, seed {RANDOM.seed}.",
        ),
    )


def majority(parts: Sequence[Triple]) -> str:
    """What the majority of the draws says under all priors together."""
    if all(high < 0.5 for _, _, high in parts):
        return NO
    if all(low > 0.5 for _, low, _ in parts):
        return YES
    sides = any(high < 0.5 for _, _, high in parts), any(low > 0.5 for _, low, _ in parts)
    return TURNS if all(sides) else OPEN
