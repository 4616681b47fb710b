"""The unstated number or reading that decides who is first: Sobol indices of the margin of the proposed law."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.draws import PAIRED_DESIGN, margin, rmse_by_law, sweep_name
from studies.a6_unstated_choices.loops import NAMES, PROPOSED_LAW, SCENARIOS
from studies.a6_unstated_choices.scope import ASSUMPTIONS, INFORMATION, LIMITATIONS
from studies.a6_unstated_choices.shares import COLUMNS
from studies.paper.card import LAWS

FIGURE_FACTORS = 8  # factors of a figure
TABLE_FACTORS = 3  # factors of a column in the table
UNCLEAR = "none"


def indices(results: wb.Results) -> wb.uncertainty.SobolIndices:
    """Of the margin of the proposed law in each column, which a run that diverged has too: every draw counts."""
    margins = np.concatenate([margin(rmse_by_law(results, "paired", scenario)) for scenario in SCENARIOS], axis=1)
    return wb.sobol(PAIRED_DESIGN, margins, list(COLUMNS.values()), factors=NAMES)


@dataclass(frozen=True)
class Part:
    """The total index of a factor with the half width of its interval."""

    factor: str
    ST: float
    half: float

    def __str__(self) -> str:
        return f"{self.factor} ({self.ST:.2f} \N{PLUS-MINUS SIGN} {self.half:.2f})"


def largest(every: wb.uncertainty.SobolIndices) -> dict[str, tuple[Part, ...]]:
    """The factors with the largest ST in each column that has indices."""
    found = {}
    for name in every.names:
        if name not in every.refusals:
            ST = every[name].ST
            order = np.argsort(-ST.value)[:TABLE_FACTORS]
            found[name] = tuple(Part(every.factors[i], float(ST.value[i]), float(ST.half[i])) for i in order)
    return found


def decider(parts: tuple[Part, ...]) -> str:
    """The factor whose interval lies above all others, if one does."""
    first, second = parts[:2]
    return first.factor if first.ST - first.half > second.ST + second.half else UNCLEAR


def deciding_finding(every: wb.uncertainty.SobolIndices) -> wb.Finding:
    """The number that decides who wins, where one has an index above all others."""
    top = largest(every)
    by = {name: decider(top[name]) if name in top else UNCLEAR for name in every.names}
    clear = {name: factor for name, factor in by.items() if factor != UNCLEAR}
    same = set(by.values())
    answer = same.pop() if len(same) == 1 else UNCLEAR
    listed = "; ".join(f"{name}: {factor}" for name, factor in clear.items())
    return wb.Finding(
        name="deciding",
        statement=f"In {len(clear)} of {len(COLUMNS)} columns one unstated number or reading decides more than any "
        f"other how {PROPOSED_LAW} compares with its best rival{': ' + answer if answer != UNCLEAR else ''}.",
        evidence=f"{listed or 'In no column do the intervals separate the largest index from the second'}."
        " The table of indices has the three largest of each column.",
        statistic="Total Sobol index (ST) of the margin, with separate intervals. The margin is the RMSE of "
        f"{PROPOSED_LAW}, divided by the sum of this RMSE and the RMSE of the best rival. With a margin below 1/2, "
        f"{PROPOSED_LAW} is first. The margin is 1 if the run of {PROPOSED_LAW} diverged.",
        sample=f"{PAIRED_DESIGN.size:,} points of a Sobol design, prior of the card, seed {PAIRED_DESIGN.seed}, for "
        f"{len(NAMES)} numbers and readings.",
        information=INFORMATION,
        assumptions=ASSUMPTIONS,
        answer=answer,
        variations=tuple(wb.Variation(name, factor, _detail(top, name)) for name, factor in by.items()),
        limitations=f"The other three priors; a torque limit; {LIMITATIONS}",
        is_decided=bool(clear),
    )


def _detail(top: Mapping[str, tuple[Part, ...]], name: str) -> str:
    return " against ".join(map(str, top[name][:2])) if name in top else "no index: the margin does not vary"


def deciding_table(every: wb.uncertainty.SobolIndices) -> wb.document.ReportTable:
    """The largest indices of each column."""
    top = largest(every)
    rows = tuple((name, *map(str, parts), decider(parts)) for name, parts in top.items())
    heads = ("column", "largest ST", "second", "third", "above all others")
    caption = f"The numbers and readings with the largest total Sobol index of the margin of {PROPOSED_LAW}."
    return wb.document.ReportTable(
        "indices",
        caption,
        tuple(map(wb.document.TableColumn, heads)),
        rows,
        ("Each index has the half width of its interval.",),
    )


def deciding_figure(results: wb.Results, every: wb.uncertainty.SobolIndices) -> wb.document.Figure:
    """The indices of the factors with the largest ST in any column."""
    runs = sum(len(results.sample(sweep_name("paired", law, scenario))) for law in LAWS for scenario in SCENARIOS)
    known = [name not in every.refusals for name in every.names]
    order = np.sort(np.argsort(-every.ST.value[known].max(axis=0), kind="stable")[:FIGURE_FACTORS])
    S1, ST = (wb.uncertainty.Estimate(part.value[:, order], part.half[:, order]) for part in (every.S1, every.ST))
    few = replace(every, factors=tuple(every.factors[i] for i in order), S1=S1, ST=ST)
    return wb.sobol_bars(
        "deciding_indices",
        f"Sobol indices of the margin of {PROPOSED_LAW}: the {FIGURE_FACTORS} numbers with the largest ST.",
        few,
        f"{PAIRED_DESIGN.size:,} points of a Sobol design, of which {runs:,} runs differ; a run that diverged counts "
        f"as a margin of 1; seed {PAIRED_DESIGN.seed}",
    )
