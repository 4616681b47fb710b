"""The closed loops of the AOSMC-RGS paper: each law in each scenario, from the numbers of the card."""

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.card import CARD
from studies.paper.printed_arm import PrintedArm

LINKS = tuple(map(wb.arms.mechanics.PointMass, CARD["masses"], CARD["lengths"]))
ARM = wb.arms.mechanics.PlanarArm(LINKS, CARD["gravity"])
SURFACE: dict[str, Any] = {"model": ARM, "Lambda": CARD["Lambda"], "phi": CARD["phi"]}
LEARNING: dict[str, Any] = {"gamma": CARD["ASMC: gamma"], "K": CARD["ASMC: K(0)"]}

SINES = wb.Sines("q", "rad", CARD["FS: reference amplitude"], CARD["FS: reference frequency"])
SQUARE_WAVE = wb.SquareWave("q", "rad", CARD["SS: a1, a2"], CARD["SS: f"])
REFERENCES: Mapping[str, wb.Reference] = {"FS": SINES, "SS": SQUARE_WAVE}

RULES = wb.arms.laws.RuleBase(
    sizes=CARD["Fuzzy-ASMC: centres of |s|"],
    size_width=CARD["Fuzzy-ASMC: width of |s|"],
    trends=CARD["Fuzzy-ASMC: centres of the trend"],
    trend_width=CARD["Fuzzy-ASMC: width of the trend"],
    scale=CARD["Fuzzy-ASMC: rules"],
)

RIVALS: Mapping[str, wb.Controller] = {
    "PID": wb.arms.laws.ArmPID(CARD["PID: Kp"], CARD["PID: Ki"], CARD["PID: Kd"]),
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

PRINTED_ARM = PrintedArm(LINKS, ARM.gravity)


def disturbance(scenario: str) -> wb.SineTorque:
    """The disturbance of a scenario, a torque at each joint."""
    return wb.SineTorque(
        CARD[f"{scenario}: disturbance amplitude"],
        CARD[f"{scenario}: disturbance frequency"],
        CARD[f"{scenario}: disturbance phase"],
    )


def plant(scenario: str) -> wb.Manipulator:
    """The derived arm with the start and the disturbance of a scenario."""
    return wb.Manipulator(ARM, q=CARD[f"{scenario}: q(0)"], qd=CARD["qd(0)"], disturbance=disturbance(scenario))


def rival(scenario: str, law: str) -> wb.ClosedLoop:
    """A rival law on exact measurements of q and qd: the best that it can be given."""
    return wb.ClosedLoop(plant(scenario), wb.ArmFullState(2), RIVALS[law], REFERENCES[scenario])


def proposed_as_printed(scenario: str, shape: str = "outer") -> wb.ClosedLoop:
    """AOSMC-RGS letter by letter on the derived arm: (3) in model and observer, (24), (28) and the minus of (33)."""
    weights = {"Q": CARD["Q as printed"], "R": CARD["R as printed"]}
    law = wb.arms.laws.AosmcRgs(
        **SURFACE | {"model": PRINTED_ARM}, K=CARD["K(0)"], P=CARD["P(0)"], **weights, gain_shape=shape
    )
    observer = wb.arms.observers.StateAndDisturbanceObserver(
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


def arm_law(name: str) -> wb.arms.AbstractArmController:
    """A rival law, as a law of an arm."""
    law = RIVALS[name]
    if not isinstance(law, wb.arms.AbstractArmController):
        raise TypeError(f"'{name}' must be a law of an arm.")
    return law


def own_law(loop: wb.ClosedLoop) -> wb.arms.laws.AosmcRgs:
    """AOSMC-RGS of a loop that it closes."""
    if not isinstance(loop.controller, wb.arms.laws.AosmcRgs):
        raise TypeError("The law of the loop must be AOSMC-RGS.")
    return loop.controller


def state_observer(loop: wb.ClosedLoop) -> wb.arms.observers.Luenberger:
    """Observer (10) of a loop that has it."""
    observer = loop.observer
    if not (
        isinstance(observer, wb.arms.observers.StateAndDisturbanceObserver)
        and isinstance(observer.state, wb.arms.observers.Luenberger)
    ):
        raise TypeError("The observer of the loop must have observer (10) for its states.")
    return observer.state


def repaired_observer() -> wb.arms.observers.StateAndDisturbanceObserver:
    """(10) as printed, and (24) with D_hat = eta, which follows D but must know it."""
    return wb.arms.observers.StateAndDisturbanceObserver(paper_observer(), wb.arms.observers.OracleFilter(2, CARD["l"]))


def paper_observer(model: wb.arms.AbstractArm = ARM) -> wb.arms.observers.Luenberger:
    """(10), on the right model if not said otherwise, with the gains of section 5."""
    return wb.arms.observers.Luenberger(model, CARD["L1"], CARD["L2"], CARD["q_hat(0)"], CARD["qd_hat(0)"])


def mass_matrices(q: wb.Array) -> wb.Array:
    """M of the derived arm at the positions q (N, 2), as (N, 2, 2) in kg m^2."""
    pose = ca.SX.sym("q", 2)
    M = ca.Function("M", [pose], [ca.vec(ARM.mass_matrix(pose))])
    return np.array(M.map(len(q))(q.T)).T.reshape(-1, 2, 2)
