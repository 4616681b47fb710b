"""A double integrator under PD control: a tuning whose best gains are those of a Riccati equation."""

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.engine.distributions import LogUniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import effort, ise
from workbench.study.run_and_sweep import Run
from workbench.study.tuning import Trial, Tuning

HORIZON = 20.0  # s: at the best gains nothing is left after that


class DoubleIntegrator:
    """q'' = -Kp q - Kd q' from q(0) = start."""

    def __init__(self, start=1.0):
        self.start = start

    def ode(self, name="loop"):
        """The loop, with its error and its torque."""
        states = Layout((Entry("q", np.array([self.start])), Entry("qd", np.zeros(1))))
        parameters = Layout((Entry("Kp", np.array(0.5), "1/s^2"), Entry("Kd", np.array(0.5), "1/s")))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        tau = -p[0] * x[0] - p[1] * x[1]
        outputs, units = {"e": x[0], "tau_applied": tau}, {"e": "rad", "tau_applied": "N m"}
        return Ode.of(name, states, parameters, (t, x, p), {"q": x[1], "qd": tau}, outputs, units)


GAINS = (Factor("Kp", ("Kp",), LogUniform(0.1, 10.0)), Factor("Kd", ("Kd",), LogUniform(0.1, 10.0)))


def quadratic(runs):
    """The integral of e^2 + tau^2 over all trials: of the double integrator least at Kp = 1, Kd = sqrt(2)."""
    return sum(run.score("ISE").value + HORIZON * run.score("effort").value ** 2 for run in runs.values())


def tuning(**changes):
    """A search of ten generations."""
    declared = {
        "name": "pd",
        "trials": (Trial("step", Run(DoubleIntegrator(), (ise(), effort()), HORIZON, h=0.01)),),
        "factors": GAINS,
        "objective": quadratic,
        "evaluations": 80,
        "population": 8,
    }
    return Tuning(**(declared | changes))
