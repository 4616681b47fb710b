"""The probability of each published ranking over all that is open, and the open number that decides who wins."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Literal, TypeAlias

import numpy as np

from studies.a6_unstated_choices.fits import CLOSE
from studies.a6_unstated_choices.loops import NAMES, PAIRED, PRIORS, PROPOSED, RANDOM, SCENARIOS, drawn, margin, named
from studies.paper.card import LAWS, PUBLISHED
from workbench.study.document.document import Column, Figure, Table, Verdict
from workbench.study.evidence import Ranks, paired, ranks
from workbench.study.pictures import rank_figure, sobol_bars
from workbench.study.study import Results
from workbench.study.uncertainty import Estimate, SobolIndices, sobol

COLUMNS = {(scenario, joint): f"{scenario}, q{joint}" for scenario in SCENARIOS for joint in (1, 2)}
SHOWN = 8  # factors of a figure
SHARES = len(COLUMNS) * len(PRIORS)  # of one question, which a sentence on it rests on together
TOGETHER = 1 - 0.05 / SHARES  # Bonferroni
INTERVALS = f"intervals of Clopper and Pearson, which for the {SHARES} shares of one question hold together, 95 %"

Triple: TypeAlias = tuple[float, float, float]  # a share and the ends of its interval
NO, YES, TURNS, OPEN = "no, under each", "yes, under each", "depends on the prior", "open"  # in most draws
KINDS: Mapping[str, Literal["found", "depends", "open"]] = {NO: "found", YES: "found", TURNS: "depends", OPEN: "open"}
SAMPLE = (
    f"Shares of {RANDOM.runs} independent draws for each prior, the same points of the unit cube for all of them, "
    f"with {INTERVALS}."
)
GIVEN = (
    "All readings alike; the same square wave, horizon and kind of measurement for the rivals in a draw, while the "
    "proposed law draws its own between exact measurement and observer (10); K(0) and gamma the same for all that "
    "adapt."
)


Ranked: TypeAlias = Mapping[str, Mapping[tuple[str, int], Ranks]]  # by the name of the prior


def ranked(results: Results) -> Ranked:
    """The ranks of the laws in all four columns under each prior."""
    every: dict[str, dict[tuple[str, int], Ranks]] = {}
    for name, prior in PRIORS.items():
        for scenario, joint in COLUMNS:
            rmse = {law: values[:, joint - 1] for law, values in drawn(results, "random", scenario, prior).items()}
            held = ranks(paired(rmse, metric="RMSE (43)", unit="rad"), TOGETHER)
            every.setdefault(name, {})[scenario, joint] = held
    return every


def ahead(one: Ranks, rival: str | None = None) -> Triple:
    """The probability that the proposed law is below a rival, or else first, with its interval."""
    part = one.ranks if rival is None else one.below
    at = LAWS.index(PROPOSED), 0 if rival is None else LAWS.index(rival)
    return float(part.value[at]), float(part.low[at]), float(part.high[at])


def printed_words(columns: Mapping[tuple[str, int], Ranks]) -> str:
    """The share of draws in which laws come in their printed order, two at a time and all six."""
    likely, whole = 0, 0.0
    for column, one in columns.items():
        order = sorted(range(len(LAWS)), key=lambda i: PUBLISHED[column].values[LAWS[i]])
        likely += sum(bool(one.below.value[pair] > 0.5) for pair in combinations(order, 2))
        values = one.paired.values[:, order]
        whole = max(whole, float((values[:, :-1] < values[:, 1:]).all(axis=1).mean()))
    pairs = len(columns) * len(LAWS) * (len(LAWS) - 1) // 2
    return (
        f"Under the prior of the card {likely} of the {pairs} printed pairs of laws come in their printed order in "
        f"more than half of the draws, and all six laws of a column in at most {100 * whole:.1f} %."
    )


def ranks_figure(results: Results, columns: Mapping[tuple[str, int], Ranks]) -> Figure:
    """The ranks of the laws in the four columns, a panel each."""
    samples = [results.sample(named("random", law, scenario)) for law in LAWS for scenario in SCENARIOS]
    lost = sum(int(columns[scenario, 1].paired.failed.sum()) for scenario in SCENARIOS)
    error = np.nanmax([sample.score("RMSE (43)", joint).largest_error for sample in samples for joint in (0, 1)])
    note = (
        f"{RANDOM.runs} draws for each scenario, prior of the card, seed {RANDOM.seed}; runs that diverge before the "
        f"horizon of their draw: {lost}, each taken as worse than any other; error of the step at most {error:.2g} rad"
    )
    caption = "How often each law has which rank by RMSE, over all that the paper leaves open, in its four columns."
    one = {
        column: rank_figure("ranks", caption, dict(zip(LAWS, each.ranks.value, strict=True)), note)
        for column, each in columns.items()
    }
    panels = tuple(replace(figure.panels[0], title=COLUMNS[column]) for column, figure in one.items())
    first = one["FS", 1]
    rows = tuple((COLUMNS[column], *row) for column, figure in one.items() for row in figure.numbers.rows)
    numbers = Table("ranks", caption, (Column("column"), *first.numbers.columns), rows)
    return replace(first, panels=panels, columns=2, numbers=numbers)


def priors_table(every: Ranked) -> Table:
    """Of a hundred draws how many have the proposed law below each rival, and first, by column and prior."""
    rows = []
    for rival in (*LAWS[1:], None):
        for column, title in COLUMNS.items():
            parts = [ahead(columns[column], rival) for columns in every.values()]
            shown = (f"{100 * value:.0f} ({100 * low:.0f} to {100 * high:.0f})" for value, low, high in parts)
            words = "first" if rival is None else f"below {rival}"
            rows.append((f"{PROPOSED} {words}", title, *shown, majority(parts)))
    return Table(
        "priors",
        f"Of a hundred draws how many have {PROPOSED} below a rival, or first, under four priors.",
        (Column("is"), Column("column"), *(Column(name, "%", "right") for name in every), Column("in most draws")),
        tuple(rows),
        (f"In brackets {INTERVALS}; one question has four lines. Seed {RANDOM.seed}.",),
    )


def indices(results: Results) -> SobolIndices:
    """Of the margin of the proposed law in each column, which a run that diverged has too: every draw counts."""
    margins = np.concatenate([margin(drawn(results, "paired", scenario)) for scenario in SCENARIOS], axis=1)
    return sobol(PAIRED, margins, list(COLUMNS.values()), factors=NAMES)


def deciding_figure(results: Results, every: SobolIndices) -> Figure:
    """The indices of the factors with the largest ST in any column."""
    runs = sum(len(results.sample(named("paired", law, scenario))) for law in LAWS for scenario in SCENARIOS)
    known = [name not in every.refused for name in every.names]
    order = np.sort(np.argsort(-every.ST.value[known].max(axis=0), kind="stable")[:SHOWN])
    S1, ST = (Estimate(part.value[:, order], part.half[:, order]) for part in (every.S1, every.ST))
    few = replace(every, factors=tuple(every.factors[i] for i in order), S1=S1, ST=ST)
    return sobol_bars(
        "deciding",
        f"Sobol indices of the margin of {PROPOSED}: the {SHOWN} numbers with the largest ST.",
        few,
        f"{PAIRED.size:,} points of a Sobol design, of which {runs:,} runs differ; a run that diverged counts as a "
        f"margin of 1; seed {PAIRED.seed}",
    )


def step_words(results: Results) -> str:
    """The error of the proposed law by the step, which the intervals leave out."""
    moves: list[tuple[float, str]] = []
    count = 0
    for scenario in SCENARIOS:
        for name in sorted({named("random", PROPOSED, scenario, prior) for prior in PRIORS.values()}):
            sample = results.sample(name)
            for joint in (0, 1):
                score = sample.score("RMSE (43)", joint)
                values, errors = score.value, score.error
                count += int((errors > CLOSE * values).sum())
                moves += [(float(error), SCENARIOS[scenario]) for error in errors[~np.isnan(errors)]]
    most, where = max(moves)
    return (
        f"The intervals leave out the error of the step: of {len(moves)} values of {PROPOSED} at 30 s that were taken "
        f"at half of it too, {count} are off by more than {100 * CLOSE:g} %, and their ranks are as much the step's as "
        f"the law's; a draw of the {where} is off most, by {most:.2g} rad."
    )


def first_verdict(every: Ranked, step: str) -> Verdict:
    """The share of draws in which the proposed law is first, under each prior and in each column."""
    parts = {name: [ahead(one) for one in columns.values()] for name, columns in every.items()}
    shares = [part for held in parts.values() for part in held]
    ends = "; ".join(f"{name} {interval(min(held))} to {interval(max(held))}" for name, held in parts.items())
    return Verdict(
        KINDS[majority(shares)],
        f"{PROPOSED} has the smallest RMSE of the six laws in {percent(min(shares)[0])} to {percent(max(shares)[0])} "
        "of the choices drawn of what is not stated, by column of the tables and prior; the paper prints it first in "
        "all four columns.",
        f"From the least to the largest of the four columns: {ends}. {printed_words(next(iter(every.values())))} "
        f"{step}",
        SAMPLE,
        GIVEN,
        "Ranges about a few of the choices that meet the tables: there it is first by construction.",
    )


def pairs_verdict(every: Ranked, step: str) -> Verdict:
    """The share of draws in which the proposed law is below each rival, in one sentence for all."""
    ours = {rival: [[ahead(by[column], rival) for by in every.values()] for column in COLUMNS] for rival in LAWS[1:]}
    flat = {rival: [part for parts in by_column for part in parts] for rival, by_column in ours.items()}
    shares = ", ".join(f"{rival} in {percent(min(p)[0])} to {percent(max(p)[0])}" for rival, p in flat.items())
    ends = "; ".join(f"{rival} {interval(min(p))} to {interval(max(p))}" for rival, p in flat.items())
    words = "; ".join(f"{rival} {majority(parts)}" for rival, parts in flat.items())
    # two priors whose intervals of one share have nothing in common
    apart = any(
        max(low for _, low, _ in parts) > min(high for _, _, high in parts)
        for by_column in ours.values()
        for parts in by_column
    )
    return Verdict(
        "depends" if apart else "found",
        f"{PROPOSED} has a smaller RMSE than {shares} of the draws, by {'prior and ' * apart}column.",
        f"Is it below in most draws, under all priors and in all columns? {words}. Least and largest share over four "
        f"priors and four columns: {ends}. {step}",
        SAMPLE,
        GIVEN,
        "Another prior: these four are the corners of two scales, and a range twice as wide is a prior too.",
    )


def interval(part: Triple) -> str:
    return f"{100 * part[0]:.0f} % ({100 * part[1]:.0f} to {100 * part[2]:.0f})"


def percent(part: float) -> str:
    return f"{100 * part:.0f} %"


def majority(parts: Sequence[Triple]) -> str:
    """The answer of most draws under all priors together."""
    below, above = [high < 0.5 for _, _, high in parts], [low > 0.5 for _, low, _ in parts]
    if all(below):
        return NO
    if all(above):
        return YES
    return TURNS if any(below) and any(above) else OPEN


def deciding_verdict(every: SobolIndices) -> Verdict:
    """The number that decides who wins, where one has an index above all others."""
    top = {}
    for name in every.names:
        if name not in every.refused:
            ST = every[name].ST
            top[name] = [(every.factors[i], float(ST.value[i]), float(ST.half[i])) for i in np.argsort(-ST.value)[:3]]
    clear = sum(first[1] - first[2] > second[1] + second[2] for first, second, _ in top.values())
    words = "; ".join(
        f"{name}: " + ", ".join(f"{factor} ({ST:.2f} \N{PLUS-MINUS SIGN} {half:.2f})" for factor, ST, half in three)
        for name, three in top.items()
    )
    return Verdict(
        "found" if clear == len(COLUMNS) else "open",
        f"In {clear} of {len(COLUMNS)} columns one of the {len(NAMES)} unstated numbers and readings has a larger part "
        f"than any other in how {PROPOSED} stands beside its best rival.",
        f"The largest ST are, {words}.",
        f"Total Sobol indices (ST) of the margin, the RMSE of {PROPOSED} as a share of its sum with that of the best "
        f"rival: below 1/2 {PROPOSED} is first, and it is 1 where its run diverged. Each interval by itself.",
        "The prior of the card; these indices hold for no other.",
        "More points of the design, where two intervals meet.",
    )
