"""The distance of a law's runs from its printed cells at any horizon, and the runs that come nearest."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.draws import at_draws
from studies.a6_unstated_choices.loops import (
    LONGEST,
    PROPOSED_LAW,
    RMSE,
    SCENARIOS,
    SHORTEST,
    STEPS,
    factors_of,
    loop,
    slug,
    with_relay,
)
from studies.paper.card import CARD, PUBLISHED_COLUMNS

CLOSE = 0.01
AGAIN = 3  # points that are run again for a target, the nearest, and as many from all of the search
EVALUATIONS, POPULATION, SEED = 864, 48, 0
FINE = 1e-3 / 12  # s
FINE_TIMES = 0.1  # s
SEEDS = {PROPOSED_LAW: (0, 1)}  # it has the most readings
SEARCH_HORIZON = 30.0  # s, up to which the four cells of a law are sought; its first row alone up to `LONGEST`
SPARE = 1.0  # s, by which a run at the fine step is longer than the longest of its horizons
SAMPLE = float(CARD["sample time of (43)"])
EVERY = {"FS": 1.0, "SS": 0.5}  # s
# The joints of each scenario that are to be met together.
TARGETS: Mapping[str, Mapping[str, tuple[int, ...]]] = {
    **{f"{scenario} q{joint}": {scenario: (joint,)} for scenario in SCENARIOS for joint in (1, 2)},
    **{scenario: {scenario: (1, 2)} for scenario in SCENARIOS},
    "both": dict.fromkeys(SCENARIOS, (1, 2)),
}
CELLS = tuple(TARGETS)[:4]


def horizons(sample: wb.study.Sample) -> tuple[wb.Array, wb.Array]:
    """Horizons (H,) every `FINE_TIMES` from the shortest to the end of the runs, and RMSE (N, H, 2) there.

    Between the times of the sample the sum of squares is taken to grow by straight lines.
    """
    t = np.arange(round(SHORTEST / FINE_TIMES), round(float(sample.t[-1]) / FINE_TIMES) + 1) * FINE_TIMES
    right = np.clip(np.searchsorted(sample.t, t - 1e-9), 1, len(sample.t) - 1)
    share = ((t - sample.t[right - 1]) / (sample.t[right] - sample.t[right - 1]))[:, np.newaxis]
    sums = sample.values**2 * (sample.t + SAMPLE)[:, np.newaxis]
    between = sums[:, right - 1] * (1 - share) + sums[:, right] * share
    return np.asarray(t, dtype=float), np.asarray(np.sqrt(between / (t + SAMPLE)[:, np.newaxis]))


def misses(law: str, scenario: str, rmse: wb.Array, joints: Sequence[int] = (1, 2)) -> wb.Array:
    """The largest part by which RMSE (..., 2) is off the printed cells of some joints; infinite for a run that
    diverged.
    """
    printed = np.array([PUBLISHED_COLUMNS[scenario, joint].values[law] for joint in (1, 2)])
    size = np.abs(rmse / printed - 1)[..., [joint - 1 for joint in joints]].max(axis=-1)
    return np.where(np.isnan(size), np.inf, size)


def nearest(law: str, target: str, samples: Mapping[str, wb.study.Sample]) -> wb.Array:
    """The miss (N,) of the cells of a target, each scenario at its best horizon, from its runs by scenario."""
    parts = [
        misses(law, scenario, horizons(samples[scenario])[1], joints).min(axis=1)
        for scenario, joints in TARGETS[target].items()
    ]
    return np.asarray(np.max(parts, axis=0))


def best_horizons(law: str, target: str, scenario: str, sample: wb.study.Sample) -> wb.Array:
    """The horizon (N,) in s at which each run comes nearest to the cells of a target in a scenario."""
    t, rmse = horizons(sample)
    return np.asarray(t[misses(law, scenario, rmse, TARGETS[target][scenario]).argmin(axis=1)])


def until(longest: float) -> float:
    """The end in s of runs at the fine step whose longest horizon is `longest`."""
    return min(float(np.ceil(longest)) + SPARE, LONGEST)


def checked_misses(law: str, scenario: str, sample: wb.study.Sample, joints: Sequence[int] = (1, 2)) -> wb.Array:
    """The misses (N, T) of runs that were all looked at, their errors by the step added; infinite before the
    shortest horizon.
    """
    sizes = [misses(law, scenario, sample.values + side * sample.measurement.errors, joints) for side in (-1, 0, 1)]
    return np.where(sample.t < SHORTEST - 1e-9, np.inf, np.max(sizes, axis=0))


@dataclass(frozen=True)
class BothRows:
    """The misses of both rows of a law together: each is made small even where the other cannot be."""

    law: str

    def __call__(self, samples: Mapping[str, wb.study.Sample]) -> wb.Array:
        return np.asarray(sum(nearest(self.law, scenario, by_scenario(samples)) for scenario in SCENARIOS))


def by_scenario(samples: Mapping[str, wb.study.Sample]) -> dict[str, wb.study.Sample]:
    return {scenario: samples[scenario.lower()] for scenario in SCENARIOS}


def trial(law: str, scenario: str) -> wb.tuning.Trial:
    run = wb.Run(with_relay(law, loop(law, scenario)), (RMSE,), SEARCH_HORIZON, EVERY[scenario], STEPS[law])
    return wb.tuning.Trial(scenario.lower(), run)


def search(law: str) -> wb.tuning.Tuning:
    """The search for the numbers and readings of a law: one set of gains for both scenarios."""
    trials = tuple(trial(law, scenario) for scenario in SCENARIOS)
    seeds = SEEDS.get(law, (SEED,))
    return wb.tuning.Tuning(
        slug("search", law), trials, factors_of(law, "SS"), BothRows(law), EVALUATIONS, POPULATION, seeds
    )


def points_to_check(law: str, tuning_result: wb.tuning.TuningResult, scenario: str) -> tuple[wb.core.Integers, float]:
    """The points of a search that are run again in a scenario, each once, and the longest of their horizons in s.

    Of each target these are the nearest, and some from the whole course of the search that are near: the nearest are
    much alike, and their gains may all be too large for the fine step.
    """
    places: list[int] = []
    longest = 0.0
    for target in (target for target, rows in TARGETS.items() if scenario in rows):
        sizes = nearest(law, target, by_scenario(tuning_result.samples))
        order = np.argsort(sizes, kind="stable")
        near = np.sort(order[: max(AGAIN, np.count_nonzero(sizes <= CLOSE / 2))])
        again = [*order[:AGAIN], *near[np.linspace(0, len(near) - 1, AGAIN).astype(int)]]
        found = best_horizons(law, target, scenario, tuning_result.samples[scenario.lower()].only(np.unique(again)))
        longest = max(longest, float(found.max()))
        places += again
    return np.unique(places), longest


def check(law: str, tuning_result: wb.tuning.TuningResult, scenario: str) -> wb.Sweep:
    """The nearest points again, with the boundary layer of the paper, at a fine step and at half of it."""
    places, longest = points_to_check(law, tuning_result, scenario)
    design = wb.uncertainty.ListedPoints(tuning_result.points[places])
    run = wb.Run(loop(law, scenario), (RMSE,), until(longest), FINE_TIMES, FINE)
    return wb.Sweep(slug("check", law, scenario), run, factors_of(law, "SS"), design, half_step_every=1)


@dataclass(frozen=True, eq=False)
class Fit:
    """The nearest to a target, by runs at a fine step."""

    numbers: wb.Array  # the value of each factor, in the order of `factors_of`
    horizon: Mapping[str, float]  # by scenario, in s
    values: Mapping[str, wb.Array]  # by scenario: RMSE (2,) in rad
    errors: Mapping[str, wb.Array]  # its error by the step
    miss: float  # the largest of the cells, with the error added
    of_draws: int  # how many of the independent draws come within 1 % at their steps
    of_search: int  # and of the points of the search


def fits_of(results: wb.Results, law: str) -> dict[str, Fit]:
    """The nearest to each target of a law."""
    tuned = results.tuning(slug("search", law))
    again = {scenario: points_to_check(law, tuned, scenario)[0] for scenario in SCENARIOS}
    return {target: fit(results, law, target, tuned, again) for target in TARGETS}


def fit(
    results: wb.Results,
    law: str,
    target: str,
    tuning_result: wb.tuning.TuningResult,
    again: Mapping[str, wb.core.Integers],
) -> Fit:
    """The best of the points that were run `again` in the scenarios of a target, each scenario at its best horizon."""
    random = {scenario: at_draws(results, "random", law, scenario) for scenario in SCENARIOS}
    places = reduce(np.intersect1d, (again[scenario] for scenario in TARGETS[target]))
    samples, sizes = {}, {}
    for scenario, joints in TARGETS[target].items():
        rows = np.isin(again[scenario], places).nonzero()[0]
        samples[scenario] = results.sample(slug("check", law, scenario)).only(rows)
        sizes[scenario] = checked_misses(law, scenario, samples[scenario], joints)
    worst = np.max([size.min(axis=1) for size in sizes.values()], axis=0)
    one = int(np.argmin(worst))
    at = {scenario: int(np.argmin(size[one])) for scenario, size in sizes.items()}
    return Fit(
        tuning_result.numbers[places[one]],
        {scenario: float(samples[scenario].t[i]) for scenario, i in at.items()},
        {scenario: samples[scenario].values[one, i] for scenario, i in at.items()},
        {scenario: samples[scenario].measurement.errors[one, i] for scenario, i in at.items()},
        float(worst[one]),
        *(int((nearest(law, target, runs) <= CLOSE).sum()) for runs in (random, by_scenario(tuning_result.samples))),
    )
