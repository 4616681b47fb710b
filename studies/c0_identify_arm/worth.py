"""The worth of a model: laws made for the arm that is believed, on the arm as it is or as a log allows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

import workbench as wb
from studies.c0_identify_arm.arm import (
    BASE,
    FREE,
    NOMINAL,
    PERIOD,
    START,
    SUBSTEPS,
    TRUTH,
    Numbers,
    arm_of,
    friction_of,
    instruments,
    plant_of,
    proposed_loop,
)
from studies.c0_identify_arm.estimates import LogFit
from studies.c0_identify_arm.own_laws import FrictionCompensation
from studies.paper.scenarios import FAST, FIRST

PROPOSED, REGULATOR, COMPUTED = "AOSMC-RGS", "LQR + model", "computed torque"
LAWS = (PROPOSED, REGULATOR, COMPUTED)
MODELS = ("nominal", "short log", "law's log", "designed log", "true")
MOTIONS = {"paper": FIRST, "fast": FAST}
PUSHES = {"": False, "push": True}
HORIZON = 6.0  # s
RMSE, EFFORT, SETTLED = "RMSE", "effort", "settled RMSE"
BEHIND = 2.0  # s, from which on a run counts as settled
DRAWS = 48  # of the start and the noise, or of the arm, too
SEED = 3600
FREQUENCY, DAMPING = 8.0, 1.0  # rad/s and 1: of the errors under a computed torque
POLE = 100.0  # 1/s: both of observer (10) beside the linear laws
GOOD_ERRORS = (0.02, 0.2, 5.0)  # rad, rad/s and N m that count alike in the quadratic cost
KEYS = {PROPOSED: "aosmc", REGULATOR: "lqr", COMPUTED: "ct"}
MODEL_KEYS = dict(zip(MODELS, ("nominal", "short", "law_log", "designed_log", "true"), strict=True))


def gains(numbers: Numbers) -> wb.Array:
    """The gain (2, 4) of the LQR for an arm that hangs and slides, whose Coulomb friction is compensated."""
    plant = wb.open_loop(plant_of((*numbers[:6], 0.0, 0.0)))
    q, qd, tau = GOOD_ERRORS
    linear = wb.linearize(plant, 0.0, np.zeros(4), at_rest=True)
    weights = np.diag([q**-2.0, q**-2.0, qd**-2.0, qd**-2.0])
    return np.asarray(wb.lqr(linear, Q=weights, R=np.eye(2) * tau**-2.0).K)


def law_of(law: str, model: Numbers) -> wb.arms.AbstractArmController:
    """One of the linear laws for the numbers of an arm, with compensation of the friction."""
    if law == REGULATOR:
        inner: wb.arms.AbstractArmController = wb.ArmStateFeedback.of(arm_of(model), gains(model))
    else:
        inner = wb.arms.laws.ComputedTorque(
            arm_of(model), np.full(2, FREQUENCY**2), np.full(2, 2 * DAMPING * FREQUENCY)
        )
    return FrictionCompensation(inner, friction_of(model))


def closed_loop(law: str, model: Numbers, plant: wb.Manipulator, reference: wb.Reference) -> wb.ClosedLoop:
    """A law made for the numbers of a model on a plant."""
    if law == PROPOSED:
        return replace(proposed_loop(plant, arm_of(model)), reference=reference)
    L1, L2 = 2 * POLE * np.eye(2), POLE**2 * np.eye(2)
    observer = wb.arms.observers.Luenberger(arm_of(model), L1, L2, START, (0.0, 0.0), integrator="cayley")
    return wb.ClosedLoop(plant, observer, law_of(law, model), reference)


def digital_loop(law: str, model: Numbers, plant: wb.Manipulator, reference: wb.Reference) -> wb.DigitalLoop:
    """The same as the computer runs it, with the encoders of the logs."""
    return wb.DigitalLoop(closed_loop(law, model, plant, reference), PERIOD, instruments(plant, BASE.noise))


@dataclass(frozen=True)
class Trial:
    """A law with a model, a motion, and the paper's disturbance or none."""

    law: str
    model: str  # of `MODELS`
    motion: str = "paper"
    push: str = ""
    is_drawn: bool = False  # True for arms that the log of the model allows, in the place of the true one

    @property
    def name(self) -> str:
        """The name of its sweep."""
        parts = (KEYS[self.law], MODEL_KEYS[self.model], self.motion, self.push, "drawn" if self.is_drawn else "")
        return "_".join(part for part in parts if part)


TRIALS = tuple(
    Trial(law, model, motion, push) for law in LAWS for model in MODELS for motion in MOTIONS for push in PUSHES
) + tuple(Trial(law, model, is_drawn=True) for law in LAWS for model in MODELS[1:4])


def starts(loop: wb.DigitalLoop) -> tuple[wb.Factor, ...]:
    """The first positions, of which the observer knows, as factors."""
    memory = [name for name in loop.loop.observer.memory.names if name.split(".")[-1] == "q_hat"]
    paths = ("plant.q", *(f"observer.{name}" for name in memory))
    return tuple(
        wb.Factor(f"start {j + 1}", tuple(f"{path}[{j}]" for path in paths), wb.Uniform(-0.1, 0.1)) for j in (0, 1)
    )


def arm_factors(fit: LogFit) -> tuple[wb.Factor, ...]:
    """The arms that a log allows, as `Fit.factors` has them for the plant of a loop."""
    return tuple(
        wb.Factor(
            f"direction {k + 1}",
            tuple(f"plant.{name}" for name in FREE),
            wb.uncertainty.Normal(0.0, 1.0, -4.0, 4.0),
            "derived",
            direction=wb.uncertainty.FactorDirection(fit.numbers, tuple(row.tolist())),
        )
        for k, row in enumerate(fit.directions)
    )


def settled_error() -> wb.metrics.Integral:
    """The root mean square of each position's error after the start."""
    return wb.metrics.Integral(
        SETTLED,
        "rad",
        f"root mean square of e from {BEHIND:g} s on",
        lambda t, y: ca.if_else(t >= BEHIND, y["e"] ** 2, 0),
        lambda integral, horizon: np.sqrt(np.maximum(integral, 0) / (horizon - BEHIND)),
    )


def sweep(trial: Trial, fits: Mapping[str, LogFit]) -> wb.Sweep:
    """The runs of a trial."""
    numbers = {"nominal": NOMINAL, "true": TRUTH} | {name: fit.numbers for name, fit in fits.items()}
    model = numbers[trial.model]
    plant = plant_of(model if trial.is_drawn else TRUTH, PUSHES[trial.push])
    loop = digital_loop(trial.law, model, plant, MOTIONS[trial.motion])
    factors = starts(loop) + (arm_factors(fits[trial.model]) if trial.is_drawn else ())
    design = wb.uncertainty.MonteCarlo(len(factors), DRAWS, SEED)
    run = wb.Run(loop, (wb.rmse(), settled_error(), wb.effort()), HORIZON, h=PERIOD / SUBSTEPS, seed=SEED)
    return wb.Sweep(trial.name, run, factors, design, common=False)


def sweeps(answers: Mapping[str, Any]) -> tuple[wb.Sweep, ...]:
    """All runs, with the models that both logs gave."""
    law, designed = answers["law_log"][0], answers["designed_log"][0]
    fits = {"short log": law.short, "law's log": law.fit, "designed log": designed.fit}
    return tuple(sweep(trial, fits) for trial in TRIALS)
