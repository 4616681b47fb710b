"""Metrics: one number per run and component of a signal, computed during the run, with its error from a halved step.

This package takes equations, their outputs and steps; it does not know plants or laws. Read `metric_catalogue.py`
first, then `contract.py` for a metric of your own.

Examples
--------
>>> wb.metrics.late_error(2.0).name
'late error'
"""

from workbench.engine.metrics.accumulators import final_values, step_with_metrics
from workbench.engine.metrics.contract import AbstractMetric, AbstractSignalMetric, Integral, Parts
from workbench.engine.metrics.measure_loop import measure
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
from workbench.engine.metrics.signal_choice import Signal, SignalChoice
from workbench.engine.metrics.step_metrics import Peak, TotalVariation

__all__ = [
    "AbstractMetric",
    "AbstractSignalMetric",
    "SignalChoice",
    "Integral",
    "Measurement",
    "Parts",
    "Peak",
    "Score",
    "Signal",
    "TotalVariation",
    "effort",
    "energy",
    "final_values",
    "iae",
    "ise",
    "itae",
    "late_error",
    "measure",
    "step_with_metrics",
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
