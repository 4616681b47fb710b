"""The Kalman filter and its smoothers against the joint normal distribution, and what no covariance may lose."""

import mpmath
import numpy as np
import pytest

from tests.support.plain_filters import given_samples, random_model
from workbench.core import layout
from workbench.identification.filters import consistency, kalman_filter


@pytest.mark.parametrize("changing", [False, True])
def test_filter_smoothers_and_likelihood_are_those_of_the_joint_normal_distribution(changing):
    model, y = random_model(3, changing=changing)
    answer = kalman_filter(y, **model)
    smooth, lag = answer.smooth(), answer.smooth(4)
    close = {"rtol": 1e-9, "atol": 1e-9}  # what the inverse of the joint covariance loses
    for k in (0, 1, 5, 6, 17, 29):
        for of, up_to in ((("x_predicted", "P_predicted"), k), (("x", "P"), k + 1)):
            x, P, _ = given_samples(model, y, up_to)
            np.testing.assert_allclose(getattr(answer, of[0])[k], x[k], **close)
            np.testing.assert_allclose(getattr(answer, of[1])[k], P[k], **close)
        x, P, _ = given_samples(model, y, min(k + 5, 30))
        np.testing.assert_allclose(lag.x[k], x[k], **close)
        np.testing.assert_allclose(lag.P[k], P[k], **close)
    x, P, log_density = given_samples(model, y, 30)
    np.testing.assert_allclose(smooth.x, x, **close)
    np.testing.assert_allclose(smooth.P, P, **close)
    assert answer.log_likelihood == pytest.approx(log_density, rel=1e-10)  # the same inverse


def test_a_smoother_whose_lag_is_the_whole_log_is_the_one_over_all_samples():
    model, y = random_model(8)
    answer = kalman_filter(y, **model)
    np.testing.assert_allclose(answer.smooth(29).x, answer.smooth().x, rtol=0, atol=1e-12)  # rounding


def test_covariances_that_are_not_computed_again_are_the_same_to_the_last_bit():
    model, y = random_model(5, N=400)
    y[100:300] = 1.0  # over which the covariance settles
    at_each = {name: np.repeat(model[name][None], 400, axis=0) for name in "AQ"}
    once, again = kalman_filter(y, **model), kalman_filter(y, **model | at_each)
    for name in ("x", "S", "x_predicted", "S_predicted", "innovations", "log_likelihood"):
        np.testing.assert_array_equal(getattr(once, name), getattr(again, name))


SHARP = {
    "A": [[0.99, 0.2, 0], [-0.2, 0.95, 0.1], [0, 0, 1]],
    "C": np.array([[1.0, 0, 0], [0, 1, 1]]),
    "Q": np.diag([1e-8, 1e-6, 1e-12]),
    "R": np.diag([1e-12, 1e-2]),
    "x0": np.zeros(3),
    "P0": 1e7 * (np.eye(3) + 0.5),
}


