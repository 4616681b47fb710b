"""Samples that a test makes of numbers of its own."""

from dataclasses import replace

import numpy as np

from workbench.engine.metrics import Measurement
from workbench.engine.metrics.score import MetricColumn
from workbench.study.sample import Sample


def made_sample(
    name,
    factors,
    columns,
    t,
    h,
    seed,
    fingerprint,
    factor_values,
    values,
    again,
    errors,
    limits,
    diverged_at,
    design=None,
):
    """A sample of runs of which those of the numbers `again` were looked at; the runs that have no error ended then."""
    columns = tuple(MetricColumn(*one) for one in columns)
    lost = np.where(np.isnan(errors[:, -1]).all(axis=1), t[-1], np.nan) if len(errors) else np.empty(0)
    found = Measurement(columns, t, h, values, diverged_at, again, errors, lost, limits)
    return Sample(name, factors, factor_values, found, seed, fingerprint, design)


def with_measurement(sample, **changes):
    """The sample with other numbers in its measurement."""
    return replace(sample, measurement=replace(sample.measurement, **changes))
