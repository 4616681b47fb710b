"""The memories of a computer, stepped by declared methods: against exact flows, SciPy and steps written by hand."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are

from tests.support.arms import arm_instruments
from tests.support.cases import heavy_but
from tests.support.riccati_steps import cayley, hamiltonian, moebius
from workbench.arms.laws import AosmcRgs, ArmPID, DisturbanceCompensation, RbfAsmc, SuperTwisting
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import paper_arm
from workbench.arms.observers import ArmFullState, Luenberger, MomentumObserver, StateAndDisturbanceObserver
from workbench.blocks.loop import ClosedLoop
from workbench.blocks.signals import Constant, Sines
from workbench.core import Signals
from workbench.engine import simulate

ARM, I = paper_arm(), np.eye(2)
LAW = {
    "model": ARM,
    "Lambda": [6.0, 5.0],
    "phi": 0.05,
    "K": 107 * I,
    "P": 10 * I,
    "Q": 3 * I,
    "R": I,
    "velocity": "reference",
    "gain_sign": "zero",
}
PIDS = {"Kp": [60.0, 40.0], "Ki": [20.0, 10.0], "Kd": [10.0, 8.0]}
TUNED = {"model": ARM, "L1": 5.13 * I, "L2": 3180 * I, "q_hat": [0.5, -0.7]}  # damping 0.045
LAMBDA = -5.13 / 2 + 1j * np.sqrt(3180 - 5.13**2 / 4)  # a mode of its error


def loop(law, observer=None):
    return ClosedLoop(
        Manipulator(ARM, q=[0.6, -0.8]),
        observer or ArmFullState(2),
        law,
        Sines("q", "rad", amplitude=[1.0, 0.5], frequency=[2.0, 3.0]),
    )


@pytest.mark.parametrize(("K", "period"), heavy_but([(107, 4e-3), (107, 1e-2), (500, 1e-2)], (500, 1e-2)))
def test_where_euler_loses_the_riccati_equation_its_cayley_step_keeps_it(K, period):
    """Its factor at the algebraic solution is 1 - 2 h |a|, as large as -4.0 at 107 N m and 4 ms."""
    ends = {
        name: simulate(
            loop(AosmcRgs(**LAW | {"K": K * I}, integrator=name)).digital(period).step(4), until=1.0, every=0.1
        )
        for name in ("euler", "cayley")
    }
    assert ends["euler"].diverged_at[0] < 0.5
    assert np.isnan(ends["cayley"].diverged_at[0])
    assert (np.linalg.eigvalsh(ends["cayley"]["controller.P"][0]) > 0).all()


def test_in_a_loop_k_moves_by_euler_and_p_by_the_step_at_the_k_before():
    law = AosmcRgs(**LAW | {"gain_sign": "raised", "gain_shape": "norm"}, integrator="cayley")
    step = loop(law).digital(4e-3).step()
    before, after = (
        step.states.unpack(x)
        for x in (step.states.default, np.array(step.F(0, step.states.default, step.parameters.default, [])).ravel())
    )
    M = np.array(ca.DM(ARM.mass_matrix(ca.SX([0.6, -0.8]))))
    A, G = -np.linalg.solve(M, before["controller.K"]), np.diag([36.0, 25.0])
    P = moebius(cayley(hamiltonian(A, G, 3 * I), 4e-3), 10 * I)
    np.testing.assert_allclose(after["controller.P"], P, rtol=1e-9)
    growth = 10 * I * np.abs(after["hold.s"]).sum()
    np.testing.assert_allclose(after["controller.K"], 107 * I + 4e-3 * growth, rtol=1e-13)


def error_dynamics(period, **changes):
    """The error (q - q_hat, qd - qd_hat) of an observer of the arm after a period, where the model's a is right."""
    observer = Luenberger(**TUNED | changes)
    z = {"q_hat": ca.SX.sym("q", 2), "qd_hat": ca.SX.sym("v", 2)}
    est = Signals(q=z["q_hat"], qd=z["qd_hat"], d=ca.SX.zeros(2))
    tau = ca.SX(ARM.coriolis_matrix(*z.values()) @ z["qd_hat"] + ARM.gravity_vector(z["q_hat"]))  # so that a = 0
    after = observer.advance(ca.SX(0), z, Signals(q=ca.SX.zeros(2), qd=ca.SX.zeros(2)), est, Signals(tau=tau), period)
    x = ca.vertcat(*z.values())
    return np.array(ca.Function("J", [x], [ca.jacobian(ca.vertcat(*after.values()), x)])(np.array([0.3, 1, 0.1, -0.2])))


def test_the_cayley_step_keeps_the_decay_of_the_tuned_observer_that_euler_loses():
    exact = abs(np.exp(LAMBDA * 1e-3))
    euler, stepped_ = (np.linalg.eigvals(error_dynamics(1e-3, integrator=name)) for name in ("euler", "cayley"))
    loss = {name: 1 - np.log(abs(z)) / np.log(exact) for name, z in {"euler": euler, "cayley": stepped_}.items()}
    assert (loss["euler"] > 0.5).all()
    assert (np.abs(loss["cayley"]) < 1e-2).all()
    factor = (1 + LAMBDA * 5e-4) / (1 - LAMBDA * 5e-4)  # of second order: off exp(lambda h) by |lambda h|^3 / 12
    np.testing.assert_allclose(np.sort_complex(stepped_)[-1], factor, rtol=1e-6)  # double eigenvalues: root of rounding
    assert abs(factor - np.exp(LAMBDA * 1e-3)) < abs(LAMBDA * 1e-3) ** 3 / 11


