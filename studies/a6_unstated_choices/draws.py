"""Draws of all that the paper leaves open, at once for all laws: each law is run where its own numbers change."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from studies.a6_unstated_choices.loops import (
    FACTORS,
    PID,
    PROPOSED,
    SCENARIOS,
    SQUARE,
    STEPS,
    Reading,
    minus,
    observed_pid,
    searched,
)
from studies.paper.card import CARD, LAWS
from workbench.metrics import sampled_rmse
from workbench.study.contract import Run
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.sweep import Sweep
from workbench.study.uncertainty import AbstractDesign, MonteCarlo, SobolDesign
from workbench.study.uncertainty.designs import span
from workbench.study.uncertainty.distributions import LogUniform, Uniform
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Array, Integers

Scale: TypeAlias = Literal["linear", "log"]
RMSE = sampled_rmse(CARD["sample time of (43)"])
SHORTEST, LONGEST = 5, 30  # s, the horizons of the card
HORIZONS = {scenario: f"horizon of {scenario}" for scenario in SCENARIOS}


def factors_of(law: str, scenario: str) -> tuple[Factor, ...]:
    """What a law and a scenario leave open, but for the horizon, which needs no run of its own."""
    return FACTORS[law] + (SQUARE if scenario == "SS" else ())


def all_names() -> tuple[str, ...]:
    """Everything that is open, each once."""
    every = [factor.name for law in LAWS for factor in factors_of(law, "SS")]
    return (*dict.fromkeys(every), *HORIZONS.values())


NAMES = all_names()
RANDOM = MonteCarlo(len(NAMES), 512, seed=6)
PAIRED = SobolDesign(len(NAMES), 128, seed=6)
ASIDE = {law: MonteCarlo(len(FACTORS[law]), 64, seed=6) for law in (PROPOSED, PID)}
KINDS: Mapping[str, MonteCarlo | SobolDesign] = {"random": RANDOM, "paired": PAIRED}


@dataclass(frozen=True)
class Part(AbstractDesign):
    """Of a design of all that is open the points that differ in some of its columns."""

    whole: MonteCarlo | SobolDesign
    columns: tuple[int, ...]
    dimensions: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "dimensions", len(self.columns))

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


@dataclass(frozen=True)
class Prior:
    """On which scale each number is drawn evenly: those of the proposed law, and all others with the experiment's."""

    ours: Scale
    rest: Scale

    def scales(self, law: str, scenario: str) -> tuple[Scale, ...]:
        """Those of a law's own numbers and, where there is one, of the square wave."""
        return (self.ours if law == PROPOSED else self.rest, *((self.rest,) if scenario == "SS" else ()))

    def factors(self, law: str, scenario: str) -> tuple[Factor, ...]:
        """What a law and a scenario leave open, spread on these scales."""
        own, *square = self.scales(law, scenario)
        return tuple(on_scale(factor, square[0] if factor in SQUARE else own) for factor in factors_of(law, scenario))

    def horizons(self, u: Array) -> Integers:
        """Whole seconds for numbers (N,) from 0 to 1."""
        spread = RANGES[self.rest](SHORTEST, LONGEST + 1)
        return np.minimum(spread.quantile(u).astype(int), LONGEST)


RANGES = {"linear": Uniform, "log": LogUniform}
# Logarithmic is what the card knows by its order of magnitude only: Q, R and l of the proposed law.
OF_CARD = Prior("log", "linear")
PRIORS: Mapping[str, Prior] = {
    "of the card": OF_CARD,
    "all linear": Prior("linear", "linear"),
    "all logarithmic": Prior("log", "log"),
    "exchanged": Prior("linear", "log"),
}


def on_scale(factor: Factor, scale: Scale) -> Factor:
    """The factor drawn evenly on a scale; a reading has none, and a range from 0 on no logarithmic one."""
    spread = factor.distribution
    if isinstance(spread, Reading) or spread.low <= 0:
        return factor
    return replace(factor, distribution=RANGES[scale](spread.low, spread.high))


def slug(*words: str) -> str:
    """A name for files."""
    return "_".join(word.lower().replace("-", "_") for word in words)


def named(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> str:
    """The name of the runs of a law in a scenario: several priors share them."""
    return slug(kind, law, scenario, *prior.scales(law, scenario))


def draws(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> Sweep:
    """A law in a scenario, over all that they leave open: the same points of the unit cube for every prior."""
    factors = prior.factors(law, scenario)
    design = Part(KINDS[kind], tuple(NAMES.index(factor.name) for factor in factors))
    halved = 32 if kind == "random" else None
    run = Run(searched(law, scenario), (RMSE,), LONGEST, every=1.0, h=STEPS[law])
    name = named(kind, law, scenario, prior)
    return Sweep(name, run, factors, design, halved=halved)


def asides() -> tuple[Sweep, ...]:
    """Two readings that are left out of all others, in the first scenario: the minus of (33), and PID beside (10)."""
    loops = {"minus": (PROPOSED, minus("FS")), "observed_pid": (PID, observed_pid("FS"))}
    return tuple(
        Sweep(name, run, FACTORS[law], ASIDE[law], halved=None)
        for name, (law, loop) in loops.items()
        for run in (Run(loop, (RMSE,), LONGEST, every=1.0, h=STEPS[law]),)
    )


def at_draws(results: Results, kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> Sample:
    """The runs of a law in a scenario, one a point of the whole design."""
    sample = results.sample(named(kind, law, scenario, prior))
    assert isinstance(sample.design, Part)
    places, none = sample.design.places, np.empty(0, dtype=int)
    held = {name: getattr(sample, name)[places] for name in ("drawn", "values", "diverged_at")}
    return replace(sample, **held, again=none, errors=sample.errors[:0], design=None)


@dataclass(frozen=True, eq=False)
class Drawn:
    """RMSE (N, 2) by law, in rad, over the same N draws of a scenario; NaN for a run that diverged."""

    rmse: Mapping[str, Array]

    @property
    def margin(self) -> Array:
        """The RMSE of the proposed law as a share of its sum with that of the best rival, (N, 2).

        Below 1/2 the proposed law is first; 1 where it diverged.
        """
        filled = {law: np.where(np.isnan(values), np.inf, values) for law, values in self.rmse.items()}
        ours = filled.pop(PROPOSED)
        best = np.min(list(filled.values()), axis=0)
        return np.asarray(np.where(np.isinf(ours), 1.0, 1 / (1 + best / ours)))

    def ordered(self, joint: int, laws: tuple[str, ...]) -> Array:
        """Whether the laws come in this order, the smallest RMSE first, (N,); none that diverged does."""
        values = np.stack([self.rmse[law][:, joint - 1] for law in laws], axis=1)
        return np.asarray((np.diff(values, axis=1) > 0).all(axis=1))


def drawn(results: Results, kind: str, scenario: str, prior: Prior = OF_CARD) -> Drawn:
    """The draws of a scenario, each at its own horizon."""
    whole = KINDS[kind]
    u = whole.points()[:, NAMES.index(HORIZONS[scenario])]
    rmse = {}
    for law in LAWS:
        sample = at_draws(results, kind, law, scenario, prior)
        rows = np.round(sample.t).astype(int).searchsorted(prior.horizons(u))
        rmse[law] = sample.values[np.arange(len(sample)), rows]
    return Drawn(rmse)
