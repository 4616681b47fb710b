"""Linear models of logs with missing or marked outputs, against a Kalman filter's likelihood that is written here."""

import numpy as np
import pytest
from scipy.signal import lfilter

import workbench as wb

N, SIGMA = 260, 0.3
U = np.random.default_rng(5).choice([-1.0, 1.0], N)
E = SIGMA * np.random.default_rng(6).standard_normal(N)
A, B, C, D, F = [1, -0.7], [0, 0.5, 0.2], [1, 0.6], [1, -0.8], [1, -1.2, 0.5]
GAPS = np.zeros(N, dtype=bool)
GAPS[np.random.default_rng(7).choice(np.arange(5, N), 24, replace=False)] = True
GAPS[200:210] = True


def outputs(kind):
    if kind == "ARX":
        return lfilter(B, A, U) + lfilter([1], A, E)
    if kind == "ARMAX":
        return lfilter(B, A, U) + lfilter(C, A, E)
    if kind == "OE":
        return lfilter(B, F, U) + E
    return lfilter(B, F, U) + lfilter(C, D, E)


ORDERS = {
    "ARX": {"na": 1, "nb": (2,)},
    "ARMAX": {"na": 1, "nb": (2,), "nc": 1},
    "OE": {"nb": (2,), "nf": (2,)},
    "BJ": {"nb": (2,), "nf": (2,), "nc": 1, "nd": 1},
}


def structure(kind):
    return wb.linear_models.PolynomialStructure(**ORDERS[kind])


def log(y, gaps=None):
    return wb.Dataset.of(
        0.1 * np.arange(N), {"u": U, "y": y if gaps is None else np.where(gaps, np.nan, y)}, {"u": "V", "y": "rad"}
    )


def model_of(kind, gaps=GAPS, y=None):
    data = log(outputs(kind) if y is None else y, gaps)
    return wb.linear_models.polynomial_model(data, "u", "y", structure(kind), offsets="none", initial="zero", starts=0)


def deviance(kind, theta, y, gaps):
    """Minus twice the log-likelihood, sigma at its best, by a Kalman filter with the noise states as a chain of e."""
    p = structure(kind).polynomials(np.asarray(theta))
    below = np.convolve(p.A, p.D)
    mean = lfilter(p.B[0], np.convolve(p.A, p.F[0]), U)
    n = max(len(p.C), len(below)) - 1
    a, c = (np.pad(part, (0, n + 1 - len(part))) for part in (below, p.C))
    # controller form: z = e / (A D) and its past; the output is C z
    T = np.vstack([-a[1:], np.eye(n)[:-1]])
    out = c[1:] - c[0] * a[1:]
    z, P, squares, logs, count = np.zeros(n), np.zeros((n, n)), 0.0, 0.0, 0
    drive = np.zeros(n)
    drive[0] = 1.0
    for k in range(N):
        H, R = out, 1.0  # y = out z_{k-1} + e_k, z_k = T z_{k-1} + drive e_k
        if gaps[k]:
            z, P = T @ z, T @ P @ T.T + np.outer(drive, drive)
            continue
        S = H @ P @ H + R
        nu = y[k] - mean[k] - H @ z
        K = (T @ P @ H + drive) / S
        z, P = T @ z + K * nu, T @ P @ T.T + np.outer(drive, drive) - np.outer(K, K) * S
        squares, logs, count = squares + nu**2 / S, logs + np.log(S), count + 1
    return count * np.log(squares / count) + logs


@pytest.mark.parametrize("kind", ["ARMAX", "BJ"])
def test_with_c_the_estimate_is_the_most_likely_one_of_a_kalman_filter(kind):
    y, found = outputs(kind), model_of(kind)
    errors = np.array(list(found.standard_errors.values()))
    least = deviance(kind, found.theta, y, GAPS)
    assert found.samples == N - GAPS.sum()
    assert found.samples * np.log(found.squares / found.samples) == pytest.approx(least, rel=1e-9)
    h, n = 1e-2 * errors, len(errors)
    at = {}
    for i in range(n):
        for j in range(n):
            for si in (1, -1):
                for sj in (1, -1):
                    moved = found.theta + si * h[i] * np.eye(n)[i] + sj * h[j] * np.eye(n)[j]
                    at[i, j, si, sj] = deviance(kind, moved, y, GAPS)
    slope = [(at[i, i, 1, 1] - at[i, i, -1, -1]) / (4 * h[i]) for i in range(n)]
    assert np.abs(np.array(slope) * errors).max() < 1e-3  # of the deviance by a standard error: a minimum
    hessian = [
        [(at[i, j, 1, 1] - at[i, j, 1, -1] - at[i, j, -1, 1] + at[i, j, -1, -1]) / (8 * h[i] * h[j]) for j in range(n)]
        for i in range(n)
    ]
    degrees = found.samples - n
    expected = np.linalg.inv(np.array(hessian)) * found.samples / degrees
    scale = np.outer(errors, errors)
    assert found.covariance / scale == pytest.approx(expected / scale, abs=5e-3)  # differences over 1 % of an error


