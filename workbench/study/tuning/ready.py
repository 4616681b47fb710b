"""A tuning ready to search: its trials with their equations, at the step and at half of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.study.prepared import Prepared, prepared
from workbench.study.sampling import AbstractDesign
from workbench.study.sweep import Sweep
from workbench.study.tuning.contract import Trial, Tuning
from workbench.validation.words import Array

FINALISTS = 8  # points that are run again at half the step: as many as one vector of the widest processors holds


@dataclass(frozen=True)
class Awaited(AbstractDesign):
    """As many points as a search will ask for, none of which is known yet."""

    dimensions: int
    count: int

    @property
    def size(self) -> int:
        """How many runs."""
        return self.count

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """None yet.

        Raises
        ------
        LookupError
            Always.
        """
        raise LookupError("`points(first, last)` of a search are not known before it asks for them.")


@dataclass(frozen=True, eq=False)
class Ready:
    """A tuning with the equations of its trials: at the step h for all points, and at h / 2 for the best of them."""

    tuning: Tuning
    trials: tuple[Prepared, ...]
    halves: tuple[Prepared, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Those of the trials."""
        return tuple(trial.name for trial in self.tuning.trials)

    @property
    def finalists(self) -> int:
        """How many points are run again at h / 2."""
        return min(FINALISTS, self.tuning.size)


def ready(tuning: Tuning, arithmetics: Mapping[str, str] | None = None) -> Ready:
    """The tuning with its equations, in arithmetics by the names of its sweeps.

    Raises
    ------
    LookupError, ValueError
        As `prepared`, with the name of the trial: if a factor varies what its loop does not have, say.
    """
    trials = tuple(_prepared(tuning, trial, arithmetics or {}) for trial in tuning.trials)
    few = Awaited(len(tuning.factors), min(FINALISTS, tuning.size))
    halves = tuple(one.at_half(f"{one.sweep.name}_half").at(few) for one in trials)
    return Ready(tuning, trials, halves)


def _prepared(tuning: Tuning, trial: Trial, arithmetics: Mapping[str, str]) -> Prepared:
    """A trial as a sweep, whose points are only known as the search goes on."""
    try:
        sweep = Sweep(
            name=f"{tuning.name}_{trial.name}",
            loop=trial.loop,
            metrics=trial.metrics,
            factors=tuning.factors,
            design=Awaited(len(tuning.factors), tuning.size),
            h=trial.h,
            until=trial.until,
            every=trial.every,
            seed=trial.seed,
            common=True,
            halved=None,
            runs_of_chunk=tuning.population,
        )
        return prepared(sweep, arithmetics.get(sweep.name))
    except (LookupError, ValueError) as error:
        if type(error) not in (LookupError, ValueError):
            raise
        raise type(error)(f"`Tuning({tuning.name!r})` in the trial '{trial.name}': {error}") from error
