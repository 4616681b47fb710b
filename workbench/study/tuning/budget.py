"""The same search for every law that is compared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from workbench.study.factors import Factor
from workbench.study.tuning.contract import Objective, Trial, Tuning
from workbench.validation.doors import door


@door
def equal_budget(
    laws: Mapping[str, tuple[Sequence[Trial], Sequence[Factor]]],
    objective: Objective,
    *,
    evaluations: int,
    population: int,
    seeds: tuple[int, ...] = (0,),
) -> tuple[Tuning, ...]:
    """Tunings of several laws by one objective, with one budget, from the same seeds and in the same trials.

    Parameters
    ----------
    laws
        From the name of each law to its loops, as trials, and its factors.

    Raises
    ------
    ValueError
        If two laws differ in the names, metrics, steps, horizons or seeds of their trials, or `Tuning` refuses.
    """
    made = tuple(
        Tuning(name, tuple(trials), tuple(factors), objective, evaluations, population, seeds)
        for name, (trials, factors) in laws.items()
    )
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
    return made


def _conditions(tuning: Tuning) -> list[str]:
    """What the trials of two laws must have in common, in words."""
    return [
        f"'{t.name}' with {', '.join(metric.name for metric in t.metrics)} at h = {t.h:g} s for {t.until:g} s, "
        f"values every {t.every or t.until:g} s, seed {t.seed}"
        for t in tuning.trials
    ]
