"""The laws and plants of the catalogue, each in a loop of its own, for the live pages of the gallery."""

from functools import cache
from typing import Any, NamedTuple

from studies.b3_any_plant.loops import loop
from studies.b3_any_plant.settings import SETTINGS
from studies.paper.entrants import LAWS, PROPOSED_LAW
from studies.paper.laws import REFERENCES, plant, proposed_repaired
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop

STIFF = PROPOSED_LAW, "ASMC", "Fuzzy-ASMC", "RBF-ASMC", "terminal SMC"  # whose boundary layers limit the step
HORIZON, BRIEF = 10.0, 5.0  # s
STEP, BRIEF_STEP = 4e-4, 2.5e-5  # s: below half of the stability limits of the laws, and of those that are stiff


class Shown(NamedTuple):
    """A loop with its horizon and its step, in s."""

    loop: Any
    until: float
    h: float


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
