"""The sweeps of a7: screenings, indices, bands and a tornado, over the factors of `studies.paper.factors`."""

from dataclasses import replace

import workbench as wb
from studies.paper import factors as card
from studies.paper.factors import SEED, TOLERANCE
from studies.paper.fitted_arm import fitted_factors, unless_fitted, with_fit, with_fit_in_case
from studies.paper.laws import RIVALS, proposed_repaired, rival
from studies.paper.rest import rest_case

PROPOSED_LAW = "AOSMC-RGS"
LAWS = (PROPOSED_LAW, *RIVALS)
SCENARIO = "FS"
UNTIL, EVERY, LATE, SAMPLE = 5.0, 0.25, 3.0, 1e-3  # s: horizon, windows, when the start is over, grid of the TV
SECOND = 1.0  # s: the windows of the proposed law's indices
CURVE_INTERVAL = 0.01  # s, between two points of a curve
OF_LATE = f"The late error is the largest |e| from {LATE:g} to {UNTIL:g} s."
METRICS = (
    wb.rmse(),
    wb.metrics.late_error(LATE),
    wb.total_variation(SAMPLE),
    wb.total_variation(SAMPLE, after=LATE),
    wb.effort(),
)
OBSERVER = wb.metrics.observer_error("q_error")

# Steps in s, so short that the largest gains that grow within the ranges stay within the limit of stability.
STEPS = {
    PROPOSED_LAW: 1e-3 / 16,
    "PID": 1e-3,
    "SMC": 1e-3 / 2,
    "ASMC": 1e-3 / 20,
    "Fuzzy-ASMC": 1e-3 / 20,
    "RBF-ASMC": 1e-3 / 16,
    "super-twisting": 1e-3,
}
TRAJECTORIES = {"ASMC": 24, "Fuzzy-ASMC": 24, "RBF-ASMC": 24}  # and 50 elsewhere
# Of the Sobol design, and 1024 elsewhere: what brings the intervals that decide a sentence below `NARROW`.
BASE = {PROPOSED_LAW: 512, "ASMC": 256, "Fuzzy-ASMC": 256, "RBF-ASMC": 256}
EQUAL = 256  # and of that in which all numbers of the proposed law have the same range
NARROW = 0.1  # of a variance, the whole width of an interval: a sentence that rests on a wider one stays open
RANDOM = 256
HALF_STEP_EVERY = 32  # one run in so many is run again at half of the step
# What the screening finds of little weight, and the Sobol indices so leave at its value: see `SCREENING_SHARE`.
SCREENING_SHARE = 0.2  # of the largest mu* of an output
HELD_FACTORS = {
    PROPOSED_LAW: ("phi", "K(0)", "P(0)", "l", "D"),
    "PID": ("D",),
    "SMC": ("phi", "D"),
    "ASMC": ("D",),
    "Fuzzy-ASMC": ("K(0)", "width of |s|", "width of the trend", "D"),
    "RBF-ASMC": ("Gamma", "sigma", "centres", "D"),
    "super-twisting": (),
}


def fitted_loop(law: str) -> wb.ClosedLoop:
    """The loop of a law with the arm and the models of the fit."""
    return with_fit(proposed_repaired(SCENARIO) if law == PROPOSED_LAW else rival(SCENARIO, law))


@unless_fitted(fitted_loop)
def loop(law: str) -> wb.ClosedLoop:
    return proposed_repaired(SCENARIO) if law == PROPOSED_LAW else rival(SCENARIO, law)


def factors_of_fit(law: str) -> tuple[wb.Factor, ...]:
    """The factors of a law with the directions of the fit in place of its numbers' ranges."""
    return fitted_factors(card.factors(law), loop(law))


factors = unless_fitted(factors_of_fit)(card.factors)


def metrics(law: str) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The metrics of a law, with the error of its observer where it has one."""
    return (*METRICS, OBSERVER) if law == PROPOSED_LAW else METRICS


def own_numbers() -> tuple[wb.Case, ...]:
    """Each law with the numbers of the card, for the page to turn, and the proposed one at rest."""
    tracking = (
        wb.Case(SCENARIO, law, wb.Run(loop(law), metrics(law), UNTIL, CURVE_INTERVAL, STEPS[law] / 2), style=i)
        for i, law in enumerate(LAWS)
    )
    return (*tracking, with_fit_in_case(rest_case(STEPS[PROPOSED_LAW] / 2)))


def free(law: str) -> tuple[wb.Factor, ...]:
    return tuple(factor for factor in factors(law) if factor.name not in HELD_FACTORS[law])


def equal_ranges(law: str) -> tuple[wb.Factor, ...]:
    """The factors of the Sobol indices, the assumed ones within the range of the stated ones."""
    return tuple(
        factor if factor.direction else replace(factor, distribution=wb.Uniform(1 - TOLERANCE, 1 + TOLERANCE))
        for factor in free(law)
    )


def sweep_name(law: str, kind: str) -> str:
    return f"{law.lower().replace('-', '_')}_{kind}"


def sweeps(law: str) -> dict[str, wb.Sweep]:
    """The sweeps of a law by their kind, the bands over time; the proposed one has a tornado and equal ranges, too."""
    every, some, ours = factors(law), free(law), law == PROPOSED_LAW
    of: dict[str, tuple[tuple[wb.Factor, ...], wb.uncertainty.AbstractDesign]] = {
        "screening": (every, wb.uncertainty.MorrisDesign(len(every), TRAJECTORIES.get(law, 50), seed=SEED)),
        "indices": (some, wb.SobolDesign(len(some), BASE.get(law, 1024), ours, seed=SEED)),
        "bands": (every, wb.uncertainty.MonteCarlo(len(every), RANDOM, SEED)),
    }
    if ours:
        of["tornado"] = (every, wb.uncertainty.OneAtATime(len(every), levels=(0.0, 1.0)))
        of["equal"] = (equal_ranges(law), wb.SobolDesign(len(some), EQUAL, seed=SEED))
    made = {}
    for kind, (moved, design) in of.items():
        measured, times = ((*metrics(law), wb.metrics.ise()), EVERY) if kind == "bands" else (metrics(law), None)
        if ours and kind == "indices":
            times = SECOND
        run = wb.Run(loop(law), measured, UNTIL, times, STEPS[law], seed=SEED)
        least = (
            wb.uncertainty.least_base(len(some), ours and kind == "indices")
            if isinstance(design, wb.SobolDesign)
            else None
        )
        made[kind] = wb.Sweep(
            sweep_name(law, kind), run, moved, design, half_step_every=HALF_STEP_EVERY, least_samples=least
        )
    return made
