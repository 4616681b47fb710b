"""Searches for the printed row of AOSMC-RGS in the first scenario, one for each sign and shape of (33)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.a6_unstated_choices.fits import (
    CLOSE,
    EVERY,
    FINE,
    FINE_TIMES,
    Fit,
    best_horizons,
    checked_misses,
    nearest,
    until,
)
from studies.a6_unstated_choices.loops import (
    LONGEST,
    PROPOSED_LAW,
    RMSE,
    STEPS,
    Reading,
    factors_of,
    in_words,
    loop,
    slug,
)

PLUS, MINUS, TWO = "plus", "minus", "minus, two repairs"
PRINTED_READINGS = {  # the reading that the paper prints
    "sign of (33)": "minus",
    "velocity in (28)": "printed",
    "D_hat of (24)": "its integral",
    "observer (10)": "in",
    "C of (3)": "printed",
}
# The readings that a search does not vary. Two repairs are those of (3) and (28).
FIXED_READINGS: Mapping[str, Mapping[str, str]] = {
    PLUS: {"sign of (33)": "plus"},
    MINUS: {"sign of (33)": "minus"},
    TWO: PRINTED_READINGS | {"velocity in (28)": "reference", "C of (3)": "right"},
}
EVALUATIONS = {PLUS: 336, MINUS: 336, TWO: 192}
POPULATION, SEED = 24, 0
AGAIN = 2  # points of a search that are run again, the nearest
CASES = tuple((sign, shape) for sign in FIXED_READINGS for shape in wb.arms.laws.SHAPES)


@dataclass(frozen=True)
class AnyHorizon:
    """The larger miss of the two cells of the row, at the best horizon of each run."""

    def __call__(self, samples: Mapping[str, wb.study.Sample]) -> wb.Array:
        return nearest(PROPOSED_LAW, "FS", {"FS": samples["fs"]})


def factors(sign: str, shape: str) -> tuple[wb.Factor, ...]:
    """The open numbers of the law, with the readings of a search as constants."""
    fixed = {**FIXED_READINGS[sign], "shape of (33)": shape}

    def narrow(factor: wb.Factor) -> wb.Factor:
        spread = factor.distribution
        if not isinstance(spread, Reading) or factor.name not in fixed:
            return factor
        return replace(factor, distribution=replace(spread, only=fixed[factor.name]))

    return tuple(map(narrow, factors_of(PROPOSED_LAW, "FS")))


def search_name(sign: str, shape: str) -> str:
    return slug("row", *sign.replace(",", "").split(), shape)


def search(sign: str, shape: str) -> wb.tuning.Tuning:
    """The search for the numbers, and for the readings that are left."""
    trial = wb.tuning.Trial("fs", wb.Run(loop(PROPOSED_LAW, "FS"), (RMSE,), LONGEST, EVERY["FS"], STEPS[PROPOSED_LAW]))
    sought = factors(sign, shape)
    return wb.tuning.Tuning(
        search_name(sign, shape), (trial,), sought, AnyHorizon(), EVALUATIONS[sign], POPULATION, (SEED,)
    )


def points_to_check(tuning_result: wb.tuning.TuningResult) -> wb.core.Integers:
    """The points of a search that are run again."""
    return np.argsort(nearest(PROPOSED_LAW, "FS", {"FS": tuning_result.samples["fs"]}), kind="stable")[:AGAIN]


def place_of(factor: wb.Factor, point: float, number: float) -> float:
    """The coordinate of a number in the unit cube in which every reading is free."""
    spread = factor.distribution
    return (number + 0.5) / len(spread.names) if isinstance(spread, Reading) else point


def check(tuning_results: Mapping[str, wb.tuning.TuningResult]) -> wb.Sweep:
    """The nearest points of all searches again, at a fine step and at half of it."""
    open_numbers, points, longest = factors_of(PROPOSED_LAW, "FS"), [], 0.0
    for case in CASES:
        one = tuning_results[search_name(*case)]
        rows = points_to_check(one)
        found = best_horizons(PROPOSED_LAW, "FS", "FS", one.samples["fs"].only(np.sort(rows)))
        longest = max(longest, float(found.max()))
        for row in rows:
            each = zip(open_numbers, one.points[row], one.numbers[row], strict=True)
            points.append([place_of(*part) for part in each])
    run = wb.Run(loop(PROPOSED_LAW, "FS"), (RMSE,), until(longest), FINE_TIMES, FINE)
    return wb.Sweep("check_rows", run, open_numbers, wb.uncertainty.ListedPoints(np.array(points)), half_step_every=1)


@dataclass(frozen=True, eq=False)
class Row:
    """The nearest of one search to the printed row, by runs at the fine step."""

    sign: str
    shape: str
    fit: Fit

    @property
    def is_met(self) -> bool:
        return self.fit.miss <= CLOSE

    @property
    def readings(self) -> dict[str, str]:
        """The reading of each equation, by its name."""
        every = zip(factors_of(PROPOSED_LAW, "FS"), self.fit.numbers, strict=True)
        return {
            factor.name: factor.distribution.names[round(float(number))]
            for factor, number in every
            if isinstance(factor.distribution, Reading)
        }

    @property
    def repairs(self) -> tuple[str, ...]:
        """The names of the readings in which it differs from the print."""
        readings = self.readings
        return tuple(name for name, printed in PRINTED_READINGS.items() if readings[name] != printed)

    @property
    def words(self) -> str:
        return in_words(factors_of(PROPOSED_LAW, "FS"), self.fit.numbers)


def rows_of(results: wb.Results) -> tuple[Row, ...]:
    """The nearest of each search, in the order of `CASES`."""
    sample = results.sample("check_rows")
    sizes = checked_misses(PROPOSED_LAW, "FS", sample)
    rows = []
    for i, case in enumerate(CASES):
        own = slice(AGAIN * i, AGAIN * (i + 1))
        one = AGAIN * i + int(sizes[own].min(axis=1).argmin())
        at = int(sizes[one].argmin())
        tuned = results.tuning(search_name(*case))
        near = nearest(PROPOSED_LAW, "FS", {"FS": tuned.samples["fs"]})
        values, errors = sample.values[one, at], sample.measurement.errors[one, at]
        fit = Fit(
            sample.factor_values[one],
            {"FS": float(sample.t[at])},
            {"FS": values},
            {"FS": errors},
            float(sizes[one, at]),
            0,
            int((near <= CLOSE).sum()),
        )
        rows.append(Row(*case, fit))
    return tuple(rows)
