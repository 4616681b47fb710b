"""Observers of the disturbance: their error equations, their use of the truth, and their place beside a state."""

import casadi as ca
import numpy as np
import pytest

from tests.support.oracles import (
    closed_loop,
    disturbance,
    integrate,
    matrices,
    momentum_observer,
    nonlinear_disturbance_observer,
    oracle_filter,
    printed_filter,
    sliding_mode,
    with_disturbance,
    worst_difference,
)
from workbench.arms.laws import SlidingMode
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm, robot
from workbench.arms.observers import (
    AbstractDisturbanceObserver,
    ArmFullState,
    Luenberger,
    MomentumObserver,
    NonlinearDisturbanceObserver,
    OracleFilter,
    PrintedFilter,
    StateAndDisturbanceObserver,
)
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines, SineTorque
from workbench.core import Layout, block, rk4
from workbench.engine import simulate

OBSERVERS = {
    "printed": (PrintedFilter(2, l=20.0), printed_filter),
    "oracle": (OracleFilter(2, l=20.0), oracle_filter),
    "nonlinear": (NonlinearDisturbanceObserver(paper_arm(), l=15.0), nonlinear_disturbance_observer),
    "momentum": (MomentumObserver(paper_arm(), l=20.0), momentum_observer),
}
HONEST = ("nonlinear", "momentum")


@block
class Cheat(AbstractDisturbanceObserver):
    """Takes the true disturbance without saying so."""

    joints: int = 2

    @property
    def dof(self):
        return self.joints

    @property
    def uses_truth(self):
        return False

    @property
    def memory(self):
        return Layout()

    def estimate(self, t, z, y, est):
        return 1.0 * y.d

    def rate(self, t, z, y, est, tau):
        return {}


