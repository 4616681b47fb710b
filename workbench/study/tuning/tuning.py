"""The contract of a tuning: its trials, numbers, objective and budget, the same for every law that is compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np

from workbench.core.validation.refusals import Array, describe, finite, known_name, positive, seed, text, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.factors import Factor
from workbench.study.document.phrases_and_tables import check_name
from workbench.study.run_and_sweep import Run
from workbench.study.sample import Sample

LEAST = 4  # members of a population, of which a new point is made
GAIN = 0.01  # of the objective: a search that gains no more in a window has settled
WINDOW = 4  # a window is one part of so many of the evaluations that a search may have
ENDS = ("low", "high")
WIDTH = 8  # runs of one vector of the widest processors: a population is a multiple of it
NOISES = 1000  # from the seed of a trial's noise in one search to that in the next

# The runs of each trial by its name, finite in all of them, to what they are worth, (n,): the smaller the better.
Objective = Callable[[Mapping[str, Sample]], Array]


@dataclass(frozen=True, eq=False)
@check_arguments
class Trial:
    """A run on which a search judges the numbers of a loop: one of the scenarios that it trains on.

    A search takes the values of its points at the step of the run, and repeats the best points at half the step.
    Without `h`, pilot runs at the ends of each factor's range choose the step.
    """

    name: str
    run: Run

    def __post_init__(self) -> None:
        check_name("Trial", self.name)


@dataclass(frozen=True, eq=False)
@check_arguments
class Tuning:
    """A search for the numbers of a loop that minimise an objective over some trials, within a budget.

    Attributes
    ----------
    factors
        The numbers to search, with the same paths in each trial. A search stays within the ends of their distributions;
        for a `LogUniform` it searches the logarithm.
    objective
        A function from the samples of n points, by the name of the trial, to (n,) numbers, the smaller the better. It
        must judge each point by its own runs alone. It is infinite for a point that is not admissible, such as one with
        a run that diverged.
    evaluations, population
        The largest number of points that each search tries, and the number of points in each of its generations.
    seeds
        One search for each seed, with its own training noise: in search k, counted from 0, the noise of a trial has the
        seed of its run + 1000 k.
    starts
        By factor, the range of the first population; by default from limit to limit.
    physical
        By factor and end, as in `("gamma", "low")`, the reason in words why nothing can lie beyond that limit.
    settle
        A share of the evaluations after which a search ends as soon as it has settled: the last quarter of the
        evaluations allowed gained at most 1 %. By default every search uses all its evaluations.

    Raises
    ------
    ValueError
        If a name comes twice, a range is open, a start is not within the limits, or the evaluations are no multiple of
        the population.
    LookupError
        If a start or a physical limit names no factor.

    References
    ----------
    Storn and Price (1997), Differential evolution, Journal of Global Optimization 11.
    """

    name: str
    trials: tuple[Trial, ...]
    factors: tuple[Factor, ...]
    objective: Objective
    evaluations: int
    population: int
    seeds: tuple[int, ...] = (0,)
    starts: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    physical: Mapping[tuple[str, str], str] = field(default_factory=dict)
    settle: float | None = None

    def __post_init__(self) -> None:
        check_name("Tuning", self.name)
        for part in ("trials", "factors"):
            names = [one.name for one in getattr(self, part)]
            if not names or len(set(names)) < len(names):
                raise ValueError(
                    f"`Tuning({self.name!r}, {part}=...)` needs at least one {part[:-1]}, each of another name; "
                    f"got {names}."
                )
        for trial in self.trials:  # the sweep that its best points become
            check_name(f"Tuning({self.name!r}, trials=...): Sweep", f"{self.name}_{trial.name}_half")
        for factor in self.factors:
            spread = factor.distribution
            if not (np.isfinite(spread.low) and np.isfinite(spread.high)):
                raise ValueError(
                    f"`Tuning({self.name!r}, factors=...)` needs ranges with two ends, within which all laws search; "
                    f"that of '{factor.name}' is {spread.words()}."
                )
        self._check_limits()
        self._check_budget()

    def _check_limits(self) -> None:
        ranges = {factor.name: factor.distribution for factor in self.factors}
        for name, (low, high) in self.starts.items():
            limits = ranges[known_name(name, ranges, f"factors of `Tuning({self.name!r}, starts=...)`")]
            if not limits.low <= low < high <= limits.high:
                raise ValueError(
                    f"`Tuning({self.name!r}, starts=...)` must be ranges, low < high, within the limits of their "
                    f"factors; that of '{name}' is {low:g} to {high:g}, and its limits are {limits.words()}."
                )
        for (name, end), why in self.physical.items():
            known_name(name, ranges, f"factors of `Tuning({self.name!r}, physical=...)`")
            known_name(end, ENDS, "ends of a range")
            text(f"Tuning({self.name!r}, physical=...) at the {end} end of '{name}'", why)

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
            raise ValueError(f"`{call}, seeds=...)` needs at least one seed, each once; got {describe(self.seeds)}.")
        for one in self.seeds:
            seed(f"{call}, seeds=...)", one)
        for trial in self.trials:
            seed(f"{call}, seeds=...): the noise of the last search in '{trial.name}'", self.noise(trial, -1))
        if self.settle is not None:
            finite(f"{call}, settle=...)", self.settle, ", a share of the evaluations", low=0.0, high=1.0)

    @property
    def size(self) -> int:
        """The greatest number of points that all searches together evaluate."""
        return self.evaluations * len(self.seeds)

    @property
    def generations(self) -> int:
        """The greatest number of generations of a search, each a whole population."""
        return self.evaluations // self.population

    @property
    def window(self) -> int:
        """The length of a settled search's last window in generations; 0 if the search is too short to have one."""
        return self.generations // WINDOW

    @property
    def least(self) -> int:
        """The least number of generations of a search, each a whole population."""
        return self.generations if self.settle is None else max(1, ceil(self.settle * self.generations))

    @property
    def evaluations_per_number(self) -> float:
        """The evaluations of a search, divided by the number of its factors."""
        return self.evaluations / len(self.factors)

    @check_arguments
    def noise(self, trial: Trial, search: int) -> int:
        """The seed of the noise of a trial in a search; searches and noises are counted from 0."""
        return trial.run.seed + NOISES * (search % len(self.seeds))


