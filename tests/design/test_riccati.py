"""Algebraic Riccati equations against closed forms, 300-bit solutions, and what no change of view may change."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support import riccati_oracles as oracle
from tests.support.cases import heavy_but
from workbench.design.matrices import DesignError, libraries, one_thread
from workbench.design.riccati import care, dare, lyapunov
from workbench.design.riccati.algebraic_equation import Data, RiccatiEquation
from workbench.design.riccati.newton import refine

EPS = np.finfo(float).eps
LAST_DIGIT = 2 * EPS  # X is rounded once when its units are exact; twice leaves room for the norm


def system(seed, n, m=2, weighed_across=True, descriptor=True):
    rng = np.random.default_rng(seed)
    A, B, root = rng.normal(size=(n, n)), rng.normal(size=(n, m)), rng.normal(size=(n, n))
    Q, R = root @ root.T, np.diag(rng.uniform(0.1, 10, m))
    S = 0.1 * rng.normal(size=(n, m)) if weighed_across else None
    E = np.eye(n) + 0.3 * rng.normal(size=(n, n)) / np.sqrt(n) if descriptor else None
    return A, B, (Q + Q.T) / 2, R, S, E


def turned(seed, n):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0]


def test_one_state_has_the_positive_root_of_its_quadratic_equation():
    for a, b, q, r in 10 ** np.random.default_rng(0).uniform(-6, 6, size=(15, 4)):
        # 2 a X - X^2 b^2 / r + q = 0, solved without cancellation as a > 0
        X = r / b**2 * (a + np.sqrt(a**2 + q * b**2 / r))
        found = care([[a]], [[b]], [[q]], [[r]])
        np.testing.assert_allclose(found.X[0, 0], X, rtol=8 * EPS)  # the formula rounds about six times
        np.testing.assert_allclose(found.poles[0], -np.sqrt(a**2 + q * b**2 / r), rtol=1e-9)  # a - b K may cancel


def test_the_double_integrator_has_the_solution_of_the_textbook():
    found = care([[0, 1], [0, 0]], [[0], [1]], np.eye(2), 1)
    np.testing.assert_allclose(found.X, [[np.sqrt(3), 1], [1, np.sqrt(3)]], rtol=2 * EPS)
    np.testing.assert_allclose(found.K, [[1, np.sqrt(3)]], rtol=2 * EPS)
    np.testing.assert_allclose(found.certificate.decay_rate, np.sqrt(3) / 2, rtol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("discrete", [False, True])
def test_x_is_right_to_its_last_digit(n, discrete):
    for seed in range(3):
        A, B, Q, R, S, E = system(seed, n)
        found = (dare if discrete else care)(A, B, Q, R, S, E)
        X, K = oracle.riccati(A, B, Q, R, found.X, S, E, discrete)
        assert oracle.away(found.X, X) <= LAST_DIGIT
        assert oracle.away(found.K, K) <= 1e-12 * max(1, found.certificate.condition / 100)  # K is made of X
        assert found.certificate.error <= LAST_DIGIT
        np.testing.assert_array_equal(found.X, found.X.T)


def test_chains_of_integrators_are_solved_where_float_solvers_lose_half_their_digits():
    n = 12
    A, B, Q = np.eye(n, k=1), np.eye(n)[:, -1:], 100 * np.diag(np.eye(n)[0])
    found = care(A, B, Q, [[0.01]])
    X, _ = oracle.riccati(A, B, Q, np.array([[0.01]]), found.X)
    assert oracle.away(found.X, X) <= LAST_DIGIT
    assert found.certificate.condition > 1e3


@pytest.mark.parametrize("discrete", heavy_but([False, True], False))
def test_the_condition_bounds_what_a_change_of_the_data_does(discrete):
    solve = dare if discrete else care
    change = 1e-9  # far above rounding, far below where the linear picture ends
    for seed in range(10):
        A, B, Q, R, _, _ = system(seed, 4, weighed_across=False, descriptor=False)
        rng = np.random.default_rng(100 + seed)

        def moved(matrix, rng=rng, even=False):
            noise = rng.normal(size=matrix.shape)
            noise = noise + noise.T if even else noise
            return matrix + change * noise * np.linalg.norm(matrix, 2) / np.linalg.norm(noise, 2)

        first = solve(A, B, Q, R)
        second = solve(moved(A), moved(B), moved(Q, even=True), moved(R, even=True))
        shift = np.linalg.norm(second.X - first.X, 2) / np.linalg.norm(first.X, 2)
        # norms of the data are taken in good units, which differ from these by small powers of two
        assert shift <= 4 * first.certificate.condition * change
        assert shift >= 1e-4 * first.certificate.condition * change


@pytest.mark.parametrize("discrete", [False, True])
def test_an_orthogonal_change_of_coordinates_turns_x(discrete):
    solve = dare if discrete else care
    for seed in range(5):
        A, B, Q, R, S, E = system(seed, 6)
        T = turned(seed, 6)
        first = solve(A, B, Q, R, S, E)
        second = solve(T @ A @ T.T, T @ B, T @ Q @ T.T, R, T @ S, T @ E @ T.T)
        rounding = 40 * EPS * first.certificate.condition  # of the data by three products of six terms
        assert oracle.away(T.T @ second.X @ T, first.X) <= rounding


def test_scalar_problems_of_all_sizes_stay_apart_when_they_are_turned():
    rng = np.random.default_rng(3)
    for seed in range(20):
        a, b, q = rng.normal(size=4), 10 ** rng.uniform(-3, 3, 4), 10 ** rng.uniform(-3, 3, 4)
        root = np.sqrt(a**2 + q * b**2)
        X = np.where(a > 0, (a + root) / b**2, q / (root - a))  # without cancellation
        T = turned(seed, 4)
        found = care(T @ np.diag(a) @ T.T, T @ np.diag(b), T @ np.diag(q) @ T.T, np.eye(4))
        assert oracle.away(T.T @ found.X @ T, np.diag(X)) <= 20 * EPS * found.certificate.condition


def test_units_of_states_and_inputs_change_x_as_they_must():
    A, B, Q, R, S, E = system(5, 4)
    x, u = np.diag([1e-4, 1.0, 30.0, 1e5]), np.diag([1e-3, 1e4])
    first = care(A, B, Q, R, S, E)
    X = np.linalg.inv(x)
    second = care(X @ A @ x, X @ B @ u, x @ Q @ x, u @ R @ u, x @ S @ u, X @ E @ x)
    np.testing.assert_allclose(second.X, x @ first.X @ x, rtol=1e-11)  # the change itself rounds
    np.testing.assert_allclose(second.K, np.linalg.inv(u) @ first.K @ x, rtol=1e-11)


def test_units_by_powers_of_two_refuse_nothing_and_change_no_digit():
    """Five vehicles in a string: balancing is a similarity, and new units of inputs change R by a congruence."""
    A, B, Q = np.zeros((9, 9)), np.zeros((9, 5)), np.diag([0.0, 10] * 4 + [0.0])
    A[::2, ::2], B[::2] = -np.eye(5), np.eye(5)
    A[1::2, ::2] = np.eye(4, 5) - np.eye(4, 5, k=1)
    first = care(A, B, Q, np.eye(5))
    for seed in range(30):
        rng = np.random.default_rng(seed)
        x, u = (2.0 ** rng.integers(-26, 27, size) for size in (9, 5))
        second = care(A / x[:, None] * x, B / x[:, None] * u, Q * x[:, None] * x, np.diag(u * u))
        assert oracle.away(second.X / x[:, None] / x, first.X) <= LAST_DIGIT
        assert second.certificate.warnings == ()


def test_a_heavier_cost_is_a_heavier_x_and_the_same_gain():
    A, B, Q, R, S, E = system(6, 5)
    for solve in (care, dare):
        first, second = solve(A, B, Q, R, S, E), solve(A, B, 8 * Q, 8 * R, 8 * S, E)
        np.testing.assert_allclose(second.X, 8 * first.X, rtol=1e-14)
        np.testing.assert_allclose(second.K, first.K, rtol=1e-12)


def test_cayleys_transform_makes_a_discrete_equation_of_a_continuous_one():
    for seed in range(10):
        A, B, Q, R, _, _ = system(seed, 4, weighed_across=False, descriptor=False)
        A = A / 4  # away from the eigenvalue 1 that has no image
        root = np.linalg.cholesky(Q).T
        weight = np.linalg.cholesky(R).T
        C, D = np.vstack([root, np.zeros((2, 4))]), np.vstack([np.zeros((4, 2)), weight])
        back = np.linalg.inv(np.eye(4) - A)
        Ad, Bd = back @ (np.eye(4) + A), np.sqrt(2) * back @ B
        Cd, Dd = np.sqrt(2) * C @ back, D + C @ back @ B
        sampled = dare(Ad, Bd, Cd.T @ Cd, Dd.T @ Dd, Cd.T @ Dd)
        found = care(A, B, Q, R)
        rounding = 1e3 * EPS * sampled.certificate.condition  # of the transform, by an inverse
        assert oracle.away(sampled.X, found.X) <= rounding


def test_x_is_the_cost_of_its_own_gain_and_no_gain_costs_less():
    A, B, Q, R, _, _ = system(7, 4, weighed_across=False, descriptor=False)
    found = care(A, B, Q, R)

    def cost(K):
        return lyapunov((A - B @ K).T, Q + K.T @ R @ K).X

    np.testing.assert_allclose(cost(found.K), found.X, rtol=1e-12)
    rng = np.random.default_rng(0)
    for _ in range(20):
        other = cost(found.K + 0.05 * rng.normal(size=found.K.shape))
        assert np.linalg.eigvalsh(other - found.X).min() >= -1e-12 * np.linalg.norm(found.X)


def test_the_error_is_that_of_x_where_its_rounding_leaves_the_linear_picture():
    """An unstable mode that the input hardly moves: X is large, and its last digits move the poles."""
    for seed in range(12):
        rng = np.random.default_rng(seed)
        T, weak = turned(seed, 3), 10 ** rng.uniform(-7, -4)
        A, B, root = T @ np.diag([0.2, 0.0, -1.0]) @ T.T, T @ [[weak], [1.0], [0.7]], T @ [[1.0], [1.0], [0.3]]
        Q = root @ root.T
        found = care(A, B, (Q + Q.T) / 2, [[1.0]])
        X, K = oracle.riccati(A, B, (Q + Q.T) / 2, np.eye(1), found.X)
        assert oracle.away(found.X, X) <= 2 * found.certificate.error  # an estimate of the first digit
        assert oracle.away(found.K, K) <= 2 * found.certificate.error


def test_a_margin_that_rounding_blurs_is_said_to_be_no_surer_than_it_is():
    """Poles near zero that meet, seen through an ill-conditioned E: each is known to a root of the rounding."""
    blurred = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        U, V = turned(seed, 4), turned(100 + seed, 4)
        E = U @ np.diag(10.0 ** np.array([-5, -3, 0, 1])) @ V
        A, B = rng.normal(size=(4, 4)), rng.normal(size=(4, 2))
        try:
            found = dare(A, B, np.eye(4), np.eye(2), E=E)
        except DesignError:
            continue
        _, K = oracle.riccati(A, B, np.eye(4), np.eye(2), found.X, E=E, discrete=True)
        margin = oracle.margin(A, B, K, E)
        told = [w for w in found.certificate.warnings if w.startswith("rounding moves the poles")]
        blurred += bool(told)
        sure = float(told[0].split("only ")[1].split()[0]) if told else 0.99 * found.certificate.decay_rate
        assert sure <= margin * (1 + 1e-2)
    assert blurred
    assert not care([[0, 1], [0, 0]], [[0], [1]], np.eye(2), 1).certificate.warnings


def test_the_gain_has_digits_that_a_rounded_x_does_not_hold():
    """With more cheap inputs than states K divides what rounding leaves of X by R."""
    for seed in range(10):
        rng = np.random.default_rng(seed)
        A, B = rng.normal(size=(2, 2)), rng.normal(size=(2, 3))
        R = 1e-12 * np.diag(rng.uniform(0.5, 2, 3))
        found = dare(A, B, np.eye(2), R)
        _, K = oracle.riccati(A, B, np.eye(2), R, found.X, discrete=True)
        assert oracle.away(found.K, K) <= 1e-9


def test_newton_keeps_only_what_makes_the_residual_smaller():
    A, B, Q, R, S, E = system(8, 5)
    X = care(A, B, Q, R, S, E).X
    equation = RiccatiEquation(Data(A, B, Q, R, S, E), discrete=False)
    start = X * (1 + 1e-3)
    found = refine(equation, start)
    assert found.steps >= 2
    assert found.point.relative < 1e-16 < equation.at(start).relative
    assert refine(equation, X).steps <= 1


def test_the_poles_are_those_of_the_closed_loop():
    for solve in (care, dare):
        A, B, Q, R, S, E = system(9, 5)
        found = solve(A, B, Q, R, S, E)
        poles = np.linalg.eigvals(np.linalg.solve(E, A - B @ found.K))
        np.testing.assert_allclose(oracle.in_order(found.poles), oracle.in_order(poles), rtol=1e-10)
        margin = 1 - np.abs(poles).max() if solve is dare else -poles.real.max()
        np.testing.assert_allclose(found.certificate.decay_rate, margin, rtol=1e-9)


def test_an_indefinite_q_is_solved_with_a_warning():
    # Laub (1992), the H-infinity example with eigenvalues -eps +- i: X does not depend on eps
    golden = (3 + np.sqrt(5)) / 2  # its largest eigenvalue, X being [2 1; 1 1]
    eps = 0.5
    Q = [[4 * eps - 11, 2 * eps - 5], [2 * eps - 5, 2 * eps - 2]]
    found = care([[3 - eps, 1], [4, 2 - eps]], [[1], [1]], Q, 1)
    np.testing.assert_allclose(found.X, [[2, 1], [1, 1]], rtol=4 * EPS)
    np.testing.assert_allclose(np.linalg.eigvalsh(found.X)[-1], golden, rtol=1e-14)
    assert "Q is not positive semidefinite" in found.certificate.warnings[0]


def test_nothing_that_costs_leaves_a_stable_system_alone():
    for solve, A in ((care, [[-1.0, 5.0], [0.0, -2.0]]), (dare, [[0.5, 5.0], [0.0, 0.2]])):
        found = solve(A, [[0.0], [1.0]], np.zeros((2, 2)), 1)
        np.testing.assert_array_equal(found.X, np.zeros((2, 2)))
        np.testing.assert_array_equal(found.K, np.zeros((1, 2)))
        assert found.certificate.error == found.certificate.condition == 0


def test_unstable_poles_that_cost_nothing_are_mirrored():
    found = care(np.diag([1.0, 2.0]), [[1.0], [1.0]], np.zeros((2, 2)), 1)
    np.testing.assert_allclose(np.sort(found.poles.real), [-2, -1], rtol=1e-12)  # Anderson and Moore, section 3.1


def test_inputs_that_cost_nothing_are_used_to_the_full_in_discrete_time():
    found = dare([[1.0, 1.0], [0.0, 1.0]], [[0.0], [1.0]], np.eye(2), [[0.0]])
    X, K = oracle.riccati([[1, 1], [0, 1]], np.array([[0.0], [1.0]]), np.eye(2), [[0.0]], found.X, discrete=True)
    assert oracle.away(found.X, X) <= LAST_DIGIT
    assert oracle.away(found.K, K) <= 1e-14


def threads():
    return [library["num_threads"] for library in libraries().info() if library["user_api"] == "blas"]


def test_solvers_run_in_one_thread_and_leave_the_number_of_threads_as_it_was():
    before = threads()
    with one_thread():
        assert threads() == [1] * len(before)
    with pytest.raises(DesignError):
        care([[1.0]], [[0.0]], [[1.0]], [[1.0]])
    assert threads() == before


def test_the_answer_says_how_far_it_can_be_trusted():
    text = str(care([[0, 1], [0, 0]], [[0], [1]], np.eye(2), 1).certificate)
    assert text.startswith("residual ")
    assert "decay rate 0.866" in text
