"""The same search for every law that is compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil

from workbench.study.tuning.contract import Objective, Trial, Tuning
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import known, positive
from workbench.validation.signatures import door

WIDTH = 8  # runs of one vector of the widest processors: a population is a multiple of it


@door
def equal_budget(
    laws: Mapping[str, tuple[Sequence[Trial], Sequence[Factor]]],
    objective: Objective,
    *,
    evaluations: int | None = None,
    evaluations_per_number: float | None = None,
    population: int | None = None,
    seeds: tuple[int, ...] = (0,),
    starts: Mapping[str, Mapping[str, tuple[float, float]]] | None = None,
    physical: Mapping[str, Mapping[tuple[str, str], str]] | None = None,
    settle: float | None = None,
) -> tuple[Tuning, ...]:
    """Tunings of several laws by one objective, with one budget, from the same seeds and in the same trials.

    Parameters
    ----------
    laws
        From the name of each law to its loops, as trials, and its factors.
    evaluations, evaluations_per_number
        Of each search, at most: as many for every law, or as many for each number that is sought, rounded up to whole
        populations. One of the two.
    population
        8 + 2 d points for d numbers, rounded up to a multiple of 8, if it is not given.
    starts, physical
        Those of the tuning of each law, by its name.
    settle
        That of all tunings: the share of its evaluations after which a settled search ends.

    Raises
    ------
    ValueError
        If two laws differ in the names, metrics, steps, horizons or seeds of their trials, both budgets are given or
        none, or `Tuning` refuses.
    LookupError
        If starts or limits are those of no law, or `Tuning` finds no such factor.
    """
    for named, of in ((starts, "starts"), (physical, "physical")):
        for law in named or {}:
            known(law, laws, f"laws of `equal_budget({of}=...)`")
    made = []
    for name, (trials, factors) in laws.items():
        at_once = population_of(len(factors)) if population is None else population
        most = _most(len(factors), at_once, evaluations, evaluations_per_number)
        limits = ((starts or {}).get(name, {}), (physical or {}).get(name, {}))
        made.append(Tuning(name, tuple(trials), tuple(factors), objective, most, at_once, seeds, *limits, settle))
    _refuse_different(made)
    return tuple(made)


def population_of(numbers: int) -> int:
    """How many points a search for so many numbers looks at together: more of them need more evaluations to settle."""
    return WIDTH * ceil((WIDTH + 2 * numbers) / WIDTH)


def _most(numbers: int, population: int, in_all: int | None, each: float | None) -> int:
    """The evaluations of a search for so many numbers."""
    if in_all is not None and each is None:
        return in_all
    if each is not None and in_all is None:
        return population * ceil(numbers * positive("equal_budget(evaluations_per_number=...)", each) / population)
    raise ValueError(
        "`equal_budget(...)` takes either `evaluations` or `evaluations_per_number`; got "
        f"{'none' if each is None else 'both'}."
    )


def _refuse_different(made: Sequence[Tuning]) -> None:
    for one in made[1:]:
        for ours, theirs in zip(_conditions(one), _conditions(made[0]), strict=False):
            if ours != theirs:
                raise ValueError(
                    f"`equal_budget(laws=...)` needs the same trials for every law; '{one.name}' has {ours}, and "
                    f"'{made[0].name}' has {theirs}."
                )
        if len(one.trials) != len(made[0].trials):
            raise ValueError(
                f"`equal_budget(laws=...)` needs the same trials for every law; '{one.name}' has {len(one.trials)}, "
                f"and '{made[0].name}' has {len(made[0].trials)}."
            )


def _conditions(tuning: Tuning) -> list[str]:
    """What the trials of two laws must have in common, in words."""
    return [
        f"'{t.name}' with {', '.join(metric.name for metric in t.run.metrics)} at {t.run.steps} for {t.run.until:g} s, "
        f"values every {t.run.kept:g} s, seed {t.run.seed}"
        for t in tuning.trials
    ]
