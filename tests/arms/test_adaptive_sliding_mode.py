"""Gains that learn, against a hand-written loop: growth, dead zone and leakage."""

import casadi as ca
import numpy as np
import pytest

from tests.support.oracles import adaptive_sliding_mode, closed_loop, integrate, worst_difference
from workbench.arms.laws import AdaptiveSlidingMode, DeadZoneAdaptation, LeakageAdaptation, PlainAdaptation
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4, with_quadrature
from workbench.engine import simulate

LAW = {"model": paper_arm(), "Lambda": [6.0, 5.0], "phi": 0.1, "gamma": 3.0, "K": [1.0, 0.5]}
FORMS = {
    "plain": PlainAdaptation(),
    "dead_zone": DeadZoneAdaptation(width=0.8),
    "leakage": LeakageAdaptation(sigma=0.7, level=[1.0, 0.5]),
}


def loop(**changes):
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=[0.6, -0.8],
            disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]),
        ),
        observer=ArmFullState(2),
        controller=AdaptiveSlidingMode(**(LAW | changes)),
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


@pytest.mark.parametrize("kind", ["clip", "tanh"])
@pytest.mark.parametrize("form", FORMS)
def test_the_loop_is_the_one_written_by_hand(form, kind):
    ode = loop(adaptation=FORMS[form], saturation=kind).ode()
    rates = closed_loop(adaptive_sliding_mode(kind, form))
    assert worst_difference(ode, rates, np.random.default_rng(4)) < 1e-12  # rounding


@pytest.mark.parametrize("form", ["plain", "leakage"])
def test_the_motion_is_that_of_another_integrator(form):
    """Over a time in which no component of s changes its sign: |s| is smooth there."""
    ode = loop(adaptation=FORMS[form], saturation="tanh", phi=5.0).ode()
    run = simulate(rk4(ode, 1e-4), until=0.3, every=1e-3)
    assert (np.sign(run["s"][0]) == np.sign(run["s"][0, 0])).all()
    theirs = integrate(ode, closed_loop(adaptive_sliding_mode("tanh", form)), 0.3)
    np.testing.assert_allclose(run.x[0, -1], theirs, rtol=0, atol=1e-10)  # (h lambda)^4 of RK4


def test_the_plain_gain_never_falls():
    K = simulate(rk4(loop().ode(), 5e-4), until=8.0, every=5e-3)["controller.K"][0]
    assert (np.diff(K, axis=0) >= 0).all()


def test_the_plain_gain_grows_by_gamma_times_the_integral_of_the_size_of_s():
    ode = loop().ode()
    ode = with_quadrature(ode, {"area": ca.fabs(ode.output[ode.outputs.slice("s")])})
    run = simulate(rk4(ode, 5e-4), until=4.0, every=4.0)
    grown = run["controller.K"][0, -1] - np.array([1.0, 0.5])
    np.testing.assert_allclose(grown, 3.0 * run["area"][0, -1], rtol=1e-12)  # the same sums


def test_with_a_layer_the_plain_gain_keeps_growing_and_the_dead_zone_stops_it():
    gains = {
        name: simulate(rk4(loop(adaptation=form).ode(), 5e-4), until=16.0, every=2.0)["controller.K"][0]
        for name, form in {"plain": PlainAdaptation(), "dead zone": DeadZoneAdaptation(width=0.1)}.items()
    }
    assert (gains["plain"][-1] - gains["plain"][-3] > 0.05).all()
    np.testing.assert_array_equal(gains["dead zone"][-1], gains["dead zone"][-3])


def test_the_leaking_gain_stays_below_its_bound():
    """K_i <= level_i + gamma c / sigma for |s_i| <= c."""
    run = simulate(rk4(loop(adaptation=FORMS["leakage"]).ode(), 5e-4), until=8.0, every=5e-3)
    c = np.abs(run["s"][0]).max(axis=0)
    assert (run["controller.K"][0] <= np.array([1.0, 0.5]) + 3.0 * c / 0.7).all()


def test_the_leaking_gain_returns_to_its_level():
    run = simulate(rk4(loop(adaptation=FORMS["leakage"]).ode(), 5e-4), until=20.0, every=5e-3)
    K, s = run["controller.K"][0], np.abs(run["s"][0])
    late = run.t > 15.0
    # what s was before t = 5 s has decayed by e^(-0.7 * 10)
    bound = np.array([1.0, 0.5]) + 3.0 * s[run.t > 5.0].max(axis=0) / 0.7 + K.max(axis=0) * np.exp(-0.7 * 10)
    assert (K[late] <= bound).all()


def test_gains_that_start_below_zero_are_refused():
    with pytest.raises(ValueError, match=r"`AdaptiveSlidingMode\(K=...\)` must not be negative.*Got \[ 1., -2.\]"):
        AdaptiveSlidingMode(**(LAW | {"K": [1.0, -2.0]}))


def test_a_leak_to_a_level_of_another_number_of_joints_is_refused():
    with pytest.raises(ValueError, match="one number for each of the 2 gains it leaks to; got 3"):
        AdaptiveSlidingMode(**LAW, adaptation=LeakageAdaptation(sigma=1.0, level=[0.0, 0.0, 0.0]))


def test_a_dead_zone_without_width_is_refused():
    with pytest.raises(ValueError, match=r"`DeadZoneAdaptation\(width=...\)` must be finite, with 0 < value"):
        DeadZoneAdaptation(width=0.0)
