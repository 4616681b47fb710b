"""The step of the algebraic Riccati gain: a symplectic map that keeps P symmetric and definite at every period."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are

from tests.support.riccati_steps import cayley, hamiltonian, moebius
from workbench.arms.laws.algebraic_riccati import cayley_step


def step_of(n):
    matrices = [ca.SX.sym(name, n, n) for name in "AGQP"]
    h = ca.SX.sym("h")
    return ca.Function("step", [*matrices, h], [cayley_step(*matrices, h)])


STEP = {n: step_of(n) for n in (1, 2, 3)}


def equation(seed, n, K=5.0):
    """A = -M^-1 K, G = B R^-1 B, Q and P of (34), with B and R, for a random M."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    M, B, R = root @ root.T + 0.1 * np.eye(n), np.diag(rng.uniform(1, 20, n)), rng.uniform(0.1, 10) * np.eye(n)
    Q, P = np.diag(rng.uniform(0.1, 600, n)), rng.uniform(0.1, 100) * np.eye(n)
    return -K * np.linalg.inv(M), B @ np.linalg.solve(R, B), Q, P, B, R


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_linear_form_of_the_riccati_equation_has_its_flow(n):
    """The sign of H, held against an integrator that knows (34) alone."""
    A, G, Q, P, *_ = equation(1, n)
    rate = lambda t, p: (lambda X: A.T @ X + X @ A - X @ G @ X + Q)(p.reshape(n, n)).ravel()  # noqa: E731
    theirs = solve_ivp(rate, (0, 0.02), P.ravel(), rtol=1e-11, atol=1e-11).y[:, -1].reshape(n, n)
    np.testing.assert_allclose(moebius(expm(0.02 * hamiltonian(A, G, Q)), P), theirs, rtol=1e-8)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_step_is_the_moebius_map_of_a_symplectic_matrix(n):
    A, G, Q, P, *_ = equation(2, n)
    X = cayley(hamiltonian(A, G, Q), 0.01)
    J = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    np.testing.assert_allclose(X.T @ J @ X, J, atol=1e-11 * np.abs(X).max() ** 2)  # rounding
    np.testing.assert_allclose(STEP[n](A, G, Q, P, 0.01), moebius(X, P), rtol=1e-10)


@settings(max_examples=60)
@given(
    seed=st.integers(0, 10**6),
    n=st.sampled_from([1, 2, 3]),
    K=st.floats(5, 500),
    h=st.floats(1e-4, 0.1),
    size=st.floats(1e-6, 1e6),
)
def test_p_stays_symmetric_and_definite_at_every_period_and_gain(seed, n, K, h, size):
    A, G, Q, P, *_ = equation(seed, n, K)
    for _ in range(5):
        P = np.array(STEP[n](A, G, Q, size * P, h))
        np.testing.assert_array_equal(P, P.T)
        assert np.linalg.eigvalsh(P)[0] > 0


@pytest.mark.parametrize("h", [1e-3, 0.1])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_algebraic_solution_stays_where_it_is(n, h):
    A, G, Q, _, B, R = equation(3, n)
    P = solve_continuous_are(A, B, Q, R)
    np.testing.assert_allclose(STEP[n](A, G, Q, P, h), P, rtol=1e-9)  # SciPy's rounding and ours


def test_the_step_is_of_second_order():
    A, G, Q, P, *_ = equation(4, 2)
    exact = moebius(expm(0.1 * hamiltonian(A, G, Q)), P)
    steps, errors = np.array([400, 800, 1600]), []
    for count in steps:
        X = P
        for _ in range(count):
            X = np.array(STEP[2](A, G, Q, X, 0.1 / count))
        errors.append(np.abs(X - exact).max())
    assert np.polyfit(np.log(1 / steps), np.log(errors), 1)[0] == pytest.approx(2, abs=0.05)
