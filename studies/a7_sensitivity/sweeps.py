"""The factors that a7 varies of each law: its gains, the arm that is simulated, and the arm that the law believes in.

One rule for all laws. A number that the paper states, or that follows from one, is off by up to 10 % either way. A
number that is assumed lies within a factor of 1.5 of its value, and within the range on the card where that is
narrower. All are shares of the loop's own numbers, so that all entries of a gain move together. The gains of PID move
one by one, although they follow from one assumed pole.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.laws import RIVALS, proposed_repaired, rival
from studies.paper.rest import rest_case

TOLERANCE = 0.1  # of what is stated or derived
SPAN = 1.5  # of what is assumed, either way
ARM = "plant.arm"
PARTS = {
    "m1": ("masses", "links[0].mass"),
    "m2": ("masses", "links[1].mass"),
    "l1": ("lengths", "links[0].length"),
    "l2": ("lengths", "links[1].length"),
}
MODEL = "model "  # before the name of a part of the arm: as the law believes it to be
OF_MODEL = ("controller.model",)
OF_BOTH_MODELS = ("controller.model", "observer.state.model")

GROUPS = ("gains", "arm", "model")
WORDS = ("Kp", "Ki", "Kd", "lag", "width of |s|", "width of the trend", "centres", "widths")  # no symbols
SURFACE = (("Lambda", "Lambda", ("controller.Lambda",)), ("phi", "phi", ("controller.phi",)))
LEARNING = (("K(0)", "ASMC: K(0)", ("controller.K",)), ("gamma", "ASMC: gamma", ("controller.gamma",)))
# Of each law: what it is called here, its name on the card, and what it moves.
GAINS: dict[str, Sequence[tuple[str, str, tuple[str, ...]]]] = {
    "AOSMC-RGS": (
        *SURFACE,
        ("K(0)", "K(0)", ("controller.K",)),
        ("P(0)", "P(0)", ("controller.P",)),
        ("Q", "Q", ("controller.Q",)),
        ("R", "R", ("controller.R",)),
        ("L1", "L1", ("observer.state.L1",)),
        ("L2", "L2", ("observer.state.L2",)),
        ("l", "l", ("observer.disturbance.l",)),
    ),
    "PID": (
        ("Kp", "PID: poles", ("controller.Kp",)),
        ("Ki", "PID: poles", ("controller.Ki",)),
        ("Kd", "PID: poles", ("controller.Kd",)),
    ),
    "SMC": (*SURFACE, ("K", "SMC: K", ("controller.K",))),
    "ASMC": (*SURFACE, *LEARNING),
    "Fuzzy-ASMC": (
        *SURFACE,
        *LEARNING,
        ("lag", "Fuzzy-ASMC: lag", ("controller.lag",)),
        ("width of |s|", "Fuzzy-ASMC: width of |s|", ("controller.rules.size_width",)),
        ("width of the trend", "Fuzzy-ASMC: width of the trend", ("controller.rules.trend_width",)),
    ),
    "RBF-ASMC": (
        *SURFACE,
        *LEARNING,
        ("Gamma", "RBF-ASMC: Gamma", ("controller.Gamma",)),
        ("sigma", "RBF-ASMC: sigma", ("controller.sigma",)),
        ("centres", "RBF-ASMC: centres", ("controller.centres",)),
        ("widths", "RBF-ASMC: widths", ("controller.widths",)),
    ),
    "super-twisting": (
        *SURFACE,
        ("k1", "super-twisting: k1", ("controller.k1",)),
        ("k2", "super-twisting: k2", ("controller.k2",)),
    ),
}


def factors(law: str) -> tuple[wb.Factor, ...]:
    """All factors of a law: its gains, the arm and the disturbance, and the model where the law has one."""
    models = () if law == "PID" else OF_BOTH_MODELS if law == "AOSMC-RGS" else OF_MODEL
    gains = (factor(name, card, paths) for name, card, paths in GAINS[law])
    arm = (factor(name, card, (f"{ARM}.{part}",)) for name, (card, part) in PARTS.items())
    gravity = factor("g", "gravity", tuple(f"{place}.gravity" for place in (ARM, *models)))
    disturbance = factor("D", "FS: disturbance amplitude", ("plant.disturbance.amplitude",))
    model = (
        factor(MODEL + name, card, tuple(f"{place}.{part}" for place in models))
        for name, (card, part) in PARTS.items()
        if models
    )
    return (*gains, *arm, gravity, disturbance, *model)


def factor(name: str, card: str, paths: tuple[str, ...]) -> wb.Factor:
    """The factor of a number on the card, as a share of that number."""
    given = next(given for given in CARD if given.name == card)
    return wb.Factor(name, paths, spread(given), given.mark, share=True)


def spread(given: wb.provenance.Given) -> wb.uncertainty.AbstractDistribution:
    """The distribution of a number's share, by the mark of the number."""
    if given.mark != "assumed":
        return wb.Uniform(1 - TOLERANCE, 1 + TOLERANCE)
    largest = float(np.abs(given.value).max())
    low = max(1 / SPAN, (given.low or 0.0) / largest) if (given.low or 0.0) > 0 else 1 / SPAN
    high = SPAN if given.high is None else min(SPAN, given.high / largest)
    return wb.LogUniform(low, high)


