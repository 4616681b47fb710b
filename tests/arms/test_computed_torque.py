"""Computed torque against a hand-written loop, and the linear error that it promises."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from tests.support.oracles import (
    closed_loop,
    integrate,
    matrices,
    momentum_observer,
    with_disturbance,
    worst_difference,
)
from workbench.arms.laws import ComputedTorque
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.observers import ArmFullState, MomentumObserver, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.core.claim import claims_of
from workbench.engine import simulate
from workbench.proofs.falsify import Budget, RunSearch

ARM, Kp, Kd = paper_arm(), np.array([64.0, 49.0]), np.array([16.0, 10.0])
LAW = ComputedTorque(ARM, Kp, Kd)
MOMENTUM = StateAndDisturbanceObserver(ArmFullState(2), MomentumObserver(ARM, l=20.0))


def loop(law=LAW, observer=None, push=(0.5, 0.4), frequency=(3.0, 4.0), reference=None):
    return ClosedLoop(
        Manipulator(ARM, q=[0.6, -0.8], disturbance=SineTorque(push, frequency, [0.3, np.pi / 2])),
        observer or ArmFullState(2),
        law,
        reference or Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )


def computed_torque(p, z, q, qd, d, ref):
    M, C, G = matrices(p, "controller.model", q, qd)
    wanted = ref[2] - p["controller.Kd"] * (qd - ref[1]) - p["controller.Kp"] * (q - ref[0])
    return M @ wanted + C @ qd + G + d, {}


@pytest.mark.parametrize("observer", [None, MOMENTUM], ids=["alone", "momentum"])
def test_the_loop_is_the_one_written_by_hand(observer):
    rates = closed_loop(computed_torque, *([with_disturbance(momentum_observer)] if observer else []))
    assert worst_difference(loop(observer=observer).ode(), rates, np.random.default_rng(61)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    ode = loop(observer=MOMENTUM).ode()
    ours = simulate(rk4(ode, 1e-4), until=0.5, every=0.5).x[0, -1]
    theirs = integrate(ode, closed_loop(computed_torque, with_disturbance(momentum_observer)), 0.5)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-10)  # (h lambda)^4 of RK4 at 0.1 ms


def test_with_the_right_model_the_error_of_each_joint_is_that_of_a_linear_oscillator():
    """e and ed against the matrix exponential of [[0, 1], [-Kp, -Kd]], along a fast motion of both joints."""
    run = simulate(rk4(loop(push=(0.0, 0.0)).ode(), 1e-4), until=1.0, every=0.1)
    for j in (0, 1):
        A = np.array([[0.0, 1.0], [-Kp[j], -Kd[j]]])
        start = np.array([run["e"][0, 0, j], run["ed"][0, 0, j]])
        theirs = np.array([expm(A * t) @ start for t in run.t])
        np.testing.assert_allclose(run["e"][0, :, j], theirs[:, 0], rtol=0, atol=1e-10)  # of RK4
        np.testing.assert_allclose(run["ed"][0, :, j], theirs[:, 1], rtol=0, atol=1e-9)


def test_behind_an_observer_of_the_disturbance_a_constant_push_leaves_no_error():
    still = {"push": (1.5, -1.0), "frequency": (0.0, 0.0), "reference": Constant("q", "rad", [0.6, -0.8])}
    alone, behind = (
        simulate(rk4(loop(observer=observer, **still).ode(), 1e-3), until=20.0)["e"][0, -1]
        for observer in (None, MOMENTUM)
    )
    p = loop(**still).ode().parameters
    D = np.array([1.5, -1.0]) * np.sin([0.3, np.pi / 2])
    M = matrices(p.unpack(p.default), "plant.arm", np.array([0.6, -0.8]) + alone, np.zeros(2))[0]
    np.testing.assert_allclose(Kp * alone, -np.linalg.solve(M, D), rtol=1e-6)  # M^-1 (D_hat - D), all modes decayed
    np.testing.assert_allclose(behind, 0, atol=1e-9)


BOX = {"plant.q": (-2.0, 2.0), "plant.qd": (-2.0, 2.0)}


@pytest.mark.parametrize(
    ("law", "push", "kind"),
    [
        (LAW, 0.0, "not refuted"),
        (replace(LAW, model=replace(ARM, gravity=12.0)), 0.0, "refuted"),
        (LAW, 0.5, "not checkable"),
    ],
    ids=["right model", "wrong model", "unknown disturbance"],
)
def test_its_promise_holds_with_the_right_model_and_where_no_disturbance_is_unknown(law, push, kind):
    kept = loop(law, push=(push, push))
    assert RunSearch(kept.ode(), claims_of(kept)[-1], BOX, 0.5, 5e-4).search(1, Budget(16, 3, 0)).kind == kind


def test_gains_for_another_arm_are_refused():
    with pytest.raises(ValueError, match=r"`ComputedTorque\(Kp=...\)` must be an array of shape \(n = 3\)"):
        ComputedTorque(robot("planar-3r"), Kp, Kd)
