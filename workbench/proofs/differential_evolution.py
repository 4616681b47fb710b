"""Differential evolution over the unit cube: a population search that asks for whole generations at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workbench.core.validation.refusals import Array, refusal, require, whole
from workbench.core.validation.signatures import check_arguments

Flags = NDArray[np.bool_]

CROSSOVER = 0.9
# The differential weight is drawn anew for every trial from this range, which keeps a small population from stalling.
WEIGHTS = (0.4, 1.0)


@dataclass(frozen=True, eq=False)
@check_arguments
class TrialValues:
    """The worth of trials: `value` (B,), which is maximised, and `excess` (B,), by how much each is inadmissible.

    An excess of zero or less is admissible. Infinity as a value is the best there is; a NaN is none.
    """

    value: Array
    excess: Array

    def __post_init__(self) -> None:
        if self.value.ndim != 1 or not self.value.size or self.value.shape != self.excess.shape:
            got = f"shapes {self.value.shape} and {self.excess.shape}"
            raise ValueError(
                f"`TrialValues(value, excess)` must be two vectors of one number a trial, at least one; got {got}."
            )

    @check_arguments
    def beats(self, other: TrialValues) -> Flags:
        """True where each trial is no worse than another: admissible first, then by value, among others by excess."""
        mine, theirs = self.excess <= 0, other.excess <= 0
        by_value = mine & theirs & (self.value >= other.value)
        by_excess = ~mine & ~theirs & (self.excess <= other.excess)
        return np.asarray((mine & ~theirs) | by_value | by_excess)

    def best(self) -> int:
        """The place of the best trial."""
        return int(np.lexsort((self.value, -np.maximum(self.excess, 0)))[-1])


@check_arguments
def evolve(
    judge: Callable[[Array], TrialValues],
    dimensions: int,
    population: int,
    generations: int,
    rng: np.random.Generator,
    start: tuple[Array, Array] | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    mix_strategies: bool = True,
) -> tuple[Array, TrialValues]:
    """The last population u (B, d) in the unit cube, and its worth, by DE/best/1 and, if `mix_strategies`, DE/rand/1.

    A trial beyond the cube is put between its parent and the face. `judge` gives trials (B, d) their worth, once a
    generation and once before; `start` has the ends (d,) of the box from which the first population is drawn;
    `should_stop` is asked before each generation.

    References
    ----------
    Storn and Price (1997), Differential evolution, Journal of Global Optimization 11; Deb (2000), An efficient
    constraint handling method for genetic algorithms, Computer Methods in Applied Mechanics and Engineering 186.
    """
    dimensions, population = whole("evolve(dimensions=...)", dimensions), whole("evolve(population=...)", population, 4)
    generations = whole("evolve(generations=...)", generations, 0)
    u = _first(start, dimensions, population, rng)
    worth = _worth(judge, u)
    for _ in range(generations):
        if should_stop():
            break
        trial = _trials(u, u[worth.best()], rng, mix_strategies)
        found = _worth(judge, trial)
        better = found.beats(worth)
        value, excess = np.where(better, found.value, worth.value), np.where(better, found.excess, worth.excess)
        u, worth = np.where(better[:, None], trial, u), TrialValues(value, excess)
    return u, worth


def _trials(u: Array, best: Array, rng: np.random.Generator, mixed: bool) -> Array:
    population, dimensions = u.shape
    a, b, c = (rng.permutation(population) for _ in range(3))
    elsewhere = mixed & (np.arange(population) % 2 == 1)
    base = np.where(elsewhere[:, None], u[a], best)
    trial = base + rng.uniform(*WEIGHTS, (population, 1)) * (u[b] - u[c])
    inherited = rng.random((population, dimensions)) > CROSSOVER
    inherited[np.arange(population), rng.integers(dimensions, size=population)] = False
    trial = np.where(inherited, u, trial)
    back = rng.random((population, dimensions))
    return np.where(trial < 0, u * back, np.where(trial > 1, u + (1 - u) * back, trial))


def _first(start: tuple[Array, Array] | None, dimensions: int, population: int, rng: np.random.Generator) -> Array:
    """A Latin hypercube (B, d): one point in every slice of every axis of a box."""
    low, high = (np.zeros(dimensions), np.ones(dimensions)) if start is None else start
    if low.shape != (dimensions,) or high.shape != low.shape or not ((low >= 0) & (low < high) & (high <= 1)).all():
        must = f"the low and the high ends ({dimensions},) of a box in the unit cube, low < high"
        raise refusal("evolve(start=...)", must, start)
    u = np.argsort(rng.random((dimensions, population)), axis=1).T + rng.random((population, dimensions))
    return np.asarray(low + (high - low) * (u / population))


def _worth(judge: Callable[[Array], TrialValues], trials: Array) -> TrialValues:
    worth: TrialValues = require("evolve(judge=...)", judge(trials), TrialValues, ", which it gave for trials")
    if len(worth.value) != len(trials):
        raise ValueError(f"`evolve(judge=...)` must judge all of {len(trials)} trials; it judged {len(worth.value)}.")
    return worth
