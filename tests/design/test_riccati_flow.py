"""Riccati equations in time, against closed forms, another integrator, and what optimality says of the cost."""

import re

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_are

from tests.support.cases import heavy_but
from workbench.design.matrices import DesignError
from workbench.design.riccati_flow import fpre, rde

A4 = np.array([[0.0, 1, 0, 0], [-2, -0.3, 0.5, 0], [0, 0, 0, 1], [1, 0, 3, 0.2]])
B4 = np.array([[0.0, 0], [1, 0], [0, 0], [0.3, 2]])
I2 = np.eye(2)


def scalar(a, g, q, p0, t):
    """The closed form of p' = 2 a p - g p^2 + q."""
    s = np.sqrt(a * a + g * q)
    T = np.tanh(s * t)
    return (p0 * (s + a * T) + q * T) / (s + (g * p0 - a) * T)


def by_dop853(A, B, Q, R, P0, times):
    """(34) integrated as a plain ODE, at tolerances near rounding."""
    n = len(P0)

    def rhs(t, p):
        P = p.reshape(n, n)
        return (A(t).T @ P + P @ A(t) - P @ B(t) @ np.linalg.solve(R(t), B(t).T @ P) + Q(t)).ravel()

    done = solve_ivp(rhs, (times[0], times[-1]), P0.ravel(), "DOP853", t_eval=times, rtol=1e-12, atol=1e-13)
    assert done.success
    return done.y.T.reshape(-1, n, n)


def paper_A(t):
    """A = -5 M^-1 along q_d = (sin 2t, 0.5 sin 3t) for the paper's arm, whose C = 2 + 2 cos q2 and so on."""
    c = np.cos(0.5 * np.sin(3 * t))
    return -5 * np.linalg.inv(np.array([[3 + 2 * c, 1 + c], [1 + c, 1.0]]))


@pytest.mark.parametrize("a", [-3.0, 0.0, 2.0])
@pytest.mark.parametrize("p0", [0.0, 1.0, 1e6])
def test_one_state_follows_the_closed_form(a, p0):
    times = np.array([0.0, 1e-6, 1e-3, 0.1, 1.0, 20.0])
    flow = fpre(a, 1.0, 3.0, 2.0, p0, times)
    # rounding of the closed form, which loses the digits of a large p0 against g p0 tanh
    np.testing.assert_allclose(flow.P[:, 0, 0], scalar(a, 0.5, 3.0, p0, times), rtol=1e-12)


def test_with_varying_coefficients_p_is_that_of_another_integrator():
    times = np.linspace(0, 3, 13)
    flow = fpre(paper_A, 6 * I2, I2, I2, 10 * I2, times)
    theirs = by_dop853(paper_A, lambda t: 6 * I2, lambda t: I2, lambda t: I2, 10 * I2, times)
    np.testing.assert_allclose(flow.P, theirs, rtol=1e-10, atol=1e-11)  # both tolerances


def test_every_coefficient_may_vary():
    def B(t):
        return B4 * (1 + 0.5 * np.cos(t))

    def Q(t):
        return np.diag([1.0, 2, 3, 4]) * (1.5 + np.sin(2 * t))

    def R(t):
        return np.array([[2 + np.sin(t), 0.3], [0.3, 1.0]])

    times = np.linspace(1.0, 3.0, 5)
    flow = fpre(lambda t: A4 * np.cos(t), B, Q, R, np.eye(4), times)
    theirs = by_dop853(lambda t: A4 * np.cos(t), B, Q, R, np.eye(4), times)
    np.testing.assert_allclose(flow.P, theirs, rtol=1e-9, atol=1e-10)  # both tolerances, small entries beside large
    np.testing.assert_allclose(flow.K, [np.linalg.solve(R(t), B(t).T @ P) for t, P in zip(times, flow.P, strict=True)])


