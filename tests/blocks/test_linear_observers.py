"""Luenberger's observer, the steady Kalman filter and the extended-state observer, of any plant."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are, solve_discrete_are

from tests.support.observed import Balance, CartPole, Constant, Oscillator, Pendulum, Swaying
from workbench.arms.observers import ExtendedStateObserver
from workbench.blocks.loop import ClosedLoop, Instruments, open_loop
from workbench.blocks.observers import ExtendedKalmanFilter, LinearObserver, SteadyKalmanFilter, UnscentedKalmanFilter
from workbench.blocks.observers.observer_model import phi
from workbench.core import Signals, rk4
from workbench.design.riccati import lqr, steady_kalman
from workbench.engine import simulate

A, B, C = np.array([[0.0, 1.0], [-4.0, -0.3]]), np.array([[0.0], [1.0]]), np.eye(1, 2)
L = np.array([[3.0], [4.0]])


@pytest.mark.parametrize("size", [1e-3, 1.0, 30.0])
def test_phi_of_a_matrix_is_that_of_scipy(size):
    rng = np.random.default_rng(3)
    for _ in range(20):
        M = rng.normal(size=(4, 4))
        M[3] = M[0] + M[1]  # singular
        M *= size / np.abs(np.linalg.eigvals(M)).max()
        expected = expm(np.block([[M, np.eye(4)], [np.zeros((4, 8))]]))[:4, 4:]
        # six squarings double what rounding leaves, relative to the largest entry
        np.testing.assert_allclose(ca.DM(phi(ca.SX(M))), expected, rtol=0, atol=1e-11 * np.abs(expected).max())


def rates(observer, plant=None):
    """The rates of an observer's states as a function of all states, with the outputs and the command by hand."""
    ode = ClosedLoop(plant or Pendulum(), observer, Swaying()).ode()
    return lambda x, t: np.array(ode.f(t, x, ode.parameters.default)).ravel()[2:]


def test_with_the_nonlinear_model_it_is_the_equation_written_by_hand():
    rate, rng = rates(LinearObserver(Pendulum(k=8.0), L, ("height",))), np.random.default_rng(1)
    for _ in range(20):
        t, (p, v, q, w) = rng.uniform(0, 9), rng.normal(size=4)
        off = np.cos(q) - np.cos(p)
        expected = [w + 3 * off, -8 * np.sin(q) - 0.2 * w + np.sin(3 * t) + 4 * off]
        np.testing.assert_allclose(rate([p, v, q, w], t), expected, rtol=0, atol=1e-13)  # rounding


def test_about_a_point_it_is_the_linear_equation_written_by_hand():
    """At phi = 0.7 the command 9 sin 0.7 rests; without u_0 the rate that is left there counts."""
    x_0, rng = 0.7, np.random.default_rng(2)
    for u_0 in (9 * np.sin(x_0), None):
        rate = rates(LinearObserver(Pendulum(), L, ("height",), [x_0, 0.0], None if u_0 is None else [u_0]))
        for _ in range(20):
            t, (p, v, q, w) = rng.uniform(0, 9), rng.normal(size=4)
            off = (1 - np.cos(p)) - (1 - np.cos(x_0)) - np.sin(x_0) * (q - x_0)
            f = -9 * np.sin(x_0) - 9 * np.cos(x_0) * (q - x_0) - 0.2 * w + np.sin(3 * t)
            np.testing.assert_allclose(rate([p, v, q, w], t), [w + 3 * off, f + 4 * off], rtol=0, atol=1e-13)


def test_its_error_has_the_poles_of_a_minus_l_c():
    ode = ClosedLoop(Oscillator(), LinearObserver(Oscillator(), L, ("p",)), Swaying()).ode()
    both = np.linalg.eigvals(np.array(ode.A(0.0, np.zeros(4), ode.parameters.default)))
    expected = np.concatenate([np.linalg.eigvals(A), np.linalg.eigvals(A - L @ C)])
    np.testing.assert_allclose(np.sort_complex(both), np.sort_complex(expected), rtol=1e-10)  # simple poles


@pytest.mark.parametrize("point", [[0.0, 0.0], None])
def test_in_a_computer_it_is_exact_for_what_is_held(point):
    h = 0.2
    loop = ClosedLoop(Oscillator(), LinearObserver(Oscillator(p=0.0), L, ("p",), point), Swaying()).digital(h)
    r = simulate(loop.step(2), until=4.0)
    Phi = expm(np.block([[A - L @ C, B, L], [np.zeros((2, 4))]]) * h)
    x = np.zeros(2)
    for k in range(len(r.t) - 1):
        x = Phi[:2] @ [*x, r["hold.a"][0, k + 1, 0], r["plant.p"][0, k]]
        got = [r["observer.p_hat"][0, k + 1], r["observer.v_hat"][0, k + 1]]
        np.testing.assert_allclose(got, x, rtol=0, atol=1e-13)  # rounding


