"""A predictive law as a function of one period."""

import casadi as ca
import numpy as np

from workbench.core import Signals


def step_of(law):
    """The law as a function of time, memory, states and references, to inputs and the next memory."""
    t, z = ca.SX.sym("t"), law.memory.symbols()
    x, r = law.reads.symbols(), law.follows.symbols()
    signals = Signals(law.memory.view(z)), Signals(law.reads.view(x)), Signals(law.follows.view(r))
    command, following = law.command(t, *signals), law.update(t, *signals)
    return ca.Function("law", [t, z, x, r], [law.drives.flatten(dict(command)), law.memory.flatten(following)])


def first_period(law, x, r=()):
    """The inputs (N, nu) of the plan of the first period, and the memory after it."""
    u, z = step_of(law)(0.0, law.memory.default, x, r)
    memory = law.memory.unpack(np.array(z).ravel())
    return np.vstack([np.array(u).T, memory["plan_u"].reshape(law.horizon, -1)[:-1]]), memory
