"""Twenty chunks of some fifty milliseconds, for the exam of durability.

Question  Does what was acknowledged outlive its process?
Method    A mass on a spring, pushed; stiffness and damping are drawn at random.
"""

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import rmse
from workbench.study.document.document import Paragraph, Section
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.study import Study
from workbench.study.uncertainty import MonteCarlo


class Spring:
    """q'' = sin t - stiffness q - damping q'."""

    def ode(self, name="loop"):
        """The equation of motion."""
        states = Layout((Entry("q", np.ones(1), "m"), Entry("qd", np.zeros(1), "m/s")))
        parameters = Layout((Entry("stiffness", np.array(4.0), "1/s^2"), Entry("damping", np.array(0.4), "1/s")))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        rates = {"q": x[1], "qd": ca.sin(t) - p[0] * x[0] - p[1] * x[1]}
        return Ode.of(name, states, parameters, (t, x, p), rates, {"e": x[0]})


FACTORS = (
    Factor("stiffness", ("stiffness",), Uniform(2.0, 6.0)),
    Factor("damping", ("damping",), Uniform(0.2, 0.8)),
)
RUN = Run(Spring(), (rmse(),), until=20.0, h=1e-3)

study = Study(
    name="small_study",
    title="A study to be killed",
    question=__doc__.split("Question  ")[1].split("Method")[0],
    method=__doc__.split("Method    ")[1],
    sections=lambda results: [Section("Runs", (Paragraph(results.sample("spring").note),))],
    sweeps=(Sweep("spring", RUN, FACTORS, MonteCarlo(2, 20 * 256), runs_of_chunk=256),),
)
