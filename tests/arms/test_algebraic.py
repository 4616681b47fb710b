"""The algebraic Riccati equation as an expression, against the solver of the design room."""

import casadi as ca
import numpy as np
import pytest

from tests.support.cases import heavy_but
from workbench.arms.laws.algebraic_riccati import closed_form, doubling_solution, norm, residual, stabilising_solution
from workbench.design.riccati import care


def cases(n, spread, rng):
    """Random A, of which every third is stable, and definite G and Q, each over a range of sizes."""
    A, B, C = (rng.normal(size=(n, n)) * 10 ** rng.uniform(-spread, spread) for _ in range(3))
    return (-A @ A.T if rng.random() < 1 / 3 else A), B @ B.T, C.T @ C


def function(n, solve):
    A, G, Q = (ca.SX.sym(letter, n, n) for letter in "AGQ")
    P = solve(A, G, Q)
    return ca.Function("P", [A, G, Q], [P, residual(A, G, Q, P)])


def apart(P, X):
    return np.linalg.norm(np.array(P) - X) / np.linalg.norm(X)


@pytest.mark.parametrize("n", [1, 2])
def test_the_closed_form_is_the_solution_of_the_solver(n):
    """25 random equations: within the condition of the least squares, which is squared."""
    rng, P = np.random.default_rng(21), function(n, closed_form)
    worst = []
    for _ in range(25):
        A, G, Q = cases(n, 1.0, rng)
        root = np.linalg.cholesky(G + 1e-12 * np.trace(G) * np.eye(n))
        G = root @ root.T
        found, left = P(A, G, Q)
        X = care(A, root, Q, np.eye(n)).X
        worst.append(apart(found, X))
        assert float(left) < 1e-6
    assert np.median(worst) < 1e-14
    assert max(worst) < 1e-6


@pytest.mark.parametrize("n", heavy_but([2, 4], 2))
def test_doubling_is_the_solution_of_the_solver_where_the_poles_are_near_its_rate(n):
    rng = np.random.default_rng(22)
    P = function(n, lambda A, G, Q: doubling_solution(A, G, Q, norm(A) + ca.sqrt(norm(G) * norm(Q)), 10))
    checked = 0
    for _ in range(25):
        A, G, Q = cases(n, 0.3, rng)
        w, V = np.linalg.eigh(G)
        answer = care(A, V * np.sqrt(w), Q, np.eye(n))
        rate = np.linalg.norm(A) + np.sqrt(np.linalg.norm(G) * np.linalg.norm(Q))
        if np.abs(answer.poles).min() > rate / 50:  # exp(-4 1024 / 50) is below rounding
            checked += 1
            found, left = P(A, G, Q)
            assert apart(found, answer.X) < 1e-9  # rounding, by the condition of the equation
            assert float(left) < 1e-11
    assert checked > 6


def test_the_residual_tells_where_doubling_has_not_come_to_its_end():
    """A pole 10,000 times slower than the rate, and three doublings."""
    A, G, Q = np.diag([-1e-3, -10.0, -1.0]), 1e-6 * np.eye(3), 1e-6 * np.eye(3)
    P, left = function(3, lambda A, G, Q: stabilising_solution(A, G, Q, 3))(A, G, Q)
    X = care(A, 1e-3 * np.eye(3), Q, np.eye(3)).X
    assert apart(P, X) > 0.1
    assert float(left) > 1e-3


@pytest.mark.parametrize("n", [1, 2, 3])
def test_where_nothing_costs_the_residual_is_zero_and_not_undefined(n):
    A, G, Q = -np.eye(n) - np.eye(n, k=1), np.eye(n), np.zeros((n, n))
    P = stabilising_solution(ca.SX(A), ca.SX(G), ca.SX(Q), 8)
    np.testing.assert_allclose(np.array(ca.evalf(P)), 0, atol=1e-15)
    assert float(ca.evalf(residual(ca.SX(A), ca.SX(G), ca.SX(Q), ca.SX(Q)))) == 0
