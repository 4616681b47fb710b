"""One experiment for all laws: one horizon in the first scenario, one square wave and one horizon in the second.

The square wave was found by hand outside of this study: 32 square waves, each with gains for every law, evolved for 194
generations (seed 0) to a1 = 0.8162 rad, a2 = 0.3741 rad, f = 0.7278 Hz. Then the amplitudes were moved by hand, by half
a percent.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.blocks import EitherObserver, EitherReference
from studies.a6_unstated_choices.fits import (
    EVALUATIONS,
    EVERY,
    FINE,
    FINE_TIMES,
    POPULATION,
    SEED,
    checked_misses,
    horizons,
    misses,
    until,
)
from studies.a6_unstated_choices.loops import (
    MEASUREMENT_READING,
    PID,
    PROPOSED_LAW,
    RMSE,
    SQUARE,
    STEPS,
    factors_of,
    in_words,
    loop,
    slug,
    with_relay,
)
from studies.paper.card import LAWS

COMMON = (18, 22, 26)  # s, the horizons at which the rows of the first scenario are sought
OF_COMMON, COMMON_POPULATION = 864, 24  # choices of each search; 288 find four rows of six
COMMON_AGAIN = 3  # points of a law that are run again at the fine step

BY_HAND = 0.8162, 0.3741  # rad: the amplitudes of the search by hand
AMPLITUDES, FREQUENCY = (0.82, 0.373), 0.7278  # rad, Hz
HORIZON, UNTIL = 9.0, 10.0  # s: of the search by hand, and of the runs
SHARED_AGAIN = 8  # points of a search that are run again at the fine step
OUR_STEP = 1e-3 / 4  # s: at the gains of this experiment a step of 1 ms errs by more than 1 %


@dataclass(frozen=True)
class OneRow:
    """The miss of the row of a law in a scenario at one horizon, in s."""

    law: str
    scenario: str
    horizon: float

    def __call__(self, samples: Mapping[str, wb.study.Sample]) -> wb.Array:
        sample = samples[self.scenario.lower()]
        at = int(np.argmin(np.abs(sample.t - self.horizon)))
        return misses(self.law, self.scenario, sample.values[:, at])


def common_search(law: str, horizon: int) -> wb.tuning.Tuning:
    """The search for the row of a law in the first scenario at one horizon in s."""
    run = wb.Run(with_relay(law, loop(law, "FS")), (RMSE,), horizon, EVERY["FS"], STEPS[law])
    name, sought = slug("common", law, str(horizon)), factors_of(law, "FS")
    return wb.tuning.Tuning(
        name, (wb.tuning.Trial("fs", run),), sought, OneRow(law, "FS", horizon), OF_COMMON, COMMON_POPULATION, (SEED,)
    )


def common_horizon(tuning_results: Mapping[str, wb.tuning.TuningResult]) -> tuple[int, float]:
    """The searches, and a horizon in s within them, at which the farthest of the six laws is nearest to its row."""
    best: list[tuple[float, int, float]] = []
    for searched in COMMON:
        samples = [tuning_results[slug("common", law, str(searched))].samples["fs"] for law in LAWS]
        t = horizons(samples[0])[0]
        near = [misses(law, "FS", horizons(one)[1]).min(axis=0) for law, one in zip(LAWS, samples, strict=True)]
        worst = np.max(near, axis=0)
        at = int(np.argmin(worst))
        best.append((float(worst[at]), searched, float(t[at])))
    _, searched, horizon = min(best)
    return searched, horizon


def common_points(
    law: str, tuning_results: Mapping[str, wb.tuning.TuningResult]
) -> tuple[wb.tuning.TuningResult, wb.core.Integers, float]:
    """The nearest points of a law at the one horizon, the search that has them, and the horizon in s."""
    searched, horizon = common_horizon(tuning_results)
    one = tuning_results[slug("common", law, str(searched))]
    t, rmse = horizons(one.samples["fs"])
    size = misses(law, "FS", rmse[:, int(np.argmin(np.abs(t - horizon)))])
    return one, np.argsort(size, kind="stable")[:COMMON_AGAIN], horizon


def common_check(law: str, tuning_results: Mapping[str, wb.tuning.TuningResult]) -> wb.Sweep:
    """The nearest points of a law at the one horizon again, with the boundary layer of the paper, at a fine step."""
    one, places, horizon = common_points(law, tuning_results)
    run = wb.Run(loop(law, "FS"), (RMSE,), until(horizon), FINE_TIMES, FINE)
    return wb.Sweep(
        slug("common_check", law),
        run,
        factors_of(law, "FS"),
        wb.uncertainty.ListedPoints(one.points[places]),
        half_step_every=1,
    )


def own(law: str) -> tuple[wb.Factor, ...]:
    """The open numbers of a law beside the one experiment, in which the rivals that switch read observer (10)."""
    return tuple(factor for factor in factors_of(law, "SS") if factor not in (*SQUARE, MEASUREMENT_READING))


def shared_loop(law: str) -> wb.ClosedLoop:
    one = loop(law, "SS")
    reference, observer = one.reference, one.observer
    if not (isinstance(reference, EitherReference) and isinstance(observer, EitherObserver)):
        raise TypeError("A loop of a6 must hold both references and both observers.")
    square = replace(reference.square, amplitude=np.array(AMPLITUDES), frequency=FREQUENCY)
    inside = 1.0 if MEASUREMENT_READING in factors_of(law, "SS") and law != PID else observer.inside
    return replace(one, reference=replace(reference, square=square), observer=replace(observer, inside=inside))


def shared_search(law: str) -> wb.tuning.Tuning:
    """The search for the numbers and readings of a law in the one experiment."""
    h = OUR_STEP if law == PROPOSED_LAW else STEPS[law]
    trial = wb.tuning.Trial("ss", wb.Run(with_relay(law, shared_loop(law)), (RMSE,), UNTIL, EVERY["SS"], h))
    objective = OneRow(law, "SS", HORIZON)
    return wb.tuning.Tuning(slug("shared", law), (trial,), own(law), objective, EVALUATIONS, POPULATION // 2, (SEED,))


def shared_check(law: str, tuning_result: wb.tuning.TuningResult) -> wb.Sweep:
    """The nearest points again, with the boundary layer of the paper, at a fine step and at half of it."""
    design = wb.uncertainty.ListedPoints(
        tuning_result.points[np.argsort(tuning_result.objectives, kind="stable")[:SHARED_AGAIN]]
    )
    run = wb.Run(shared_loop(law), (RMSE,), UNTIL, FINE_TIMES, FINE)
    return wb.Sweep(slug("shared_check", law), run, own(law), design, half_step_every=1)


@dataclass(frozen=True, eq=False)
class Experiment:
    """One experiment at the fine step: the horizon in s, by law the larger miss of its cells, and its numbers."""

    horizon: float
    miss: Mapping[str, float]
    numbers: Mapping[str, str]


def shared_experiment(results: wb.Results) -> Experiment:
    """The nearest to the rows of all six laws in the second scenario at once, the error by the step added."""
    factors = {law: own(law) for law in LAWS}
    return _experiment("SS", {law: results.sample(slug("shared_check", law)) for law in LAWS}, factors)


def common_experiment(results: wb.Results) -> Experiment:
    """The nearest to the rows of all six laws in the first scenario at once, the error by the step added."""
    factors = {law: factors_of(law, "FS") for law in LAWS}
    return _experiment("FS", {law: results.sample(slug("common_check", law)) for law in LAWS}, factors)


def _experiment(
    scenario: str, samples: Mapping[str, wb.study.Sample], factors: Mapping[str, tuple[wb.Factor, ...]]
) -> Experiment:
    every = {law: checked_misses(law, scenario, sample) for law, sample in samples.items()}
    at = int(np.argmin(np.max([size.min(axis=0) for size in every.values()], axis=0)))
    best = {law: int(np.argmin(size[:, at])) for law, size in every.items()}
    return Experiment(
        float(samples[PROPOSED_LAW].t[at]),
        {law: float(size[best[law], at]) for law, size in every.items()},
        {law: in_words(factors[law], sample.factor_values[best[law]]) for law, sample in samples.items()},
    )
