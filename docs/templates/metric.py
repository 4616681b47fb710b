"""A metric to fill in, with its tests: `pytest metric.py` runs them. Nothing is registered anywhere."""

from dataclasses import dataclass

import casadi as ca
import numpy as np

import workbench as wb


@dataclass(frozen=True)
class MyMetric(wb.metrics.AbstractMetric):
    """The largest error in the share of the mean absolute one: max |e| T / integral of |e| dt."""

    @property
    def watches(self):
        """The outputs of the loop that it looks at; the first has as many numbers as the metric."""
        return ("e_omega",)

    def integrand(self, t, y):
        """The expression that is integrated over time; leave it out if nothing is."""
        return ca.fabs(y["e_omega"])

    def memory(self, size):
        """What is updated at each step, with its start; leave it and `update` out if nothing is."""
        return wb.layout(largest=("rad/s", np.zeros(size)))

    def update(self, k, h, z, y):
        """The memory behind a step, as expressions."""
        return {"largest": ca.fmax(z["largest"], ca.fabs(y["e_omega"]))}

    def value(self, integral, z, horizon):
        """The metric of each run, a row for each, from the integrals (B, k) and the memory."""
        return z["largest"] * horizon / integral


class TestMyMetric(wb.testing.MetricTests):
    """The tests of every metric of the workbench, for this one."""

    def metric(self):
        """The metric with its name, its unit, and a phrase on it."""
        return MyMetric("crest", "1", "largest error relative to the mean one")
