"""The searches of a8: their results, their cost, and the numbers as tuned."""

from __future__ import annotations

import numpy as np

from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, GIVEN, Given
from studies.a8_fair_comparison.objective import LATE, both
from workbench.notation.formula import symbol
from workbench.study.document.document import Column, Measured, Phrase, Section, Table
from workbench.study.document.phrases import raised
from workbench.study.pictures import budget_curves, pareto_fronts
from workbench.study.study import Results
from workbench.study.tuning import Tuned
from workbench.validation.refusals import Array

NOTE = (
    "Here and in the tables below. Least cost: the mean over both training scenarios and the training noises of all "
    "searches, at half the step; in brackets its change from the step. Of each search: its least cost at the step "
    "under its own noise."
)


def tuning(results: Results) -> Section:
    """The searches."""
    shown = {one.name: results.tuned(one.key) for one in ENTRANTS[BOTH.key]}
    note = next(iter(shown.values())).note
    budget = budget_curves(
        "budget",
        "The least cost so far, all laws behind both observers. Bands: between the searches.",
        {name: curves(one) for name, one in shown.items()},
        f"Of {next(iter(shown))}: {note}",
        "cost",
    )
    late_error, chattering = (
        lambda runs, metric=metric: np.mean([both(sample, metric) for sample in runs.values()], axis=0)
        for metric in (LATE, "TV")
    )
    front = pareto_fronts(
        "front_chattering",
        "Error against chattering in the training scenarios: points of the searches that none beats in both.",
        {name: one.measures(late_error, chattering) for name, one in shown.items()},
        "The runs of the figure above",
        "late RMSE [rad]",
        "TV [N m/s]",
    )
    tables = (searches(results, given, (NOTE,) if given == GIVEN[0] else ()) for given in GIVEN)
    return Section("Tuning with the same budget", (budget, front, *tables))


def searches(results: Results, given: Given, notes: tuple[str, ...]) -> Table:
    """The result of each search, and the doubts about it."""
    rows = []
    for entrant in ENTRANTS[given.key]:
        tuned = results.tuned(entrant.key)
        cost, bests = Measured(tuned.objective, tuned.step_error), ", ".join(f"{best:.4g}" for best in tuned.bests)
        physical = (f"'{name}' is at a physical limit: {why}." for name, why in tuned.at_physical.items())
        rows.append((entrant.name, len(entrant.tuned), cost, bests, " ".join((*tuned.warnings, *physical))))
    heads = (Column("law"), *(Column(name, align="right") for name in ("numbers", "least cost")))
    columns = (*heads, Column("of each search"), Column("doubts, and limits"))
    return Table(f"searches_{given.key}", f"The searches of all laws given {given.words}.", columns, tuple(rows), notes)


def tuned_numbers(results: Results, given: Given) -> Table:
    """All numbers as tuned."""
    rows = []
    for entrant in ENTRANTS[given.key]:
        best = results.tuned(entrant.key).best
        for one in entrant.tuned:
            spread, tuned = f"{one.low:g} to {one.high:g}", f"{best[one.name]:.7g}"
            rows.append((entrant.name, letter(one.name), raised(one.unit), spread, tuned))
    heads = tuple(map(Column, ("law", "number", "unit", "begins within", "as tuned")))
    note = (
        "Sought on a scale of logarithms, from where a search begins to a thousandth of its lower and a thousand times "
        "its upper end, where no physical limit comes before."
    )
    notes = (note,) if given == GIVEN[0] else ()
    return Table(f"numbers_{given.key}", f"The numbers as tuned, given {given.words}.", heads, tuple(rows), notes)


def letter(name: str) -> Phrase:
    """A number's name as it is printed: K(0) by its letter too."""
    stem, bracket, rest = name.partition("(")
    return (symbol(stem), bracket + rest) if bracket else name if name == "lag" else symbol(name)


def curves(one: Tuned) -> tuple[Array, Array]:
    """The evaluations, and the best so far of each search; one that ended early stays where it was."""
    longest = max(one.searches, key=lambda search: len(search.bests)).spent
    bests = [np.append(s.bests, np.full(len(longest) - len(s.bests), s.bests[-1])) for s in one.searches]
    return longest, np.stack(bests)
