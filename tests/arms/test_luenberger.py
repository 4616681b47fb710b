"""The paper's observer (10) against a hand-written loop, and where a disturbance that it ignores takes it."""

import numpy as np
import pytest

from tests.support.oracles import (
    closed_loop,
    integrate,
    luenberger,
    matrices,
    oracle_filter,
    pid,
    with_disturbance,
    worst_difference,
)
from workbench.arms.laws import ArmPID
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import Luenberger, OracleFilter, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

L1, L2 = np.array([[30.0, 1.0], [0.5, 28.0]]), np.array([[400.0, 5.0], [3.0, 380.0]])


def loop(d=(0.5, 0.4), frequency=(3.0, 4.0), reference=None, compensated=None):
    """With the paper's disturbance unless told otherwise; `compensated` takes (10) beside an oracle of D."""
    state = Luenberger(
        paper_arm(), L1=L1, L2=L2, q_hat=[0.5, -0.9], disturbance="compensated" if compensated else "ignored"
    )
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=[0.6, -0.8],
            disturbance=SineTorque(amplitude=d, frequency=frequency, phase=[np.pi / 2, np.pi / 2]),
        ),
        observer=state if compensated is None else StateAndDisturbanceObserver(state, OracleFilter(2, l=20.0)),
        controller=ArmPID(Kp=[60.0, 30.0], Ki=[20.0, 15.0], Kd=[15.0, 6.0], model=paper_arm()),
        reference=reference or Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


@pytest.mark.parametrize(
    ("compensated", "by_hand"),
    [
        (None, luenberger),
        (False, with_disturbance(oracle_filter, "luenberger")),
        (True, with_disturbance(oracle_filter, "luenberger", compensated=True)),
    ],
    ids=["alone", "ignored", "compensated"],
)
def test_the_loop_is_the_one_written_by_hand(compensated, by_hand):
    rates = closed_loop(pid(gravity=True), by_hand)
    assert worst_difference(loop(compensated=compensated).ode(), rates, np.random.default_rng(18)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    ode = loop().ode()
    ours = simulate(rk4(ode, 5e-5), until=0.5, every=0.5).x[0, -1]
    # RK4 at 0.05 ms on modes of about 60 1/s: (h lambda)^4 is 1e-10, and the error a fraction of it
    np.testing.assert_allclose(
        ours, integrate(ode, closed_loop(pid(gravity=True), luenberger), 0.5), rtol=0, atol=1e-10
    )


def test_it_sees_positions_only():
    """The observer's rates, and through them the torque, do not depend on the true velocity."""
    ode = loop().ode()
    A = np.array(ode.A(0.3, np.random.default_rng(19).uniform(-1, 1, ode.states.size), ode.parameters.default))
    rows = [*ode.states.indices("observer.q_hat"), *ode.states.indices("observer.qd_hat")]
    np.testing.assert_array_equal(A[np.ix_(rows, ode.states.indices("plant.qd"))], 0)


def test_without_a_disturbance_the_estimates_become_the_state():
    run = simulate(rk4(loop(d=(0.0, 0.0)).ode(), 1e-3), until=4.0, every=0.1)
    np.testing.assert_allclose(run["q_error"][0, -1], 0, atol=1e-8)
    np.testing.assert_allclose(run["qd_error"][0, -1], 0, atol=1e-7)


@pytest.mark.parametrize("compensated", [False, True])
def test_a_constant_disturbance_biases_the_observer_that_ignores_it(compensated):
    """At rest tau = G(q) + D, and L2 (q - q_hat) must make up for M^-1 (tau - C qd_hat - G(q_hat)) at the bias."""
    ode = loop(
        d=(1.5, -1.0), frequency=(0.0, 0.0), reference=Constant("q", "rad", [0.6, -0.8]), compensated=compensated
    ).ode()
    run = simulate(rk4(ode, 1e-3), until=60.0, every=1.0)
    np.testing.assert_allclose(ode.rate_at(60.0, run.x[0, -1])[:2], 0, atol=1e-8)  # at rest
    q_error = run["q_error"][0, -1]
    if compensated:
        np.testing.assert_allclose(q_error, 0, atol=1e-8)
        return
    z = ode.states.unpack(run.x[0, -1])
    q, q_hat, qd_hat = z["plant.q"], z["observer.state.q_hat"], z["observer.state.qd_hat"]
    p = ode.parameters.unpack(ode.parameters.default)
    M, C, G = matrices(p, "plant.arm", q_hat, qd_hat)
    tau = matrices(p, "plant.arm", q, 0 * q)[2] + [1.5, -1.0]
    np.testing.assert_allclose(qd_hat, -L1 @ q_error, atol=1e-7)
    np.testing.assert_allclose(np.linalg.solve(M, tau - C @ qd_hat - G), -L2 @ q_error, atol=1e-6)
    assert np.abs(q_error).max() > 1e-3


def test_gains_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"`Luenberger\(L1=...\)` must be an array of shape \(n = 2, n = 2\)"):
        Luenberger(paper_arm(), L1=[30.0, 30.0], L2=L2, q_hat=[0.0, 0.0])


def test_a_start_for_another_number_of_joints_is_refused():
    with pytest.raises(ValueError, match=r"`Luenberger\(q_hat=...\)` must be an array of shape \(n = 2\)"):
        Luenberger(paper_arm(), L1=L1, L2=L2, q_hat=[0.0, 0.0, 0.0])


def test_a_misspelt_reading_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="Did you mean 'compensated'"):
        Luenberger(paper_arm(), L1=L1, L2=L2, q_hat=[0.0, 0.0], disturbance="compensate")