def loop(disturbance_observer, state=None, amplitude=(0.5, 0.4), frequency=(3.0, 4.0), reference=None, **changes):
    law = {"model": paper_arm(), "Lambda": [6.0, 5.0], "K": [4.0, 3.0], "phi": 0.5, "saturation": "tanh"}
    return ClosedLoop(
        plant=Manipulator(
            paper_arm(),
            q=[0.6, -0.8],
            disturbance=SineTorque(amplitude=amplitude, frequency=frequency, phase=[0.3, np.pi / 2]),
        ),
        observer=StateAndDisturbanceObserver(state or ArmFullState(2), disturbance_observer),
        controller=SlidingMode(**(law | changes)),
        reference=reference or Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


def slope_of_the_estimate(ode):
    """D_hat and D_hat' = dD_hat/dx f + dD_hat/dt, as a function of (t, x, p)."""
    y = dict(
        zip(
            ode.outputs.names,
            ca.vertsplit(ode.output, [0, *np.cumsum([e.size for e in ode.outputs.entries])]),
            strict=True,
        )
    )
    d_hat = y["d"] - y["d_error"]
    slope = ca.jacobian(d_hat, ode.x) @ ode.rate + ca.jacobian(d_hat, ode.t)
    return ca.Function("slope", [ode.t, ode.x, ode.p], [d_hat, slope])


@pytest.mark.parametrize("state", ["full", "luenberger"])
@pytest.mark.parametrize("name", OBSERVERS)
def test_the_loop_is_the_one_written_by_hand(name, state):
    ours, by_hand = OBSERVERS[name]
    copy = Luenberger(paper_arm(), L1=30 * np.eye(2), L2=50 * np.eye(2), q_hat=[0.0, 0.0])
    ode = loop(ours, state=None if state == "full" else copy).ode()
    rates = closed_loop(sliding_mode("tanh"), with_disturbance(by_hand, state))
    assert worst_difference(ode, rates, np.random.default_rng(20)) < 1e-12  # rounding


@pytest.mark.parametrize("name", OBSERVERS)
def test_the_motion_is_that_of_another_integrator(name):
    ours, by_hand = OBSERVERS[name]
    ode = loop(ours, phi=1.0).ode()
    last = simulate(rk4(ode, 1e-4), until=0.5, every=0.5).x[0, -1]
    theirs = integrate(ode, closed_loop(sliding_mode("tanh"), with_disturbance(by_hand)), 0.5)
    np.testing.assert_allclose(last, theirs, rtol=0, atol=1e-10)  # (h lambda)^4 of RK4 at 0.1 ms


@pytest.mark.parametrize("name", ["oracle", "momentum", "nonlinear"])
def test_the_error_obeys_its_equation_at_any_state(name):
    """D_hat' = l (D - D_hat) exactly; the nonlinear observer has l M^-1(q) in place of l."""
    ode, rng = loop(OBSERVERS[name][0]).ode(), np.random.default_rng(21)
    slope, p = slope_of_the_estimate(ode), ode.parameters.unpack(ode.parameters.default)
    for _ in range(20):
        t, x = rng.uniform(0, 10), rng.uniform(-2, 2, ode.states.size)
        d_hat, rate = (np.array(v).ravel() for v in slope(t, x, ode.parameters.default))
        z = ode.states.unpack(x)
        M = matrices(p, "plant.arm", z["plant.q"], z["plant.qd"])[0]
        gain = 15.0 * np.linalg.inv(M) if name == "nonlinear" else 20.0 * np.eye(2)
        wanted = gain @ (disturbance(t, p) - d_hat)
        np.testing.assert_allclose(rate, wanted, atol=1e-12 * (1 + np.abs(wanted).max()) * 100)  # rounding


@pytest.mark.parametrize("compensated", [False, True])
def test_beside_observer_10_the_nonlinear_observer_follows_the_correction_of_the_copy(compensated):
    """D_hat' = l M^-1 (-M L2 (q - q_hat) - D_hat), without the last term where (10) is compensated."""
    L2 = np.array([[50.0, 2.0], [1.0, 40.0]])
    reading = "compensated" if compensated else "ignored"
    copy = Luenberger(paper_arm(), L1=30 * np.eye(2), L2=L2, q_hat=[0.0, 0.0], disturbance=reading)
    ode, rng = loop(OBSERVERS["nonlinear"][0], state=copy).ode(), np.random.default_rng(22)
    slope, p = slope_of_the_estimate(ode), ode.parameters.unpack(ode.parameters.default)
    for _ in range(10):
        t, x = rng.uniform(0, 10), rng.uniform(-2, 2, ode.states.size)
        d_hat, rate = (np.array(v).ravel() for v in slope(t, x, ode.parameters.default))
        z = ode.states.unpack(x)
        M = matrices(p, "plant.arm", z["observer.state.q_hat"], z["observer.state.qd_hat"])[0]
        correction = -L2 @ (z["plant.q"] - z["observer.state.q_hat"])
        wanted = 15.0 * (correction if compensated else correction - np.linalg.solve(M, d_hat))
        np.testing.assert_allclose(rate, wanted, atol=1e-10 * (1 + np.abs(wanted).max()))  # rounding


def test_the_printed_filter_follows_the_integral_of_the_disturbance():
    """D_hat + eta / l is the integral of D exactly, whatever l."""
    run = simulate(rk4(loop(OBSERVERS["printed"][0]).ode(), 5e-4), until=3.0, every=0.1)
    integral = (
        np.array([0.5, 0.4])
        / [3.0, 4.0]
        * (np.cos([0.3, np.pi / 2]) - np.cos(np.outer(run.t, [3.0, 4.0]) + [0.3, np.pi / 2]))
    )
    followed = run["observer.disturbance.D_hat"][0] + run["observer.disturbance.eta"][0] / 20.0
    np.testing.assert_allclose(followed, integral, atol=1e-11)  # RK4: (h l)^4 = 1e-8 of terms that cancel


def test_a_faster_printed_filter_is_no_better_an_estimate():
    """As l grows D_hat tends to the integral of D: its error stays that of the integral."""
    errors = []
    for l in (20.0, 200.0):
        run = simulate(rk4(loop(PrintedFilter(2, l=l)).ode(), 1e-3), until=6.0, every=1e-2)
        errors.append(np.sqrt(np.mean(run["d_error"][0, 200:] ** 2)))
    assert errors[1] > 0.9 * errors[0] > 0.1


@pytest.mark.parametrize("name", ["oracle", *HONEST])
def test_a_constant_disturbance_is_found_at_the_promised_rate(name):
    """|D - D_hat| falls at the rate l, or l / max eig M for the nonlinear observer."""
    ode = loop(OBSERVERS[name][0], amplitude=(2.0, 1.0), frequency=(0.0, 0.0)).ode()
    run = simulate(rk4(ode, 5e-4), until=1.0, every=1e-2)
    p = ode.parameters.unpack(ode.parameters.default)
    largest = max(np.linalg.eigvalsh(matrices(p, "plant.arm", q, 0 * q)[0])[-1] for q in run["q"][0])
    rate = 15.0 / largest if name == "nonlinear" else 20.0
    size = np.linalg.norm(run["d_error"][0], axis=1)
    assert (size <= size[0] * np.exp(-rate * run.t) * (1 + 1e-6) + 1e-10).all()  # RK4 at h l = 0.01


@pytest.mark.parametrize("name", ["oracle", *HONEST])
def test_a_moving_disturbance_is_followed_within_its_bound(name):
    """|D - D_hat| <= L_D / l in the end; the nonlinear observer max eig M L_D / l."""
    ode = loop(OBSERVERS[name][0]).ode()
    run = simulate(rk4(ode, 1e-3), until=8.0, every=1e-2)
    p = ode.parameters.unpack(ode.parameters.default)
    L_D = np.hypot(0.5 * 3, 0.4 * 4)
    largest = max(np.linalg.eigvalsh(matrices(p, "plant.arm", q, 0 * q)[0])[-1] for q in run["q"][0])
    bound = largest * L_D / 15.0 if name == "nonlinear" else L_D / 20.0
    assert np.linalg.norm(run["d_error"][0, 400:], axis=1).max() <= bound * (1 + 1e-6)


@pytest.mark.parametrize("name", HONEST)
def test_what_the_model_leaves_out_counts_as_disturbance(name):
    """Held at rest, D_hat is D and the weight that the believed arm lacks: G of the true arm minus G of the model."""
    ode = loop(
        OBSERVERS[name][0], reference=Constant("q", "rad", [0.6, -0.8]), amplitude=(2.0, 1.0), frequency=(0.0, 0.0)
    ).ode()
    run = simulate(rk4(ode, 1e-3), ode.parameters.pack({"plant.arm.links[1].mass": 1.3}), until=30.0, every=1.0)
    q = run["q"][0, -1]
    tip = 0.3 * 9.81 * np.sin(q.sum())
    lacking = np.array([0.3 * 9.81 * np.sin(q[0]) + tip, tip])
    np.testing.assert_allclose(run["d_error"][0, -1], -lacking, atol=1e-8)  # the slowest mode has decayed for 30 s


@pytest.mark.parametrize("name", OBSERVERS)
def test_who_uses_the_truth_says_so(name):
    truth = name not in HONEST
    assert OBSERVERS[name][0].uses_truth is truth
    assert bool(loop(OBSERVERS[name][0]).ode().notes) is truth


def test_who_takes_the_truth_without_saying_so_cannot_be_built():
    with pytest.raises(
        LookupError, match=r"`StateAndDisturbanceObserver.estimate\(...\)` asks for a signal that its ports do not"
    ):
        loop(Cheat()).ode()


def test_the_state_of_each_lies_below_its_name():
    copy = Luenberger(paper_arm(), L1=30 * np.eye(2), L2=50 * np.eye(2), q_hat=[0.0, 0.0])
    ode = loop(OBSERVERS["momentum"][0], state=copy).ode()
    own = [name for name in ode.states.names if name.startswith("observer.")]
    assert own == ["observer.state.q_hat", "observer.state.qd_hat", "observer.disturbance.p_hat"]
    assert "observer.disturbance.l" in ode.parameters
    assert "observer.state.L1" in ode.parameters


def test_observers_of_different_arms_are_refused():
    with pytest.raises(ValueError, match="a state of 2 joints and a disturbance of 3"):
        StateAndDisturbanceObserver(ArmFullState(2), MomentumObserver(robot("planar-3r"), l=10.0))


def test_a_rate_of_zero_is_refused():
    with pytest.raises(ValueError, match=r"`MomentumObserver\(l=...\)` must be finite, with 0 < value \[1/s\]"):
        MomentumObserver(paper_arm(), l=0.0)


@pytest.mark.parametrize("kind", [PrintedFilter, OracleFilter])
def test_what_is_no_number_of_joints_is_refused(kind):
    with pytest.raises(ValueError, match=r"\(joints=...\)` must be a whole number( of joints from 1 to 1000)?; got"):
        kind(0, l=1.0)