def test_arx_leaves_out_the_rows_that_touch_a_gap():
    y, found = outputs("ARX"), model_of("ARX")
    rows = [k for k in range(2, N) if not GAPS[k] and not GAPS[k - 1]]
    X = np.array([[-y[k - 1], U[k - 1], U[k - 2]] for k in rows])
    first = [k for k in range(2) if not GAPS[k]]
    past = np.array([[-(y[k - 1] if k else 0), U[k - 1] if k else 0, 0] for k in first])
    X, target = np.vstack([past, X]), np.concatenate([y[:2], y[rows]])
    theta, squares = np.linalg.lstsq(X, target, rcond=None)[:2]
    assert found.theta == pytest.approx(theta, rel=1e-9)
    assert found.samples == len(target)
    variance = squares[0] / (len(target) - 3)
    assert found.noise_variance == pytest.approx(variance, rel=1e-9)
    assert found.covariance == pytest.approx(variance * np.linalg.inv(X.T @ X), rel=1e-9)
    assert "missing or marked" in " ".join(found.remarks)


def test_output_errors_leave_out_the_missing_samples_and_nothing_else():
    y, found = outputs("OE"), model_of("OE")
    assert found.samples == N - GAPS.sum()
    p = found.polynomials
    e = (y - lfilter(p.B[0], p.F[0], U))[~GAPS]
    assert found.squares == pytest.approx(e @ e, rel=1e-12)
    for direction in np.eye(4):  # a minimum of these errors
        h = 0.05 * direction * np.array(list(found.standard_errors.values()))
        for side in (1, -1):
            moved = structure("OE").polynomials(found.theta + side * h)
            assert np.sum((y - lfilter(moved.B[0], moved.F[0], U))[~GAPS] ** 2) > found.squares


@pytest.mark.parametrize("kind", ORDERS)
def test_tests_of_residuals_pass_for_the_right_model_and_fail_for_a_wrong_one(kind):
    found = model_of(kind)
    assert all(test.is_passed for test in found.residual_tests())
    late = np.concatenate([np.zeros(6), U[:-6]])  # a response that the model does not have
    wrong = model_of(kind, y=outputs(kind) + 0.3 * late)
    assert not all(test.is_passed for test in wrong.residual_tests())


@pytest.mark.parametrize("kind", ["ARX", "ARMAX"])
def test_a_log_without_gaps_and_one_whose_marked_samples_are_wild_give_estimates_alike(kind):
    y = outputs(kind)
    wild = log(np.where(GAPS, 1e3, y)).mark_limits("y", high=100.0)
    whole, gapped = model_of(kind, None), model_of(kind)
    away = (gapped.theta - whole.theta) / np.array(list(gapped.standard_errors.values()))
    assert np.abs(away).max() < 2  # the difference of nested estimates is below a standard error of the smaller one
    marked = wb.linear_models.polynomial_model(
        wild, "u", "y", structure(kind), offsets="none", initial="zero", starts=0
    )
    assert np.array_equal(marked.theta, gapped.theta)


def test_missing_inputs_and_too_many_gaps_are_refused_by_name():
    u = np.where(GAPS, np.nan, U)
    data = wb.Dataset.of(0.1 * np.arange(N), {"u": u, "y": outputs("ARX")}, {"u": "V", "y": "rad"})
    with pytest.raises(ValueError, match="of 'u' in 'log' are missing"):
        wb.linear_models.polynomial_model(data, "u", "y", structure("ARX"))
    none = log(np.full(N, np.nan))
    with pytest.raises(ValueError, match="all are missing"):
        wb.linear_models.polynomial_model(none, "u", "y", structure("ARX"))


def test_a_hold_out_and_initial_values_go_with_gaps():
    y = outputs("BJ") + 3.0
    data = log(y, GAPS)
    found = wb.linear_models.polynomial_model(data, "u", "y", structure("BJ"), starts=0)
    assert found.y0[0] == pytest.approx(3.0, abs=0.3)
    assert found.fit.prediction > 50.0
    assert np.isfinite(found.covariance).all()


def test_orders_are_not_compared_by_errors_of_different_samples():
    orders = [wb.linear_models.PolynomialStructure(na=na, nb=(2,)) for na in (1, 2)]
    data = log(outputs("ARX"), GAPS)
    chosen = wb.linear_models.select_orders(data, "u", "y", orders, log(outputs("ARX")), starts=0)
    assert chosen.best("hold-out").structure.na == 1
    with pytest.raises(ValueError, match="use the hold-out"):
        chosen.best("BIC")
