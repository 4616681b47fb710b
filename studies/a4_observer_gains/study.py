"""The observer of the AOSMC-RGS paper: do its gains keep Theorem 1, and which would?

Runs in about half a minute on two cores.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import workbench as wb
from studies.a4_observer_gains import findings
from studies.a4_observer_gains.candidates import HOW, SCENARIOS, STYLES, WITH_JUMPS, WORKS
from studies.a4_observer_gains.pages import gains_section, noise_and_rate, poles, promise_section, tracking_section
from studies.a4_observer_gains.settled_error import settled_error
from studies.paper.card import CARD
from studies.paper.citation import introduction
from studies.paper.laws import ARM, proposed_repaired

UNTIL, EVERY, STEP = 10.0, 0.01, 1e-3 / 24  # s
APART = 1 / CARD["SS: f"]  # s between two jumps of the second scenario
OF_ALL = wb.metrics.observer_error("qd_error"), wb.arms.peak_torque()
METRICS = {
    "FS": (wb.metrics.late_error(findings.AFTER), *OF_ALL),
    "SS": (
        *(settled_error(name, findings.AFTER, clear, APART) for clear, name in findings.ERROR_LABELS.items()),
        replace(wb.metrics.late_error(findings.AFTER), name=WITH_JUMPS),
        *OF_ALL,
    ),
}


def cases(answers: Mapping[str, Any]) -> tuple[wb.Case, ...]:
    """The repaired law with each observer, started as in section 5 and at the measured positions."""
    starts = ("FS", CARD["q_hat(0)"]), ("FS", CARD["FS: q(0)"]), ("SS", CARD["q_hat(0)"])
    made = []
    for name, (key, q) in zip(SCENARIOS, starts, strict=True):
        for law, mine in zip(HOW, answers["gains"], strict=True):
            state = wb.arms.observers.Luenberger(ARM, mine.L1, mine.L2, q, CARD["qd_hat(0)"])
            loop = proposed_repaired(
                key, wb.arms.observers.StateAndDisturbanceObserver(state, wb.arms.observers.OracleFilter(2, CARD["l"]))
            )
            made.append(wb.Case(name, law, wb.Run(loop, METRICS[key], UNTIL, EVERY, STEP), style=STYLES[law]))
    return tuple(made)


def sections(results: wb.Results) -> wb.Page:
    """The answer and the findings with their pictures, then the tables behind them."""
    return wb.Page(
        findings.answer(results),
        findings.findings(results),
        (
            wb.Section("Frozen modes and noise", (poles(results), noise_and_rate(results))),
            gains_section(results),
            tracking_section(results),
            promise_section(),
        ),
    )


study = wb.Study(
    name="a4_observer_gains",
    title="The gains of the observer: what the paper claims, what is proved, and better gains",
    question=(
        "Do the paper's gains L1 = 30 I, L2 = 50 I make the observer converge as Theorem 1 claims? Which gains would?"
    ),
    method=(
        f"{introduction(10, 24, rivals=False)} The exact Jacobian of the error is frozen at states of a region and "
        "along the path. Lipschitz constants are proved by intervals. Quadratic certificates over the region are "
        "proposed by linear matrix inequalities (LMI), and proved by intervals and in rational arithmetic. Other gains "
        "come from pole placement, high gain, Kalman's filter and one LMI. The repaired law of report a1 then runs "
        "with each observer, by RK4 at a step and at half of it."
    ),
    works=WORKS,
    cases=cases,
    sections=sections,
)