def test_in_a_computer_it_is_of_second_order_for_a_nonlinear_model():
    observer = LinearObserver(Pendulum(phi=1.0), L, ("phi",))
    z = {"phi_hat": ca.SX(1.0), "omega_hat": ca.SX(0.5)}
    y, u = Signals(phi=ca.SX(0.3)), Signals(a=ca.SX(2.0))

    def held(t, x):
        off = 0.3 - x[0]
        return [x[1] + 3 * off, -9 * np.sin(x[0]) - 0.2 * x[1] + 2.0 + 4 * off]

    misses = []
    for h in (0.04, 0.02):
        z_next = observer.advance(ca.SX(0), z, y, Signals(), u, h)
        exact = solve_ivp(held, (0, h), [1.0, 0.5], rtol=1e-12, atol=1e-13).y[:, -1]
        misses.append(np.abs(np.array(ca.DM(ca.vertcat(*z_next.values()))).ravel() - exact).max())
    assert 7 < misses[0] / misses[1] < 9  # one step of second order errs by h^3


Q, R, h = np.diag([0.1, 0.2]), np.array([[0.01]]), 0.05


def test_the_steady_gain_is_that_of_scipys_riccati_equations():
    ode = open_loop(Oscillator())
    X = solve_continuous_are(A.T, C.T, Q, R)
    np.testing.assert_allclose(steady_kalman(ode, Q, R, ("p",)).K, X @ C.T / R, rtol=1e-9)  # SciPy's rounding
    Phi = expm(A * h)
    s, weights = np.polynomial.legendre.leggauss(12)
    Qd = sum(
        w * h / 2 * expm(A * h * (1 + a) / 2) @ Q @ expm(A.T * h * (1 + a) / 2) for a, w in zip(s, weights, strict=True)
    )
    X = solve_discrete_are(Phi.T, C.T, Qd, R)
    answer = steady_kalman(ode, Q, R, ("p",), period=h)
    np.testing.assert_allclose(answer.K, X @ C.T / (C @ X @ C.T + R), rtol=1e-9)
    np.testing.assert_allclose(
        np.sort_complex(answer.poles), np.sort_complex(np.linalg.eigvals((np.eye(2) - answer.K @ C) @ Phi)), rtol=1e-9
    )


def test_the_steady_filter_is_the_extended_one_that_starts_where_it_settles():
    answer, model = steady_kalman(open_loop(Oscillator()), Q, R, ("p",), period=h), Oscillator(p=0.0)
    runs = [
        simulate(ClosedLoop(Oscillator(), observer, Swaying()).digital(h).step(2), until=4.0)
        for observer in (
            SteadyKalmanFilter(model, answer.K, h, ("p",), substeps=4),
            ExtendedKalmanFilter(model, Q, R, answer.X, h, ("p",), substeps=4),
        )
    ]
    for name in ("p_error", "v_error"):
        np.testing.assert_allclose(*(r[name] for r in runs), rtol=0, atol=1e-8)  # P moved by RK4, not exactly


@pytest.mark.parametrize("chain", [("p",), ("p", "v"), ("p", "v", "w")])
def test_each_pole_of_the_error_of_an_extended_state_observer_is_minus_its_bandwidth(chain):
    observer = ExtendedStateObserver(chain, "a", b=2.0, omega_o=7.0, unit="m")
    ode = ClosedLoop(Oscillator(), observer, Swaying()).ode()
    n = len(chain) + 1
    F = np.array(ode.A(0.0, np.zeros(2 + n), ode.parameters.default))[2:, 2:]
    # coefficients and not the poles, of which n equal ones move by the n-th root of rounding
    np.testing.assert_allclose(np.poly(F), np.poly([-7.0] * n), rtol=1e-11)
    assert [e.unit for e in observer.gives.entries] == ["m", "m/s", "m/s^2", "m/s^3"][:n]


@pytest.mark.parametrize("digital", [False, True])
def test_an_extended_state_observer_finds_all_that_it_was_not_told(digital):
    """A pendulum comes to rest; there phi'' = 0 and so d_hat = -b a, here 0.5, whatever its numbers are."""
    observer = ExtendedStateObserver(("phi", "omega"), "a", b=1.0, omega_o=20.0)
    loop = ClosedLoop(Pendulum(c=4.0, d=1.5), observer, Constant(-0.5))
    r = simulate(loop.digital(0.01).step(1) if digital else rk4(loop.ode(), 1e-3), until=20.0, every=20.0)
    np.testing.assert_allclose(r["observer.d_hat"][0, -1], 0.5, rtol=0, atol=1e-9)  # exp(-2 * 20) is left, and rounding


def test_a_fast_extended_state_observer_is_stable_in_a_slow_computer():
    """omega_o h = 20, where explicit Euler would multiply its error by 19 each period."""
    loop = ClosedLoop(Pendulum(c=4.0), ExtendedStateObserver(("phi", "omega"), "a", 1.0, 200.0), Constant(0.0))
    r = simulate(loop.digital(0.1).step(10), until=10.0)
    assert np.abs(r["phi_error"][0, -1]) < 1e-8


