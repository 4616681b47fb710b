"""One number per run and number of a signal, accumulated inside the loop, with its error from a halved step."""

from workbench.metrics.accumulated import measured
from workbench.metrics.catalogue import (
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
from workbench.metrics.contract import AbstractMetric
from workbench.metrics.measure import measure
from workbench.metrics.measurement import Measurement, Score

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
