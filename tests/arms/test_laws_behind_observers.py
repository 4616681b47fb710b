"""Every law behind two observers, and every observer, in a computer with noisy readings: a law knows what they say."""

from functools import cache

import casadi as ca
import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.cases import heavy_but
from workbench.arms.laws import (
    AdaptiveSlidingMode,
    AosmcRgs,
    ArmPID,
    ArmStateFeedback,
    ComputedTorque,
    DisturbanceCompensation,
    FuzzyAsmc,
    NonsingularTerminalSlidingMode,
    RbfAsmc,
    Rise,
    SlidingMode,
    SuperTwisting,
)
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import (
    ArmFullState,
    DirtyDerivative,
    Luenberger,
    MomentumObserver,
    StateAndDisturbanceObserver,
    VelocityFilter,
)
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.engine import simulate

ARM, I, START, PERIOD = paper_arm(), np.eye(2), [0.6, -0.8], 1e-3
SURFACE = {"model": ARM, "Lambda": 6.0, "phi": 0.5}
LEARNING = SURFACE | {"gamma": 5.0, "K": [5.0, 4.0]}
ALONE = {
    "PID": ArmPID([60.0, 30.0], [20.0, 15.0], [15.0, 6.0]),
    "PID and gravity": ArmPID([60.0, 30.0], [20.0, 15.0], [15.0, 6.0], ARM),
    "feedforward and PD": ArmStateFeedback(ARM, 60 * I, 15 * I),
    "SMC": SlidingMode(**SURFACE, K=5.0),
    "ASMC": AdaptiveSlidingMode(**LEARNING),
    "Fuzzy-ASMC": FuzzyAsmc(**LEARNING, lag=0.02),
    "RBF-ASMC": RbfAsmc(**LEARNING, Gamma=5.0, sigma=0.1, centres=[[0.0] * 4, [1.0] * 4], widths=[1.0] * 4),
    "super-twisting": SuperTwisting(**SURFACE, k1=8.0, k2=15.0),
    "RISE": Rise([6.0, 6.0], 4.0, [40.0, 15.0], 8.0, 0.5, model=ARM),
    "NTSMC": NonsingularTerminalSlidingMode(ARM, 4.0, 1.5, 10.0, 15.0, 0.5, 0.1),
}
LAWS = (
    ALONE
    | {f"{name}, compensated": DisturbanceCompensation(law) for name, law in ALONE.items()}
    | {"computed torque": ComputedTorque(ARM, 64.0, 16.0)}
    | {"AOSMC-RGS": AosmcRgs(**SURFACE, K=5 * I, P=2 * I, Q=I, R=I, velocity="reference", gain_sign="raised")}
)
STATES = {
    "readings": ArmFullState(2),
    "velocity filter": VelocityFilter(2, 200.0),
    "dirty derivative": DirtyDerivative(2, 200.0, START),
    "Luenberger": Luenberger(ARM, 60 * I, 900 * I, q_hat=START),
}
OBSERVERS = STATES | {
    f"{name} and momentum": StateAndDisturbanceObserver(state, MomentumObserver(ARM, 20.0))
    for name, state in STATES.items()
}
INSTRUMENTS = arm_instruments(2, noise_q=1e-4, noise_qd=5e-3, limit=[100.0, 50.0])
INSTANT = ["readings", "readings and momentum"]  # where a reading of the velocity reaches the law at once
# Of all pairs a quarter: each law behind one observer of the state, by itself and with that of the disturbance, each
# observer for five or six laws. What leaks the true state is a law or an observer, whatever the other one is.
PLACES = {(law, observer): i + j for i, law in enumerate(LAWS) for j, observer in enumerate(OBSERVERS)}
LIGHT = [pair for pair, place in PLACES.items() if place % 8 == 0]
PAIRS = [pair for pair, place in PLACES.items() if place % 8 in (0, 4)]


@cache
def sampled(law, observer):
    plant = Manipulator(ARM, q=START, disturbance=SineTorque([0.5, 0.4], [3.0, 4.0]))
    loop = ClosedLoop(plant, OBSERVERS[observer], LAWS[law], Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]))
    return loop.digital(PERIOD, INSTRUMENTS)


@pytest.mark.parametrize(("law", "observer"), heavy_but(PAIRS, *LIGHT))
def test_a_law_runs_behind_an_observer(law, observer):
    loop = sampled(law, observer)
    x0 = np.tile(loop.states.default, (3, 1))
    run = simulate(loop.step(2), until=0.25, x0=x0, seed=4, every=0.01, arithmetic="casadi")  # compiles nothing
    assert np.isfinite(run.x).all()
    # noise, three draws of it, is the least that tells runs apart; from 0.8 rad none goes astray
    assert np.ptp(run["e"][:, -1], axis=0).min() > 0
    assert np.abs(run["e"]).max() < 1.5


@pytest.mark.parametrize(("law", "observer"), heavy_but(PAIRS, *LIGHT))
def test_the_torque_of_an_instant_depends_on_the_true_state_through_the_observer_alone(law, observer):
    """Behind the Luenberger observer on its memory only; behind a filter not on the velocity of that instant."""
    loop = sampled(law, observer)
    states = loop.states
    tau = loop.jump[list(states.indices("hold.tau"))]
    seen = {name: ca.depends_on(tau, loop.flow.x[list(states.indices(f"plant.{name}"))]) for name in ("q", "qd")}
    assert seen == {"q": not observer.startswith("Luenberger"), "qd": observer in INSTANT}