@pytest.mark.parametrize("period", [4e-3, 1e-2, 0.1])
def test_at_a_longer_period_euler_makes_the_tuned_observer_grow_and_the_cayley_step_does_not(period):
    grows = {n: np.abs(np.linalg.eigvals(error_dynamics(period, integrator=n))).max() for n in ("euler", "cayley")}
    assert grows["euler"] > 1 > grows["cayley"]


def test_the_error_dynamics_of_the_cayley_step_are_similar_to_the_cayley_transform():
    """For any L1 and L2, which need not commute."""
    L1, L2, h = np.array([[30.0, 8.0], [-4.0, 25.0]]), np.array([[400.0, 90.0], [-30.0, 380.0]]), 5e-3
    ours = np.linalg.eigvals(error_dynamics(h, L1=L1, L2=L2, integrator="cayley"))
    theirs = np.linalg.eigvals(cayley(np.block([[-L1, I], [-L2, 0 * I]]), h))
    np.testing.assert_allclose(np.sort_complex(ours), np.sort_complex(theirs), rtol=1e-10)


def test_without_an_error_the_cayley_step_moves_as_the_acceleration_of_the_model_moves_an_arm():
    observer, h = Luenberger(**TUNED, integrator="cayley"), 1e-2
    q, v, tau = ca.SX([0.3, -0.5]), ca.SX([1.0, 2.0]), ca.SX([4.0, 1.0])
    z = {"q_hat": q, "qd_hat": v}
    after = observer.advance(ca.SX(0), z, Signals(q=q, qd=v), Signals(q=q, qd=v, d=ca.SX.zeros(2)), Signals(tau=tau), h)
    a = np.array(ca.DM(ARM.acceleration(q, v, tau)))
    np.testing.assert_allclose(ca.DM(after["q_hat"]), ca.DM(q) + h * ca.DM(v) + h**2 / 2 * a, rtol=1e-14)
    np.testing.assert_allclose(ca.DM(after["qd_hat"]), ca.DM(v) + h * a, rtol=1e-14)


@pytest.mark.parametrize("n", [2, pytest.param(3, marks=pytest.mark.heavy)])
def test_p_that_is_solved_for_runs_in_a_sampled_loop_too(n):
    """Its matrix among the signals stopped the loop from being made: 'hold.P' had the shape of a column."""
    solved = AosmcRgs(**{k: v for k, v in LAW.items() if k != "P"} | {"K": 5 * I}, riccati="algebraic")
    if n == 3:
        from workbench.arms.mechanics import robot

        solved = replace(solved, model=robot("planar-3r"), Lambda=[6.0] * 3, K=5 * np.eye(3), Q=np.eye(3), R=np.eye(3))
    q = [0.1] * n
    closed = ClosedLoop(Manipulator(solved.model, q=q), ArmFullState(n), solved, Constant("q", "rad", q))
    for step in (
        closed.digital(1e-3).step(2),
        closed.digital(1e-3, arm_instruments(n, noise_q=1e-4), delay=True).step(2),
    ):
        run = simulate(step, until=0.02)
        shown = run["P"][0, -1].reshape(n, n)
        np.testing.assert_array_equal(shown, shown.T)
        M = np.array(ca.DM(solved.model.mass_matrix(ca.SX(run["plant.q"][0, -1]))))
        exact = solve_continuous_are(-np.linalg.solve(M, 5 * np.eye(n)), np.diag(solved.Lambda), solved.Q, solved.R)
        np.testing.assert_allclose(shown, exact, rtol=2e-2)  # where q was read, with noise
        assert run["residual"].max() < 1e-12