def test_backward_is_forward_with_time_turned_round():
    times = np.array([0.0, 0.5, 2.0])
    backward = rde(lambda t: paper_A(2.0 - t), 6 * I2, I2, I2, 10 * I2, times)
    forward = fpre(paper_A, 6 * I2, I2, I2, 10 * I2, 2.0 - times[::-1])
    np.testing.assert_allclose(backward.P, forward.P[::-1], rtol=1e-10)  # the tolerance of both


def test_the_two_marches_agree_where_both_apply():
    times = [0.0, 0.3, 1.0]
    constant = rde(A4, B4, np.eye(4), I2, np.zeros((4, 4)), times)
    varying = rde(lambda t: A4, B4, np.eye(4), I2, np.zeros((4, 4)), times)
    np.testing.assert_allclose(constant.P, varying.P, rtol=1e-10, atol=1e-10)  # the tolerance asked for


def test_far_from_the_horizon_p_is_the_algebraic_solution():
    X = solve_continuous_are(A4, B4, np.eye(4), I2)
    flow = rde(A4, B4, np.eye(4), I2, np.zeros((4, 4)), [0.0, 100.0])
    np.testing.assert_allclose(flow.P[0], X, rtol=1e-11)  # SciPy's rounding
    assert flow.rest[0] < 1e-14
    assert flow.distance[0] < 1e-11
    assert flow.distance[1] == 1.0  # P = 0 at the horizon


def test_the_least_cost_is_the_one_that_simulation_pays():
    """x0' P(0) x0 against the cost of the loop closed by K(t), and against a loop with another gain."""
    P1 = np.diag([3.0, 1, 2, 1])
    points = chebyshev.chebpts1(65)
    K = rde(A4, B4, np.eye(4), I2, P1, [*(points + 1), 2.0]).K[:-1]
    series = chebyshev.chebfit(points, K.reshape(65, -1), 64)
    x0 = np.array([1.0, -0.5, 0.3, 0.8])

    def cost(scale):
        def rhs(t, z):
            u = -scale * chebyshev.chebval(t - 1, series).reshape(2, 4) @ z[:4]
            return np.append(A4 @ z[:4] + B4 @ u, z[:4] @ z[:4] + u @ u)

        end = solve_ivp(rhs, (0, 2.0), np.append(x0, 0.0), "DOP853", rtol=1e-8, atol=1e-9).y[:, -1]
        return end[4] + end[:4] @ P1 @ end[:4]

    best = x0 @ rde(A4, B4, np.eye(4), I2, P1, [0.0, 2.0]).P[0] @ x0
    assert cost(1.0) == pytest.approx(best, rel=1e-7)  # the integrator's tolerance
    assert cost(1.1) > best * (1 + 1e-4)


@pytest.mark.heavy
def test_the_value_of_the_time_varying_regulator_falls_along_its_loop():
    """d/dt x'P(t)x = -x'Qx - u'Ru <= 0."""
    times = np.linspace(0.0, 4.0, 201)
    flow = rde(paper_A, 6 * I2, I2, I2, 10 * I2, times)
    x, values = np.array([1.0, -2.0]), []
    for i, t in enumerate(times):
        values.append(x @ flow.P[i] @ x)
        x = x + (times[1] - times[0]) * (paper_A(t) - 6 * flow.K[i]) @ x
    assert (np.diff(values) < 0).all()


def test_p_keeps_its_symmetry_and_its_sign():
    rng = np.random.default_rng(5)
    for _ in range(8):
        n = int(rng.integers(1, 6))
        A, B, C = rng.normal(size=(n, n)), rng.normal(size=(n, 1)), rng.normal(size=(1, n))
        flow = fpre(A, B, C.T @ C, 1.0, np.zeros((n, n)), [0.0, 0.1, 1.0, 5.0])
        np.testing.assert_array_equal(flow.P, flow.P.transpose(0, 2, 1))
        size = np.linalg.norm(flow.P, axis=(1, 2))
        assert (flow.least >= -1e-15 * n * size).all()  # rounding of the eigenvalues themselves


