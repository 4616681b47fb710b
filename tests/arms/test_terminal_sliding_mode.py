"""Nonsingular terminal sliding mode against a hand-written loop, and the finite times that it promises."""

import numpy as np
import pytest

from tests.support.oracles import closed_loop, integrate, matrices, sat, worst_difference
from workbench.arms.laws import NonsingularTerminalSlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import rk4
from workbench.core.claim import claims_of
from workbench.engine import simulate
from workbench.proofs.falsify import Budget, RunSearch

ARM = paper_arm()
LAW = {"beta": [4.0, 5.0], "gamma": 1.5, "k1": [10.0, 8.0], "k2": [15.0, 12.0], "rho": 0.5, "phi": 0.1}


def loop(q=(0.6, -0.8), qd=(0.0, 0.0), push=(0.5, 0.4), reference=None, **changes):
    return ClosedLoop(
        Manipulator(ARM, q=q, qd=qd, disturbance=SineTorque(push, [3.0, 4.0], [0.0, np.pi / 2])),
        ArmFullState(2),
        NonsingularTerminalSlidingMode(ARM, **(LAW | changes)),
        reference or Sines("q", "rad", [1.0, 0.5], [2.0, 3.0]),
    )


def sig(x, a):
    return np.abs(x) ** a * np.sign(x)


def terminal(kind):
    def law(p, z, q, qd, d, ref):
        M, C, G = matrices(p, "controller.model", q, qd)
        beta, gamma, rho = (p[f"controller.{name}"] for name in ("beta", "gamma", "rho"))
        e, ed = q - ref[0], qd - ref[1]
        s = e + sig(ed, gamma) / beta
        switch = np.abs(s) ** rho * sat(s / p["controller.phi"], kind)
        u = p["controller.k1"] * s + p["controller.k2"] * switch
        return M @ (ref[2] - beta / gamma * sig(ed, 2 - gamma) - u) + C @ qd + G, {}

    return law


@pytest.mark.parametrize("rho", [0.0, 0.5])
@pytest.mark.parametrize("kind", ["clip", "tanh"])
def test_the_loop_is_the_one_written_by_hand(kind, rho):
    ode = loop(saturation=kind, rho=rho).ode()
    assert worst_difference(ode, closed_loop(terminal(kind)), np.random.default_rng(63)) < 1e-12  # rounding


def test_the_motion_is_that_of_another_integrator():
    """Over a time in which no component of ed or s changes its sign: their powers are smooth there."""
    ode = loop(saturation="tanh", phi=1.0, qd=(1.0, 2.0)).ode()
    run = simulate(rk4(ode, 1e-5), until=0.03, every=1e-3)
    for signal in ("ed", "surface"):
        assert (np.sign(run[signal][0]) == np.sign(run[signal][0, 0])).all()
    theirs = integrate(ode, closed_loop(terminal("tanh")), 0.03)
    np.testing.assert_allclose(run.x[0, -1], theirs, rtol=0, atol=1e-10)  # of RK4


@pytest.mark.parametrize("saturation", ["clip", "sign"])
def test_at_rest_beside_the_reference_torque_and_jacobian_are_finite(saturation):
    """ed = 0 with e != 0, where the torque of a singular terminal law is infinite."""
    ode = loop(reference=Constant("q", "rad", [0.0, 0.0]), saturation=saturation).ode()
    x = ode.states.default
    y = ode.outputs_at(0.0, x)
    np.testing.assert_array_equal(y["ed"], 0)
    p = ode.parameters.unpack(ode.parameters.default)
    M, _, G = matrices(p, "controller.model", y["q"], np.zeros(2))
    s = y["q"]
    switch = np.sign(s) if saturation == "sign" else np.clip(s / 0.1, -1, 1)
    u = p["controller.k1"] * s + p["controller.k2"] * np.sqrt(np.abs(s)) * switch
    np.testing.assert_allclose(y["tau"], G - M @ u, rtol=1e-12)
    assert np.isfinite(np.array(ode.A(0.0, x, ode.parameters.default))).all()


def test_near_ed_zero_the_torque_shrinks_with_ed_where_a_singular_law_s_would_grow():
    """The share of the surface, beta / gamma |ed|^(2 - gamma): below 1e-3 rad/s^2 at 1e-8 rad/s."""
    ode = loop(reference=Constant("q", "rad", [0.0, 0.0])).ode()
    x, y = ode.states.default.copy(), ode.outputs_at(0.0, ode.states.default)
    x[ode.states.slice("plant.qd")] = 1e-8
    np.testing.assert_allclose(ode.outputs_at(0.0, x)["tau"], y["tau"], atol=3e-3)  # M at most 5 kg m^2


def test_on_the_surface_the_error_ends_at_the_time_of_the_theorem():
    """|e|^(1 - 1/gamma) falls along a line that ends at gamma / (gamma - 1) beta^(-1/gamma) |e(0)|^(1 - 1/gamma)."""
    e, beta, gamma = np.array([0.6, -0.8]), np.array(LAW["beta"]), LAW["gamma"]
    on = -sig(beta * e, 1 / gamma)
    run = simulate(rk4(loop(e, on, (0.0, 0.0), Constant("q", "rad", [0.0, 0.0])).ode(), 1e-4), until=1.5, every=1e-2)
    ends = gamma / (gamma - 1) * beta ** (-1 / gamma) * np.abs(e) ** (1 - 1 / gamma)
    line = np.abs(e) ** (1 - 1 / gamma) * np.maximum(1 - run.t[:, None] / ends, 0)
    before = run.t[:, None] < 0.95 * ends  # at the end ed^(2 - gamma) has no slope, and RK4 no order
    np.testing.assert_allclose(
        np.where(before, np.abs(run["e"][0]) ** (1 - 1 / gamma), 0), np.where(before, line, 0), atol=1e-6
    )
    assert (np.abs(run["e"][0])[run.t[:, None] > ends + 0.02] < 1e-5).all()
    assert 0.5 < ends.min() < ends.max() < 1.4  # both ends lie within the run


def test_a_relay_reaches_the_surface_and_holds_it_against_the_disturbance():
    """Without a layer, k2 = 15 and 12 rad/s^2 beyond |M^-1 D| of at most 3: what is left is the step's."""
    changes = {"rho": 0.0, "k1": 0.0, "saturation": "sign"}
    late = [
        np.abs(simulate(rk4(loop(**changes).ode(), h), until=4.0, every=1e-2)["e"][0, 300:]).max() for h in (4e-4, 1e-4)
    ]
    assert late[1] < 0.35 * late[0]  # in proportion to h, or better
    assert late[1] < 1e-3


def test_no_run_breaks_what_it_promises():
    kept = loop()
    box = {"plant.q": (-2.0, 2.0), "plant.qd": (-2.0, 2.0)}
    assert RunSearch(kept.ode(), claims_of(kept)[-1], box, 0.5, 5e-4).search(1, Budget(16, 3, 0)).kind == "not refuted"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gamma": 2.0}, r"\(gamma=...\)` must be finite, with 1 < value < 2"),
        ({"gamma": 1.0}, r"\(gamma=...\)` must be finite, with 1 < value < 2"),
        ({"rho": 1.0}, r"\(rho=...\)` must be below 1"),
        ({"k2": -1.0}, r"\(k2=...\)` must be finite, with 0 <= value"),
        ({"beta": 0.0}, r"\(beta=...\)` must be finite, with 0 < value"),
    ],
)
def test_numbers_without_a_theorem_are_refused(changes, message):
    with pytest.raises(ValueError, match=r"`NonsingularTerminalSlidingMode" + message):
        loop(**changes)
