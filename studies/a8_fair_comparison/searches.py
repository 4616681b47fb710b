"""The searches of a8: what they found, at what cost, and the numbers as tuned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from studies.a8_fair_comparison.entrants import BOTH, ENTRANTS, GIVEN, TOLD, Entrant
from studies.a8_fair_comparison.objective import LATE, both
from workbench.notation.formula import symbol
from workbench.study.document.document import Cell, Column, Measured, Phrase, Section, Table
from workbench.study.document.phrases import raised
from workbench.study.pictures import budget_curves, pareto_fronts
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.tuning import Tuned
from workbench.validation.refusals import Array


def tuning(results: Results) -> Section:
    """The searches."""
    tuned = {one.key: results.tuned(one.key) for entrants in ENTRANTS.values() for one in entrants}
    tuned[TOLD.key] = results.tuned(TOLD.key)
    shown = {one.name: tuned[one.key] for one in ENTRANTS[BOTH.key]}
    asked = next(iter(shown.values())).tuning
    note = (
        f"{len(asked.seeds)} searches a law of at most {asked.evaluations_per_number:.3g} evaluations a number; seeds "
        f"{', '.join(map(str, asked.seeds))}; step {2e3 * asked.trials[0].run.h:g} ms, at half of which the least cost "
        f"changes by at most {max(one.step_error for one in shown.values()):.1g}"
    )
    fronts = {name: one.measures(_late, _chattering) for name, one in shown.items()}
    costs = {name: one.measures(_late, _effort) for name, one in shown.items()}
    return Section(
        "Tuning with the same budget",
        (
            *(
                searches(f"searches_{given.key}", f"The searches of all laws given {given.words}.", tuned, entrants)
                for given in GIVEN
                for entrants in (ENTRANTS[given.key] + ((TOLD,) if given == BOTH else ()),)
            ),
            budget_curves(
                "budget",
                "The least cost so far, all laws behind both observers. Bands: between the searches.",
                {name: _curves(one) for name, one in shown.items()},
                note,
                "cost",
            ),
            pareto_fronts(
                "front_chattering",
                "Error against chattering in the training scenarios: points of the searches that none beats in both.",
                fronts,
                note,
                "late RMSE [rad]",
                "TV [N m/s]",
            ),
            pareto_fronts(
                "front_effort", "Error against effort, likewise.", costs, note, "late RMSE [rad]", "effort [N m]"
            ),
        ),
    )


def searches(name: str, caption: str, found: Mapping[str, Tuned], entrants: Sequence[Entrant]) -> Table:
    """What each search found."""
    rows: list[tuple[Cell, ...]] = []
    for entrant in entrants:
        tuned = found[entrant.key]
        own = ", ".join(f"{best:.4g}" for best in tuned.bests)
        used = ", ".join(
            f"{used:,}{'' if settled else '*'}" for used, settled in zip(tuned.used, tuned.settled, strict=True)
        )
        least = Measured(tuned.objective, tuned.step_error)
        rows.append(
            (
                f"{entrant.name}, oracle" if entrant == TOLD else entrant.name,
                len(entrant.tuned),
                least,
                tuned.spread,
                own,
                f"{100 * (tuned.bests.max() / tuned.bests.min() - 1):.2g}",
                used,
                tuned.tuning.evaluations,
                tuned.failed,
                _remarks(tuned),
            )
        )
    columns = (
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
    asked = found[entrants[0].key].tuning
    notes = (
        "Least cost: the mean over both training scenarios and the training noises of all searches, at half the step; "
        "in brackets its change from the step. By noise: how far it varies between the training noises. Of "
        "each search: its least cost at the step under its own noise; apart: by how much the worst is above the best. "
        "*: not settled, as its last quarter of the "
        "evaluations allowed gained more than 1 %. Not admissible: a run diverged.",
        f"{asked.evaluations_per_number:.3g} evaluations a number and search at most, {asked.population} at once; a "
        f"search ends from {100 * (asked.settle or 1):g} % of them on, once it has settled; seeds "
        f"{', '.join(map(str, asked.seeds))}; step "
        f"{2e3 * asked.trials[0].run.h:g} ms.",
    )
    return Table(name, caption, columns, tuple(rows), notes)


def _remarks(tuned: Tuned) -> str:
    """Where the best numbers lie at a limit, and where the step is not known to be stable."""
    edge = [*tuned.at_edge, *(f"{name} ({why})" for name, why in tuned.at_physical.items())]
    unstable = [t.name for t in tuned.tuning.trials if not 2 * t.run.h <= tuned.stable_steps[t.name]]
    step = [f"step not known to be stable in {', '.join(unstable)}"] if unstable else []
    return "; ".join([*edge, *step])


def numbers(name: str, caption: str, found: Mapping[str, Tuned], entrants: Sequence[Entrant]) -> Table:
    """All numbers as tuned."""
    rows: list[tuple[Cell, ...]] = []
    for entrant in entrants:
        best = found[entrant.key].best
        for one in entrant.tuned:
            spread = f"{one.low:g} to {one.high:g}"
            row = (_letter(one.name), raised(one.unit), spread, f"{one.card:.4g}", f"{best[one.name]:.7g}")
            rows.append((entrant.name, *row))
    heads = tuple(map(Column, ("law", "number", "unit", "begins within", "as assumed", "as tuned")))
    notes = (
        "Sought on a scale of logarithms, from where a search begins to a thousandth of its lower and a thousand times "
        "its upper end, where no physical limit comes before. As assumed: the card of a1, or a usual number.",
    )
    return Table(name, caption, heads, tuple(rows), notes)


def _letter(name: str) -> Phrase:
    """A number's name as it is printed: K(0) by its letter too."""
    letter, bracket, rest = name.partition("(")
    return (symbol(letter), bracket + rest) if bracket else name if name == "lag" else symbol(name)


def _curves(one: Tuned) -> tuple[Array, Array]:
    """The evaluations, and the best so far of each search; one that ended early stays where it was."""
    longest = max(one.searches, key=lambda search: len(search.bests)).spent
    bests = [np.append(s.bests, np.full(len(longest) - len(s.bests), s.bests[-1])) for s in one.searches]
    return longest, np.stack(bests)


def _late(held: Mapping[str, Sample]) -> Array:
    return _mean(held, LATE)


def _chattering(held: Mapping[str, Sample]) -> Array:
    return _mean(held, "TV")


def _effort(held: Mapping[str, Sample]) -> Array:
    return _mean(held, "effort")


def _mean(held: Mapping[str, Sample], metric: str) -> Array:
    """A metric of both joints, the mean over the training scenarios."""
    return np.mean([both(sample, metric) for sample in held.values()], axis=0)
