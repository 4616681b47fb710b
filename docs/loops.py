"""The laws and plants of the catalogue, each in a loop of its own, for the live pages of the gallery."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

import workbench as wb
from studies.b3_any_plant.loops import loop
from studies.b3_any_plant.settings import SETTINGS
from studies.paper.entrants import LAWS, PROPOSED_LAW
from studies.paper.laws import REFERENCES, plant, proposed_repaired
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop

STIFF = PROPOSED_LAW, "ASMC", "Fuzzy-ASMC", "RBF-ASMC", "terminal SMC"  # whose boundary layers limit the step
HORIZON, BRIEF = 10.0, 5.0  # s
STEP, BRIEF_STEP = 4e-4, 2.5e-5  # s: below half of the stability limits of the laws, and of those that are stiff


WEIGHTS = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)  # of the force of the predictive law


class Shown(NamedTuple):
    """A loop with its horizon and its step, in s, and the knobs of its page; without any, a knob for each number."""

    loop: Any
    until: float
    h: float
    knobs: tuple[Any, ...] = ()


ARMS = {law.name: law for law in LAWS}
PLANTS = {f"{law}, {setting.name}": (setting, law) for setting in SETTINGS for law in ("LQG", "PID")}


@cache
def gallery_loop(name: str) -> Shown:
    """One of the loops: a law of arms in the first scenario of the paper, or LQG or PID on a plant of b3.

    Arms have exact readings but for the law that has its observer.
    """
    if name in PLANTS:
        setting, law = PLANTS[name]
        return Shown(loop(setting, law, computer=False), setting.until, setting.period / 4)
    closed = ClosedLoop(plant("FS"), ArmFullState(2), ARMS[name].block, REFERENCES["FS"])
    times = (BRIEF, BRIEF_STEP) if name in STIFF else (HORIZON, STEP)
    return Shown(proposed_repaired("FS") if name == PROPOSED_LAW else closed, *times)


def of_arms() -> dict[str, Shown]:
    """The laws of arms."""
    return {name: gallery_loop(name) for name in ARMS}


def of_plants() -> dict[str, Shown]:
    """LQG and PID on each plant of b3."""
    return {name: gallery_loop(name) for name in PLANTS}


def of_plans() -> dict[str, Shown]:
    """The predictive law on a cart-pole, with knobs for a weight, its limit and what it does not know."""
    weight = wb.DesignKnob.of("weight of the force", WEIGHTS, predictive_cart)
    limit = wb.Knob("limit of the force", ("controller.low", "controller.high"), 0.5, 2.0, share=True)
    mass = wb.Knob("mass of the cart", "plant.M", 0.5, 2.0, share=True)
    start = wb.Knob("angle at the start", "plant.phi", -0.3, 0.3)
    return {"MPC, cart-pole": Shown(predictive_cart(0.1), 6.0, 0.01, (weight, limit, mass, start))}


def predictive_cart(weight: float) -> wb.DigitalLoop:
    """The predictive law for a weight of the force, which moves the cart by a metre with at most 3 N."""
    plant = wb.CartPole(phi=0.1)
    model = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    Q, R, limits = np.diag([10.0, 1.0, 10.0, 1.0]), [[weight]], {"F": (-3.0, 3.0)}
    design = wb.predictive_design(model, 0.02, Q, R, 20, limits=limits, sweeps=4, modes=2)
    law = wb.ModelPredictive.of(plant, design, follow=("x",))
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=wb.Step("x", "m", 1.0))
    return wb.DigitalLoop(loop, 0.02)
