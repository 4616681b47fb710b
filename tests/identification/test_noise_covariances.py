"""Noise covariances of largest likelihood: against closed forms, and against the joint normal distribution."""

import casadi as ca
import numpy as np
import pytest
from scipy.stats import multivariate_normal

from workbench.core import Ode, layout
from workbench.identification.datasets import Dataset
from workbench.identification.filters import (
    StochasticModel,
    extended_kalman_filter,
    kalman_filter,
    noise_covariances,
)
from workbench.identification.filters.autocovariance_start import _model, autocovariance_numbers


def walk(seed, q, r, N=150):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(0, np.sqrt(q), N)) + rng.normal(0, np.sqrt(r), N)


def filter_of(y, **keys):
    return lambda Q, R: kalman_filter(y, [[1]], [[1]], Q, R, x0=[0], P0=[[1]], **keys)


def test_a_variance_without_motion_is_the_mean_of_squares_with_its_standard_error():
    y = np.random.default_rng(1).normal(0, 0.3, 400)

    def run(Q, R):
        return kalman_filter(y, np.eye(1), np.eye(1), 0 * Q, R, x0=[0], P0=[[0]], outputs=layout(gauge="m"))

    answer = noise_covariances(run, [[1.0]], [[1.0]])
    assert answer.names == ("Q[x]", "R[gauge]")
    assert answer.values[1] == pytest.approx(np.mean(y**2), rel=1e-6)  # the step of the differences, squared
    assert answer.standard_errors[1] == pytest.approx(np.mean(y**2) * np.sqrt(2 / 400), rel=1e-4)
    assert np.isnan(answer.standard_errors[0])
    assert "do not tell 'Q[x]' from 0" in answer.remarks[0]


def test_values_and_standard_errors_are_those_of_the_joint_normal_distribution():
    y = walk(2, 0.04, 0.09)
    answer = noise_covariances(filter_of(y), [[1.0]], [[0.01]])
    n = np.arange(150)

    def cost(logs):
        q, r = np.exp(logs)
        return -multivariate_normal(cov=1 + q * np.minimum(n, n[:, None]) + r * np.eye(150)).logpdf(y)

    top, h = np.log(answer.values), 1e-2
    e = h * np.eye(2)
    slope = [(cost(top + d) - cost(top - d)) / (2 * h) for d in e]
    H = np.array([[(cost(top + a + b) - cost(top + a) - cost(top + b) + cost(top)) / h**2 for a in e] for b in e])
    errors = np.sqrt(np.diag(np.linalg.inv(H)))
    assert np.abs(slope).max() < 2e-3  # h^2 / 6 of the third derivative, which is about the curvature
    np.testing.assert_allclose(answer.standard_errors, answer.values * errors, rtol=3e-2)  # forward differences above
    assert answer.distance < 1e-3
    assert answer.log_likelihood == pytest.approx(-cost(top), rel=1e-10)
    assert (np.abs(answer.values - [0.04, 0.09]) < 3.3 * answer.standard_errors).all()


def test_several_experiments_tell_more_than_one_and_their_likelihoods_add():
    runs = [filter_of(walk(seed, 0.04, 0.09)) for seed in range(3, 7)]
    together = noise_covariances(lambda Q, R: [run(Q, R) for run in runs], [[0.1]], [[0.1]])
    alone = noise_covariances(runs[0], [[0.1]], [[0.1]])
    assert (together.standard_errors < 0.7 * alone.standard_errors).all()
    answers = (run(together.Q, together.R).log_likelihood for run in runs)
    assert together.log_likelihood == pytest.approx(sum(answers), rel=1e-12)


def test_the_form_scaled_keeps_the_shape_of_both_matrices():
    y = walk(5, 0.04, 0.09)
    scaled = noise_covariances(filter_of(y), [[2.0]], [[3.0]], form="scaled")
    diagonal = noise_covariances(filter_of(y), [[0.1]], [[0.1]])
    assert scaled.names == ("Q", "R")
    np.testing.assert_allclose(scaled.values * [2, 3], diagonal.values, rtol=1e-4)  # both searches end near the top


def diverging(Q, R):
    return kalman_filter(np.full(20, np.nan), [[1e30]], [[1]], Q, R, x0=[1], P0=[[1]])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"Q": np.ones((2, 2))}, "must be diagonal in the form 'diagonal'"),
        ({"Q": np.zeros((1, 1))}, "must have a variance that is not 0, where the search begins"),
        ({"R": [[0.0]]}, "R must be positive definite"),
        ({"form": "full"}, "is one of 'diagonal', 'scaled'"),
        ({"run": lambda Q, R: 1.0}, "must give a `FilterEstimate`, or several; it gave 1.0"),
        ({"run": diverging}, "must be a start at which the filter does not diverge"),
    ],
)
def test_a_search_that_cannot_begin_is_refused_in_one_sentence(change, sentence):
    keys = {"run": filter_of(walk(1, 1, 1)), "Q": [[1.0]], "R": [[1.0]]}
    with pytest.raises(ValueError, match=sentence):
        noise_covariances(**keys | change)


