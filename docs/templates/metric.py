"""A metric to fill in, with its tests: `pytest metric.py` runs them. Nothing is registered anywhere."""

from dataclasses import dataclass

import casadi as ca
import numpy as np

import workbench as wb


@dataclass(frozen=True)
class MyMetric(wb.metrics.AbstractMetric):
    """The largest error divided by the mean absolute one: max |e| T / integral of |e| dt."""

    signal: str  # fields of your own follow the name, the unit and the phrase that each metric has

    @property
    def watches(self):
        """The signals that it reads, of `loop.ode().outputs.names`; it has as many numbers as the first one."""
        return (self.signal,)

    def integrand(self, t, y):
        """The expression that is integrated over time; leave this method out if nothing is integrated."""
        return ca.fabs(y[self.signal])

    def memory(self, size):
        """The numbers that `update` changes at each step, with their starts; without them leave out both methods."""
        return wb.layout(largest=("rad/s", np.zeros(size)))

    def update(self, k, h, z, y):
        """The memory after the signals y at the time k h were read, from k = 0 on, as expressions."""
        return {"largest": ca.fmax(z["largest"], ca.fabs(y[self.signal]))}

    def value(self, integral, z, horizon):
        """The metric of B runs, (B, k), from the integrals (B, k) and the memory, for signals of k numbers.

        A metric that is a time, such as a settling time, also has `is_time = True`.
        """
        return z["largest"] * horizon / integral


class TestMyMetric(wb.testing.MetricTests):
    """The tests of every metric of the workbench, for this one."""

    def metric(self):
        """The metric with its name, its unit, a phrase on it, and its own fields."""
        return MyMetric("crest", "1", "largest error relative to the mean one", "e_omega")
