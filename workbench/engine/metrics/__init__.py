"""Metrics: one number a run and number of a signal, accumulated inside the loop, with its error from a halved step.

The room knows equations, their outputs and steps; it does not know plants or laws. Read `metric_catalogue.py` first,
then `contract.py` for a metric of your own.
"""

from workbench.engine.metrics.accumulators import measured
from workbench.engine.metrics.contract import AbstractMetric
from workbench.engine.metrics.measure import measure
from workbench.engine.metrics.measurement import Measurement
from workbench.engine.metrics.metric_catalogue import (
    effort,
    energy,
    iae,
    ise,
    itae,
    late_error,
    observer_error,
    overshoot,
    peak,
    peak_error,
    rmse,
    sampled_rmse,
    settling_time,
    total_variation,
    violation,
)
from workbench.engine.metrics.score import Score

__all__ = [
    "AbstractMetric",
    "Measurement",
    "Score",
    "effort",
    "energy",
    "iae",
    "ise",
    "itae",
    "late_error",
    "measure",
    "measured",
    "observer_error",
    "overshoot",
    "peak",
    "peak_error",
    "rmse",
    "sampled_rmse",
    "settling_time",
    "total_variation",
    "violation",
]
