"""The closed loops of the AOSMC-RGS paper: each law in each scenario, from the numbers of the card."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from studies.paper.card import CARD
from studies.paper.printed_arm import PrintedArm
from workbench.arms import laws as arm_laws
from workbench.arms.dynamics import AbstractArm
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observers import FullState, Luenberger, OracleFilter, PrintedFilter, WithDisturbance
from workbench.blocks.loop import AbstractController, AbstractObserver, AbstractReference, ClosedLoop
from workbench.blocks.signals import Sines, SineTorque, SquareWave

ARM = PlanarArm(tuple(map(PointMass, CARD["masses"], CARD["lengths"])), CARD["gravity"])
SURFACE: dict[str, Any] = {"model": ARM, "Lambda": CARD["Lambda"], "phi": CARD["phi"]}
LEARNING: dict[str, Any] = {"gamma": CARD["ASMC: gamma"], "K": CARD["ASMC: K(0)"]}

REFERENCES: Mapping[str, AbstractReference] = {
    "FS": Sines(CARD["FS: reference amplitude"], CARD["FS: reference frequency"]),
    "SS": SquareWave(CARD["SS: a1, a2"], CARD["SS: f"]),
}

RULES = arm_laws.RuleBase(
    sizes=CARD["Fuzzy-ASMC: centres of |s|"],
    size_width=CARD["Fuzzy-ASMC: width of |s|"],
    trends=CARD["Fuzzy-ASMC: centres of the trend"],
    trend_width=CARD["Fuzzy-ASMC: width of the trend"],
    scale=CARD["Fuzzy-ASMC: rules"],
)

RIVALS: Mapping[str, AbstractController] = {
    "PID": arm_laws.PID(CARD["PID: Kp"], CARD["PID: Ki"], CARD["PID: Kd"]),
    "SMC": arm_laws.SlidingMode(**SURFACE, K=CARD["SMC: K"]),
    "ASMC": arm_laws.AdaptiveSlidingMode(**SURFACE, **LEARNING),
    "Fuzzy-ASMC": arm_laws.FuzzyAsmc(**SURFACE, **LEARNING, lag=CARD["Fuzzy-ASMC: lag"], rules=RULES),
    "RBF-ASMC": arm_laws.RbfAsmc(
        **SURFACE,
        **LEARNING,
        Gamma=CARD["RBF-ASMC: Gamma"],
        sigma=CARD["RBF-ASMC: sigma"],
        centres=np.outer(CARD["RBF-ASMC: centres"], np.ones(4)),
        widths=CARD["RBF-ASMC: widths"],
    ),
    "super-twisting": arm_laws.SuperTwisting(**SURFACE, k1=CARD["super-twisting: k1"], k2=CARD["super-twisting: k2"]),
}

PRINTED_ARM = PrintedArm(ARM.links, ARM.gravity)


def plant(scenario: str) -> Manipulator:
    """The derived arm with the start and the disturbance of a scenario."""
    disturbance = SineTorque(
        CARD[f"{scenario}: disturbance amplitude"],
        CARD[f"{scenario}: disturbance frequency"],
        CARD[f"{scenario}: disturbance phase"],
    )
    return Manipulator(ARM, q=CARD[f"{scenario}: q(0)"], qd=CARD["qd(0)"], disturbance=disturbance)


def rival(scenario: str, law: str) -> ClosedLoop:
    """A rival law on exact measurements of q and qd: the best that it can be given."""
    return ClosedLoop(plant(scenario), FullState(2), RIVALS[law], REFERENCES[scenario])


def proposed_as_printed(scenario: str, shape: str = "outer") -> ClosedLoop:
    """AOSMC-RGS letter by letter on the derived arm: (3) in model and observer, (24), (28) and the minus of (33)."""
    weights = {"Q": CARD["Q as printed"], "R": CARD["R as printed"]}
    law = arm_laws.AosmcRgs(
        **SURFACE | {"model": PRINTED_ARM}, K=CARD["K(0)"], P=CARD["P(0)"], **weights, gain_shape=shape
    )
    observer = WithDisturbance(paper_observer(PRINTED_ARM), PrintedFilter(2, CARD["l"]))
    return ClosedLoop(plant(scenario), observer, law, REFERENCES[scenario])


def proposed_repaired(scenario: str, observer: AbstractObserver | None = None) -> ClosedLoop:
    """AOSMC-RGS with a repair of four slips: C right, qd_r in (28), a plus in (33), D_hat = eta in (24)."""
    law = arm_laws.AosmcRgs(
        **SURFACE,
        K=CARD["K(0)"],
        P=CARD["P(0)"],
        Q=CARD["Q"],
        R=CARD["R"],
        velocity="reference",
        gain_sign="raised",
        gain_shape=CARD["reading of (33)"],
    )
    return ClosedLoop(plant(scenario), observer or repaired_observer(), law, REFERENCES[scenario])


def repaired_observer() -> WithDisturbance:
    """(10) as printed, and (24) with D_hat = eta, which follows D but must know it."""
    return WithDisturbance(paper_observer(), OracleFilter(2, CARD["l"]))


def paper_observer(model: AbstractArm = ARM) -> Luenberger:
    """(10), on the right model if not said otherwise, with the gains of section 5."""
    return Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])
