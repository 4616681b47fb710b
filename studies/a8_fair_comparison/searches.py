"""The searches of a8: their results, their cost, and the numbers as tuned."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, GIVEN, TOLD, Given
from studies.a8_fair_comparison.objective import LATE, both
from workbench.notation.formula import symbol
from workbench.study.document.document import Column, Measured, Phrase, Section, Table
from workbench.study.document.phrases import raised
from workbench.study.pictures import budget_curves, pareto_fronts
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.tuning import Tuned
from workbench.validation.refusals import Array

COLUMNS = (
    Column("law"),
    Column("numbers", align="right"),
    Column("least cost", align="right"),
    Column("by noise", align="right"),
    Column("of each search"),
    Column("apart", "%", "right"),
    Column("evaluations"),
    Column("at most", align="right"),
    Column("not admissible", align="right"),
    Column("at a limit"),
)
NOTE = (
    "Here and in the tables below. Least cost: the mean over both training scenarios and the training noises of all "
    "searches, at half the step; in brackets its change from the step. By noise: how far it varies between the "
    "training noises. Of each search: its least cost at the step under its own noise; apart: by how much the worst is "
    "above the best. *: not settled, as its last quarter of the evaluations allowed gained more than 1 %. Not "
    "admissible: a run diverged. A search ends from 40 % of its evaluations on, once it has settled."
)


def tuning(results: Results) -> Section:
    """The searches."""
    shown = {one.name: results.tuned(one.key) for one in ENTRANTS[BOTH.key]}
    asked = next(iter(shown.values())).tuning
    note = (
        f"{len(asked.seeds)} searches a law of at most {asked.evaluations_per_number:.3g} evaluations a number; seeds "
        f"{', '.join(map(str, asked.seeds))}; step {2e3 * asked.trials[0].run.h:g} ms, at half of which the least cost "
        f"changes by at most {max(one.step_error for one in shown.values()):.1g}"
    )
    return Section(
        "Tuning with the same budget",
        (
            budget_curves(
                "budget",
                "The least cost so far, all laws behind both observers. Bands: between the searches.",
                {name: curves(one) for name, one in shown.items()},
                note,
                "cost",
            ),
            pareto_fronts(
                "front_chattering",
                "Error against chattering in the training scenarios: points of the searches that none beats in both.",
                {name: one.measures(late_error, chattering) for name, one in shown.items()},
                note,
                "late RMSE [rad]",
                "TV [N m/s]",
            ),
            *(searches(results, given, (NOTE,) if given == GIVEN[0] else ()) for given in GIVEN),
        ),
    )


def searches(results: Results, given: Given, notes: tuple[str, ...]) -> Table:
    """The result of each search."""
    rows = []
    for entrant in (*ENTRANTS[given.key], *((TOLD,) if given == BOTH else ())):
        tuned = results.tuned(entrant.key)
        spent = zip(tuned.used, tuned.settled, strict=True)
        rows.append(
            (
                f"{entrant.name}, oracle" if entrant == TOLD else entrant.name,
                len(entrant.tuned),
                Measured(tuned.objective, tuned.step_error),
                tuned.spread,
                ", ".join(f"{best:.4g}" for best in tuned.bests),
                f"{100 * (tuned.bests.max() / tuned.bests.min() - 1):.2g}",
                ", ".join(f"{used:,}{'' if settled else '*'}" for used, settled in spent),
                tuned.tuning.evaluations,
                tuned.failed,
                remarks(tuned),
            )
        )
    return Table(f"searches_{given.key}", f"The searches of all laws given {given.words}.", COLUMNS, tuple(rows), notes)


def remarks(tuned: Tuned) -> str:
    """The numbers that lie at a limit, and the trials in which the step is not known to be stable."""
    edge = [*tuned.at_edge, *(f"{name} ({why})" for name, why in tuned.at_physical.items())]
    unstable = [t.name for t in tuned.tuning.trials if not 2 * t.run.h <= tuned.stable_steps[t.name]]
    return "; ".join([*edge, *(f"step not known to be stable in {name}" for name in unstable)])


def tuned_numbers(results: Results, given: Given) -> Table:
    """All numbers as tuned."""
    rows = []
    for entrant in ENTRANTS[given.key]:
        best = results.tuned(entrant.key).best
        for one in entrant.tuned:
            spread, tuned = f"{one.low:g} to {one.high:g}", f"{best[one.name]:.7g}"
            rows.append((entrant.name, letter(one.name), raised(one.unit), spread, f"{one.card:.4g}", tuned))
    heads = tuple(map(Column, ("law", "number", "unit", "begins within", "as assumed", "as tuned")))
    note = (
        "Sought on a scale of logarithms, from where a search begins to a thousandth of its lower and a thousand times "
        "its upper end, where no physical limit comes before. As assumed: the card of a1, or a usual number."
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


def late_error(held: Mapping[str, Sample]) -> Array:
    """The late error of both joints, the mean over the training scenarios."""
    return np.mean([both(sample, LATE) for sample in held.values()], axis=0)


def chattering(held: Mapping[str, Sample]) -> Array:
    """The chattering of both joints, the mean over the training scenarios."""
    return np.mean([both(sample, "TV") for sample in held.values()], axis=0)
