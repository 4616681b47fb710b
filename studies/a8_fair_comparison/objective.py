"""The cost that every law of a8 is tuned for and judged by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from studies.a8_fair_comparison.conditions import HORIZON, LEVEL, Scenario
from workbench.metrics import AbstractMetric, effort, rmse, total_variation
from workbench.metrics.contract import Integral
from workbench.study.sample import Sample
from workbench.validation.refusals import Array

LATE = "late RMSE"
HALF = 0.5  # of the time, that counts as late


def metrics(scenario: Scenario) -> tuple[AbstractMetric, ...]:
    """Those of a run: late is the second half of each level of a square wave, and of the whole run otherwise.

    The torque is sampled as often as the computer changes it.
    """
    span = LEVEL if scenario.jumps else HORIZON
    late = Integral(
        LATE,
        "rad",
        f"root mean square of e over the second half {'of each level' if scenario.jumps else 'of the run'}",
        lambda t, y: ca.if_else(ca.fmod(t, span) >= HALF * span, y["e"] ** 2, 0),
        lambda integral, horizon: np.sqrt(np.maximum(integral, 0) / (HALF * horizon)),
    )
    return rmse(), late, total_variation(scenario.period), effort()


@dataclass(frozen=True)
class Term:
    """A part of the objective: a metric, both joints together, in units of what is called acceptable."""

    metric: str
    unit: str
    acceptable: float
    why: str


TERMS = (
    Term("RMSE", "rad", 0.5, "the whole run with its first error"),
    Term(LATE, "rad", 0.005, "what is left once the first error is gone: a quarter of a degree"),
    Term("TV", "N m/s", 300.0, "chattering: about three times what the wanted motion itself takes"),
    Term("effort", "N m", 50.0, "torque: twice what gravity takes"),
)


def both(sample: Sample, metric: str) -> Array:
    """A metric of both joints together, the root of the sum of their squares, (N,)."""
    return np.hypot(sample.outputs(metric, 0), sample.outputs(metric, 1))


def cost(sample: Sample, terms: tuple[Term, ...] = TERMS) -> Array:
    """The sum of all terms, (N,)."""
    return np.sum([both(sample, term.metric) / term.acceptable for term in terms], axis=0)


def objective(samples: Mapping[str, Sample]) -> Array:
    """The mean cost over the training scenarios, (n,)."""
    return np.mean([cost(sample) for sample in samples.values()], axis=0)