@pytest.mark.parametrize("horizon", [1.0, 50.0, 1e4])
def test_stiff_and_undamped_modes_take_long_horizons(horizon):
    """From the algebraic solution nothing moves, however long."""
    A, B = np.array([[-1e4, 20, 0], [0, 0, 1.0], [0, -4, 0]]), np.array([[1.0], [0], [0.1]])
    Q = np.diag([1.0, 1.0, 0.0])
    X = solve_continuous_are(A, B, Q, [[1.0]])
    flow = fpre(A, B, Q, 1.0, X, [0.0, horizon], rtol=1e-8)
    np.testing.assert_allclose(flow.P[-1], X, atol=1e-9 * np.abs(X).max())  # eps |A| / slowest rate, of both


def test_the_error_is_what_it_is_said_to_be():
    times = np.array([0.0, 1.0, 3.0])
    theirs = by_dop853(paper_A, lambda t: 6 * I2, lambda t: I2, lambda t: I2, 10 * I2, times)
    for rtol in (1e-3, 1e-6):
        flow = fpre(paper_A, 6 * I2, I2, I2, 10 * I2, times, rtol=rtol)
        off = np.linalg.norm(flow.P - theirs, axis=(1, 2)) / np.linalg.norm(theirs, axis=(1, 2))
        assert (off <= flow.error + 1e-11).all()  # that of the other integrator
        assert flow.error.max() <= rtol


@pytest.mark.parametrize("coefficient", [1.0, lambda t: 1.0], ids=["constant", "varying"])
def test_a_finite_escape_is_refused_with_its_time(coefficient):
    """p' = 2 p - p^2 + 1 from -1: (p - p+)/(p - p-) = z exp(-2 s t) reaches 1 at ln(z) / 2s."""
    s = np.sqrt(2.0)
    when = np.log((-2 - s) / (-2 + s)) / (2 * s)
    for solve, times, pole in ((fpre, [0.0, 1.0], when), (rde, [0.0, 2.0], 2 - when)):
        with pytest.raises(DesignError, match="grows beyond every bound between") as refusal:
            solve(coefficient, 1.0, 1.0, 1.0, -1.0, times)
        low, high = map(float, re.findall(r"between t = (\S+) and (\S+) s", str(refusal.value))[0])
        assert low - 1e-9 <= pole <= high + 1e-9  # a step by the tolerance, magnified near a pole
        assert high - low < 1e-8


def test_an_indefinite_start_that_does_not_escape_is_followed():
    times = np.array([0.0, 0.5, 3.0])
    flow = fpre(-3.0, 1.0, 1.0, 1.0, -2.0, times)
    np.testing.assert_allclose(flow.P[:, 0, 0], scalar(-3.0, 1.0, 1.0, -2.0, times), rtol=1e-13)
    assert flow.least[0] == -2.0


def test_a_weight_that_rewards_lets_p_escape_only_where_it_does():
    """p' = -p^2 - 1 from 1 is tan(pi/4 - t), with a pole at 3 pi/4."""
    flow = fpre(0.0, 1.0, -1.0, 1.0, 1.0, [0.0, 2.3])
    assert flow.P[-1, 0, 0] == pytest.approx(np.tan(np.pi / 4 - 2.3), rel=1e-12)  # near the pole
    with pytest.raises(DesignError, match=r"between t = 2\.35619449"):
        fpre(0.0, 1.0, -1.0, 1.0, 1.0, [0.0, 2.4])


def test_a_jump_of_a_coefficient_is_met_or_refused_but_never_passed_over():
    def A(t):
        return -1.0 if t < 1.0 else 2.0

    times = np.array([0.0, 2.0])
    exact = scalar(2.0, 1.0, 1.0, scalar(-1.0, 1.0, 1.0, 0.0, 1.0), 1.0)
    with pytest.raises(DesignError, match="cannot be followed beyond t = 1 s"):
        fpre(A, 1.0, 1.0, 1.0, 0.0, times)
    parts = fpre(A, 1.0, 1.0, 1.0, 0.0, times, rtol=1e-6).P[-1, 0, 0]
    assert parts == pytest.approx(exact, rel=1e-6)


