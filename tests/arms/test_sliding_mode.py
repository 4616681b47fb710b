"""Sliding mode against a hand-written loop, and the bound that its boundary layer promises."""

import casadi as ca
import numpy as np
import pytest

from tests.support.oracles import closed_loop, disturbance, integrate, matrices, sliding_mode, wanted, worst_difference
from workbench.arms.laws import SlidingMode
from workbench.arms.laws.sliding_surface import saturation
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

LAW = {"model": paper_arm(), "Lambda": [6.0, 5.0], "K": [4.0, 3.0], "phi": 0.1}


def loop(**changes):
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=[0.6, -0.8],
            disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]),
        ),
        observer=ArmFullState(2),
        controller=SlidingMode(**(LAW | changes)),
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


@pytest.mark.parametrize("kind", ["clip", "tanh"])
def test_the_loop_is_the_one_written_by_hand(kind):
    rates = closed_loop(sliding_mode(kind))
    assert worst_difference(loop(saturation=kind).ode(), rates, np.random.default_rng(2)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    ode = loop(saturation="tanh", phi=1.0).ode()
    ours = simulate(rk4(ode, 1e-4), until=0.5, every=0.5).x[0, -1]
    # RK4 at 0.1 ms on modes of 30 1/s: (h lambda)^4 is 1e-10, and the error a fraction of it
    np.testing.assert_allclose(ours, integrate(ode, closed_loop(sliding_mode("tanh")), 0.5), rtol=0, atol=1e-10)


def test_with_the_right_model_only_the_switching_torque_and_the_disturbance_move_s():
    """M s' + C s = -K sat(s / phi) - D at any state."""
    ode, rng = loop().ode(), np.random.default_rng(3)
    p = ode.parameters.unpack(ode.parameters.default)
    for _ in range(20):
        t, q, qd = rng.uniform(0, 10), rng.uniform(-3, 3, 2), rng.uniform(-3, 3, 2)
        M, C, _ = matrices(p, "plant.arm", q, qd)
        q_d, qd_d, qdd_d = wanted(t, p)
        qdd = ode.rate_at(t, np.concatenate([q, qd]))[2:]
        Lambda = p["controller.Lambda"]
        s, s_rate = qd - qd_d + Lambda * (q - q_d), qdd - qdd_d + Lambda * (qd - qd_d)
        torque = -p["controller.K"] * np.clip(s / 0.1, -1, 1) - disturbance(t, p)
        np.testing.assert_allclose(M @ s_rate + C @ s, torque, atol=1e-11)  # rounding, terms of about 100 N m


def test_once_in_the_layer_the_error_stays_below_its_width_over_lambda():
    """K exceeds the disturbance in both joints: s stays in the layer, e within phi / Lambda."""
    run = simulate(rk4(loop().ode(), 5e-4), until=12.0, every=5e-3)
    settled = run.t > 4.0
    assert np.abs(run["s"][0, settled]).max() <= 0.1  # phi
    assert (np.abs(run["e"][0, settled]) <= 0.1 / np.array([6.0, 5.0]) + 1e-8).all()  # phi / Lambda; e^(-6 * 3) is left


def test_a_gain_below_the_disturbance_lets_s_leave_the_layer():
    run = simulate(rk4(loop(K=[0.3, 0.2]).ode(), 5e-4), until=12.0, every=5e-3)
    assert np.abs(run["s"][0, run.t > 4.0]).max() > 0.1  # phi


@pytest.mark.parametrize("kind", ["clip", "tanh"])
def test_saturation_has_slope_one_over_phi_at_zero_and_tends_to_the_sign(kind):
    s = ca.SX.sym("s")
    sat = saturation(s, 0.01, kind)
    value, slope = ca.Function("f", [s], [sat, ca.jacobian(sat, s)])(0.0)
    assert float(value) == 0
    assert float(slope) == 100
    far = ca.Function("f", [s], [sat])
    assert float(far(-1.0)) == -1
    assert float(far(1.0)) == 1


def test_gains_for_another_number_of_joints_are_refused():
    with pytest.raises(ValueError, match=r"`SlidingMode\(K=...\)` must be an array of shape \(n = 2\)"):
        SlidingMode(**(LAW | {"K": [1.0, 2.0, 3.0]}))


def test_a_misspelt_saturation_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="Did you mean 'tanh'"):
        SlidingMode(**LAW, saturation="tan")
