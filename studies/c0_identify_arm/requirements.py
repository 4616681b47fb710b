"""Limits on the linear loop of the regulator, checked on the arms that a log allows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.c0_identify_arm.arm import FREE, NOMINAL, START, TRUTH, Numbers, plant_of
from studies.c0_identify_arm.estimates import LogFit
from studies.c0_identify_arm.worth import REGULATOR, arm_factors, closed_loop

SPECIFICATION = wb.Specification(Ms=1.5, damping=0.7, delay_margin=0.01, disk_margin=0.5, overshoot=5.0)
ANSWER = ("q_ref[0]", "q[0]")  # of which the overshoot is limited
ARMS, SEED = 12, 36
SLIDING = FREE[:6]  # without Coulomb friction, which does not damp an arm that slides and is compensated
BEYOND = 3.3  # standard errors of the box that is searched, for 99.9 % of each number
SEARCHED = 32


@dataclass(frozen=True)
class CheckedGains:
    """The limits of one set of gains on some arms: figures (B, k) at draws, those at the worst found in a box."""

    gains: str  # the model for which they were designed
    arms: str  # the log whose arms were drawn; or "true"
    figures: wb.Array
    holds: wb.Array  # (B, k), 1 for a limit that is held
    in_box: tuple[str, ...]  # verdicts of the search in a box; empty for the true arm


def loop_for(model: Numbers, arm: Numbers) -> wb.ClosedLoop:
    """The regulator with gains for a model, on an arm that slides about the pose in which it hangs."""
    sliding = (*arm[:6], 0.0, 0.0)
    return closed_loop(REGULATOR, (*model[:6], 0.0, 0.0), plant_of(sliding), wb.Constant("q", "rad", START))


def arms_of(fit: LogFit) -> list[dict[str, float]]:
    """Arms that a log allows, drawn by its factors: the values of the parameters of the plant."""
    loop = loop_for(fit.numbers, fit.numbers)
    factors = arm_factors(fit)
    space = wb.uncertainty.Space(factors, loop.ode().parameters)
    rows, _ = space.rows(wb.uncertainty.MonteCarlo(len(factors), ARMS, SEED).points())
    labels = [f"plant.{name}" for name in SLIDING]
    columns = [loop.ode().parameters.labels.index(label) for label in labels]
    return [dict(zip(labels, row[columns].tolist(), strict=True)) for row in rows]


def check(gains: str, model: Numbers, arms: str, fit: LogFit) -> CheckedGains:
    """The limits of gains for a model at draws of the arms of a log, and in the box of their intervals."""
    loop = loop_for(model, fit.numbers)
    verdicts = [judge(loop, values) for values in arms_of(fit)]
    ends = zip(SLIDING, fit.theta.tolist(), (BEYOND * fit.errors).tolist(), strict=False)
    box = {f"plant.{name}": (value - far, value + far) for name, value, far in ends}
    searched = SPECIFICATION.check(
        wb.linear_loop(loop), box, inputs=ANSWER[0], outputs=ANSWER[1], draws=SEARCHED, parts=0
    )
    return CheckedGains(gains, arms, *figures_of(verdicts), tuple(one.kind for one in searched))


def check_true(gains: str, model: Numbers) -> CheckedGains:
    """The same on the true arm."""
    return CheckedGains(gains, "true", *figures_of([judge(loop_for(model, TRUTH), {})]), ())


def judge(loop: wb.ClosedLoop, values: dict[str, float]) -> wb.study.specifications.SpecificationVerdicts:
    """The verdicts on a loop whose plant has these parameters."""
    return SPECIFICATION.check(wb.linear_loop(loop, values=values), inputs=ANSWER[0], outputs=ANSWER[1])


def figures_of(verdicts: list[wb.study.specifications.SpecificationVerdicts]) -> tuple[wb.Array, wb.Array]:
    """The figures (B, k) and the limits that are held (B, k)."""
    figures = [[np.nan if one.figure.value is None else one.figure.value.value for one in each] for each in verdicts]
    return np.array(figures), np.array([[float(one.kind == "holds") for one in each] for each in verdicts])


def all_checks(name: str, fit: LogFit) -> tuple[CheckedGains, ...]:
    """Gains of the paper's arm and gains for a log, on the arms of the log; and the latter on the true arm."""
    return (
        check("nominal", NOMINAL, name, fit),
        check(name, fit.numbers, name, fit),
        check_true(name, fit.numbers),
    )
