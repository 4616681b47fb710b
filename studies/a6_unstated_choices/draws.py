"""Draws of everything that the paper leaves open, under four priors, without and with a limit of the torques."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal, TypeAlias

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.loops import (
    HORIZONS,
    LONGEST,
    NAMES,
    PID,
    PROPOSED_LAW,
    RMSE,
    SHORTEST,
    SQUARE,
    STEPS,
    Reading,
    factors_of,
    loop,
    slug,
    with_relay,
)
from studies.paper.card import LAWS

Scale: TypeAlias = Literal["linear", "log"]
LIMIT = 100.0, 50.0  # N m, of either joint
RANDOM = wb.uncertainty.MonteCarlo(len(NAMES), 512, seed=6)
LIMITED_DESIGN = wb.uncertainty.MonteCarlo(len(NAMES), 256, seed=6)  # the first draws of RANDOM
PAIRED_DESIGN = wb.SobolDesign(len(NAMES), 64, seed=6)
DESIGNS: Mapping[str, wb.uncertainty.MonteCarlo | wb.SobolDesign] = {
    "random": RANDOM,
    "limited": LIMITED_DESIGN,
    "paired": PAIRED_DESIGN,
}
HALF_STEP_EVERY = {PROPOSED_LAW: 4}  # one draw of so many is run at half of the step too
RIVALS_HALF_STEP_EVERY = 32
PEAK_HORIZON = 10.0  # s, in which the peak torque of PID is taken: its largest is at the start or at a jump
RANGES = {"linear": wb.Uniform, "log": wb.LogUniform}


@dataclass(frozen=True)
class Prior:
    """On which scale each number is drawn evenly: those of the proposed law, and all others with the experiment's."""

    ours: Scale
    rest: Scale

    def scales(self, law: str, scenario: str) -> tuple[Scale, ...]:
        """Those of a law's own numbers and, where there is one, of the square wave."""
        return (self.ours if law == PROPOSED_LAW else self.rest, *((self.rest,) if scenario == "SS" else ()))

    def factors(self, law: str, scenario: str) -> tuple[wb.Factor, ...]:
        """The open numbers of a law and a scenario, spread on these scales."""
        own, *square = self.scales(law, scenario)
        return tuple(on_scale(factor, square[0] if factor in SQUARE else own) for factor in factors_of(law, scenario))

    def horizons_of(self, kind: str, scenario: str) -> wb.core.Integers:
        """The horizon of each draw of a design in whole seconds, (N,)."""
        return self.horizons(DESIGNS[kind].points()[:, NAMES.index(HORIZONS[scenario])])

    def horizons(self, u: wb.Array) -> wb.core.Integers:
        """Whole seconds for numbers (N,) from 0 to 1."""
        spread = RANGES[self.rest](SHORTEST, LONGEST + 1)
        return np.asarray(np.minimum(spread.quantile(u).astype(int), LONGEST))


# Logarithmic is what the card knows by its order of magnitude only: Q, R and l of the proposed law.
OF_CARD = Prior("log", "linear")
PRIORS: Mapping[str, Prior] = {
    "of the card": OF_CARD,
    "all linear": Prior("linear", "linear"),
    "all logarithmic": Prior("log", "log"),
    "exchanged": Prior("linear", "log"),
}


def on_scale(factor: wb.Factor, scale: Scale) -> wb.Factor:
    """The factor drawn evenly on a scale; a reading has none, and a range from 0 on no logarithmic one."""
    spread = factor.distribution
    if isinstance(spread, Reading) or spread.low <= 0:
        return factor
    return replace(factor, distribution=RANGES[scale](spread.low, spread.high))


def sweep_name(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> str:
    """The name of the runs of a law in a scenario: several priors share them."""
    return slug(kind, law, scenario, *prior.scales(law, scenario))


def part(kind: str, factors: Sequence[wb.Factor]) -> tuple[wb.uncertainty.ListedPoints, wb.core.Integers]:
    """The points of a design of all that is open that differ in some factors, and which of them stands at each (N,)."""
    return _part(kind, tuple(NAMES.index(factor.name) for factor in factors))


@cache
def _part(kind: str, columns: tuple[int, ...]) -> tuple[wb.uncertainty.ListedPoints, wb.core.Integers]:
    points, places = np.unique(DESIGNS[kind].points()[:, list(columns)], axis=0, return_inverse=True)
    return wb.uncertainty.ListedPoints(points), places.ravel()


def draws(kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> wb.Sweep:
    """A law in a scenario, over all that they leave open: the same points of the unit cube for every prior."""
    factors = prior.factors(law, scenario)
    one = loop(law, scenario, LIMIT if kind == "limited" else None)
    run = wb.Run(with_relay(law, one), (RMSE,), LONGEST, every=1.0, h=STEPS[law])
    halved = HALF_STEP_EVERY.get(law, RIVALS_HALF_STEP_EVERY) if kind == "random" else None
    return wb.Sweep(
        sweep_name(kind, law, scenario, prior), run, factors, part(kind, factors)[0], half_step_every=halved
    )


def peaks(scenario: str) -> wb.Sweep:
    """PID in a scenario over the draws of the prior of the card, for its peak torque."""
    factors = OF_CARD.factors(PID, scenario)
    run = wb.Run(loop(PID, scenario), (wb.arms.peak_torque(),), PEAK_HORIZON, h=STEPS[PID])
    return wb.Sweep(slug("peaks", scenario), run, factors, part("random", factors)[0], half_step_every=None)


def at_draws(results: wb.Results, kind: str, law: str, scenario: str, prior: Prior = OF_CARD) -> wb.study.Sample:
    """The runs of a law in a scenario, one a point of the whole design."""
    sample, (_, places) = results.sample(sweep_name(kind, law, scenario, prior)), part(kind, factors_of(law, scenario))
    found = sample.measurement.only(np.empty(0, dtype=int))  # without errors
    values, lost = sample.values[places], sample.diverged_at[places]
    return replace(
        sample,
        factor_values=sample.factor_values[places],
        measurement=replace(found, values=values, diverged_at=lost),
        design=None,
    )


def rmse_by_law(results: wb.Results, kind: str, scenario: str, prior: Prior = OF_CARD) -> dict[str, wb.Array]:
    """RMSE (N, 2) by law, in rad, over the same N draws of a scenario, each at its own horizon; NaN where a run
    diverged before it.
    """
    times = prior.horizons_of(kind, scenario)
    rmse = {}
    for law in LAWS:
        sample = at_draws(results, kind, law, scenario, prior)
        rows = np.round(sample.t).astype(int).searchsorted(times)
        rmse[law] = sample.values[np.arange(len(sample)), rows]
    return rmse


def margin(rmse: Mapping[str, wb.Array]) -> wb.Array:
    """The RMSE of the proposed law as a share of its sum with that of the best rival, (N, 2).

    Below 1/2 the proposed law is first; 1 where it diverged.
    """
    ours, *rivals = (np.where(np.isnan(rmse[law]), np.inf, rmse[law]) for law in LAWS)
    return np.where(np.isinf(ours), 1.0, 1 / (1 + np.min(rivals, axis=0) / ours))
