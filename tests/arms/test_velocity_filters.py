"""Filters of the velocity: their error equations, in continuous time and in a computer, and what they read."""

import numpy as np
import pytest

from tests.support.arms import arm_instruments
from tests.support.oracles import closed_loop, pid, sliding_mode, with_disturbance, worst_difference
from tests.support.oracles import momentum_observer as momentum_by_hand
from workbench.arms.laws import ArmPID, SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import (
    ArmFullState,
    DirtyDerivative,
    MomentumObserver,
    StateAndDisturbanceObserver,
    VelocityFilter,
)
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.core.claim import claims_of
from workbench.engine import simulate
from workbench.proofs.falsify import Budget, RunSearch

ARM = paper_arm()
FILTERS = {"velocity": VelocityFilter(2, 60.0), "positions": DirtyDerivative(2, 60.0, [0.6, -0.8])}


def velocity_filter(p, z, q, qd, D):
    qd_hat = z["observer.qd_hat"]
    return (q, qd_hat, np.zeros(2)), lambda tau: {"observer.qd_hat": p["observer.omega"] * (qd - qd_hat)}


def dirty_derivative(p, z, q, qd, D):
    qd_hat = p["observer.omega"] * (q - z["observer.q_hat"])
    return (q, qd_hat, np.zeros(2)), lambda tau: {"observer.q_hat": qd_hat}


BY_HAND = {"velocity": velocity_filter, "positions": dirty_derivative}


def loop(observer, law=None, reference=None, push=(0.5, 0.4)):
    return ClosedLoop(
        Manipulator(ARM, q=[0.6, -0.8], disturbance=SineTorque(push, [3.0, 4.0], [0.0, np.pi / 2])),
        observer,
        law or ArmPID([60.0, 30.0], [20.0, 15.0], [15.0, 6.0], ARM),
        reference or Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )


@pytest.mark.parametrize("name", FILTERS)
def test_the_loop_is_the_one_written_by_hand(name):
    rates = closed_loop(pid(gravity=True), BY_HAND[name])
    assert worst_difference(loop(FILTERS[name]).ode(), rates, np.random.default_rng(51)) < 1e-12  # rounding


@pytest.mark.parametrize("name", FILTERS)
def test_beside_an_observer_of_the_disturbance_the_loop_is_the_one_written_by_hand(name):
    def both(p, z, q, qd, D):
        state = {key.replace("observer.state.", "observer."): part for key, part in z.items()}
        omega = {"observer.omega": p["observer.state.omega"]}
        (q_hat, qd_hat, _), rates = BY_HAND[name](omega, state, q, qd, D)
        (_, _, d), d_rates = with_disturbance(momentum_by_hand)(p, z, q_hat, qd_hat, D)
        return (
            (q_hat, qd_hat, d),
            lambda tau: (
                {key.replace("observer.", "observer.state."): part for key, part in rates(tau).items()} | d_rates(tau)
            ),
        )

    law = SlidingMode(ARM, Lambda=[6.0, 5.0], K=[4.0, 3.0], phi=0.5)
    ode = loop(StateAndDisturbanceObserver(FILTERS[name], MomentumObserver(ARM, 20.0)), law).ode()
    assert worst_difference(ode, closed_loop(sliding_mode(), both), np.random.default_rng(52)) < 1e-12  # rounding


@pytest.mark.parametrize("name", FILTERS)
def test_no_run_breaks_what_a_filter_promises(name):
    kept = loop(FILTERS[name])
    promise = next(said for said in claims_of(kept) if said.path == "observer.")
    box = {"plant.q": (-2.0, 2.0), "plant.qd": (-2.0, 2.0)}
    assert RunSearch(kept.ode(), promise, box, 0.5, 5e-4).search(1, Budget(16, 3, 0)).kind == "not refuted"


def test_both_filters_of_one_cut_off_make_the_same_estimate():
    """Their errors obey one equation; from qd = 0, with the first reading in the filter, they start alike too."""
    runs = [simulate(rk4(loop(FILTERS[name]).ode(), 1e-4), until=1.0, every=1e-2) for name in FILTERS]
    np.testing.assert_allclose(runs[0]["qd_error"], runs[1]["qd_error"], rtol=0, atol=1e-9)  # of RK4


