"""The loops of a3: the proposed law with each choice of P, without adaptation, and beside other laws."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from studies.a1_paper_tables.study import METRICS, PROPOSED_STEP, STEPS
from studies.paper.card import CARD
from studies.paper.laws import ARM, REFERENCES, RIVALS, plant, proposed_repaired, repaired_observer, rival
from workbench.controllers import StateFeedback
from workbench.design import linearize
from workbench.design.riccati import Riccati, lqr
from workbench.loop import AbstractController, ClosedLoop, open_loop
from workbench.observers import FullState
from workbench.plants import Manipulator
from workbench.study.contract import Run
from workbench.study.study import Case

FORWARD, ALGEBRAIC, AT_START, NONE = "(34)", "algebraic", "P = P(0)", "no adaptation"
ASMC, OBSERVED, LQR = "ASMC", "ASMC, same observer", "LQR"
EVERY = 1e-3 / 12 * 30  # s: the path of P is a spline through the kept states


def law(scenario: str, variant: str) -> AbstractController:
    """The repaired law with one choice of P; (33) with P = 0 leaves the gain at K(0)."""
    ours = proposed_repaired(scenario).controller
    changes: dict[str, dict[str, Any]] = {
        FORWARD: {},
        ALGEBRAIC: {"riccati": "algebraic", "P": None},
        AT_START: {"riccati": "frozen", "Q": None, "R": None},
        NONE: {"riccati": "frozen", "Q": None, "R": None, "P": np.zeros((2, 2))},
    }
    return replace(ours, **changes[variant])


@cache
def hanging() -> Any:
    """The arm at rest, by its exact Jacobians."""
    return linearize(open_loop(Manipulator(ARM, q=np.zeros(2))), 0.0, np.zeros(4), at_rest=True)


def weight() -> float:
    """kappa, in (N m/rad)^2."""
    heaviest = 1 / np.linalg.eigvalsh(hanging().B[2:]).min()
    return float((CARD["Lambda"][0] ** 2 * 2 * heaviest) ** 2)


@cache
def regulator() -> Riccati:
    """The regulator of the arm that hangs at rest, x = [q; qd], without weight on qd.

    With Qp = kappa I and R = I a direction of inertia m alone gets poles of real part -kappa^(1/4) / (2 m)^(1/2);
    kappa gives the heaviest direction the rate of the surface, as PID has it.
    """
    return lqr(hanging(), Q=np.diag([weight(), weight(), 0.0, 0.0]), R=np.eye(2))


def cases(scenario: str) -> tuple[Case, ...]:
    """All loops of a scenario, on its horizon."""
    loop = proposed_repaired(scenario)
    observed = ClosedLoop(loop.plant, repaired_observer(), RIVALS["ASMC"], loop.reference)
    linear = ClosedLoop(plant(scenario), FullState(2), StateFeedback.of(ARM, regulator().K), REFERENCES[scenario])
    fine = PROPOSED_STEP / 4  # P left at P(0) lets K grow by half as much again
    runs = {
        **{
            variant: (replace(loop, controller=law(scenario, variant)), EVERY, fine)
            for variant in (FORWARD, ALGEBRAIC, AT_START, NONE)
        },
        OBSERVED: (observed, 0.01, STEPS["ASMC"] / 2),
        ASMC: (rival(scenario, "ASMC"), 0.01, STEPS["ASMC"] / 2),
        LQR: (linear, 0.01, STEPS["PID"] / 2),
    }
    return tuple(
        Case(scenario, name, Run(loop, METRICS[scenario], CARD[f"{scenario}: horizon"], every, h), style=style)
        for style, (name, (loop, every, h)) in enumerate(runs.items())
    )