@check_arguments
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
        The largest number of evaluations of each search: the same for every law, or so many for each tuned number, in
        whole populations. Give one of the two.
    population
        The number of points in a generation; by default 8 + 2 d for d numbers, rounded up to a multiple of 8.
    starts, physical
        Those of the tuning of each law, by the name of the law.

    Raises
    ------
    ValueError
        If two laws differ in the names, metrics, steps, horizons or seeds of their trials, both budgets are given or
        none, or `Tuning` refuses.
    LookupError
        If `starts` or `physical` name no law, or `Tuning` finds no such factor.
    """
    for named, of in ((starts, "starts"), (physical, "physical")):
        for law in named or {}:
            known_name(law, laws, f"laws of `equal_budget({of}=...)`")
    made = []
    for name, (trials, factors) in laws.items():
        at_once = population_of(len(factors)) if population is None else population
        most = _most(len(factors), at_once, evaluations, evaluations_per_number)
        limits = ((starts or {}).get(name, {}), (physical or {}).get(name, {}))
        made.append(Tuning(name, tuple(trials), tuple(factors), objective, most, at_once, seeds, *limits, settle))
    _refuse_different(made)
    return tuple(made)


def population_of(numbers: int) -> int:
    """The population of a search for so many numbers: the points that it evaluates together."""
    return WIDTH * ceil((WIDTH + 2 * numbers) / WIDTH)


def _most(numbers: int, population: int, in_all: int | None, each: float | None) -> int:
    if in_all is not None and each is None:
        return in_all
    if each is not None and in_all is None:
        return population * ceil(numbers * positive("equal_budget(evaluations_per_number=...)", each) / population)
    raise ValueError(
        "`equal_budget(...)` takes either `evaluations` or `evaluations_per_number`; got "
        f"{'none' if each is None else 'both'}."
    )


def _refuse_different(tunings: Sequence[Tuning]) -> None:
    for one in tunings[1:]:
        if (ours := _conditions(one)) != (theirs := _conditions(tunings[0])):
            raise ValueError(
                f"`equal_budget(laws=...)` needs the same trials for every law; '{one.name}' has {ours}, and "
                f"'{tunings[0].name}' has {theirs}."
            )


def _conditions(tuning: Tuning) -> str:
    """The conditions that the trials of two laws must have in common."""
    return "; ".join(
        f"'{t.name}' with {', '.join(metric.name for metric in t.run.metrics)} at {t.run.steps} for {t.run.until:g} s, "
        f"values every {t.run.sampling_interval:g} s, seed {t.run.seed}"
        for t in tuning.trials
    )
