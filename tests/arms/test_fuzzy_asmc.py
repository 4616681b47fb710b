"""The rule base in closed form, and the law whose learning it steers, against a hand-written loop."""

import casadi as ca
import numpy as np
import pytest

from tests.support.oracles import closed_loop, fuzzy_asmc, integrate, worst_difference
from workbench.arms.laws import (
    AdaptiveSlidingMode,
    DeadZoneAdaptation,
    FuzzyAsmc,
    LeakageAdaptation,
    PlainAdaptation,
    RuleBase,
)
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

RULES = RuleBase(
    sizes=[0.0, 1.0, 3.0],
    size_width=2.0,
    trends=[-8.0, 8.0],
    trend_width=9.0,
    scale=[[0.1, 0.6], [0.8, 1.5], [1.1, 3.0]],
)
LAW = {
    "model": paper_arm(),
    "Lambda": [6.0, 5.0],
    "phi": 0.1,
    "gamma": 3.0,
    "lag": 0.2,
    "K": [1.0, 0.5],
    "rules": RULES,
}
FORMS = {
    "plain": PlainAdaptation(),
    "dead_zone": DeadZoneAdaptation(width=0.8),
    "leakage": LeakageAdaptation(sigma=0.7, level=[1.0, 0.5]),
}


def loop(controller):
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=[0.6, -0.8],
            disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]),
        ),
        observer=ArmFullState(2),
        controller=controller,
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def strength(rules, x, v):
    """r(x, v) as numbers."""
    return np.array(ca.DM(ca.Function("r", [], [rules.strength(ca.SX(x), ca.SX(v))])()["o0"])).ravel()


@pytest.mark.parametrize("kind", ["clip", "tanh"])
@pytest.mark.parametrize("form", FORMS)
def test_the_loop_is_the_one_written_by_hand(form, kind):
    ode = loop(FuzzyAsmc(**LAW, adaptation=FORMS[form], saturation=kind)).ode()
    rates = closed_loop(fuzzy_asmc(kind, form))
    assert worst_difference(ode, rates, np.random.default_rng(5)) < 1e-11  # rounding, in exponents of up to 50


def test_the_motion_is_that_of_another_integrator():
    """Over a time in which no component of s changes its sign: |s| is smooth there."""
    ode = loop(FuzzyAsmc(**(LAW | {"phi": 5.0}), saturation="tanh")).ode()
    run = simulate(rk4(ode, 1e-4), until=0.3, every=1e-3)
    assert (np.sign(run["s"][0]) == np.sign(run["s"][0, 0])).all()
    theirs = integrate(ode, closed_loop(fuzzy_asmc("tanh")), 0.3)
    np.testing.assert_allclose(run.x[0, -1], theirs, rtol=0, atol=1e-10)  # (h lambda)^4 of RK4


def test_the_rules_say_nothing_beyond_their_consequents():
    rng = np.random.default_rng(6)
    r = strength(RULES, rng.uniform(0, 40, 200), rng.uniform(-500, 500, 200))
    assert ((r >= 0.1) & (r <= 3.0)).all()


def test_far_beyond_the_last_centres_the_last_rule_wins():
    """Where every membership is zero in floating point, too: 0 / 0 must not come."""
    np.testing.assert_allclose(strength(RULES, [1e4, 1e4], [1e5, -1e5]), [3.0, 1.1], rtol=1e-12)


def test_narrow_sets_make_a_table_of_the_rules():
    narrow = RuleBase(sizes=[0, 1], size_width=0.05, trends=[-1, 1], trend_width=0.05, scale=[[1, 2], [3, 4]])
    np.testing.assert_allclose(strength(narrow, [0, 0, 1, 1], [-1, 1, -1, 1]), [1, 2, 3, 4], rtol=1e-12)


def test_with_consequents_of_one_it_is_the_adaptive_law():
    ones = RuleBase(sizes=[0, 1], size_width=1.0, trends=[-1, 1], trend_width=1.0, scale=np.ones((2, 2)))
    fuzzy = loop(FuzzyAsmc(**(LAW | {"rules": ones}))).ode()
    plain = loop(AdaptiveSlidingMode(**{k: LAW[k] for k in ("model", "Lambda", "phi", "gamma", "K")})).ode()
    ours = simulate(rk4(fuzzy, 1e-3), until=2.0, every=0.1).x[0, :, : plain.states.size]
    np.testing.assert_allclose(ours, simulate(rk4(plain, 1e-3), until=2.0, every=0.1).x[0], atol=1e-10)  # rounding


def test_the_trend_is_that_of_the_size_of_s_behind_the_lag():
    """v - d|s|/dt is of the order of the lag times the second derivative, after some lags."""
    run = simulate(rk4(loop(FuzzyAsmc(**(LAW | {"lag": 5e-3, "phi": 5.0}))).ode(), 1e-4), until=0.3, every=1e-3)
    size = np.abs(run["s"][0])
    v = (size - run["controller.s_slow"][0]) / 5e-3
    slope, bend = np.gradient(size, run.t, axis=0), np.gradient(np.gradient(size, run.t, axis=0), run.t, axis=0)
    settled = slice(60, -5)  # twelve lags: e^-12 of |s(0)| / lag is left
    assert (np.abs(v - slope)[settled] <= 1.2 * 5e-3 * np.abs(bend).max() + 0.02).all()


def test_the_gain_never_falls():
    K = simulate(rk4(loop(FuzzyAsmc(**LAW)).ode(), 5e-4), until=4.0, every=5e-3)["controller.K"][0]
    assert (np.diff(K, axis=0) >= 0).all()


def test_centres_out_of_order_are_refused():
    with pytest.raises(ValueError, match=r"`RuleBase\(sizes=...\)` must hold at least one centre, in rising order"):
        RuleBase(sizes=[1.0, 0.5, 2.0])


def test_a_table_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"`RuleBase\(scale=...\)` must be an array of shape \(a = 3, b = 3\)"):
        RuleBase(scale=[[1.0, 2.0]])


def test_gains_that_start_below_zero_are_refused():
    with pytest.raises(ValueError, match=r"`FuzzyAsmc\(K=...\)` must not be negative"):
        FuzzyAsmc(**(LAW | {"K": [-1.0, 1.0]}))
