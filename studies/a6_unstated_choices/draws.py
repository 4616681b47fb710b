"""Draws of all that the paper leaves open, at once for all laws: each law is run where its own numbers change."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from studies.a6_unstated_choices.loops import PROPOSED, SCENARIOS, SQUARE, STEPS, Reading, factors_of, loop, relayed
from studies.paper.card import CARD, LAWS
from workbench.metrics import sampled_rmse
from workbench.study.contract import Run
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.sweep import Sweep
from workbench.study.uncertainty import Listed, MonteCarlo, SobolDesign
from workbench.study.uncertainty.distributions import LogUniform, Uniform
from workbench.study.uncertainty.factors import Factor
from workbench.validation.refusals import Array, Integers

Scale: TypeAlias = Literal["linear", "log"]
RMSE = sampled_rmse(CARD["sample time of (43)"])
SHORTEST, LONGEST = 5, 30  # s, the horizons of the card
HORIZONS = {scenario: f"horizon of {scenario}" for scenario in SCENARIOS}
OPEN = dict.fromkeys(factor.name for law in LAWS for factor in factors_of(law, "SS"))
NAMES = (*OPEN, *HORIZONS.values())
RANDOM = MonteCarlo(len(NAMES), 512, seed=6)
PAIRED = SobolDesign(len(NAMES), 128, seed=6)
DESIGNS: Mapping[str, MonteCarlo | SobolDesign] = {"random": RANDOM, "paired": PAIRED}
RANGES = {"linear": Uniform, "log": LogUniform}


@dataclass(frozen=True)
class Prior:
    """On which scale each number is drawn evenly: those of the proposed law, and all others with the experiment's."""

    ours: Scale
    rest: Scale

    def scales(self, law: str, scenario: str) -> tuple[Scale, ...]:
        """Those of a law's own numbers and, where there is one, of the square wave."""
        return (self.ours if law == PROPOSED else self.rest, *((self.rest,) if scenario == "SS" else ()))

    def factors(self, law: str, scenario: str) -> tuple[Factor, ...]:
        """The open numbers of a law and a scenario, spread on these scales."""
        own, *square = self.scales(law, scenario)
        return tuple(on_scale(factor, square[0] if factor in SQUARE else own) for factor in factors_of(law, scenario))

    def horizons(self, u: Array) -> Integers:
        """Whole seconds for numbers (N,) from 0 to 1."""
        spread = RANGES[self.rest](SHORTEST, LONGEST + 1)
        return np.minimum(spread.quantile(u).astype(int), LONGEST)


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


def part(kind: str, factors: Sequence[Factor]) -> tuple[Listed, Integers]:
    """The points of a design of all that is open that differ in some factors, and which of them stands at each (N,)."""
    columns = [NAMES.index(factor.name) for factor in factors]
    points, places = np.unique(DESIGNS[kind].points()[:, columns], axis=0, return_inverse=True)
    return Listed(points), places.ravel()


def draws(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> Sweep:
    """A law in a scenario, over all that they leave open: the same points of the unit cube for every prior."""
    factors = prior.factors(law, scenario)
    run = Run(relayed(law, loop(law, scenario)), (RMSE,), LONGEST, every=1.0, h=STEPS[law])
    halved = 32 if kind == "random" else None
    return Sweep(named(kind, law, scenario, prior), run, factors, part(kind, factors)[0], halved=halved)


def at_draws(results: Results, kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> Sample:
    """The runs of a law in a scenario, one a point of the whole design."""
    sample, (_, places) = results.sample(named(kind, law, scenario, prior)), part(kind, factors_of(law, scenario))
    held = {name: getattr(sample, name)[places] for name in ("drawn", "values", "diverged_at")}
    return replace(sample, **held, again=np.empty(0, dtype=int), errors=sample.errors[:0], design=None)


def drawn(results: Results, kind: str, scenario: str, prior: Prior = OF_CARD) -> dict[str, Array]:
    """RMSE (N, 2) by law, in rad, over the same N draws of a scenario, each at its own horizon; NaN where a run
    diverged before it.
    """
    u = DESIGNS[kind].points()[:, NAMES.index(HORIZONS[scenario])]
    rmse = {}
    for law in LAWS:
        sample = at_draws(results, kind, law, scenario, prior)
        rows = np.round(sample.t).astype(int).searchsorted(prior.horizons(u))
        rmse[law] = sample.values[np.arange(len(sample)), rows]
    return rmse


def margin(rmse: Mapping[str, Array]) -> Array:
    """The RMSE of the proposed law as a share of its sum with that of the best rival, (N, 2).

    Below 1/2 the proposed law is first; 1 where it diverged.
    """
    ours, *rivals = (np.where(np.isnan(rmse[law]), np.inf, rmse[law]) for law in LAWS)
    return np.where(np.isinf(ours), 1.0, 1 / (1 + np.min(rivals, axis=0) / ours))
