"""A tuning ready to search: its trials with their equations, at the step and at half of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.study.preparation import prepared
from workbench.study.prepared import Prepared
from workbench.study.sweep import Sweep
from workbench.study.tuning.contract import Trial, Tuning
from workbench.study.uncertainty.designs import AbstractDesign
from workbench.study.uncertainty.distributions import AbstractDistribution
from workbench.validation.words import Array

# Points of a search that are run again at half the step: as many as one vector of the widest processors holds.
FINALISTS = 8
BISECTIONS = 60  # of the unit interval, to its last bit


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

    @cached_property
    def noises(self) -> int:
        """How many training noises there are: one a search, or one alone where no trial has any."""
        return len(self.tuning.seeds) if any(one.coarse.noises for one in self.trials) else 1

    @property
    def start(self) -> tuple[Array, Array]:
        """The ends of the box in the unit cube from which the first population is drawn."""
        starts, low, high = self.tuning.starts, np.zeros(len(self.tuning.factors)), np.ones(len(self.tuning.factors))
        for i, factor in enumerate(self.tuning.factors):
            if factor.name in starts:
                low[i], high[i] = (_place(factor.distribution, end) for end in starts[factor.name])
        return low, high

    def under(self, sweeps: Sequence[Prepared], noise: int) -> list[Prepared]:
        """Sweeps of all trials under a training noise, counted from 0."""
        trials = self.tuning.trials
        return [one.under(self.tuning.noise(t, noise)) for one, t in zip(sweeps, trials, strict=True)]


def ready(tuning: Tuning, arithmetics: Mapping[str, str] | None = None) -> Ready:
    """The tuning with its equations, in arithmetics by the names of its sweeps.

    Raises
    ------
    LookupError, ValueError
        As `prepared`, with the name of the trial: if a factor varies what its loop does not have, say.
    """
    trials = tuple(_prepared(tuning, trial, arithmetics or {}) for trial in tuning.trials)
    made = Ready(tuning, trials, ())
    few = Awaited(len(tuning.factors), min(FINALISTS, tuning.evaluations) * len(tuning.seeds) * made.noises)
    return replace(made, halves=tuple(one.at_half(f"{one.sweep.name}_half").at(few) for one in trials))


def _place(distribution: AbstractDistribution, value: float) -> float:
    """Where a value of a range lies in the unit cube: the inverse of the quantile, by bisection."""
    low, high = 0.0, 1.0
    if value in (distribution.low, distribution.high):
        return low if value == distribution.low else high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        below = float(distribution.quantile(np.array([middle]))[0]) < value
        low, high = (middle, high) if below else (low, middle)
    return high


def _pilots(dimensions: int) -> Array:
    """The middle of the unit cube, and with each coordinate at either end, (1 + 2 d, d)."""
    middle = np.full(dimensions, 0.5)
    ends = [np.where(np.arange(dimensions) == i, end, middle) for i in range(dimensions) for end in (0.0, 1.0)]
    return np.array([middle, *ends])


def _prepared(tuning: Tuning, trial: Trial, arithmetics: Mapping[str, str]) -> Prepared:
    """A trial as a sweep, whose points are only known as the search goes on."""
    try:
        sweep = Sweep(
            name=f"{tuning.name}_{trial.name}",
            run=trial.run,
            factors=tuning.factors,
            design=Awaited(len(tuning.factors), tuning.size),
            common=True,
            halved=None,
            runs_of_chunk=tuning.population,
        )
        return prepared(sweep, arithmetics.get(sweep.name), _pilots(len(tuning.factors)), searches=True)
    except (LookupError, ValueError) as error:
        if type(error) not in (LookupError, ValueError):
            raise
        raise type(error)(f"`Tuning({tuning.name!r})` in the trial '{trial.name}': {error}") from error
