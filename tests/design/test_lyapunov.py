"""Lyapunov's and Stein's equations against closed forms and 300-bit solutions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support import riccati_oracles as oracle
from tests.support.cases import heavy_but
from workbench.design.matrices import DesignError
from workbench.design.riccati import discrete_lyapunov, lyapunov

EPS = np.finfo(float).eps
SOLVERS = pytest.mark.parametrize("discrete", [False, True])


def solver(discrete):
    return discrete_lyapunov if discrete else lyapunov


def system(seed, n):
    rng = np.random.default_rng(seed)
    A, root = rng.normal(size=(n, n)), rng.normal(size=(n, n))
    return A, (root + root.T) / 2, np.eye(n) + 0.3 * rng.normal(size=(n, n)) / np.sqrt(n)


@SOLVERS
def test_a_diagonal_matrix_has_its_solution_entry_by_entry(discrete):
    rng = np.random.default_rng(0)
    rates = rng.uniform(0.05, 0.95, 6) * (1 if discrete else -(10 ** rng.uniform(-8, 8, 6)))
    Q = rng.normal(size=(6, 6))
    Q = Q + Q.T
    below = 1 - np.multiply.outer(rates, rates) if discrete else -np.add.outer(rates, rates)
    X = solver(discrete)(np.diag(rates), Q).X
    np.testing.assert_allclose(X, Q / below, rtol=1e-14)  # the closed form cancels near a product of one


@SOLVERS
@pytest.mark.parametrize("n", heavy_but([1, 2, 4, 7], 1, 2, 4))
def test_x_is_right_to_its_last_digit_stable_or_not(discrete, n):
    for seed in range(5):
        A, Q, E = system(seed, n)
        for descriptor in (None, E):
            found = solver(discrete)(A, Q, descriptor)
            assert oracle.away(found.X, oracle.lyapunov(A, Q, descriptor, discrete)) <= 2 * EPS
            np.testing.assert_array_equal(found.X, found.X.T)


@SOLVERS
def test_a_defective_matrix_far_from_normal_is_solved_with_its_condition(discrete):
    n = 12
    A = (0.5 if discrete else -0.5) * np.eye(n) + 1.5 * np.eye(n, k=1)
    found = solver(discrete)(A, np.eye(n))
    assert oracle.away(found.X, oracle.lyapunov(A, np.eye(n), discrete=discrete)) <= 2 * EPS
    assert found.certificate.condition > 1e3


@SOLVERS
def test_the_condition_bounds_what_a_change_of_the_data_does(discrete):
    change = 1e-9
    for seed in range(6):
        A, Q, E = system(seed, 4)
        A = 0.4 * A if discrete else A - 3 * np.eye(4) * (seed % 2)  # on one side of the boundary, and on both
        rng = np.random.default_rng(50 + seed)
        noise = [rng.normal(size=(4, 4)) for _ in range(3)]
        noise[1] = noise[1] + noise[1].T
        A1, Q1, E1 = (
            matrix + change * np.linalg.norm(matrix, 2) * step / np.linalg.norm(step, 2)
            for matrix, step in zip((A, Q, E), noise, strict=True)
        )
        first, second = solver(discrete)(A, Q, E), solver(discrete)(A1, Q1, E1)
        shift = np.linalg.norm(second.X - first.X, 2) / np.linalg.norm(first.X, 2)
        assert 1e-4 * first.certificate.condition * change <= shift <= 4 * first.certificate.condition * change


def test_the_covariance_of_an_oscillator_is_that_of_the_textbook():
    # x'' + 2 z w x' + w^2 x = white noise of intensity q: variances q / (4 z w^3) and q / (4 z w)
    z, w, q = 0.02, 30.0, 7.0
    found = lyapunov([[0, 1], [-(w**2), -2 * z * w]], np.diag([0, q]))
    np.testing.assert_allclose(np.diag(found.X), [q / (4 * z * w**3), q / (4 * z * w)], rtol=1e-13)
    assert abs(found.X[0, 1]) < 1e-16 * found.X[1, 1]
    np.testing.assert_allclose(found.certificate.decay_rate, z * w, rtol=1e-12)


def test_a_sum_of_powers_is_the_discrete_gramian():
    A = np.array([[0.3, 0.5], [-0.2, 0.4]])
    B = np.array([[1.0], [2.0]])
    total, term = np.zeros((2, 2)), B
    for _ in range(200):
        total, term = total + term @ term.T, A @ term
    np.testing.assert_allclose(discrete_lyapunov(A, B @ B.T).X, total, rtol=1e-14)


def test_a_solution_that_is_no_gramian_is_marked():
    assert "A is not stable" in lyapunov([[1.0]], [[2.0]]).certificate.warnings[0]
    np.testing.assert_allclose(lyapunov([[1.0]], [[2.0]]).X, [[-1.0]])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lyapunov([[0, 1], [-1, 0]], np.eye(2)), "add up to nearly zero"),
        (lambda: lyapunov(np.diag([2.0, -2.0]), np.eye(2)), "eigenvalues 2 and -2 of A add up to nearly zero"),
        (lambda: discrete_lyapunov(np.diag([2.0, 0.5]), np.ones((2, 2))), "nearly the product 1"),
        (lambda: discrete_lyapunov([[0, 1], [-1, 0]], np.eye(2)), "nearly the product 1"),
    ],
)
def test_an_equation_without_a_unique_solution_is_refused_with_its_eigenvalues(call, message):
    with pytest.raises(DesignError, match=message):
        call()


def test_a_turned_oscillator_without_damping_is_refused():
    rng = np.random.default_rng(0)
    for _ in range(50):
        T = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        A = T @ np.array([[0, 2.0, 0], [-2.0, 0, 0], [0, 0, -1.0]]) @ T.T
        with pytest.raises(DesignError, match="add up to nearly zero"):
            lyapunov(A, np.eye(3))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: lyapunov(np.ones((2, 3)), np.eye(2)), r"`lyapunov\(A, Q\)`: A must be square"),
        (lambda: lyapunov(-np.eye(2), [[1, 2], [0, 1]]), "Q must be symmetric"),
        (lambda: lyapunov(-np.eye(2), np.eye(3)), r"Q must be a matrix of shape \(2, 2\)"),
        (lambda: lyapunov(-np.eye(2), np.eye(2), np.ones((2, 2))), "E must have an inverse"),
        (lambda: discrete_lyapunov([["a"]], [[1]]), "A must be a matrix of real numbers"),
        (lambda: discrete_lyapunov([[np.nan]], [[1]]), r"A\[0, 0\] is nan"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(call, message):
    with pytest.raises(ValueError, match=message):
        call()
