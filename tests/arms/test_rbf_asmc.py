"""The network of Gaussians against a hand-written loop, and the signs of its Lyapunov argument."""

import numpy as np
import pytest

from tests.support.oracles import closed_loop, disturbance, integrate, matrices, rbf_asmc, wanted, worst_difference
from workbench.arms.laws import DeadZoneAdaptation, LeakageAdaptation, PlainAdaptation, RbfAsmc
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Sines, SineTorque
from workbench.core import rk4
from workbench.engine import simulate

CENTRES = np.random.default_rng(7).uniform(-1, 1, (5, 4))
LAW = {
    "model": paper_arm(),
    "Lambda": [6.0, 5.0],
    "phi": 0.1,
    "gamma": 3.0,
    "Gamma": 20.0,
    "sigma": 0.4,
    "centres": CENTRES,
    "widths": [1.0, 1.2, 2.0, 2.2],
    "K": [1.0, 0.5],
}
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
        controller=RbfAsmc(**(LAW | changes)),
        reference=Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


@pytest.mark.parametrize("kind", ["clip", "tanh"])
@pytest.mark.parametrize("form", FORMS)
def test_the_loop_is_the_one_written_by_hand(form, kind):
    ode = loop(adaptation=FORMS[form], saturation=kind).ode()
    rates = closed_loop(rbf_asmc(kind, form))
    assert worst_difference(ode, rates, np.random.default_rng(8)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    """Over a time in which no component of s changes its sign: |s| is smooth there."""
    ode = loop(saturation="tanh", phi=5.0, Gamma=2.0).ode()
    run = simulate(rk4(ode, 1e-4), until=0.3, every=1e-3)
    assert (np.sign(run["s"][0]) == np.sign(run["s"][0, 0])).all()
    theirs = integrate(ode, closed_loop(rbf_asmc("tanh")), 0.3)
    np.testing.assert_allclose(run.x[0, -1], theirs, rtol=0, atol=1e-10)  # (h lambda)^4 of RK4


def test_the_network_and_the_arm_cancel_in_the_lyapunov_function():
    """s^T (M s' + C s) + tr(W^T W') / Gamma = -s^T (K o sat + D) where nothing leaks and W* = 0."""
    ode, rng = loop(sigma=0.0).ode(), np.random.default_rng(9)
    p = ode.parameters.unpack(ode.parameters.default)
    for _ in range(20):
        t, x = rng.uniform(0, 10), rng.uniform(-1, 1, ode.states.size)
        z, rate = ode.states.unpack(x), ode.states.unpack(ode.rate_at(t, x))
        q, qd, (q_d, qd_d, qdd_d), Lambda = z["plant.q"], z["plant.qd"], wanted(t, p), p["controller.Lambda"]
        M, C, _ = matrices(p, "plant.arm", q, qd)
        s = qd - qd_d + Lambda * (q - q_d)
        s_rate = rate["plant.qd"] - qdd_d + Lambda * (qd - qd_d)
        arm = s @ (M @ s_rate + C @ s)
        network = np.trace(z["controller.W"].T @ rate["controller.W"]) / 20.0
        rest = -s @ (z["controller.K"] * np.clip(s / 0.1, -1, 1) + disturbance(t, p))
        assert abs(arm + network - rest) < 1e-10  # rounding, terms of about 100


def test_the_network_makes_up_for_a_heavier_link():
    errors = []
    for Gamma in (1e-9, 60.0):
        ode = loop(Gamma=Gamma, sigma=0.05, phi=0.5, gamma=1e-9).ode()
        run = simulate(rk4(ode, 1e-3), ode.parameters.pack({"plant.arm.links[1].mass": 1.5}), until=15.0, every=1e-2)
        errors.append(np.sqrt(np.mean(run["e"][0, run.t > 10.0] ** 2)))
    assert errors[1] < 0.7 * errors[0]


def test_on_the_surface_the_weights_only_leak():
    ode = loop().ode()
    x = ode.states.pack({"controller.W": np.arange(10.0).reshape(5, 2)})[0]
    p = ode.parameters.unpack(ode.parameters.default)
    q_d, qd_d, _ = wanted(0.0, p)
    x[ode.states.slice("plant.q")], x[ode.states.slice("plant.qd")] = q_d, qd_d
    rate = ode.states.unpack(ode.rate_at(0.0, x))
    np.testing.assert_allclose(rate["controller.W"], -0.4 * np.arange(10.0).reshape(5, 2), rtol=1e-14)


def test_what_is_learned_starts_at_nothing():
    ode = loop().ode()
    np.testing.assert_array_equal(ode.outputs_at(0.0, ode.states.default)["learned"], 0)


def test_centres_in_another_space_are_refused():
    with pytest.raises(ValueError, match=r"`RbfAsmc\(centres=...\)` must have shape \(m, 4\).*Got \(5, 2\)"):
        RbfAsmc(**(LAW | {"centres": CENTRES[:, :2], "widths": [1.0, 1.0]}))


def test_gains_that_start_below_zero_are_refused():
    with pytest.raises(ValueError, match=r"`RbfAsmc\(K=...\)` must not be negative"):
        RbfAsmc(**(LAW | {"K": [-1.0, 1.0]}))
