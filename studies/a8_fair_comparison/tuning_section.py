"""The sections of a8 on the searches, and on how far the comparison can be trusted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

import workbench as wb
from studies.a8_fair_comparison import findings
from studies.a8_fair_comparison.ablations import NEW
from studies.a8_fair_comparison.evidence import Evidence
from studies.paper.costs import CONFIDENCE, FAMILY
from studies.paper.entrants import ALL_INFORMATION, BOTH, ENTRANTS, PROPOSED_LAW, Entrant
from studies.paper.scenarios import HELD_OUT, LATE, both

PARTS_WORDS = (
    f"Each law is {PROPOSED_LAW} without one of its parts. Without the disturbance estimate it is {PROPOSED_LAW} "
    "behind observer (10)."
)
GROUPS: Mapping[str, tuple[str, Sequence[Entrant]]] = {  # laws that were tuned: a sentence, and the laws
    **{given.key: (f"Every law has {given.words}.", ENTRANTS[given.key]) for given in ALL_INFORMATION},
    "parts": (PARTS_WORDS, NEW),
}
NOTE = (
    "This note is also for the tables of other measurements. The least cost is the mean over both training scenarios "
    "and the training noises of all searches; the number in brackets is its error by the step. The next column has the "
    "least cost of each search under the noise of that search."
)
RANGES = (
    "A search begins within the range of the fourth column, on a logarithmic scale. It may go down to a thousandth of "
    "the lower end and up to a thousand times the upper end, unless a physical limit comes first."
)


def trust(results: wb.Results, evidence: Evidence) -> wb.Section:
    return wb.Section(
        "How far to trust this",
        (
            wb.Paragraph(findings.divergence_words(evidence)),
            wb.Paragraph(
                "Intervals cover the chance of the draws. All intervals of one scenario hold at once with a confidence "
                f"of {100 * CONFIDENCE:g} %, and therefore all intervals of a statistic in all {len(HELD_OUT)} "
                f"scenarios with {100 * FAMILY:g} %. This is approximate: for a skewed sample of 160 draws, intervals "
                "of 99.5 % covered the true value in 98.7 % of trials. The draws are the same in all scenarios, so "
                "scenarios are not independent trials."
            ),
            wb.Paragraph(
                "Intervals do not cover the chance of a search, which may end far from another search for the same "
                "law. They do not cover the choice of objective, scenarios and ranges either. One run in sixteen was "
                "repeated with half the step; the error of the step is the largest error of the repeated runs. For all "
                "scenarios together it is a mean over the repeated runs, in which each run's error is divided by the "
                "cost of that run. The arm is integrated by RK4 with one step in each period of the computer."
            ),
            wb.Paragraph(
                "The laws were tuned for two sets of masses. A tuning over random draws could make all laws more "
                "robust, but takes many times as long. The nodes of the network of RBF-ASMC and the rules of "
                "Fuzzy-ASMC were not tuned: they are those of a1."
            ),
            *tables_with_note(partial(tuned_numbers, results), RANGES),
        ),
    )


def tuning(results: wb.Results) -> wb.Section:
    shown = {one.name: results.tuning(one.key) for one in ENTRANTS[BOTH.key]}
    note = next(iter(shown.values())).note
    budget = wb.pictures.budget_curves(
        "budget",
        "The least cost that the searches have found so far, for each law behind both observers.",
        {name: curves(one) for name, one in shown.items()},
        f"For {next(iter(shown))}: {note}",
        "cost",
    )
    late_error, chattering = (
        lambda runs, metric=metric: np.mean([both(sample, metric) for sample in runs.values()], axis=0)
        for metric in (LATE, "TV")
    )
    front = wb.pictures.pareto_fronts(
        "front_chattering",
        "Chattering against late error in the training scenarios, for each law behind both observers. A front has the "
        "evaluations that no other evaluation of the same law beats in both.",
        {name: one.measures(late_error, chattering) for name, one in shown.items()},
        "The runs are those of the figure above",
        "late RMSE [rad]",
        "TV [N m/s]",
    )
    return wb.Section(
        "Tuning with the same budget", (budget, front, *tables_with_note(partial(searches, results), NOTE))
    )


def searches(results: wb.Results, key: str, notes: tuple[str, ...]) -> wb.document.ReportTable:
    """The searches of a group of laws that were tuned: budget, least costs, and the doubts about them."""
    words, entrants = GROUPS[key]
    rows = []
    for entrant in entrants:
        tuned = results.tuning(entrant.key)
        cost, bests = (
            wb.document.ValueWithError(tuned.objective, tuned.step_error),
            ", ".join(f"{best:#.4g}" for best in tuned.bests),
        )
        physical = (f"'{name}' is at a physical limit: {why}." for name, why in tuned.at_physical.items())
        rows.append((entrant.name, len(entrant.tuned_numbers), cost, bests, " ".join((*tuned.warnings, *physical))))
    heads = (
        wb.document.TableColumn("law"),
        *(wb.document.TableColumn(name, align="right") for name in ("numbers", "least cost")),
    )
    columns = (
        *heads,
        wb.document.TableColumn("least cost of each search", width=20),
        wb.document.TableColumn("doubts and limits", width=24),
    )
    return wb.document.ReportTable(f"searches_{key}", f"The searches. {words}", columns, tuple(rows), notes)


def tuned_numbers(results: wb.Results, key: str, notes: tuple[str, ...]) -> wb.document.ReportTable:
    """The numbers of a group of laws as tuned, with the ranges in which the searches begin."""
    words, entrants = GROUPS[key]
    rows = []
    for entrant in entrants:
        best = results.tuning(entrant.key).best
        for one in entrant.tuned_numbers:
            spread, tuned = f"{one.low:g} to {one.high:g}", f"{best[one.name]:.7g}"
            rows.append((entrant.name, letter(one.name), wb.document.superscript_powers(one.unit), spread, tuned))
    heads = tuple(map(wb.document.TableColumn, ("law", "number", "unit", "a search begins within", "as tuned")))
    return wb.document.ReportTable(f"numbers_{key}", f"The numbers as tuned. {words}", heads, tuple(rows), notes)


def tables_with_note(
    make: Callable[[str, tuple[str, ...]], wb.document.ReportTable], note: str
) -> tuple[wb.document.ReportTable, ...]:
    """A table of each group of laws, the first with a note."""
    return tuple(make(key, () if i else (note,)) for i, key in enumerate(GROUPS))


def letter(name: str) -> wb.document.Phrase:
    """A number's name as it is printed: K(0) by its letter too."""
    stem, bracket, rest = name.partition("(")
    return (
        (wb.notation.symbol(stem), bracket + rest) if bracket else name if name == "lag" else wb.notation.symbol(name)
    )


def curves(one: wb.tuning.TuningResult) -> tuple[wb.Array, wb.Array]:
    """The evaluations, and the best so far of each search; one that ended early stays where it was."""
    longest = max(one.searches, key=lambda search: len(search.bests)).evaluations
    bests = [np.append(s.bests, np.full(len(longest) - len(s.bests), s.bests[-1])) for s in one.searches]
    return longest, np.stack(bests)
