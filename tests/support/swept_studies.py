"""A study with a sweep as a user's file, and what its ledger holds."""

import json

from workbench.study.ledger.store import FOLDER

SWEPT = """
import casadi as ca
import numpy as np
from workbench.core import Entry, Layout, Ode
from workbench.engine.metrics import iae, ise
from workbench.engine.distributions import Uniform
from workbench.study.document.document import Paragraph, Section
from workbench.engine.factors import Factor
from workbench.study.run_and_sweep import Run
from workbench.study.uncertainty import MonteCarlo
from workbench.study.study import Study
from workbench.study.run_and_sweep import Sweep

class Decay:
    def ode(self, name="loop"):
        states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("rate", np.array(1.0)),))
        t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
        return Ode.of(name, states, parameters, (t, x, p), {"x": -p * x}, {"e": x})

print("started", flush=True)
study = Study(
    name="swept", title="Swept", question="?", method="By running it.",
    sections=lambda results: [Section("Runs", (Paragraph(results.sample("decay").note),))],
    headlines=lambda results: [f"{len(results.sample('decay'))} runs."],
    sweeps=(Sweep(
        "decay", Run(Decay(), (iae(), ise()), until=2.0, h=0.01), (Factor("rate", ("rate",), Uniform(0.5, 3.0)),),
        MonteCarlo(1, 40, seed=3), runs_of_chunk=8,
    ),),
)
"""


def acknowledged(stdout):
    return {line.split()[1]: line.split()[2] for line in stdout.splitlines() if line.startswith("ACK ")}


def forget(out, *chunks):
    """Remove some chunks of the sweep, by their numbers."""
    for i in chunks:
        (file,) = (out / FOLDER).glob(f"decay.{8 * i}-*.record")
        file.unlink()


def digests(command, out="out"):
    done = command("results", out, "--digests")
    assert (done.exit_code, done.stderr) == (0, "")
    return json.loads(done.stdout)
