"""The door to linear matrix inequalities: answers put back into the inequalities, and what has none."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from workbench.arms.observer_gains import matrix_inequalities
from workbench.design.matrices import DesignError


def test_a_common_lyapunov_matrix_satisfies_every_inequality():
    rng = np.random.default_rng(1)
    A = -2 * np.eye(3) + 0.4 * rng.normal(size=(12, 3, 3))
    P = matrix_inequalities.common_lyapunov(A, 0.3)
    assert np.linalg.eigvalsh(P)[0] >= 1 - 1e-6  # the solver's tolerance
    for Ai in A:
        assert np.linalg.eigvalsh(P @ Ai + Ai.T @ P + 0.6 * P)[-1] < 0


def test_two_stable_matrices_without_a_common_one_are_refused():
    """Both are Hurwitz, and switching between them grows: no quadratic form falls for both."""
    A = np.array([[[-0.1, 1.0], [-10.0, -0.1]], [[-0.1, 10.0], [-1.0, -0.1]]])
    with pytest.raises(DesignError, match="infeasible"):
        matrix_inequalities.common_lyapunov(A, 0.05)


def test_of_one_matrix_the_least_noise_is_kalmans():
    """The least trace of L' P L with (A - L C)' P + P (A - L C) + w'w <= 0 is the H2 norm of the steady Kalman filter.

    With noise of the measurement alone and an unstable A, P^-1 solves the Riccati equation of the filter.
    """
    A, C, weight = np.array([[0.0, 1.0], [4.0, 0.0]]), np.array([[1.0, 0.0]]), np.diag([1.0, 0.5])
    _, L = matrix_inequalities.least_noise_observer(A[None], A, C, 0.0, weight)

    def norm(gain):
        X = solve_continuous_lyapunov(A - gain @ C, -gain @ gain.T)
        return np.trace(weight @ X @ weight)

    X = solve_continuous_are(A.T, C.T, 1e-9 * np.eye(2), np.eye(1))  # a little noise keeps SciPy's equation regular
    assert norm(L) == pytest.approx(norm(X @ C.T), rel=1e-3)  # the solver's tolerance, near the edge of the feasible


def test_without_the_extra_one_sentence_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr(matrix_inequalities, "find_spec", lambda name: None)
    with pytest.raises(DesignError, match=r"pip install control-workbench\[lmi\]"):
        matrix_inequalities.common_lyapunov(-np.eye(2)[None], 0.1)
