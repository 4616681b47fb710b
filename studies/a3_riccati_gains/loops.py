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
    frozen = replace(ours, riccati="frozen", Q=None, R=None)
    choices = {
        FORWARD: ours,
        ALGEBRAIC: replace(ours, riccati="algebraic", P=None),
        AT_START: frozen,
        NONE: replace(frozen, P=np.zeros((2, 2))),
    }
    return choices[variant]


@cache
def regulator() -> Riccati:
    """The regulator of the arm that hangs at rest, x = [q; qd], without weight on qd.

    With Qp = kappa I and R = I a direction of inertia m alone gets poles of real part -kappa^(1/4) / (2 m)^(1/2);
    kappa gives the heaviest direction the rate of the surface, as PID has it.
    """
    linear = hanging()
    return lqr(linear, Q=np.diag([weight(), weight(), 0.0, 0.0]), R=np.eye(2))


def weight() -> float:
    """kappa, in (N m/rad)^2."""
    heaviest = 1 / np.linalg.eigvalsh(hanging().B[2:]).min()
    return float((CARD["Lambda"][0] ** 2 * 2 * heaviest) ** 2)


@cache
def hanging() -> Any:
    """The arm at rest, by its exact Jacobians."""
    return linearize(open_loop(Manipulator(ARM, q=np.zeros(2))), 0.0, np.zeros(4), at_rest=True)


def cases(scenario: str) -> tuple[Case, ...]:
    """All loops of a scenario, on its horizon."""
    metrics, until = METRICS[scenario], CARD[f"{scenario}: horizon"]
    loop = proposed_repaired(scenario)
    ours = (
        Case(
            scenario,
            variant,
            # a fourth: P left at P(0) lets K grow by half as much again
            Run(replace(loop, controller=law(scenario, variant)), metrics, until, EVERY, PROPOSED_STEP / 4),
            style=i,
        )
        for i, variant in enumerate((FORWARD, ALGEBRAIC, AT_START, NONE))
    )
    observed = ClosedLoop(loop.plant, repaired_observer(), RIVALS["ASMC"], loop.reference)
    feedback = StateFeedback.of(ARM, regulator().K)
    seventh = ClosedLoop(plant(scenario), FullState(2), feedback, REFERENCES[scenario])
    others = (
        Case(scenario, OBSERVED, Run(observed, metrics, until, 0.01, STEPS["ASMC"] / 2), style=4),
        Case(scenario, ASMC, Run(rival(scenario, "ASMC"), metrics, until, 0.01, STEPS["ASMC"] / 2), style=5),
        Case(scenario, LQR, Run(seventh, metrics, until, 0.01, STEPS["PID"] / 2), style=6),
    )
    return (*ours, *others)