K = (-70.7107, -37.8345, 105.5298, 20.9238)  # of the issue: Q = diag(5000, 0, 100, 0), R = 1
CART = CartPole(phi=0.2, p=0.1)


def test_the_cart_pole_has_the_gain_of_its_tutorial():
    ode = open_loop(CartPole())
    A, B = (np.array(J(0.0, np.zeros(4), ode.parameters.default)) for J in (ode.A, ode.B))
    np.testing.assert_allclose(lqr(A, B, np.diag([5000.0, 0, 100, 0]), [[1.0]]).K[0], K, rtol=0, atol=5e-5)


def watchers():
    """Each observer of the cart-pole that reads positions alone, and starts upright in the middle."""
    model, Q, R, h = CartPole(), np.diag([0.0, 1.0, 0.0, 10.0]), np.diag([1e-4, 1e-4]), 0.005
    ode = open_loop(model)
    P = np.diag([0.04, 0.01, 0.09, 0.01])
    flow, step = steady_kalman(ode, Q, R * h).K, steady_kalman(ode, Q, R, period=h).K
    return {
        "linear": LinearObserver(model, flow, x_0=np.zeros(4)),
        "nonlinear": LinearObserver(model, flow),
        "steady": SteadyKalmanFilter(model, step, h),
        "extended": ExtendedKalmanFilter(model, Q, R, P, h),
        "unscented": UnscentedKalmanFilter(model, Q, R, P, h),
        "slow cart": ExtendedKalmanFilter(model, Q, R, P, h, every={"p": 10}),
    }


@pytest.mark.parametrize("name", ["linear", "nonlinear", "steady", "extended", "unscented", "slow cart"])
def test_a_pole_is_balanced_by_positions_alone(name):
    loop = ClosedLoop(CART, watchers()[name], Balance(np.array([K])))
    r = simulate(loop.digital(0.005).step(2), until=6.0, arithmetic="casadi")
    for state in ("p", "v", "phi", "omega"):
        assert np.abs(r[f"plant.{state}"][0, -1]) < 1e-3
    assert np.abs(r["phi"]).max() < 0.5


@pytest.mark.parametrize("name", ["linear", "extended", "unscented"])
def test_a_pole_is_balanced_under_noise(name):
    loop = ClosedLoop(CART, watchers()[name], Balance(np.array([K])))
    gauges = Instruments.of(CART, noise={"p": 0.01, "phi": 0.01})
    r = simulate(loop.digital(0.005, gauges, delay=True).step(2), until=6.0, seed=4, arithmetic="casadi")
    assert np.abs(r["phi"][0, 600:]).max() < 0.1


def test_two_observers_of_continuous_time_drive_the_loop_there_too():
    for name in ("linear", "nonlinear"):
        r = simulate(rk4(ClosedLoop(CART, watchers()[name], Balance(np.array([K]))).ode(), 1e-3), until=6.0, every=6.0)
        assert np.abs(r["phi"][0, -1]) < 1e-4


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: LinearObserver(Oscillator(), L),
            ValueError,
            r"\(2, 2\), a row for each of p, v and a column for each",
        ),
        (lambda: LinearObserver(Oscillator(), L, ("q",)), LookupError, "no 'q' among the 2 outputs of `Oscillator`"),
        (lambda: LinearObserver(Oscillator(), L, ("p",), [0.0]), ValueError, r"x_0=\.\.\.\)` must have shape \(2,\)"),
        (lambda: LinearObserver(Oscillator(), L, ("p",), u_0=[0.0]), ValueError, "must come with x_0"),
        (lambda: SteadyKalmanFilter(Oscillator(), L, 0.0, ("p",)), ValueError, "positive, finite number of seconds"),
        (lambda: SteadyKalmanFilter(Oscillator(), L, 0.1, ("p",), 0), ValueError, "whole number from 1 to 1000"),
        (lambda: ExtendedStateObserver((), "a", 1.0, 1.0), ValueError, "names that differ"),
        (lambda: ExtendedStateObserver(("p", "d"), "a", 1.0, 1.0), ValueError, "names that differ"),
        (lambda: steady_kalman(open_loop(Oscillator()), Q, R, ("q",)), LookupError, "no 'q' among the 2"),
        (lambda: steady_kalman(open_loop(Oscillator()), Q, np.eye(2), ("p",)), ValueError, "R must be"),
        (lambda: steady_kalman(open_loop(Oscillator()), Q, R, ("p",), period=-1.0), ValueError, "number of seconds"),
    ],
)
def test_what_does_not_fit_is_refused(make, error, words):
    with pytest.raises(error, match=words):
        make()


def test_a_filter_of_discrete_time_is_refused_in_continuous_time():
    with pytest.raises(ValueError, match="`SteadyKalmanFilter` is a recursion in discrete time"):
        ClosedLoop(Oscillator(), SteadyKalmanFilter(Oscillator(), L, 0.1, ("p",)), Swaying()).ode()
