"""Metrics: one number a run and number of a signal, accumulated inside the loop, with its error from a halved step.

The room knows equations, their outputs and steps; it does not know plants or laws. Read `metric_catalogue.py` first,
then `contract.py` for a metric of your own.
"""

from workbench.metrics.accumulators import measured
from workbench.metrics.contract import AbstractMetric
from workbench.metrics.measure import measure
from workbench.metrics.measurement import Measurement
from workbench.metrics.metric_catalogue import (
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
    peak_torque,
    rmse,
    sampled_rmse,
    settling_time,
    total_variation,
    violation,
)
from workbench.metrics.score import Score

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
    "peak_torque",
    "rmse",
    "sampled_rmse",
    "settling_time",
    "total_variation",
    "violation",
]
