"""Equations written as functions, run by the reference integrator."""

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.engine.reference import reference_run


def equation(rate, x0) -> Ode:
    """x' = rate(t, x) from x0."""
    states = Layout((Entry("x", np.array(x0, dtype=float)),))
    t, x = ca.SX.sym("t"), states.symbols()
    return Ode.of("equation", states, Layout(), (t, x, ca.SX(0, 1)), {"x": ca.vertcat(*rate(t, x))}, {})


def run(rate, x0, until, count=31, **options):
    return reference_run(equation(rate, x0), times=np.linspace(0, until, count), **options)


def times_of(result, what):
    return [event.t for event in result.events if event.what == what]
