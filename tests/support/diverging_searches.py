"""A search for a rate, at some of which the state grows without bound."""

import casadi as ca
import numpy as np

from tests.support.tunings import tuning
from workbench.core import Entry, Layout, Ode
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import iae
from workbench.study.run_and_sweep import Run
from workbench.study.tuning import Trial


class Bomb:
    """x' = rate x^2 from x(0) = 1: infinite at t = 1 / rate."""

    def ode(self, name="loop"):
        """The equation."""
        states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("rate", np.array(1.0)),))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        return Ode.of(name, states, parameters, (t, x, p), {"x": p * x**2}, {"e": x})


def bomb(low, high, **changes):
    """A search for the rate at which the integral of |x| comes to 1."""
    declared = {
        "name": "bomb",
        "trials": (Trial("long", Run(Bomb(), (iae(),), 1.0, h=0.005)),),
        "factors": (Factor("rate", ("rate",), Uniform(low, high)),),
        "objective": lambda runs: (runs["long"].score("IAE").value - 1.0) ** 2 + 1.0,
    }
    return tuning(**(declared | changes))