def test_a_sensor_of_nineteen_decades_below_the_first_covariance_costs_few_digits():
    y = np.random.default_rng(2).normal(0.0, 1.0, (12, 2))
    answer = kalman_filter(y, **SHARP)
    with mpmath.workdps(80):
        A, C, Q, R, P = (mpmath.matrix(np.asarray(SHARP[name]).tolist()) for name in ("A", "C", "Q", "R", "P0"))
        x, plain, P_plain = mpmath.matrix(3, 1), [], np.array(SHARP["P0"])
        for k in range(12):
            K = P * C.T * (C * P * C.T + R) ** -1
            x, P = x + K * (mpmath.matrix(y[k].tolist()) - C * x), P - K * C * P
            plain.append((np.array(x.tolist(), dtype=float).ravel(), np.array(P.tolist(), dtype=float)))
            x, P = A * x, A * P * A.T + Q
    least = []
    for k, (state, covariance) in enumerate(plain):
        size = np.sqrt(np.diag(covariance))
        # R beside P0: 19 decades, of whose square root 9.5 the sorted rows save most
        np.testing.assert_allclose(answer.x[k] / size, state / size, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(answer.P[k] / size / size[:, None], covariance / size / size[:, None], atol=1e-6)
        K = P_plain @ SHARP["C"].T @ np.linalg.inv(SHARP["C"] @ P_plain @ SHARP["C"].T + SHARP["R"])
        P_plain = P_plain - K @ SHARP["C"] @ P_plain
        least.append(np.linalg.eigvalsh(P_plain)[0])
        P_plain = np.array(SHARP["A"]) @ P_plain @ np.array(SHARP["A"]).T + SHARP["Q"]
    assert min(least) < 0 < answer.least_correlation  # the plain form loses its definiteness on these samples


@pytest.mark.parametrize("N", [20_000, pytest.param(1_000_000, marks=pytest.mark.release)])
def test_each_covariance_stays_positive_definite(N):
    rng = np.random.default_rng(7)
    y = rng.normal(size=(N, 2))
    y[rng.random((N, 2)) < 0.5] = np.nan  # so that the covariance never settles
    answer = kalman_filter(y, **SHARP)
    assert np.isfinite(answer.x).all()
    assert answer.least_correlation > 0
    scale = np.sqrt(np.diagonal(answer.P, axis1=1, axis2=2))
    # what Cholesky's factorisation of the product itself needs, far from the rounding of an entry of 1
    assert np.linalg.eigvalsh(answer.P / scale[:, :, None] / scale[:, None, :]).min() > 1e-14
    assert answer.smooth().least_correlation > 0


def simulate(model, seed, N=60):
    rng = np.random.default_rng(seed)
    root = {name: np.linalg.cholesky(model[name]) for name in ("Q", "R", "P0")}
    x, states, y = model["x0"] + root["P0"] @ rng.normal(size=3), [], []
    for _ in range(N):
        states.append(x)
        y.append(model["C"] @ x + root["R"] @ rng.normal(size=2))
        x = model["A"] @ x + root["Q"] @ rng.normal(size=3)
    return np.array(states), np.array(y)


def test_nees_and_nis_of_200_runs_lie_in_their_bands_and_those_of_a_wrong_model_do_not():
    model = {name: random_model(3)[0][name] for name in ("A", "C", "Q", "R", "x0", "P0")}
    pairs = [simulate(model, seed) for seed in range(200)]
    truths = [states for states, _ in pairs]
    test = consistency([kalman_filter(y, **model) for _, y in pairs], truths)
    assert test.is_consistent
    assert min(test.nis_inside, test.nees_inside) > 0.95  # 60 instants, each in its band with probability 0.999
    for name, factor in (("Q", 0.5), ("Q", 2.0), ("R", 0.5)):
        wrong = model | {name: factor * model[name]}
        assert not consistency([kalman_filter(y, **wrong) for _, y in pairs], truths).is_consistent


def test_a_model_that_the_samples_contradict_is_named_a_divergence():
    model = {"A": [[1.0]], "C": [[1.0]], "Q": [[0.0]], "R": [[1e-8]], "x0": [0.0], "P0": [[1e-8]]}
    answer = kalman_filter([0.0, 1e-4, 1e4, 1e4], **model)
    (remark,) = answer.remarks
    assert "diverged: from sample 2 (t = 2) on, 2 innovations lie more than 1e+06 standard deviations" in remark
    assert kalman_filter([0.0, 1e-4], **model).remarks == ()


def test_a_state_that_leaves_the_numbers_ends_the_filter_in_a_remark():
    answer = kalman_filter(np.full(50, np.nan), [[1e30]], [[1.0]], [[1.0]], [[1.0]], x0=[1.0], P0=[[1.0]])
    assert "left the finite numbers at sample" in answer.remarks[0]
    assert answer.log_likelihood == -np.inf
    with pytest.raises(ValueError, match="needs a filter that stayed finite"):
        answer.smooth()


def test_a_state_that_is_known_exactly_is_smoothed_and_its_certificate_is_0():
    answer = kalman_filter(
        np.ones(5), np.eye(2), [[1.0, 1.0]], np.diag([0.0, 1.0]), [[1.0]], x0=[3, 0], P0=np.diag([0, 1])
    )
    np.testing.assert_array_equal(answer.smooth().x[:, 0], 3.0)
    assert answer.least_correlation == 0
    with pytest.raises(ValueError, match="a state of this filter has variance 0"):
        answer.nees(np.zeros((5, 2)))


def test_one_sample_and_none_at_all_are_logs_too():
    one, none = (kalman_filter(y, [[1]], [[1]], [[1]], [[1]], x0=[0], P0=[[1]]) for y in ([1.0], 3 * [np.nan]))
    assert one.smooth().x[0, 0] == one.smooth(1).x[0, 0] == one.x[0, 0] == pytest.approx(0.5)
    np.testing.assert_allclose(none.P[:, 0, 0], [1, 2, 3])
    assert none.log_likelihood == 0
    with pytest.raises(ValueError, match="must be runs with samples"):
        none.consistency()


def test_names_and_units_go_into_the_dataset_of_the_states():
    port = layout(q=("rad", [0.0, 0.0]), omega="rad/s")
    model, y = random_model(1)
    log = kalman_filter(y, **model, states=port, t=0.1 * np.arange(30)).smooth().to_dataset()
    assert log.signals.labels[:4] == ("q[0]", "q[1]", "omega", "q_deviation[0]")
    assert log.signals["omega_deviation"].unit == "rad/s"
    assert log.experiments[0].t[-1] == pytest.approx(2.9)


GOOD = {"A": np.eye(2), "C": [[1, 0]], "Q": np.eye(2), "R": [[1]], "x0": [0, 0], "P0": np.eye(2), "y": np.ones(4)}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"Q": [[1, 2], [2, 1]]}, "Q=.*must be positive semidefinite"),
        ({"Q": np.diag([1e6, -1e-12])}, "Q=.*must be positive semidefinite"),
        ({"R": [[0]]}, "R must be positive definite"),
        ({"P0": -np.eye(2)}, "P0=.*must be positive semidefinite"),
        ({"Q": [[1, 2], [0, 1]]}, "Q must be symmetric"),
        ({"x0": None}, "x0=.*must be given, as 2 numbers: the mean of the state before the first sample"),
        ({"x0": [0, np.nan]}, r"x0=.*must be finite numbers; x0\[1\] is nan"),
        ({"P0": None}, "P0=.*must be given"),
        ({"C": np.eye(2)}, r"C=.*must have shape \(1, 2\), or \(4, 1, 2\) for 4 samples; got \(2, 2\)"),
        ({"A": np.ones((3, 2, 2))}, r"A=.*must have shape \(2, 2\), or \(4, 2, 2\) for 4 samples; got \(3, 2, 2\)"),
        ({"R": np.eye(2)}, r"R=.*must have shape \(1, 1\); got \(2, 2\)"),
        ({"u": np.ones(4)}, "must have u together with B, D or both; got u alone"),
        ({"u": [1, np.nan, 1, 1], "B": np.ones((2, 1))}, "must be 4 rows of finite numbers"),
        ({"t": [0, 1, 1, 2]}, r"t=.*must be times that increase; t\[1\] is 1 s and t\[2\] is 1 s"),
        ({"y": [1, np.inf, 1, 1]}, r"y=.*must be samples \(N, q\)"),
        ({"states": layout(x="m")}, "states=.*must have 2 numbers"),
    ],
)
def test_numbers_that_are_no_model_are_refused_in_one_sentence(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        kalman_filter(**GOOD | change)
    assert kalman_filter(**GOOD).x.shape == (4, 2)
