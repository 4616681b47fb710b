"""Tuning: what is asked of a search for the numbers of a loop, the same for every law that is compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.metrics import AbstractMetric
from workbench.study.cells import check_name
from workbench.study.contract import Loop, check_loop
from workbench.study.factors import Factor
from workbench.study.sample import Sample
from workbench.study.sweep import check_times
from workbench.validation.doors import door
from workbench.validation.words import Array, described, seed, whole

LEAST = 4  # members of a population, of which a new point is made

# The runs of each trial by its name, finite in all of them, to what they are worth, (n,): the smaller the better.
Objective = Callable[[Mapping[str, Sample]], Array]


@dataclass(frozen=True, eq=False)
@door
class Trial:
    """A loop in which numbers have to prove themselves: one of the scenarios that a search trains on.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes part of the name of a file.
    h, until, every
        Step, horizon and distance of the times at which metrics are taken, in s, as those of a `Sweep`.
    seed
        Of the noise, which is the same for all points.
    """

    name: str
    loop: Loop
    metrics: tuple[AbstractMetric, ...]
    h: float
    until: float
    every: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        check_name("Trial", self.name)
        check_loop(f"Trial({self.name!r}, loop=...)", self.loop)
        check_times("Trial", self.name, self.h, self.until, self.every)
        seed("Trial(seed=...)", self.seed)


@dataclass(frozen=True, eq=False)
@door
class Tuning:
    """A search for the numbers of a loop that make an objective least over some trials, within a budget.

    Attributes
    ----------
    name
        Lower-case letters, digits and underscores: it becomes part of the names of files.
    factors
        The numbers, the same paths in each trial, with the ranges in which they are sought. On a `LogUniform` range
        the search is one of the logarithm.
    objective
        From the runs of each trial by its name, those of one point at one place in all of them, to (n,), the smaller
        the better, each by its own runs alone; infinite where a point is not admissible. A point with a run that
        diverged is left out, and not admissible.
    evaluations, population
        Of each search: how many points it looks at in all, and how many at once.
    seeds
        One search each: chance takes part in where a search ends, and between several one sees how much.

    Raises
    ------
    ValueError
        If a part is none of its kind or missing, names come twice, a range is open, or the evaluations are no
        multiple of the population.
    """

    name: str
    trials: tuple[Trial, ...]
    factors: tuple[Factor, ...]
    objective: Objective
    evaluations: int
    population: int
    seeds: tuple[int, ...] = (0,)

    def __post_init__(self) -> None:
        check_name("Tuning", self.name)
        for part in ("trials", "factors"):
            names = [one.name for one in getattr(self, part)]
            if not names or len(set(names)) < len(names):
                raise ValueError(
                    f"`Tuning({self.name!r}, {part}=...)` needs at least one {part[:-1]}, each of another name; "
                    f"got {names}."
                )
        for trial in self.trials:  # the sweep that it becomes at half the step
            check_name(f"Tuning({self.name!r}, trials=...): Sweep", f"{self.name}_{trial.name}_half")
        for factor in self.factors:
            spread = factor.distribution
            if not (np.isfinite(spread.low) and np.isfinite(spread.high)):
                raise ValueError(
                    f"`Tuning({self.name!r}, factors=...)` needs ranges with two ends, within which all laws search; "
                    f"that of '{factor.name}' is {spread.words()}."
                )
        self._check_budget()

    def _check_budget(self) -> None:
        call = f"Tuning({self.name!r}"
        budget = whole(f"{call}, evaluations=...)", self.evaluations)
        size = whole(f"{call}, population=...)", self.population, LEAST, why="which make a new point")
        if budget % size:
            near = " or ".join(str(near) for near in (budget - budget % size, budget - budget % size + size) if near)
            raise ValueError(
                f"`{call}, evaluations=...)` must be a multiple of the population, {size}, so that every law gets the "
                f"same number of them; got {budget}: take {near}."
            )
        if not self.seeds or len(set(self.seeds)) < len(self.seeds):
            raise ValueError(f"`{call}, seeds=...)` needs at least one seed, each once; got {described(self.seeds)}.")
        for one in self.seeds:
            seed(f"{call}, seeds=...)", one)

    @property
    def size(self) -> int:
        """How many points all searches look at together."""
        return self.evaluations * len(self.seeds)

    @property
    def generations(self) -> int:
        """How often a search asks for a whole population."""
        return self.evaluations // self.population