@pytest.mark.heavy
def test_the_intensities_of_an_equation_are_found_from_jittering_samples():
    rng = np.random.default_rng(8)
    lengths = rng.uniform(0.02, 0.1, 1500)
    x, y = 0.0, []
    for h in lengths:  # x' = -x + w, exactly
        y.append(x + rng.normal(0, 0.05))
        x = np.exp(-h) * x + rng.normal(0, np.sqrt(0.3 * (1 - np.exp(-2 * h)) / 2))
    state, t, p = (ca.SX.sym(name) for name in "xtp")
    ode = Ode.of("lag", layout(x=""), layout(c="1/s"), (t, state, p), {"x": -state}, {"y": state})
    log = Dataset.of(np.concatenate([[0.0], np.cumsum(lengths[:-1])]), {"y": np.array(y)}, {"y": ""})

    def run(Q, R):
        return extended_kalman_filter(log, StochasticModel(ode, Q, R, [0.0], [[1.0]]), parts=1)

    answer = noise_covariances(run, [[1.0]], [[1.0]])
    assert answer.names == ("Q[x]", "R[y[0]]")
    assert (np.abs(answer.values - [0.3, 0.05**2]) < 3.3 * answer.standard_errors).all()  # 99.9 %
    assert (answer.standard_errors < 0.3 * answer.values).all()


def two_states(seed, N=250):
    """A position and a velocity with noise on both, measured by two sensors of their own noise."""
    A, C = np.array([[1.0, 0.1], [-0.2, 0.9]]), np.eye(2)
    q, r = np.array([0.02, 0.3]), np.array([0.5, 0.08])
    rng, x, rows = np.random.default_rng(seed), np.zeros(2), []
    for _ in range(N):
        rows.append(C @ x + np.sqrt(r) * rng.standard_normal(2))
        x = A @ x + np.sqrt(q) * rng.standard_normal(2)
    y = np.array(rows)
    return lambda Q, R: kalman_filter(y, A, C, Q, R, x0=[0, 0], P0=np.eye(2))


def test_the_end_of_the_search_does_not_depend_on_a_poor_start():
    run = two_states(1)
    near = noise_covariances(run, np.diag([0.02, 0.3]), np.diag([0.5, 0.08]))
    for q, r in ((1e-9, 1e4), (1e6, 1e-8)):
        far = noise_covariances(run, q * np.diag([1.0, 1e3]), r * np.diag([1e-3, 1.0]))
        assert far.distance < 0.01
        # both ends lie within the distance of the certificates, 1 % of a standard error each
        assert np.abs((far.values - near.values) / near.standard_errors).max() < 0.02
        assert far.log_likelihood == pytest.approx(near.log_likelihood, abs=1e-3)
    assert (np.abs(near.values - [0.02, 0.3, 0.5, 0.08]) < 4 * near.standard_errors).all()


def test_the_start_by_autocovariances_is_near_the_end_from_any_gain():
    y = walk(8, 0.04, 0.09, 4000)
    for q, r in ((1.0, 1.0), (1e-2, 10.0), (1e4, 1e-2)):
        filtered = kalman_filter(y, [[1]], [[1]], [[q]], [[r]], x0=[0], P0=[[1]])
        unit, none = np.eye(1), np.zeros((1, 1))
        numbers = autocovariance_numbers([filtered], np.array([[r]]), [(unit, none), (none, unit)])
        # of 4,000 samples, for which least squares are some times less sure than the likelihood (5 and 3 %)
        assert numbers == pytest.approx([0.04, 0.09], rel=0.4)


def test_autocovariances_of_a_model_are_those_of_a_long_simulation():
    """The formula for C_j, against the mean over a simulated error of a fixed gain."""
    A, C, K = np.array([[0.9, 0.2], [0.0, 0.7]]), np.array([[1.0, 0.0]]), np.array([[0.5], [0.1]])
    Q, R = np.diag([0.3, 0.1]), np.array([[0.4]])
    rng, e, rows = np.random.default_rng(2), np.zeros(2), []
    for _ in range(100_000):
        v = np.sqrt(R) @ rng.standard_normal(1)
        rows.append(C @ e + v)
        e = A @ e - K @ rows[-1] + np.sqrt(np.diag(Q)) * rng.standard_normal(2)
    Y = np.array(rows)
    expected = _model(A - K @ C, C, K, Q, R, 4)[:, 0, 0]
    seen = [float(np.mean(Y[j:] * Y[: len(Y) - j])) for j in range(4)]
    assert seen == pytest.approx(expected, abs=0.02 * expected[0])  # some five standard errors of a mean
