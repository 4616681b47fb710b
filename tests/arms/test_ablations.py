"""A loop less each of its parts: it runs, it is another one, and the part is gone from its equation."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

from tests.support.cases import heavy_but
from workbench.arms.laws import (
    AdaptiveSlidingMode,
    AosmcRgs,
    ArmPID,
    ArmStateFeedback,
    FuzzyAsmc,
    NonsingularTerminalSlidingMode,
    RbfAsmc,
    Rise,
    SlidingMode,
    SuperTwisting,
)
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState, Luenberger, MomentumObserver, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

ARM, I = paper_arm(), np.eye(2)
SURFACE = {"model": ARM, "Lambda": 6.0, "phi": 0.5}
LEARNING = SURFACE | {"gamma": 5.0, "K": [5.0, 4.0]}
LAWS = {
    "PID": ArmPID([9.0, 8.0], [3.0, 2.0], [4.0, 3.0], ARM),
    "SMC": SlidingMode(**SURFACE, K=5.0),
    "ASMC": AdaptiveSlidingMode(**LEARNING),
    "Fuzzy-ASMC": FuzzyAsmc(**LEARNING, lag=0.02),
    "RBF-ASMC": RbfAsmc(**LEARNING, Gamma=5.0, sigma=0.1, centres=[[0.0] * 4, [1.0] * 4], widths=[1.0] * 4),
    "super-twisting": SuperTwisting(**SURFACE, k1=8.0, k2=15.0),
    "RISE": Rise(6.0 * np.ones(2), 4.0, 20.0, 8.0, 0.5, model=ARM),
    "NTSMC": NonsingularTerminalSlidingMode(ARM, 4.0, 1.5, 10.0, 15.0, 0.5, 0.1),
    "AOSMC-RGS": AosmcRgs(**SURFACE, K=5 * I, P=2 * I, Q=I, R=I, velocity="reference", gain_sign="raised"),
}
PARTS = {
    "PID": {"integral action", "derivative action", "gravity compensation"},
    "SMC": {"switching torque", "boundary layer"},
    "ASMC": {"adaptation", "boundary layer"},
    "Fuzzy-ASMC": {"fuzzy rules", "adaptation", "boundary layer"},
    "RBF-ASMC": {"network", "adaptation", "boundary layer"},
    "super-twisting": {"integral part", "root part", "boundary layer"},
    "RISE": {"integral of the sign", "boundary layer", "feedforward"},
    "NTSMC": {"linear reaching", "switched reaching", "boundary layer"},
    "AOSMC-RGS": {"adaptation of K", "Riccati equation", "model in the torque", "boundary layer"},
}
OBSERVER = StateAndDisturbanceObserver(
    Luenberger(ARM, 30 * I, 50 * I, q_hat=[0.1, 0.0], disturbance="compensated"), MomentumObserver(ARM, 10.0)
)
# what of the memory is gone, or stands still, without a part
STATES = {
    ("ASMC", "adaptation"): {"controller.K"},
    ("Fuzzy-ASMC", "fuzzy rules"): {"controller.s_slow"},
    ("Fuzzy-ASMC", "adaptation"): {"controller.K", "controller.s_slow"},
    ("RBF-ASMC", "network"): {"controller.W"},
    ("RBF-ASMC", "adaptation"): {"controller.K"},
    ("super-twisting", "integral part"): {"controller.w"},
    ("AOSMC-RGS", "adaptation of K"): {"controller.K", "controller.P"},
    ("AOSMC-RGS", "Riccati equation"): {"controller.P"},
    ("AOSMC-RGS", "state observer"): {"observer.state.q_hat", "observer.state.qd_hat"},
    ("AOSMC-RGS", "disturbance estimate"): {"observer.disturbance.p_hat"},
}


@cache
def loop(law: str) -> ClosedLoop:
    plant = Manipulator(ARM, q=[0.6, -0.8], disturbance=SineTorque([0.5, 0.4], [3.0, 4.0]))
    observer = OBSERVER if law == "AOSMC-RGS" else ArmFullState(2)
    return ClosedLoop(plant, observer, LAWS[law], Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]))


def moving(closed: ClosedLoop) -> set[str]:
    """The states of a loop that ever move."""
    ode = closed.ode()
    rates = ode.f(ca.SX.sym("t"), ode.states.symbols(), ca.DM(ode.parameters.default))
    still = [name for name in ode.states.names if all(rates[i].is_zero() for i in ode.states.indices(name))]
    return set(ode.states.names) - set(still)


def said(closed: ClosedLoop) -> tuple[object, ...]:
    """The equation of a loop, and its numbers."""
    ode = closed.ode()
    return ode.fingerprint, *ode.parameters.default, *ode.states.default


def end(closed: ClosedLoop) -> np.ndarray:
    run = simulate(rk4(closed.ode(), 1e-3), until=0.2, every=0.2, arithmetic="casadi")  # which compiles nothing
    assert np.isnan(run.diverged_at).all()
    return run["e"][0, -1]


@pytest.mark.parametrize("law", heavy_but(LAWS, "PID", "SMC", "super-twisting"))
def test_a_loop_less_a_part_is_another_one(law):
    whole = loop(law)
    found = whole.ablations()
    expected = {"state observer", "disturbance estimate"} if law == "AOSMC-RGS" else set()
    assert set(found) == PARTS[law] | expected
    its_own = said(whole)
    for part, less in found.items():
        assert said(less) != its_own, part


@pytest.mark.parametrize("law", [pytest.param("AOSMC-RGS", marks=pytest.mark.heavy), "PID"])
def test_a_law_runs_less_any_of_its_parts_and_goes_elsewhere(law):
    whole = end(loop(law))
    for less in loop(law).ablations().values():
        assert np.abs(end(less) - whole).max() > 1e-6  # far beyond the error of the step


@pytest.mark.parametrize(("law", "part"), STATES)
def test_what_a_part_remembers_is_gone_without_it(law, part):
    whole = loop(law)
    assert STATES[law, part] <= moving(whole)
    assert not STATES[law, part] & moving(whole.ablations()[part])


@pytest.mark.heavy
def test_a_law_without_its_adaptation_is_the_law_it_is_built_on():
    smc = replace(loop("SMC"), controller=SlidingMode(**SURFACE, K=[5.0, 4.0]))
    for law in ("ASMC", "Fuzzy-ASMC"):
        np.testing.assert_array_equal(end(loop(law).ablations()["adaptation"]), end(smc))
    np.testing.assert_array_equal(end(loop("RBF-ASMC").ablations()["network"]), end(loop("ASMC")))


def test_an_ablated_law_is_not_ablated_of_the_same_part_again():
    for law in LAWS:
        for part, less in loop(law).ablations().items():
            if part in ("boundary layer", "adaptation of K", "Riccati equation", "integral action", "state observer"):
                assert part not in less.ablations()


def test_a_law_of_one_piece_has_no_ablations():
    assert replace(loop("SMC"), controller=ArmStateFeedback(ARM, 9 * I, 4 * I)).ablations() == {}


def test_without_its_model_the_torque_is_the_switching_part_and_the_estimate():
    law = LAWS["AOSMC-RGS"].without()["model in the torque"]
    ode = replace(loop("AOSMC-RGS"), controller=law).ode()
    x = np.random.default_rng(1).uniform(-1, 1, ode.states.size)
    y, z = ode.outputs_at(0.3, x), ode.states.unpack(x)
    d_hat = y["d"] - y["d_error"]
    np.testing.assert_allclose(y["tau"], d_hat - z["controller.K"] @ np.clip(y["s"] / 0.5, -1, 1), atol=1e-12)


def test_one_name_for_two_parts_is_refused(monkeypatch):
    monkeypatch.setattr(type(OBSERVER), "without", lambda self: {"boundary layer": ArmFullState(2)})
    with pytest.raises(ValueError, match="both have 'boundary layer'"):
        loop("AOSMC-RGS").ablations()