def test_in_a_computer_the_derivative_at_one_over_the_period_is_the_difference_of_two_readings():
    run = simulate(loop(DirtyDerivative(2, 1000.0, [0.6, -0.8])).digital(1e-3).step(2), until=0.2)
    estimate = (run["qd"] - run["qd_error"])[0]
    difference = np.diff(run["q"][0], axis=0) / 1e-3
    np.testing.assert_allclose(estimate[1:-1], difference[:-1], rtol=0, atol=1e-9)  # rounding of q, over h


def test_noise_of_the_velocity_passes_with_its_share_of_the_variance():
    """tanh(omega h / 2), for an arm that hangs still whatever the law is told."""
    law = ArmPID([0.0, 0.0], [0.0, 0.0], [0.0, 0.0])
    still = ClosedLoop(Manipulator(ARM, q=[0.0, 0.0]), VelocityFilter(2, 100.0), law, Constant("q", "rad", [0.0, 0.0]))
    run = simulate(still.digital(1e-3, instruments=arm_instruments(2, noise_qd=0.01)).step(2), until=20.0, seed=3)
    filtered = run["qd_error"][0, 1000:]
    # of 38,000 samples, correlated over 1 / (omega h) = 10, the variance is known to some 2.5 %
    np.testing.assert_allclose(filtered.var() / 1e-4, np.tanh(0.05), rtol=0.1)


@pytest.mark.parametrize(("omega", "lost"), [(1900.0, False), (2100.0, True)])
def test_in_a_computer_the_derivative_is_stable_up_to_two_over_the_period(omega, lost):
    law = ArmPID([0.0, 0.0], [0.0, 0.0], [0.0, 0.0])  # the estimate drives nothing
    still = ClosedLoop(
        Manipulator(ARM, q=[0.3, 0.1]), DirtyDerivative(2, omega, [0.1, 0.0]), law, Constant("q", "rad", [0.0, 0.0])
    )
    run = simulate(still.digital(1e-3).step(2), until=1.0)
    assert (np.abs(run["qd_error"][0, -1]).max() > 1e3) == lost


@pytest.mark.parametrize("omega", [50.0, 5000.0])
def test_in_a_computer_the_filter_forgets_at_its_own_rate_whatever_the_period(omega):
    """exp(-omega h) a period, of an arm that stands still: also where explicit Euler would not be stable."""
    law = ArmPID([0.0, 0.0], [0.0, 0.0], [0.0, 0.0])
    still = ClosedLoop(
        Manipulator(ARM, q=[0.0, 0.0]), VelocityFilter(2, omega, [1.0, -2.0]), law, Constant("q", "rad", [0.0, 0.0])
    )
    run = simulate(still.digital(4e-3).step(2), until=0.04)
    there = -run["qd_error"][0, 1:]  # held from this instant on
    expected = np.array([1.0, -2.0]) * np.exp(-omega * 4e-3 * np.arange(1, 1 + len(there)))[:, None]
    np.testing.assert_allclose(there, expected, rtol=0, atol=1e-12)  # rounding


@pytest.mark.parametrize("kind", [VelocityFilter, DirtyDerivative])
def test_a_filter_without_joints_or_cut_off_is_refused(kind):
    with pytest.raises(ValueError, match=rf"`{kind.__name__}\(omega=...\)` must be finite, with 0 < value"):
        kind(2, 0.0, [0.0, 0.0])
    with pytest.raises(ValueError, match="needs at least one number"):
        kind(0, 1.0, 0.0)
    with pytest.raises(ValueError, match=rf"`{kind.__name__}\(joints=...\)` must be a whole number of joints from 1"):
        kind(2000, 1.0, 0.0)


@pytest.mark.parametrize("name", FILTERS)
def test_without_its_filter_a_loop_has_the_velocity_as_it_is_measured(name):
    less = loop(StateAndDisturbanceObserver(FILTERS[name], MomentumObserver(ARM, 20.0))).ablations()["velocity filter"]
    assert isinstance(less.observer.state, ArmFullState)
