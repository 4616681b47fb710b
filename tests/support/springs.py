"""A mass on a spring as an equation, for what is handed over."""

from dataclasses import replace

import casadi as ca
import numpy as np

import workbench as wb
from workbench.core import Entry, Layout, Ode


def spring(names=("k", "F", "G"), **others):
    """A mass on a spring, of which the second force is read with the length at once."""
    states = wb.layout(x="m", v="m/s")
    parameters = Layout(tuple(Entry(name, np.array(2.0 - i)) for i, name in enumerate(names)))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rates = {"x": x[1], "v": p[1] - p[0] * x[0]}
    ode = Ode.of("spring", states, parameters, (t, x, p), rates, {"length": x[0], "force": p[2] - p[0] * x[0]})
    return replace(ode, inputs=names[1:], **others)
