"""Equations whose outputs are expressions of time, and the values of their metrics, for tests of metrics."""

from types import SimpleNamespace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.engine.metrics import measure

TIME = ca.SX.sym("time")


def measured(ode, *metrics, until=2.0, h=1e-3):
    """By its name each metric as the equation has it, and its values (1, k)."""
    found = measure(ode, metrics, until=until, h=h)
    return {
        one.name: SimpleNamespace(metric=one, value=np.array([[score.value[0] for score in found.scores_of(one.name)]]))
        for one in found.metrics
    }


def of_time(**signals):
    """An equation whose outputs are expressions of time."""
    t, clock = ca.SX.sym("t"), Layout((Entry("clock", np.zeros(1)),))
    outputs = {name: ca.substitute(ca.SX(y), TIME, t) for name, y in signals.items()}
    return Ode.of("of time", clock, Layout(), (t, clock.symbols(), ca.SX(0, 1)), {"clock": ca.SX(1)}, outputs)
