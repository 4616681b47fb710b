"""The loops of a3: the proposed law with each choice of P, without adaptation, and beside other laws."""

from dataclasses import replace
from typing import Any

import numpy as np

from studies.a1_paper_tables.study import METRICS, PROPOSED_STEP, STEPS
from studies.paper.card import CARD
from studies.paper.laws import RIVALS, proposed_repaired, repaired_observer, rival
from workbench.loop import AbstractController, ClosedLoop
from workbench.study.contract import Run
from workbench.study.study import Case

FORWARD, ALGEBRAIC, AT_START, NONE = "(34)", "algebraic", "P = P(0)", "no adaptation"
ASMC, OBSERVED = "ASMC", "ASMC, same observer"
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


def cases(scenario: str) -> tuple[Case, ...]:
    """All loops of a scenario, on its horizon."""
    loop = proposed_repaired(scenario)
    observed = ClosedLoop(loop.plant, repaired_observer(), RIVALS["ASMC"], loop.reference)
    fine = PROPOSED_STEP / 4  # P left at P(0) lets K grow by half as much again
    runs = {
        **{
            variant: (replace(loop, controller=law(scenario, variant)), EVERY, fine)
            for variant in (FORWARD, ALGEBRAIC, AT_START, NONE)
        },
        OBSERVED: (observed, 0.01, STEPS["ASMC"] / 2),
        ASMC: (rival(scenario, "ASMC"), 0.01, STEPS["ASMC"] / 2),
    }
    return tuple(
        Case(scenario, name, Run(loop, METRICS[scenario], CARD[f"{scenario}: horizon"], every, h), style=style)
        for style, (name, (loop, every, h)) in enumerate(runs.items())
    )
