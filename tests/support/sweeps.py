"""A small sweep with a closed form, for tests."""

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.numbers import Bounds
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import iae, ise
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.uncertainty import MonteCarlo


class Decay:
    """x' = -rate x + push from x(0): IAE and ISE in closed form."""

    def ode(self, name="loop"):
        states = Layout((Entry("x", np.ones(1)),))
        rate = Entry("rate", np.array(1.0), "1/s", Bounds(0, 10))
        parameters = Layout((rate, Entry("push", np.array(0.0)), Entry("gains", np.ones(2))))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        return Ode.of(name, states, parameters, (t, x, p), {"x": -p[0] * x + p[1]}, {"e": x}, {"e": "rad"})


class Explosion:
    """x' = x^2 from x(0), infinite at t = 1 / x(0)."""

    def ode(self, name="loop"):
        states = Layout((Entry("x", np.ones(1)),))
        t, x, p = ca.SX.sym("t"), states.symbols(), ca.SX(0, 1)
        return Ode.of(name, states, Layout(), (t, x, p), {"x": x**2}, {"e": x})


RATE = Factor("rate", ("rate",), Uniform(0.5, 3.0))
START = Factor("start", ("x",), Uniform(0.5, 2.0))


RUN = ("loop", "metrics", "until", "every", "h", "tolerance", "seed")  # of the changes, those of the run


def sweep(**changes):
    """Fifty runs of a decay over its rate and its start, in chunks of eight."""
    declared = {
        "name": "decay",
        "factors": (RATE, START),
        "design": MonteCarlo(2, 50, seed=3),
        "runs_of_chunk": 8,
    }
    run = {"loop": Decay(), "metrics": (iae(), ise()), "h": 0.01, "until": 2.0}
    run |= {name: changes.pop(name) for name in RUN if name in changes}
    return Sweep(**({"run": Run(**run)} | declared | changes))
