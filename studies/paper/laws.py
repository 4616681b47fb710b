"""The closed loops of the AOSMC-RGS paper: each law in each scenario, from the numbers of the card."""

from collections.abc import Mapping
from typing import Any

import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.printed_arm import PrintedArm

ARM = wb.arms.mechanics.PlanarArm(
    tuple(map(wb.arms.mechanics.PointMass, CARD["masses"], CARD["lengths"])), CARD["gravity"]
)
SURFACE: dict[str, Any] = {"model": ARM, "Lambda": CARD["Lambda"], "phi": CARD["phi"]}
LEARNING: dict[str, Any] = {"gamma": CARD["ASMC: gamma"], "K": CARD["ASMC: K(0)"]}

REFERENCES: Mapping[str, wb.Reference] = {
    "FS": wb.Sines(CARD["FS: reference amplitude"], CARD["FS: reference frequency"]),
    "SS": wb.SquareWave(CARD["SS: a1, a2"], CARD["SS: f"]),
}

RULES = wb.arms.laws.RuleBase(
    sizes=CARD["Fuzzy-ASMC: centres of |s|"],
    size_width=CARD["Fuzzy-ASMC: width of |s|"],
    trends=CARD["Fuzzy-ASMC: centres of the trend"],
    trend_width=CARD["Fuzzy-ASMC: width of the trend"],
    scale=CARD["Fuzzy-ASMC: rules"],
)

RIVALS: Mapping[str, wb.Controller] = {
    "PID": wb.arms.laws.PID(CARD["PID: Kp"], CARD["PID: Ki"], CARD["PID: Kd"]),
    "SMC": wb.arms.laws.SlidingMode(**SURFACE, K=CARD["SMC: K"]),
    "ASMC": wb.arms.laws.AdaptiveSlidingMode(**SURFACE, **LEARNING),
    "Fuzzy-ASMC": wb.arms.laws.FuzzyAsmc(**SURFACE, **LEARNING, lag=CARD["Fuzzy-ASMC: lag"], rules=RULES),
    "RBF-ASMC": wb.arms.laws.RbfAsmc(
        **SURFACE,
        **LEARNING,
        Gamma=CARD["RBF-ASMC: Gamma"],
        sigma=CARD["RBF-ASMC: sigma"],
        centres=np.outer(CARD["RBF-ASMC: centres"], np.ones(4)),
        widths=CARD["RBF-ASMC: widths"],
    ),
    "super-twisting": wb.arms.laws.SuperTwisting(
        **SURFACE, k1=CARD["super-twisting: k1"], k2=CARD["super-twisting: k2"]
    ),
}

PRINTED_ARM = PrintedArm(ARM.links, ARM.gravity)


def plant(scenario: str) -> wb.Manipulator:
    """The derived arm with the start and the disturbance of a scenario."""
    disturbance = wb.SineTorque(
        CARD[f"{scenario}: disturbance amplitude"],
        CARD[f"{scenario}: disturbance frequency"],
        CARD[f"{scenario}: disturbance phase"],
    )
    return wb.Manipulator(ARM, q=CARD[f"{scenario}: q(0)"], qd=CARD["qd(0)"], disturbance=disturbance)


def rival(scenario: str, law: str) -> wb.ClosedLoop:
    """A rival law on exact measurements of q and qd: the best that it can be given."""
    return wb.ClosedLoop(plant(scenario), wb.FullState(2), RIVALS[law], REFERENCES[scenario])


def proposed_as_printed(scenario: str, shape: str = "outer") -> wb.ClosedLoop:
    """AOSMC-RGS letter by letter on the derived arm: (3) in model and observer, (24), (28) and the minus of (33)."""
    weights = {"Q": CARD["Q as printed"], "R": CARD["R as printed"]}
    law = wb.arms.laws.AosmcRgs(
        **SURFACE | {"model": PRINTED_ARM}, K=CARD["K(0)"], P=CARD["P(0)"], **weights, gain_shape=shape
    )
    observer = wb.arms.observers.WithDisturbance(
        paper_observer(PRINTED_ARM), wb.arms.observers.PrintedFilter(2, CARD["l"])
    )
    return wb.ClosedLoop(plant(scenario), observer, law, REFERENCES[scenario])


def proposed_repaired(scenario: str, observer: wb.Observer | None = None) -> wb.ClosedLoop:
    """AOSMC-RGS with a repair of four slips: C right, qd_r in (28), a plus in (33), D_hat = eta in (24)."""
    law = wb.arms.laws.AosmcRgs(
        **SURFACE,
        K=CARD["K(0)"],
        P=CARD["P(0)"],
        Q=CARD["Q"],
        R=CARD["R"],
        velocity="reference",
        gain_sign="raised",
        gain_shape=CARD["reading of (33)"],
    )
    return wb.ClosedLoop(plant(scenario), observer or repaired_observer(), law, REFERENCES[scenario])


def repaired_observer() -> wb.arms.observers.WithDisturbance:
    """(10) as printed, and (24) with D_hat = eta, which follows D but must know it."""
    return wb.arms.observers.WithDisturbance(paper_observer(), wb.arms.observers.OracleFilter(2, CARD["l"]))


def paper_observer(model: wb.arms.AbstractArm = ARM) -> wb.arms.observers.Luenberger:
    """(10), on the right model if not said otherwise, with the gains of section 5."""
    return wb.arms.observers.Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
