"""How probable each published ranking is over all that is open, and which open number decides who wins."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from studies.a6_unstated_choices.draws import NAMES, OF_CARD, PAIRED, PRIORS, RANDOM, Prior, drawn, named
from studies.a6_unstated_choices.fits import CLOSE
from studies.a6_unstated_choices.loops import PROPOSED, SCENARIOS
from studies.paper.card import LAWS, PUBLISHED
from workbench.study.document.document import Cell, Column, Paragraph, Section, Table
from workbench.study.evidence import Paired, Ranks, paired, ranks
from workbench.study.pictures import rank_figure, sobol_bars
from workbench.study.study import Results
from workbench.study.uncertainty import Estimate, Share, SobolIndices, share, sobol
from workbench.study.uncertainty.outputs import Flags

COLUMNS = tuple((scenario, joint) for scenario in SCENARIOS for joint in (1, 2))
SHOWN = 8  # factors of a figure
SHARES = len(COLUMNS) * len(PRIORS)  # of one question, which a sentence on it rests on together
TOGETHER = 1 - 0.05 / SHARES  # Bonferroni
INTERVALS = f"intervals of Clopper and Pearson, which for the {SHARES} shares of one question hold together, 95 %"


def title(scenario: str, joint: int) -> str:
    """A column of the published tables."""
    return f"{scenario}, q{joint}"


@dataclass(frozen=True, eq=False)
class Rankings:
    """What the independent draws say of one published column.

    Attributes
    ----------
    pairs
        The probability that each pair of laws, the smaller printed RMSE first, comes in its printed order.
    order
        That all six come in it.
    """

    ranks: Ranks
    pairs: Mapping[tuple[str, str], tuple[float, float, float]]
    order: Share

    @property
    def first(self) -> tuple[float, float, float]:
        """The probability that the proposed law is first, with its interval."""
        found, at = self.ranks.ranks, self.ranks.paired.place(PROPOSED)
        return float(found.value[at, 0]), float(found.low[at, 0]), float(found.high[at, 0])


def rankings(results: Results, prior: Prior = OF_CARD) -> dict[tuple[str, int], Rankings]:
    """Those of all four columns."""
    return {column: _ranking(results, *column, prior) for column in COLUMNS}


def _ranking(results: Results, scenario: str, joint: int, prior: Prior) -> Rankings:
    held, printed = drawn(results, "random", scenario, prior), PUBLISHED[scenario, joint].values
    errors = {
        law: results.sample(named("random", law, scenario, prior)).step_error("RMSE (43)", joint - 1) for law in LAWS
    }
    values = paired(
        {law: values[:, joint - 1] for law, values in held.rmse.items()},
        metric="RMSE (43)",
        unit="rad",
        errors={law: error if np.isfinite(error) else np.nan for law, error in errors.items()},
    )
    laws = tuple(sorted(LAWS, key=printed.__getitem__))
    return counted(values, laws, held.ordered(joint, laws))


def counted(values: Paired, laws: Sequence[str], ordered: Flags) -> Rankings:
    """The shares of the draws, of laws in their printed order, with intervals that hold together over columns and
    priors.
    """
    found = ranks(values, TOGETHER)
    places = {law: found.paired.place(law) for law in laws}
    pairs = {
        (a, b): tuple(
            float(part[places[a], places[b]]) for part in (found.below.value, found.below.low, found.below.high)
        )
        for i, a in enumerate(laws)
        for b in laws[i + 1 :]
    }
    return Rankings(found, pairs, share(ordered, TOGETHER))


def indices(results: Results) -> SobolIndices:
    """Of the margin of the proposed law in each column, which a run that diverged has too: every draw counts."""
    margin = np.concatenate([drawn(results, "paired", scenario).margin for scenario in SCENARIOS], axis=1)
    return sobol(PAIRED, margin, [title(*column) for column in COLUMNS], factors=NAMES)


def _cell(value: float, low: float, high: float) -> str:
    return f"{100 * value:.0f} ({100 * low:.0f} to {100 * high:.0f})"


def ranking_section(results: Results, found: Mapping[tuple[str, int], Rankings]) -> Section:
    """The published rankings, one column of the tables after the other."""
    every = [value for one in found.values() for value, _, _ in one.pairs.values()]
    likely = sum(value > 0.5 for value in every)
    orders = max(one.order.value for one in found.values())
    ordered = f"in at most {100 * orders:.1f} %" if orders else "in none"
    figures = tuple(
        rank_figure(
            f"ranks_{scenario.lower()}_q{joint}",
            f"How often each law has which rank by RMSE of joint {joint}, {SCENARIOS[scenario]}.",
            dict(zip(LAWS, one.ranks.ranks.value, strict=True)),
            f"{one.ranks.paired.said} Seed {RANDOM.seed}.",
        )
        for (scenario, joint), one in found.items()
    )
    return Section(
        "Does the published ranking hold whatever is not stated?",
        (
            Paragraph(
                f"{RANDOM.runs} independent draws of everything at once under the prior of the card: all numbers over "
                f"its ranges, Q, R and l of {PROPOSED} evenly on logarithmic scales and all others evenly, all "
                "readings alike, the same horizon and the same square wave for the six laws of a draw. A run that "
                f"diverged is worse than any other. Of the {len(every)} printed pairs {likely} come in their printed "
                f"order in more than half of the draws; all six laws of a column do {ordered}. A run "
                "that diverges later than its horizon has its RMSE there, and counts as any other."
            ),
            Paragraph(f"{shaken(results, (OF_CARD,))} In such draws the step decides the rank."),
            _pairs(found),
            *figures,
        ),
    )


def shaken(results: Results, priors: Iterable[Prior]) -> str:
    """How many values of the proposed law the step moves, of which the intervals know nothing."""
    names = {named("random", PROPOSED, scenario, prior) for prior in priors for scenario in SCENARIOS}
    pairs = [(results.sample(name), joint) for name in sorted(names) for joint in (0, 1)]
    values = np.concatenate([sample.outputs("RMSE (43)", joint) for sample, joint in pairs])
    errors = np.concatenate([sample.errors_of("RMSE (43)", joint) for sample, joint in pairs])
    known = ~np.isnan(errors)
    moved = int((errors[known] > CLOSE * values[known]).sum())
    return (
        f"The intervals leave out the error of the step: of {known.sum()} values of {PROPOSED} at 30 s that were taken "
        f"again at half of it, {moved} change by more than {100 * CLOSE:g} %, the most by "
        f"{errors[known].max():.2g} rad."
    )


def _pairs(found: Mapping[tuple[str, int], Rankings]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for a, b in combinations(LAWS, 2):
        # the other laws come in another printed order in every column
        cells = [_cell(*one.pairs[pair]) for one in found.values() for pair in ((a, b), (b, a)) if pair in one.pairs]
        rows.append((f"{a} below {b}" if a == PROPOSED else f"{a} and {b}", *cells))
    rows.append((f"{PROPOSED} first", *(_cell(*one.first) for one in found.values())))
    orders = [one.order for one in found.values()]
    rows.append(("all six", *(_cell(s.value, s.low, s.high) for s in orders)))
    return Table(
        "rankings",
        "The published rankings over all that is open, under the prior of the card: of a hundred draws how many have "
        "laws in the printed order.",
        (Column("laws"), *(Column(title(*column), "%", "right") for column in found)),
        tuple(rows),
        (
            f"In brackets {INTERVALS}; a line has one question, under four priors.",
            f"{RANDOM.runs} draws, seed {RANDOM.seed}.",
        ),
    )


def deciding_section(results: Results) -> Section:
    """Sobol indices of the margin of the proposed law."""
    found = indices(results)
    runs = sum(len(results.sample(named("paired", law, scenario))) for law in LAWS for scenario in SCENARIOS)
    note = (
        f"{PAIRED.size:,} points of a Sobol design, of which {runs:,} runs differ; a run that diverged counts as a "
        f"margin of 1; seed {PAIRED.seed}"
    )
    return Section(
        "Which unstated number decides who wins?",
        (
            Paragraph(
                "Under the prior of the card; these indices hold for no other. "
                f"The margin is the RMSE of {PROPOSED} as a share of its sum with that of the best rival: below 1/2 "
                f"{PROPOSED} is first, and it is 1 where its run diverged. Its Sobol indices say what part of its "
                "variance is due to a number by itself (S1) and together with others (ST). " + deciding_words(found)
            ),
            sobol_bars(
                "deciding",
                f"What decides the margin of {PROPOSED}: the {SHOWN} numbers with the largest ST.",
                few(found),
                note,
            ),
        ),
    )


def deciding_words(found: SobolIndices) -> str:
    """The largest total index of each column in a sentence."""
    said = []
    for name in found.names:
        if name in found.refused:
            said.append(f"{name}: {found.refused[name]}")
            continue
        ST = found[name].ST
        top = np.argsort(-ST.value)[:3]
        said.append(
            f"{name}: "
            + ", ".join(f"{found.factors[i]} ({ST.value[i]:.2f} \N{PLUS-MINUS SIGN} {ST.half[i]:.2f})" for i in top)
        )
    return "The largest ST are, " + "; ".join(said) + "."


def few(found: SobolIndices) -> SobolIndices:
    """The same for the factors with the largest ST in any column."""
    known = [name not in found.refused for name in found.names]
    order = np.sort(np.argsort(-found.ST.value[known].max(axis=0), kind="stable")[:SHOWN])
    S1, ST = (Estimate(part.value[:, order], part.half[:, order]) for part in (found.S1, found.ST))
    return replace(found, factors=tuple(found.factors[i] for i in order), S1=S1, ST=ST)
