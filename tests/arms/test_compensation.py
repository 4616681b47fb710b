"""A law with the estimated disturbance on top: its equation, its parts, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.oracles import (
    adaptive_sliding_mode,
    closed_loop,
    momentum_observer,
    pid,
    super_twisting,
    with_disturbance,
    worst_difference,
)
from workbench.arms.laws import (
    AdaptiveSlidingMode,
    AosmcRgs,
    ArmPID,
    DisturbanceCompensation,
    SlidingMode,
    SuperTwisting,
)
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState, Luenberger, MomentumObserver, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.core.claim import claims_of
from workbench.engine import simulate
from workbench.proofs.falsify import Budget, RunSearch

ARM, I = paper_arm(), np.eye(2)
SMC = SlidingMode(ARM, Lambda=6.0, K=5.0, phi=0.5)
LAWS = {
    "PID": (ArmPID([60.0, 30.0], [20.0, 15.0], [15.0, 6.0], ARM), pid(gravity=True)),
    "ASMC": (AdaptiveSlidingMode(ARM, Lambda=6.0, phi=0.5, gamma=5.0, K=5.0), adaptive_sliding_mode()),
    "super-twisting": (SuperTwisting(ARM, Lambda=6.0, k1=8.0, k2=20.0, phi=0.5), super_twisting()),
}


def loop(law, observer=None, reference=None, push=(0.5, 0.4), frequency=(3.0, 4.0)):
    return ClosedLoop(
        Manipulator(ARM, q=[0.6, -0.8], disturbance=SineTorque(push, frequency, [0.3, np.pi / 2])),
        observer or StateAndDisturbanceObserver(ArmFullState(2), MomentumObserver(ARM, 20.0)),
        law,
        reference or Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )


def compensated(law):
    """The same by hand, with the names of the law below `law.`."""

    def whole(p, z, q, qd, d, ref):
        inner = [{k.replace("controller.law.", "controller."): part for k, part in parts.items()} for parts in (p, z)]
        tau, rates = law(*inner, q, qd, d, ref)
        return tau + d, {k.replace("controller.", "controller.law."): rate for k, rate in rates.items()}

    return whole


@pytest.mark.parametrize("name", LAWS)
def test_the_loop_is_the_one_written_by_hand(name):
    law, by_hand = LAWS[name]
    rates = closed_loop(compensated(by_hand), with_disturbance(momentum_observer))
    assert (
        worst_difference(loop(DisturbanceCompensation(law)).ode(), rates, np.random.default_rng(53)) < 1e-12
    )  # rounding


def test_beside_an_observer_that_knows_no_disturbance_the_law_is_alone():
    runs = [
        simulate(rk4(loop(law, ArmFullState(2)).ode(), 1e-3), until=1.0) for law in (SMC, DisturbanceCompensation(SMC))
    ]
    np.testing.assert_array_equal(runs[0]["tau"], runs[1]["tau"])


def test_a_constant_push_leaves_no_error_where_the_law_alone_keeps_one():
    """In the layer of SMC K s / phi balances what is not compensated; D_hat = D leaves nothing to balance."""
    at_rest = {
        name: simulate(
            rk4(
                loop(law, reference=Constant("q", "rad", [0.6, -0.8]), push=(1.5, -1.0), frequency=(0.0, 0.0)).ode(),
                1e-3,
            ),
            until=20.0,
        )["e"][0, -1]
        for name, law in {"alone": SMC, "compensated": DisturbanceCompensation(SMC)}.items()
    }
    D = np.array([1.5, -1.0]) * np.sin([0.3, np.pi / 2])
    np.testing.assert_allclose(at_rest["alone"], -D * 0.5 / 5.0 / 6.0, rtol=1e-6)  # all modes have decayed
    np.testing.assert_allclose(at_rest["compensated"], 0, atol=1e-9)


def test_a_law_that_only_a_computer_can_run_is_told_the_period():
    """An implicit relay solves over the period of the loop, whether or not D_hat, here zero, is added."""
    relay = replace(SMC, saturation="implicit")
    runs = [
        simulate(loop(law, ArmFullState(2)).digital(1e-3).step(2), until=0.3)
        for law in (relay, DisturbanceCompensation(relay))
    ]
    np.testing.assert_array_equal(runs[0]["tau"], runs[1]["tau"])


def test_a_law_that_has_the_estimate_already_is_refused():
    aosmc = AosmcRgs(ARM, 6.0, 0.05, K=5 * I, P=10 * I, Q=I, R=I)
    for law in (aosmc, DisturbanceCompensation(SMC)):
        with pytest.raises(ValueError, match=rf"that of `{type(law).__name__}` has it: take the law as it is"):
            DisturbanceCompensation(law)


@pytest.mark.heavy
def test_what_the_law_promises_is_held_against_the_law_within():
    kept = loop(DisturbanceCompensation(LAWS["ASMC"][0]))
    promises = [said for said in claims_of(kept) if said.path == "controller.law."]
    assert [said.kind for said in promises] == ["AdaptiveSlidingMode"] * 2
    box = {"plant.q": (-2.0, 2.0), "plant.qd": (-2.0, 2.0)}
    for promise in promises:
        assert RunSearch(kept.ode(), promise, box, 0.5, 5e-4).search(1, Budget(16, 3, 0)).kind == "not refuted"


def test_it_is_made_of_the_compensation_and_of_the_parts_of_the_law():
    state = Luenberger(ARM, 30 * I, 50 * I, q_hat=[0.6, -0.8])
    parts = loop(
        DisturbanceCompensation(SMC), StateAndDisturbanceObserver(state, MomentumObserver(ARM, 20.0))
    ).ablations()
    assert set(parts) == {
        "disturbance compensation",
        "switching torque",
        "boundary layer",
        "disturbance estimate",
        "state observer",
    }
    assert parts["disturbance compensation"].controller is SMC
    assert parts["boundary layer"].controller.law.saturation == "sign"
