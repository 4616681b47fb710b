"""Causes of divergence: the integrator's of a stiff law, the law's own, and what cannot be told."""

from dataclasses import dataclass

import numpy as np
import pytest

from tests.support.arms import arm_instruments
from workbench.arms.laws import AosmcRgs, ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import AbstractController, ClosedLoop
from workbench.blocks.signals import Constant
from workbench.engine.distributions import Uniform
from workbench.engine.factors import Factor
from workbench.engine.metrics import rmse
from workbench.study.case_runs import run
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.evidence.divergence_causes import Causes, causes, causes_in_sweep
from workbench.study.run_and_sweep import Run, Sweep
from workbench.study.study import Case, Study
from workbench.study.uncertainty import ListedPoints

ARM, I = paper_arm(), np.eye(2)
STIFF = {"Lambda": [6.0, 5.0], "phi": 0.05, "K": 107 * I, "P": 10 * I, "Q": 3 * I, "R": I}
PERIOD = 4e-3


@dataclass(frozen=True)
class Computed:
    """A law that a computer runs once in 4 ms, with its memory stepped in one way."""

    law: AbstractController
    integrator: str = "declared"

    def ode(self, name="loop"):
        closed = ClosedLoop(
            Manipulator(ARM, q=[0.6, -0.8]), ArmFullState(2), self.law, Constant("q", "rad", [0.5, -0.7])
        )
        return closed.digital(PERIOD, arm_instruments(2, noise_q=1e-5), integrator=self.integrator, name=name)


def ways_of(**changes):
    laws = {
        name: AosmcRgs(ARM, **STIFF | changes, velocity="reference", gain_sign="zero", integrator=name)
        for name in ("euler", "cayley")
    }
    return {name: Computed(law) for name, law in laws.items()} | {"fine": Computed(laws["euler"], "fine")}


def sampled(ways):
    return {name: way.ode(name) for name, way in ways.items()}


def test_what_a_stiff_riccati_equation_loses_by_euler_is_lost_by_the_integrator():
    ways = sampled(ways_of())
    found = causes(ways, ways["euler"].parameters.default[np.newaxis], until=0.4)
    assert {name: list(lost) for name, lost in found.diverges.items()} == {"euler": [1], "cayley": [0], "fine": [0]}
    assert found.sentence == "by the integrator: 1, by the law: 0"


def test_what_a_law_of_the_wrong_sign_loses_is_lost_by_the_law():
    law = ArmPID(Kp=[60.0, 40.0], Ki=[1.0, 1.0], Kd=[10.0, 8.0])
    ways = {"euler": Computed(law).ode(), "fine": Computed(law, "fine").ode()}
    p = ways["euler"].parameters.pack({"controller.Ki": [[1.0, 1.0], [1e9, 1e9]]})
    found = causes(ways, p, until=0.4)
    assert found.diverges["fine"].tolist() == [0, 1]
    assert (found.by_integrator, found.by_law, found.undecided_runs) == (1, 1, 0)


def test_a_run_that_fine_loses_and_another_way_keeps_is_unsettled():
    found = Causes({"fine": np.array([1, 1, 0]), "euler": np.array([1, 1, 1]), "cayley": np.array([0, 1, 0])})
    assert (found.by_integrator, found.by_law, found.undecided_runs) == (1, 1, 1)
    assert found.sentence == "by the integrator: 1, by the law: 1, unsettled: 1"


@pytest.mark.heavy
def test_lost_runs_of_a_sweep_are_run_again_from_their_own_rows():
    """K on its diagonal from 5 to 205 N m: Euler of (34) is lost above some 43 N m at 4 ms."""
    ways = ways_of(P=I)
    K = Factor("K", ("controller.K[0,0]", "controller.K[1,1]"), Uniform(5.0, 205.0))
    given = Sweep(
        "stiff", Run(ways["euler"], (rmse(),), 0.4, h=PERIOD / 2), (K,), ListedPoints(np.array([[0.0], [0.5], [1.0]]))
    )
    equations = sampled(ways)
    p, x0 = compile_sweep(given).rows(0, 3)
    x0 = x0[:, : equations["euler"].states.size]  # without those of the metrics
    lost = causes(equations, p, x0, until=0.4, substeps=2).diverges["euler"]
    assert lost.tolist() == [0, 1, 1]
    found = causes_in_sweep(given, np.flatnonzero(lost), ways)
    assert found.sentence == "by the integrator: 2, by the law: 0"
    assert found.diverges["euler"].tolist() == [1, 1]


def test_ways_without_fine_and_ways_of_another_loop_are_refused():
    ways = sampled(ways_of())
    p = ways["euler"].parameters.default[np.newaxis]
    with pytest.raises(LookupError, match=r"^`causes\(ways\)` needs the way 'fine'"):
        causes({"euler": ways["euler"]}, p, until=0.4)
    other = Computed(ArmPID(Kp=[60.0, 40.0], Ki=[1.0, 1.0], Kd=[10.0, 8.0])).ode()
    with pytest.raises(ValueError, match=r"^`causes\(ways\)` must hold one loop in several ways; 'euler' has other"):
        causes({"euler": other, "fine": ways["fine"]}, p, until=0.4)


def test_below_a_table_stands_the_method_of_each_memory():
    case = Case("S", "AOSMC-RGS", Run(ways_of(P=I)["cayley"], (rmse(),), 0.04, 0.04, PERIOD / 2))
    outcome = run(Study("s", "t", "q", "m", sections=lambda results: (), cases=(case,))).outcomes[0]
    assert "memory of the controller: K by explicit Euler, P by a Cayley step of (34)" in outcome.notes
    assert outcome.label == "AOSMC-RGS"  # the mark is for an observer that uses the truth
