"""AOSMC-RGS without each of its parts: as the whole law was tuned, with P at its steady value, and tuned again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca
import numpy as np

import workbench as wb
from studies.paper.entrants import (
    AOSMC,
    BOTH,
    ENTRANTS,
    OBSERVER,
    PROPOSAL,
    PROPOSED_LAW,
    Entrant,
    Information,
    Law,
)
from studies.paper.fitted_arm import FIT, with_fit
from studies.paper.laws import mass_matrices, own_law
from studies.paper.scenarios import HELD_OUT, Scenario

RICCATI = "Riccati equation"
PARTS = tuple(PROPOSAL.loop(HELD_OUT[0]).ablations())
STEADY = f"{RICCATI}, P at its steady value"
UNUSED_NUMBERS = {  # the numbers of the whole law that nothing reads once a part is gone
    "state observer": ("L1", "L2"),
    "adaptation of K": ("P(0)", "Q", "R"),
    RICCATI: ("Q", "R"),
    "boundary layer": ("phi",),
}


def retuned_entrant(part: str) -> Entrant:
    """AOSMC-RGS without a part, to be tuned by itself: behind observer (10) alone it is an entrant as it stands."""
    if part == "disturbance estimate":
        return next(one for one in ENTRANTS[OBSERVER.key] if one.name == PROPOSED_LAW)
    observers = BOTH.observer.without()
    block = AOSMC if part in observers else AOSMC.without()[part]
    given = BOTH if part not in observers else momentum_alone()
    tuned = tuple(one for one in PROPOSAL.law.tuned_numbers if one.name not in UNUSED_NUMBERS.get(part, ()))
    return Entrant(Law(f"without {part}", block, tuned, counts_on_d=True), given)


def momentum_alone() -> Information:
    """Positions and velocities as they are read, and the observer of the momentum."""
    observer = BOTH.observer
    if not isinstance(observer, wb.arms.observers.StateAndDisturbanceObserver):
        raise TypeError("The observers of the whole law must have the observer of the momentum among them.")
    number = tuple(one for one in BOTH.tuned_numbers if one.name == "l")
    return Information(
        "momentum", "raw readings and D_hat", "raw readings, D_hat", replace(observer, state=wb.ArmFullState(2)), number
    )


RETUNED_ENTRANTS: Mapping[str, Entrant] = {part: retuned_entrant(part) for part in PARTS}
NEW = tuple(
    one for one in RETUNED_ENTRANTS.values() if one.name != PROPOSED_LAW
)  # those that are not entrants by themselves


def as_tuned(scenario: Scenario, numbers: Mapping[str, float]) -> dict[str, wb.DigitalLoop]:
    """The whole law with these numbers, less one part at a time; without (34) P stays at P(0), or at its steady value.

    The steady value solves (34) with P' = 0 for K(0) at the posture in which the scenario starts.
    """
    whole = with_fit(PROPOSAL.loop(scenario, numbers))
    less = whole.ablations()
    frozen = less[RICCATI].loop.controller
    still = replace(less[RICCATI].loop, controller=replace(frozen, P=steady_gain(scenario, numbers)))
    return less | {STEADY: replace(whole, loop=still)}


def posture_matrix(model: wb.arms.AbstractArm, q: tuple[float, float]) -> wb.Array:
    """M (2, 2) of a model in kg m^2 at the positions q."""
    if FIT is None:
        return np.asarray(mass_matrices(np.array([q]))[0], dtype=float)
    pose = ca.SX.sym("q", 2)
    M: wb.Array = np.array(ca.Function("M", [pose], [model.mass_matrix(pose)])(q))
    return M


def steady_gain(scenario: Scenario, numbers: Mapping[str, float]) -> wb.Array:
    """P (2, 2) in N m/rad that solves (34) with P' = 0 for K(0), at the posture in which a scenario starts."""
    law = own_law(with_fit(PROPOSAL.loop(scenario, numbers)).loop)
    A = -np.linalg.solve(posture_matrix(law.model, scenario.start), law.K)
    return wb.riccati.care(A, np.diag(law.Lambda), law.Q, law.R).X
