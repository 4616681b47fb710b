"""Draws of everything that the paper leaves open, at once for all laws: each law is run where its own numbers change."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from paper_card import CARD, LAWS
from unstated_loops import FACTORS, SCENARIOS, SQUARE, STEPS, Reading, searched

from workbench.core.layout import Array
from workbench.core.numbers import Integers
from workbench.metrics import sampled_rmse
from workbench.study.factors import Factor
from workbench.study.sampling import AbstractDesign, SobolDesign
from workbench.study.sampling.contract import span
from workbench.study.study import Results
from workbench.study.sweep import Sweep

RMSE = sampled_rmse(CARD["sample time of (43)"])
SHORTEST, LONGEST = 5, 30  # s, the horizons of the card
SECONDS = tuple(f"{T} s" for T in range(SHORTEST, LONGEST + 1))
HORIZONS = {scenario: f"horizon of {scenario}" for scenario in SCENARIOS}
BASE, SEED = 128, 6


def factors_of(law: str, scenario: str) -> tuple[Factor, ...]:
    """What a law and a scenario leave open, but for the horizon, which needs no run of its own."""
    return FACTORS[law] + (SQUARE if scenario == "SS" else ())


def _names() -> tuple[str, ...]:
    every = [factor.name for law in LAWS for factor in factors_of(law, "SS")]
    return (*dict.fromkeys(every), *HORIZONS.values())


NAMES = _names()


@dataclass(frozen=True)
class Part(AbstractDesign):
    """Of a Sobol design of all that is open the points that differ in some of its columns."""

    columns: tuple[int, ...]
    base: int = BASE
    seed: int = SEED
    dimensions: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "dimensions", len(self.columns))

    @cached_property
    def whole(self) -> SobolDesign:
        """The design of all that is open."""
        return SobolDesign(len(NAMES), self.base, seed=self.seed)

    @cached_property
    def _distinct(self) -> tuple[Array, Integers]:
        points, places = np.unique(self.whole.points()[:, self.columns], axis=0, return_inverse=True)
        return points, places.ravel()

    @property
    def places(self) -> Integers:
        """(N,): which of its own points stands at each point of the whole design."""
        return self._distinct[1]

    @property
    def size(self) -> int:
        """How many points differ."""
        return len(self._distinct[0])

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1."""
        begin, end = span(self, first, last)
        return self._distinct[0][begin:end]


def slug(law: str, scenario: str = "") -> str:
    """A name for files."""
    return "_".join(part for part in (law.lower().replace("-", "_"), scenario.lower()) if part)


def draws(law: str, scenario: str) -> Sweep:
    """A law in a scenario, over all that they leave open."""
    factors = factors_of(law, scenario)
    design = Part(tuple(NAMES.index(factor.name) for factor in factors))
    return Sweep(
        f"draws_{slug(law, scenario)}",
        searched(law, scenario),
        (RMSE,),
        factors,
        design,
        h=STEPS[law],
        until=LONGEST,
        every=1.0,
        halved=32,
    )


def first_second(t: Array) -> int:
    """The place of the shortest horizon among the times."""
    return int(np.argmin(np.abs(t - SHORTEST)))


@dataclass(frozen=True, eq=False)
class Draws:
    """RMSE (N, 2) by law, in rad, over the same N draws of a scenario; infinite for a run that diverged."""

    whole: SobolDesign
    rmse: Mapping[str, Array]
    failed: Mapping[str, float]

    @property
    def rank(self) -> Array:
        """The place of the first law among all, (N, 2): 1 is the smallest RMSE; last where its own run diverged."""
        ours, *rivals = (self.rmse[law] for law in LAWS)
        below = np.sum([rival <= ours for rival in rivals], axis=0)
        return np.asarray(1 + np.where(np.isinf(ours), len(rivals), below))

    @property
    def independent(self) -> Integers:
        """The draws in which every number is drawn anew, and none is exchanged alone: two a pair of the design."""
        block = self.whole.block
        return np.flatnonzero(np.isin(np.arange(self.whole.size) % block, (0, block - 1)))


def drawn(results: Results, scenario: str) -> Draws:
    """The draws of a scenario, each at its own horizon."""
    rmse, failed = {}, {}
    for law in LAWS:
        sample = results.sample(f"draws_{slug(law, scenario)}")
        assert isinstance(sample.design, Part)
        whole, places = sample.design.whole, sample.design.places
        u = whole.points()[:, NAMES.index(HORIZONS[scenario])]
        rows = first_second(sample.t) + Reading(SECONDS).quantile(u).astype(int)
        values = sample.values[places, rows]
        rmse[law] = np.where(np.isnan(values), np.inf, values)
        failed[law] = sample.failed / len(sample)
    return Draws(whole, rmse, failed)
