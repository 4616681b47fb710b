"""The factors of each law that a7 and d0 vary: its gains, the simulated arm, and the arm that the law believes in.

One rule for all laws. A number that the paper states, or that follows from one, is off by up to 10 % either way. A
number that is assumed lies within a factor of 1.5 of its value, and within the range on the card where that is
narrower. All are shares of the loop's own numbers, so that all entries of a gain move together. The gains of PID move
one by one, although they follow from one assumed pole.
"""

from collections.abc import Sequence

import numpy as np

import workbench as wb
from studies.paper.card import CARD

SEED = 7  # of the designs over these factors
TOLERANCE = 0.1  # of what is stated or derived
SPAN = 1.5  # of what is assumed, either way
ARM = "plant.arm"
PARTS = {
    "m1": ("masses", "links[0].mass"),
    "m2": ("masses", "links[1].mass"),
    "l1": ("lengths", "links[0].length"),
    "l2": ("lengths", "links[1].length"),
}
DIRECTION = "direction "  # before the number of a direction in which a fit moves numbers of the arm together
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


def spread(entry: wb.provenance.CardEntry) -> wb.uncertainty.AbstractDistribution:
    """The distribution of a number's share, by the mark of the number."""
    if entry.mark != "assumed":
        return wb.Uniform(1 - TOLERANCE, 1 + TOLERANCE)
    largest = float(np.abs(entry.value).max())
    low = max(1 / SPAN, (entry.low or 0.0) / largest) if (entry.low or 0.0) > 0 else 1 / SPAN
    high = SPAN if entry.high is None else min(SPAN, entry.high / largest)
    return wb.LogUniform(low, high)


def factor_phrase(factor: str) -> tuple[str | wb.notation.Formula, ...]:
    """A factor as a page prints it."""
    if factor.startswith(DIRECTION):
        return (factor,)
    name = factor.removeprefix(MODEL)
    start = name.removesuffix("(0)")
    letter = start if start in WORDS else wb.notation.symbol(start)
    return ("model " if name != factor else "", letter, name.removeprefix(start))


def group_of(factor: str) -> str:
    """The group of a factor: gains, the arm with its disturbance, or the model."""
    if factor.startswith(MODEL):
        return "model"
    return "arm" if factor in (*PARTS, "g", "D") or factor.startswith(DIRECTION) else "gains"
