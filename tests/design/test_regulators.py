"""Regulators, estimators and both together against python-control, 300-bit solutions, and their theorems."""

from __future__ import annotations

import control
import numpy as np
import pytest

from tests.support import riccati_oracles as oracle
from workbench.design.riccati import lqe, lqg, lqr, lyapunov

A, B, C = np.array([[0.0, 1], [2.0, -0.1]]), np.array([[0.0], [1]]), np.array([[1.0, 0]])


@pytest.mark.parametrize("discrete", [False, True])
def test_gains_are_those_of_python_control_or_nearer_to_the_truth(discrete):
    rng = np.random.default_rng(discrete)
    theirs_lqr, theirs_lqe = (control.dlqr, control.dlqe) if discrete else (control.lqr, control.lqe)
    for _ in range(8):
        n, m = rng.integers(1, 10), rng.integers(1, 4)
        a, b, c = rng.normal(size=(n, n)), rng.normal(size=(n, m)), rng.normal(size=(m, n))
        root = rng.normal(size=(n, n))
        Q, R, N = root @ root.T, np.diag(rng.uniform(0.1, 10, m)), np.zeros((n, m))
        Q = (Q + Q.T) / 2
        found, seen = lqr(a, b, Q, R, N, discrete=discrete), lqe(a, np.eye(n), c, Q, R, discrete=discrete)
        for ours, theirs, matrices in (
            (found, theirs_lqr(a, b, Q, R), (a, b, Q, R)),
            (seen, theirs_lqe(a, np.eye(n), c, Q, R), (a.T, c.T, Q, R)),
        ):
            if oracle.away(theirs[0], ours.K) > 1e-10 or oracle.away(theirs[1], ours.X) > 1e-10:
                X, K = oracle.riccati(*matrices, ours.X, discrete=discrete)
                assert oracle.away(ours.X, X) <= 1e-15
                gain = ours.K.T if ours is seen else ours.K
                assert oracle.away(gain, K) <= 1e-11  # K divides by a matrix made of X


def test_an_estimator_is_the_regulator_of_the_transposed_system():
    G, Qn, Rn = np.eye(2), np.diag([0.2, 3.0]), [[0.5]]
    for discrete in (False, True):
        seen = lqe(A, G, C, Qn, Rn, discrete=discrete)
        acting = lqr(A.T, C.T, Qn, Rn, discrete=discrete)
        np.testing.assert_array_equal(seen.X, acting.X)
        np.testing.assert_array_equal(seen.K, acting.K.T)


def test_a_system_takes_the_place_of_its_matrices_and_says_whether_it_is_sampled():
    system = control.ss(A, B, C, 0)
    sampled = system.sample(0.05)
    N = [[0.1], [0.0]]
    for one, discrete in ((system, False), (sampled, True)):
        np.testing.assert_array_equal(
            lqr(one, np.eye(2), 2.0, N).K, lqr(one.A, one.B, np.eye(2), 2.0, N, discrete=discrete).K
        )


def test_a_weight_across_is_that_of_the_completed_square():
    N, R, Q = np.array([[0.3], [0.5]]), np.array([[2.0]]), np.eye(2)
    shift = np.linalg.solve(R, N.T)
    plain = lqr(A - B @ shift, B, Q - N @ shift, R)
    across = lqr(A, B, Q, R, N)
    np.testing.assert_allclose(across.X, plain.X, rtol=1e-13)
    np.testing.assert_allclose(across.K, plain.K + shift, rtol=1e-13)


def test_the_return_difference_of_a_regulator_is_at_least_one():
    # Kalman (1964): |1 + K (j w - A)^-1 B| >= 1 for a single input without a weight across
    K = lqr(A, B, np.diag([5.0, 0.1]), 0.3).K
    for w in 10 ** np.linspace(-3, 3, 100):
        loop = K @ np.linalg.solve(1j * w * np.eye(2) - A, B)
        assert abs(1 + loop[0, 0]) >= 1 - 1e-14


