"""The arm under sliding mode with lagging drives: where its loop is cut, and what chattering is foreseen and seen."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import FirstOrderLag, Manipulator
from workbench.arms.mechanics.planar_arm import PlanarArm, PointMass
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant
from workbench.design.chattering import (
    BoundaryLayer,
    Relay,
    harmonic_balance,
    linear_part_of,
    record_oscillation,
    relay_cycles,
)
from workbench.design.matrices import DesignError
from workbench.engine import simulate

K, LAMBDA, PHI = 5.0, 6.0, 0.01  # the gains of the paper's card
FOLDED = np.array([0.0, np.pi])  # M is the unit matrix here, so the joints are alone
LINKS = (PointMass(1.0, 1.0), PointMass(1.0, 1.0))


def loop(lag, saturation="clip", gravity=9.81, q=FOLDED):
    arm = PlanarArm(LINKS, gravity)
    law = SlidingMode(arm, Lambda=[LAMBDA] * 2, K=[K] * 2, phi=PHI, saturation=saturation)
    return ClosedLoop(Manipulator(arm, q=q, actuator=FirstOrderLag(lag)), ArmFullState(2), law, Constant("q", "rad", q))


def alone(made):
    """Parameters with no layer on the second joint."""
    p = made.parameters.default.copy()
    p[made.parameters.labels.index("controller.K[1]")] = 0.0
    return p


@pytest.mark.parametrize("lag", [1e-3, 1e-2])
def test_the_cut_of_a_joint_is_the_transfer_function_by_hand(lag):
    ode = loop(lag, gravity=0.0).ode()
    W = linear_part_of(ode, ode.states.default)
    w = np.array([0.5, 20.0, 700.0])
    s = 1j * w
    # M e'' = tau_m, lag tau_m' = -M Lambda e' + u - tau_m, s = e' + Lambda e, with M = 1
    np.testing.assert_allclose(W.response(w)[0], (s + LAMBDA) / (s * (s * (lag * s + 1) + LAMBDA)), rtol=1e-9)


def test_the_cut_of_a_sampled_joint_is_that_of_its_recursion_by_hand():
    period, lag = 2e-3, 5e-3
    made = loop(lag, gravity=0.0).digital(period).step(8)
    W = linear_part_of(made, made.states.default, alone(made))
    z = np.exp(1j * np.array([3.0, 90.0, 1200.0]) * period)
    # e, e' and the torque of the motor under a held u by exact integration; then the law's own -Lambda e' is closed
    a = np.exp(-period / lag)
    Phi = np.array([[1, period, lag * (period - lag * (1 - a))], [0, 1, lag * (1 - a)], [0, 0, a]])
    Gamma = np.array([period**2 / 2 - lag * (period - lag * (1 - a)), period - lag * (1 - a), 1 - a])
    Phi = Phi - np.outer(Gamma, [0, LAMBDA, 0])
    expected = [[LAMBDA, 1, 0] @ np.linalg.solve(zi * np.eye(3) - Phi, Gamma) for zi in z]
    # eight Runge-Kutta steps of a twentieth of the lag each: (1/20)^5 / 120 a step
    np.testing.assert_allclose(W.response(np.angle(z) / period)[0], expected, rtol=1e-6)


@pytest.mark.parametrize(("lag", "period"), [(2e-3, 2e-3), (5e-3, 2e-3)])
def test_the_chattering_of_a_relay_is_one_of_the_exact_cycles_and_near_the_balance(lag, period):
    made = loop(lag).digital(period).step(4)
    W = linear_part_of(made, made.states.default, alone(made))
    run = seen(loop(lag, "sign").digital(period).step(4))
    near = harmonic_balance(W, Relay(K)).oscillations[0]
    half = np.pi / run.frequency / period
    cycles = {c.samples: c for c in relay_cycles(W, K)}
    found = cycles[round(half)]
    assert abs(half - round(half)) < 1e-3
    # the joints are coupled by gravity still, and by M off the fold: 1e-4 of what the switch does
    assert found.amplitude * (1 - 1e-3) < run.amplitude < found.highest * (1 + 1e-3)
    # half a period is a whole number of instants, which one depends on the start; the balance knows the phase alone
    assert abs(np.pi / near.frequency / period - half) < 1


@pytest.mark.parametrize(("lag", "period", "chatters"), [(5e-3, 2e-3, False), (2e-2, 5e-3, True)])
def test_a_layer_chatters_where_it_is_thinner_than_foreseen(lag, period, chatters):
    made = loop(lag).digital(period).step(4)
    W = linear_part_of(made, made.states.default, alone(made))
    balance, run = harmonic_balance(W, BoundaryLayer(K, PHI)), seen(made)
    assert bool(balance.oscillations) == chatters == (balance.least_phi > PHI)
    if not chatters:
        assert run.amplitude < 1e-9  # six time constants of the surface a second, four seconds
        return
    found = balance.oscillations[0]
    # a whole number of instants again, five of half a period here: a fifth of a sample is 4 %
    np.testing.assert_allclose([found.frequency, found.amplitude], [run.frequency, run.amplitude], rtol=0.06)


def seen(step):
    """The oscillation of s of the first joint in the last two of six seconds, from a push."""
    x = step.states.pack({"plant.qd": np.array([0.3, -0.2])})
    run = simulate(step, x0=x, until=6.0, every=step.h)
    late = run.t > 4.0
    return record_oscillation(run.t[late], run["s"][0, late, 0])


def test_what_cannot_be_cut_is_refused_by_name():
    ode = loop(1e-3).ode()
    x = ode.states.default
    with pytest.raises(DesignError, match="must be a rest"):
        linear_part_of(ode, x + 0.1)
    with pytest.raises(DesignError, match="saturation='sign'"):
        linear_part_of(loop(1e-3, "sign").ode(), x)
    with pytest.raises(DesignError, match="this s alone"):
        linear_part_of(ode, x, variable="s[1]")
    with pytest.raises(LookupError, match="controller.k"):
        linear_part_of(ode, x, gain="controller.k")
    with pytest.raises(ValueError, match=r"linear_part_of\(x=...\)"):
        linear_part_of(ode, x[:2])
    with pytest.raises((TypeError, ValueError), match="linear_part_of"):
        linear_part_of(replace(loop(1e-3)), x)
