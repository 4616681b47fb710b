"""What laws and observers promise: kept along their own runs, and broken by runs that ought to break them."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from workbench.arms.laws import AdaptiveSlidingMode, AosmcRgs, SlidingMode, SuperTwisting
from workbench.arms.laws.aosmc_rgs import K_STAYS_DEFINITE, P_STAYS_DEFINITE
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import (
    ArmFullState,
    Luenberger,
    MomentumObserver,
    NonlinearDisturbanceObserver,
    OracleFilter,
    PrintedFilter,
    StateAndDisturbanceObserver,
)
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import Claim
from workbench.core.claim import BlockClaim, claims_of
from workbench.engine.metrics import measure
from workbench.proofs.claim_margins import violation, with_violations
from workbench.proofs.falsify import Budget, RunSearch

ARM = paper_arm()
PLANT = Manipulator(ARM, q=[0.5, -0.5], disturbance=SineTorque([0.5, 0.4], [3.0, 4.0]))
REFERENCE = Sines("q", "rad", [1.0, 0.5], [2.0, 3.0])
SMC = SlidingMode(ARM, Lambda=6.0, K=5.0, phi=0.05)
I = np.eye(2)
BOX = {"plant.q": (-2.0, 2.0), "plant.qd": (-2.0, 2.0)}


def loop(law=SMC, observer=None) -> ClosedLoop:
    return ClosedLoop(PLANT, observer or ArmFullState(2), law, REFERENCE)


def aosmc(**changes) -> AosmcRgs:
    law = AosmcRgs(ARM, 6.0, 0.05, K=5 * I, P=10 * I, Q=I, R=I, velocity="reference")
    return replace(law, **changes)


def beside(disturbance) -> ClosedLoop:
    return loop(observer=StateAndDisturbanceObserver(ArmFullState(2), disturbance))


def sought(kept: ClosedLoop, claim: BlockClaim | None = None, until: float = 1.0):
    promise = claim or claims_of(kept)[-1]
    return RunSearch(kept.ode(), promise, BOX, until, 5e-4).search(1, Budget(16, 3, 0))


@pytest.mark.parametrize(
    "kept",
    [
        loop(SMC),
        pytest.param(loop(AdaptiveSlidingMode(ARM, Lambda=6.0, phi=0.05, gamma=5.0, K=5.0)), marks=pytest.mark.heavy),
        pytest.param(loop(SuperTwisting(ARM, Lambda=6.0, k1=10.0, k2=15.0, phi=0.05)), marks=pytest.mark.heavy),
    ],
    ids=["SMC", "ASMC", "super-twisting"],
)
def test_no_run_breaks_what_a_law_promises(kept):
    for promise in claims_of(kept):
        found = sought(kept, promise)
        assert found.kind == "not refuted", promise.claim.name
        assert found.admissible_runs == found.runs


@pytest.mark.parametrize(
    "observer",
    [
        pytest.param(OracleFilter(2, l=20.0), marks=pytest.mark.heavy),
        MomentumObserver(ARM, l=20.0),
        pytest.param(NonlinearDisturbanceObserver(ARM, l=20.0), marks=pytest.mark.heavy),
    ],
    ids=["oracle", "momentum", "nonlinear"],
)
def test_no_run_breaks_what_an_observer_of_the_disturbance_promises(observer):
    kept = beside(observer)
    promise = next(said for said in claims_of(kept) if said.path == "observer.disturbance.")
    assert sought(kept, promise).kind == "not refuted"


def test_the_printed_filter_breaks_its_promise():
    kept = beside(PrintedFilter(2, l=20.0))
    promise = next(said for said in claims_of(kept) if said.path == "observer.disturbance.")
    assert sought(kept, promise).kind == "refuted"


@pytest.mark.heavy
def test_a_wrong_model_breaks_the_promise_of_the_momentum_observer():
    heavy = replace(ARM, gravity=2 * ARM.gravity)
    kept = beside(MomentumObserver(heavy, l=20.0))
    promise = next(said for said in claims_of(kept) if said.path == "observer.disturbance.")
    assert sought(kept, promise).kind == "refuted"


def test_a_promise_on_exact_estimates_says_nothing_beside_an_observer_in_error():
    kept = loop(observer=Luenberger(ARM, 30 * I, 50 * I, [1.0, 1.0]))
    promise = next(said for said in claims_of(kept) if said.kind == "SlidingMode")
    assert sought(kept, promise).kind == "not checkable"


def test_a_promise_that_asks_too_much_is_broken():
    faster = Claim("too fast", "e falls at twice the rate", "nobody", (), lambda y: _pull(y, 12.0))
    assert sought(loop(), BlockClaim(faster, "controller.")).kind == "refuted"


def _pull(y, rate: float) -> ca.SX:
    return ca.fabs(y["e"]) * ca.fabs(y["s"]) - rate * y["e"] ** 2 - y["e"] * y["e'"]


@pytest.mark.parametrize(("sign", "lost"), [("printed", True), ("raised", False)])
def test_the_gain_of_the_paper_s_law_is_lost_with_its_minus_sign(sign, lost):
    ode = loop(aosmc(gain_sign=sign, gain_shape="norm", riccati="frozen", Q=None, R=None, P=200 * I)).ode()
    gains = [BlockClaim(claim, "controller.") for claim in (K_STAYS_DEFINITE, P_STAYS_DEFINITE)]
    metrics = [violation(said.claim) for said in gains]
    found = measure(with_violations(ode, gains), metrics, until=1.0, h=5e-5)
    K, P = (max(score.value[0] for score in found.scores_of(metric.name)) for metric in metrics)
    assert (K > 0) == lost
    assert P < 0