def written(factor: str) -> wb.document.Phrase:
    """A factor as a page prints it."""
    name = factor.removeprefix(MODEL)
    start = name.removesuffix("(0)")
    letter = start if start in WORDS else wb.notation.symbol(start)
    return ("model " if name != factor else "", letter, name.removeprefix(start))


def group_of(factor: str) -> str:
    """The group of a factor: gains, the arm with its disturbance, or the model."""
    if factor.startswith(MODEL):
        return "model"
    return "arm" if factor in (*PARTS, "g", "D") else "gains"


PROPOSED = "AOSMC-RGS"
LAWS = (PROPOSED, *RIVALS)
SCENARIO = "FS"
UNTIL, EVERY, LATE, SAMPLE = 5.0, 0.25, 3.0, 1e-3  # s: horizon, windows, when the start is over, grid of the TV
SECOND = 1.0  # s: the windows of the proposed law's indices
SHOWN = 0.01  # s, between two points of a curve
SEED = 7
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
    PROPOSED: 1e-3 / 16,
    "PID": 1e-3,
    "SMC": 1e-3 / 2,
    "ASMC": 1e-3 / 20,
    "Fuzzy-ASMC": 1e-3 / 20,
    "RBF-ASMC": 1e-3 / 16,
    "super-twisting": 1e-3,
}
TRAJECTORIES = {"ASMC": 24, "Fuzzy-ASMC": 24, "RBF-ASMC": 24}  # and 50 elsewhere
# Of the Sobol design, and 1024 elsewhere: what brings the intervals that decide a sentence below `NARROW`.
BASE = {PROPOSED: 512, "ASMC": 256, "Fuzzy-ASMC": 256, "RBF-ASMC": 256}
EQUAL = 256  # and of that in which all numbers of the proposed law have the same range
NARROW = 0.1  # of a variance, the whole width of an interval: a sentence that rests on a wider one stays open
RANDOM = 256
HALVED = 32  # one run in so many is run again at half of the step
# What the screening finds of little weight, and the Sobol indices so leave at its value: see `CLEARED`.
CLEARED = 0.2  # of the largest mu* of an output
HELD = {
    PROPOSED: ("phi", "K(0)", "P(0)", "l", "D"),
    "PID": ("D",),
    "SMC": ("phi", "D"),
    "ASMC": ("D",),
    "Fuzzy-ASMC": ("K(0)", "width of |s|", "width of the trend", "D"),
    "RBF-ASMC": ("Gamma", "sigma", "centres", "D"),
    "super-twisting": (),
}


def loop(law: str) -> wb.ClosedLoop:
    return proposed_repaired(SCENARIO) if law == PROPOSED else rival(SCENARIO, law)


def metrics(law: str) -> tuple[wb.metrics.AbstractMetric, ...]:
    """The metrics of a law, with the error of its observer where it has one."""
    return (*METRICS, OBSERVER) if law == PROPOSED else METRICS


def own_numbers() -> tuple[wb.Case, ...]:
    """Each law with the numbers of the card, for the page to turn, and the proposed one at rest."""
    tracking = (
        wb.Case(SCENARIO, law, wb.Run(loop(law), metrics(law), UNTIL, SHOWN, STEPS[law] / 2), style=i)
        for i, law in enumerate(LAWS)
    )
    return (*tracking, rest_case(STEPS[PROPOSED] / 2))


def free(law: str) -> tuple[wb.Factor, ...]:
    return tuple(factor for factor in factors(law) if factor.name not in HELD[law])


def equal_ranges(law: str) -> tuple[wb.Factor, ...]:
    """The factors of the Sobol indices, the assumed ones within the range of the stated ones."""
    return tuple(replace(factor, distribution=wb.Uniform(1 - TOLERANCE, 1 + TOLERANCE)) for factor in free(law))


def called(law: str, kind: str) -> str:
    return f"{law.lower().replace('-', '_')}_{kind}"


def sweeps(law: str) -> dict[str, wb.Sweep]:
    """The sweeps of a law by their kind, the bands over time; the proposed one has a tornado and equal ranges, too."""
    every, some, ours = factors(law), free(law), law == PROPOSED
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
        made[kind] = wb.Sweep(called(law, kind), run, moved, design, halved=HALVED, least=least)
    return made