def test_times_that_do_not_rise_are_refused():
    with pytest.raises(ValueError, match=r"`rde\(A, B, Q, R, P1, times\)`: times must be a vector of rising"):
        rde(-1.0, 1.0, 1.0, 1.0, 0.0, [0.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ("name", "bad", "says"),
    [
        ("A", np.ones((2, 3)), "A must be square"),
        ("B", np.ones((3, 1)), "B must be a matrix of shape"),
        ("Q", [[1.0, 1.0], [0.0, 1.0]], "Q must be symmetric"),
        ("R", [[-1.0]], "R must be positive definite"),
        ("P0", [[np.nan, 0.0], [0.0, 1.0]], "P0 must hold finite numbers"),
        ("P0", np.eye(3), "P0 must be a matrix of shape"),
    ],
)
def test_a_matrix_that_does_not_fit_is_refused_by_name(name, bad, says):
    given = {"A": -I2, "B": [[0.0], [1.0]], "Q": I2, "R": 1.0, "P0": I2} | {name: bad}
    with pytest.raises(ValueError, match=says):
        fpre(**given, times=[0.0, 1.0])


def test_a_function_of_time_is_checked_where_it_is_called():
    with pytest.raises(ValueError, match=r"at t = .* s`: R must be positive definite"):
        fpre(-1.0, 1.0, 1.0, lambda t: 1.0 if t < 0.5 else -1.0, 0.0, [0.0, 1.0])


def test_more_accuracy_than_there_is_is_refused():
    """A rank-one start of 1e6 makes a short piece magnify its rounding: 1e-13 cannot be had."""
    rng = np.random.default_rng(3)
    A, B, v = rng.normal(size=(4, 4)), rng.normal(size=(4, 1)), rng.normal(size=(4, 1))
    with pytest.raises(DesignError, match=r"can be had to a relative error of .* only, and 1.0e-13 is asked for"):
        fpre(A, B, np.eye(4), 1.0, 1e6 * v @ v.T, [0.0, 0.1, 2.0], rtol=1e-13)


@pytest.mark.parametrize("A", heavy_but([5.0, lambda t: 5.0], 5.0), ids=["constant", "varying"])
def test_what_grows_beyond_all_numbers_is_refused(A):
    with pytest.raises(DesignError, match=r"cannot be followed beyond t = 3\d.* s: either it passes 1e\+150 there"):
        fpre(A, 0.0, 1.0, 1.0, 1.0, [0.0, 1e3])


def test_where_nothing_moves_any_horizon_will_do():
    assert fpre(0.0, 0.0, 0.0, 1.0, 1.0, [0.0, 1e9]).P.tolist() == [[[1.0]], [[1.0]]]
    assert fpre(-1.0, 1.0, 0.0, 1.0, 0.0, [0.0, 1.0]).P.tolist() == [[[0.0]], [[0.0]]]
    assert rde(-1.0, 1.0, 1.0, 1.0, 2.0, [3.0]).P.tolist() == [[[2.0]]]


def test_a_p_that_hangs_on_its_last_digits_is_refused():
    """p = 1 - sqrt(2) is an unstable rest of p' = 2 p - p^2 + 1: rounding of the start grows as exp(2 sqrt(2) t)."""
    flow = fpre(1.0, 1.0, 1.0, 1.0, 1 - np.sqrt(2), [0.0, 1.0])
    assert flow.P[-1, 0, 0] == pytest.approx(1 - np.sqrt(2), rel=1e-13)
    for horizon in (10.0, 12.0, 20.0):
        with pytest.raises(DesignError):
            fpre(1.0, 1.0, 1.0, 1.0, 1 - np.sqrt(2), [0.0, horizon])