@pytest.mark.heavy
def test_fine_is_the_exact_flow_of_the_memories_with_all_else_held():
    closed = loop(AosmcRgs(**LAW), Luenberger(**TUNED))
    step = closed.digital(4e-3, integrator="fine").step(1)  # no memory asks for the arm between two instants
    x = step.states.default
    after = step.states.unpack(np.array(step.F(0, x, step.parameters.default, [])).ravel())
    M = np.array(ca.DM(ARM.mass_matrix(ca.SX([0.5, -0.7]))))
    P = moebius(expm(4e-3 * hamiltonian(-107 * np.linalg.inv(M), np.diag([36.0, 25.0]), 3 * I)), 10 * I)
    np.testing.assert_allclose(after["controller.P"], P, rtol=1e-3)  # RK4 at 0.25 ms on modes of 1,250 1/s
    L, q, v = np.array([0.6, -0.8]), ca.SX.sym("q", 2), ca.SX.sym("v", 2)
    acceleration = ca.Function("a", [q, v], [ARM.acceleration(q, v, ca.SX(after["hold.tau"]))])

    def rate(t, z):
        a = np.array(acceleration(z[:2], z[2:])).ravel()
        return np.concatenate([z[2:] + 5.13 * (L - z[:2]), a + 3180 * (L - z[:2])])

    theirs = solve_ivp(rate, (0, 4e-3), [0.5, -0.7, 0.0, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(np.concatenate([after["observer.q_hat"], after["observer.qd_hat"]]), theirs, rtol=1e-7)


def test_a_loop_names_the_method_of_each_block_that_has_a_memory():
    behind = StateAndDisturbanceObserver(Luenberger(**TUNED, integrator="cayley"), MomentumObserver(ARM, 5.0))
    assert loop(AosmcRgs(**LAW, integrator="cayley"), behind).digital(1e-3).methods == (
        "memory of the observer: Cayley step of (10), D_hat by explicit Euler",
        "memory of the controller: K by explicit Euler, P by a Cayley step of (34)",
    )
    assert loop(ArmPID(**PIDS)).digital(1e-3).methods == ("memory of the controller: explicit Euler",)
    assert loop(ArmPID(**PIDS)).digital(1e-3, integrator="fine").methods == (
        "memory of the controller: 16 Runge-Kutta steps a period",
    )
    implicit = SuperTwisting(ARM, [6.0, 5.0], [8.0, 9.0], [20.0, 25.0], 0.1, saturation="implicit")
    assert loop(implicit).digital(1e-3).methods == ("memory of the controller: backward Euler",)


# What is refused


@pytest.mark.parametrize("integrator", ["exact", "", None, 3])
def test_an_integrator_that_is_none_is_refused(integrator):
    with pytest.raises(ValueError, match=r"`ClosedLoop.digital\(integrator=...\)`"):
        loop(ArmPID(**PIDS)).digital(1e-3, integrator=integrator)


@pytest.mark.parametrize("changes", [{"riccati": "frozen", "Q": None, "R": None}, {"riccati": "algebraic", "P": None}])
def test_a_step_of_34_is_refused_where_34_is_not_integrated(changes):
    with pytest.raises(ValueError, match=r"^`AosmcRgs\(integrator='cayley'\)` is a step of \(34\)"):
        AosmcRgs(**LAW | changes, integrator="cayley")


def test_each_part_of_the_law_can_be_left_out_whatever_its_integrator():
    assert AosmcRgs(**LAW | {"gain_sign": "raised"}, integrator="cayley").without().keys() >= {"Riccati equation"}


@pytest.mark.parametrize("sigma", [0.0, 2.0, 900.0])
def test_the_network_forgets_exactly_over_a_period(sigma):
    """W' = -Gamma h s^T - sigma W with h and s held, by SciPy; also where explicit Euler is not stable."""
    nodes = {"centres": np.outer([-1.0, 0.0, 1.0], np.ones(4)), "widths": np.ones(4)}
    law = RbfAsmc(ARM, [6.0, 5.0], 0.1, 2.0, 30.0, sigma, K=[5.0, 5.0], **nodes, integrator="exact")
    z = {"K": ca.SX([5.0, 6.0]), "W": ca.SX(np.arange(6.0).reshape(3, 2))}
    est = Signals(q=ca.SX([0.3, -0.2]), qd=ca.SX([0.1, 0.4]), d=ca.SX.zeros(2))
    ref, h = Signals(q=ca.SX([0.1, 0.0]), qd=ca.SX([0.0, 0.2]), qdd=ca.SX([0.0, 0.0])), 4e-3
    forced = np.array(ca.DM(law.rate(0.0, z | {"W": ca.SX.zeros(3, 2)}, est, ref)["W"]))
    W = np.arange(6.0).reshape(3, 2)
    exact = solve_ivp(
        lambda t, w: forced.ravel() - sigma * w, (0, h), W.ravel(), method="Radau", rtol=1e-11, atol=1e-13
    )
    moved = law.advance(0.0, z, est, ref, h)
    np.testing.assert_allclose(np.array(ca.DM(moved["W"])).ravel(), exact.y[:, -1], rtol=1e-8, atol=1e-10)  # of Radau
    assert law.method == "exact step of W, K by explicit Euler"


def test_a_law_with_compensation_steps_as_the_law_does():
    nodes = {"centres": np.outer([-1.0, 0.0, 1.0], np.ones(4)), "widths": np.ones(4)}
    law = RbfAsmc(ARM, [6.0, 5.0], 0.1, 2.0, 30.0, 900.0, K=[5.0, 5.0], **nodes, integrator="exact")
    behind = StateAndDisturbanceObserver(Luenberger(**TUNED), MomentumObserver(ARM, 5.0))
    assert (
        "memory of the controller: exact step of W, K by explicit Euler"
        in loop(DisturbanceCompensation(law), behind).digital(1e-3).methods
    )
    alone, summed = (
        simulate(loop(one).digital(4e-3).step(2), until=0.1)["tau"] for one in (law, DisturbanceCompensation(law))
    )
    np.testing.assert_array_equal(alone, summed)  # beside an observer without a disturbance D_hat = 0
