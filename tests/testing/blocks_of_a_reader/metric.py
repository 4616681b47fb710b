"""The time that the error spends outside a band, with its tests."""

from dataclasses import dataclass

import casadi as ca

import workbench as wb


@dataclass(frozen=True)
class TimeOutside(wb.metrics.AbstractMetric):
    """The time for which |e| > band."""

    signal: str
    band: float

    @property
    def watches(self):
        return (self.signal,)

    @property
    def is_time(self):
        return True

    def integrand(self, t, y):
        return ca.if_else(ca.fabs(y[self.signal]) > self.band, 1.0, 0.0)

    def value(self, integral, z, horizon):
        return integral


class TestTimeOutside(wb.testing.MetricTests):
    def metric(self):
        return TimeOutside("time outside", "s", "time for which the error is out of its band", "e_omega", 0.05)
