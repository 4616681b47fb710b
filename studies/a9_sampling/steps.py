"""Chattering over the step of the simulation: what belongs to the computer stays, what belongs to the step moves."""

from dataclasses import dataclass

import numpy as np

from studies.a9_sampling.loops import TV, switched
from studies.paper.linearization import PROPOSED
from workbench.core import Step
from workbench.metrics import measured, total_variation
from workbench.metrics.accumulators import final_values
from workbench.simulate import simulate
from workbench.validation.refusals import Array

LAWS = ("SMC", PROPOSED)
UNTIL, PERIOD = 10.0, 1e-3  # s, of the first scenario
STEPS = (5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3)  # s, of RK4 through the loop in continuous time
SUBSTEPS = (1, 2, 5)  # of the plant within a period of the computer
WORDS = {"clip": "layer", "sign": "relay"}


@dataclass(frozen=True, eq=False)
class Curve:
    """TV (N, 2) in N m/s over steps h (N,) in s, of one law, one switching, with or without a computer of 1 ms."""

    law: str
    switching: str
    digital: bool
    h: Array
    TV: Array

    @property
    def label(self) -> str:
        """What a legend says."""
        return f"{WORDS[self.switching]}, {'computer of 1 ms' if self.digital else 'continuous time'}"


def curves() -> tuple[Curve, ...]:
    """Both laws, with layer and relay, in continuous time and run by a computer."""
    return tuple(curve(law, switching, digital) for law in LAWS for switching in WORDS for digital in (False, True))


def curve(law: str, switching: str, digital: bool) -> Curve:
    """One of them; the torque is looked at once a step, or once a period of the computer, which holds it."""
    loop = switched(law, "FS", switching)
    if digital:
        sampled, grid = loop.digital(PERIOD), total_variation(PERIOD)
        h = [PERIOD / m for m in SUBSTEPS]
        steps = [measured(sampled, (grid,), length) for length in h]
    else:
        ode, h = loop.ode(), list(STEPS)
        steps = [measured(ode, (total_variation(length),), length) for length in h]
    return Curve(law, switching, digital, np.array(h), np.array([_variation(step, step.h) for step in steps]))


def _variation(step: Step, grid: float) -> Array:
    runs = simulate(step, until=UNTIL, every=UNTIL)
    return np.asarray(final_values(runs, (total_variation(grid),))[TV][0])
