"""The loops of a3: the proposed law with each choice of P, without adaptation, and beside other laws."""

from dataclasses import replace

import numpy as np
from a1_paper_tables import METRICS, PROPOSED_STEP, STEPS
from paper_card import CARD
from paper_laws import RIVALS, proposed_repaired, repaired_observer, rival

from workbench.loop import AbstractController, ClosedLoop
from workbench.study.study import Case

FORWARD, AT_START, NONE = "(34)", "P = P(0)", "no adaptation"
ASMC, OBSERVED = "ASMC", "ASMC, same observer"
EVERY = 1e-3 / 12 * 30  # s: the path of P is a spline through the kept states


def law(scenario: str, variant: str) -> AbstractController:
    """The repaired law with one choice of P; (33) with P = 0 leaves the gain at K(0)."""
    ours = proposed_repaired(scenario).controller
    frozen = replace(ours, riccati="frozen", Q=None, R=None)
    return {FORWARD: ours, AT_START: frozen, NONE: replace(frozen, P=np.zeros((2, 2)))}[variant]


def cases(scenario: str) -> tuple[Case, ...]:
    """All loops of a scenario, on its horizon."""
    common = {"metrics": METRICS[scenario], "until": CARD[f"{scenario}: horizon"]}
    loop = proposed_repaired(scenario)
    ours = (
        Case(
            scenario,
            variant,
            replace(loop, controller=law(scenario, variant)),
            h=PROPOSED_STEP / 2,  # P left at P(0) lets K grow by half as much again
            every=EVERY,
            **common,
            style=i,
        )
        for i, variant in enumerate((FORWARD, AT_START, NONE))
    )
    observed = ClosedLoop(loop.plant, repaired_observer(), RIVALS["ASMC"], loop.reference)
    others = (
        Case(scenario, OBSERVED, observed, h=STEPS["ASMC"], every=0.01, **common, style=3),
        Case(scenario, ASMC, rival(scenario, "ASMC"), h=STEPS["ASMC"], every=0.01, **common, style=4),
    )
    return (*ours, *others)