def test_the_covariance_of_a_filter_is_that_of_its_error():
    Qn, Rn = np.diag([0.1, 2.0]), np.array([[0.4]])
    seen = lqe(A, np.eye(2), C, Qn, Rn)
    error = A - seen.K @ C
    np.testing.assert_allclose(lyapunov(error, Qn + seen.K @ Rn @ seen.K.T).X, seen.X, rtol=1e-13)


@pytest.mark.parametrize("period", [0, 0.02])
def test_the_poles_of_a_loop_are_those_of_regulator_and_estimator(period):
    system = control.ss(A, B, C, [[0.2]], inputs=["tau"], outputs=["q"], states=["q", "qd"], name="arm")
    system = system.sample(period) if period else system
    made = lqg(system, np.eye(2), 0.5, np.diag([0.0, 1.0]), 1e-3)
    halves = np.concatenate([made.regulator.poles, made.estimator.poles])
    np.testing.assert_allclose(oracle.in_order(made.poles), oracle.in_order(halves), rtol=1e-8)
    assert made.certificate.residual < 1e-14
    assert made.certificate.decay_rate > 0
    loop = control.feedback(system, made.controller, sign=1)
    np.testing.assert_allclose(oracle.in_order(loop.poles()), oracle.in_order(halves), rtol=1e-8)


def test_the_controller_has_names_and_closes_the_loop_by_name():
    system = control.ss(A, B, C, 0, inputs=["tau"], outputs=["q"], states=["q", "qd"], name="arm")
    controller = lqg(system, np.eye(2), 1, np.eye(2), 1e-2).controller
    assert controller.input_labels == ["q"]
    assert controller.output_labels == ["tau"]
    assert controller.state_labels == ["q_hat", "qd_hat"]
    assert controller.name == "lqg of arm"


def test_no_other_gains_of_a_controller_give_a_lower_cost():
    system = control.ss(A, B, C, 0)
    Q, R, Qn, Rn = np.diag([3.0, 0.1]), np.array([[0.2]]), np.diag([0.0, 1.0]), np.array([[0.05]])
    made = lqg(system, Q, R, Qn, Rn)

    def cost(K, L):
        """The mean of x'Qx + u'Ru, from the covariance of x and x_hat."""
        loop = np.block([[A, -B @ K], [L @ C, A - B @ K - L @ C]])
        noise = np.block([[Qn, np.zeros((2, 2))], [np.zeros((2, 2)), L @ Rn @ L.T]])
        P = lyapunov(loop, noise).X
        return float(np.trace(Q @ P[:2, :2]) + np.trace(K.T @ R @ K @ P[2:, 2:]))

    best = cost(made.regulator.K, made.estimator.K)
    rng = np.random.default_rng(0)
    for _ in range(30):
        K, L = (gain + 0.05 * rng.normal(size=gain.shape) for gain in (made.regulator.K, made.estimator.K))
        assert cost(K, L) >= best * (1 - 1e-12)


def test_a_controller_that_is_unstable_by_itself_is_marked():
    # (s - 1) / ((s - 2) (s + 1)) has one pole between its zeros 1 and infinity: no stable controller stabilises it
    # (Youla, Bongiorno, Lu 1974, Single-loop feedback-stabilization of linear multivariable dynamical plants)
    made = lqg(control.ss([[1.0, 2], [1, 0]], [[1.0], [0]], [[1.0, -1]], 0), np.eye(2), 1, np.eye(2), 1)
    assert made.certificate.decay_rate > 0
    assert any("unstable by itself" in warning for warning in made.certificate.warnings)


def test_the_weights_of_a_system_may_be_named():
    system = control.ss([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]], 0)
    Q, R = np.diag([2.0, 1.0]), np.eye(1)
    for found in (lqr(system, Q=Q, R=R), lqr(system, Q, R=R)):
        np.testing.assert_array_equal(found.K, lqr(system, Q, R).K)


def test_a_weight_that_is_missing_is_named():
    with pytest.raises(ValueError, match="R must be a matrix of real numbers; got None"):
        lqr(np.eye(2), np.eye(2), np.eye(2))
    with pytest.raises(ValueError, match="got None"):
        lqr(np.eye(2))
    with pytest.raises(ValueError, match="Qn must be"):
        lqe(-1.0, 1.0, 1.0, None, 1.0)
