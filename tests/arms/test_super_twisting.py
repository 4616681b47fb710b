"""Super-twisting against a hand-written loop, and what its layer costs."""

import numpy as np
import pytest

from tests.support.oracles import (
    closed_loop,
    disturbance,
    integrate,
    matrices,
    super_twisting,
    wanted,
    worst_difference,
)
from workbench.arms.laws import SuperTwisting
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

LAW = {"model": paper_arm(), "Lambda": [6.0, 5.0], "k1": [8.0, 9.0], "k2": [20.0, 25.0], "phi": 0.1}


def loop(**changes):
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=[0.6, -0.8],
            disturbance=SineTorque(amplitude=[0.5, 0.4], frequency=[3.0, 4.0], phase=[0.0, np.pi / 2]),
        ),
        observer=ArmFullState(2),
        controller=SuperTwisting(**(LAW | changes)),
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


@pytest.mark.parametrize("kind", ["clip", "tanh"])
def test_the_loop_is_the_one_written_by_hand(kind):
    rates = closed_loop(super_twisting(kind))
    assert worst_difference(loop(saturation=kind).ode(), rates, np.random.default_rng(10)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    """Over a time in which no component of s changes its sign: |s|^(1/2) is smooth there."""
    ode = loop(saturation="tanh", phi=5.0).ode()
    run = simulate(rk4(ode, 1e-4), until=0.2, every=1e-3)
    assert (np.sign(run["s"][0]) == np.sign(run["s"][0, 0])).all()
    theirs = integrate(ode, closed_loop(super_twisting("tanh")), 0.2)
    np.testing.assert_allclose(run.x[0, -1], theirs, rtol=0, atol=1e-10)  # (h lambda)^4 of RK4


def test_with_the_right_model_the_joints_are_uncoupled():
    """s' = u - M^-1 D at any state, with u of each joint from its own s and w."""
    ode, rng = loop().ode(), np.random.default_rng(11)
    p = ode.parameters.unpack(ode.parameters.default)
    for _ in range(20):
        t, x = rng.uniform(0, 10), rng.uniform(-2, 2, ode.states.size)
        z, rate = ode.states.unpack(x), ode.states.unpack(ode.rate_at(t, x))
        q, qd, (q_d, qd_d, qdd_d), Lambda = z["plant.q"], z["plant.qd"], wanted(t, p), p["controller.Lambda"]
        M, _, _ = matrices(p, "plant.arm", q, qd)
        s = qd - qd_d + Lambda * (q - q_d)
        s_rate = rate["plant.qd"] - qdd_d + Lambda * (qd - qd_d)
        u = -p["controller.k1"] * np.abs(s) ** 0.5 * np.clip(s / 0.1, -1, 1) + z["controller.w"]
        np.testing.assert_allclose(s_rate, u - np.linalg.solve(M, disturbance(t, p)), atol=1e-11)  # rounding


def test_s_comes_to_rest_where_the_switching_balances_the_slope_of_the_perturbation():
    """|s| about phi L / k2, with L the largest slope of M^-1 D along the run."""
    ode = loop().ode()
    run = simulate(rk4(ode, 2e-4), until=8.0, every=2e-3)
    p = ode.parameters.unpack(ode.parameters.default)
    states = zip(run.t, run["q"][0], run["qd"][0], strict=True)
    push = np.array([np.linalg.solve(matrices(p, "plant.arm", q, qd)[0], disturbance(t, p)) for t, q, qd in states])
    slope = np.gradient(push, run.t, axis=0)
    late = run.t > 4.0
    rest = 0.1 * np.abs(slope[late]).max(axis=0) / np.array([20.0, 25.0])
    reached = np.abs(run["s"][0, late]).max(axis=0)
    assert (reached < 1.6 * rest).all()  # quasi-static up to the loop's own resonance
    assert (reached > 0.4 * rest).all()


def test_a_thinner_layer_brings_s_closer_to_zero():
    late = [
        np.abs(simulate(rk4(loop(phi=phi).ode(), 2e-4), until=6.0, every=2e-3)["s"][0, -1000:]).max()
        for phi in (0.2, 0.1)
    ]
    assert late[1] < 0.6 * late[0]


def test_on_the_surface_the_equations_have_a_finite_jacobian():
    """The slope of |s|^(1/2) is infinite at s = 0; that of |s|^(1/2) sat(s / phi) is zero."""
    ode = loop().ode()
    x = ode.states.default.copy()
    x[ode.states.slice("plant.q")], x[ode.states.slice("plant.qd")] = [0.0, 0.0], [2.0, 1.5]
    np.testing.assert_array_equal(ode.outputs_at(0.0, x)["s"], 0)
    assert np.isfinite(np.array(ode.A(0.0, x, ode.parameters.default))).all()
