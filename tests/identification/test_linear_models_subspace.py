"""Subspace identification and Markov parameters: exact without noise, consistent with it, also in closed loop."""

import control
import numpy as np
import pytest

import workbench as wb
from tests.support.linear_logs import PERIOD, closed_loop, log_of
from workbench.identification.linear_models.subspace_estimates import _with_stable_predictor

A = np.array([[0.9, 0.3, 0.0], [-0.3, 0.8, 0.1], [0.0, 0.0, 0.5]])
B = np.array([[1.0, 0.0], [0.0, 0.5], [0.3, 1.0]])
CY = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]])
K = np.array([[0.3, 0.0], [0.0, 0.2], [0.1, 0.1]])
POLES = np.sort_complex(np.linalg.eigvals(A))


def log_of_states(noise, gain, seed=1, count=2500):
    rng, x, us, ys = np.random.default_rng(seed), np.zeros(3), [], []
    for _ in range(count):
        e = noise * rng.normal(size=2)
        y = CY @ x + e
        u = rng.normal(size=2) - gain * y[::-1]
        x = A @ x + B @ u + K @ e
        ys.append(y + [1.0, -2.0])
        us.append(u + 0.5)
    return wb.Dataset.of(PERIOD * np.arange(count), {"u": us, "y": ys}, {"u": "V", "y": "m"})


def poles_of(model):
    return np.sort_complex(np.linalg.eigvals(model.A))


@pytest.mark.parametrize("weighting", ["SSARX", "CVA", "MOESP", "N4SID"])
def test_without_noise_each_weighting_gives_the_order_the_poles_and_the_point(weighting):
    log = log_of_states(0.0, 0.0, count=600)
    model = wb.linear_models.subspace_model(log, "u", "y", weighting=weighting)
    assert model.order == 3
    np.testing.assert_allclose(poles_of(model), POLES, atol=1e-7)  # rounding, times a conditioning of 1e6
    gain = CY @ np.linalg.solve(np.eye(3) - A, B)
    np.testing.assert_allclose(model.to_ss().dcgain(), gain, rtol=1e-6)
    np.testing.assert_allclose(model.y0, [1.0, -2.0] + gain @ (model.u0 - 0.5), atol=1e-6)
    assert all(fit.simulation > 99.999 for fit in model.fits)


@pytest.mark.parametrize("gain", [0.0, 0.25])
def test_with_noise_the_order_is_that_of_the_plant_and_the_hold_out_is_predicted_as_by_the_true_model(gain):
    fit, holdout = log_of_states(0.3, gain).split(0.4)
    model = wb.linear_models.subspace_model(fit, "u", "y", holdout=holdout)
    assert model.order == 3
    # the scatter of the poles over seeds is 0.01
    np.testing.assert_allclose(poles_of(model), POLES, atol=0.04)
    for held in model.holdout:
        assert held.prediction_rmse == pytest.approx(0.3, rel=0.06)  # the noise, known to 2 %
    assert model.predictor_radius < 1


def test_in_a_closed_loop_the_poles_of_ssarx_scatter_about_those_of_the_plant():
    system, gain = {"a": [-0.9], "b": [0.5], "c": [0.8]}, 1.2
    poles = []
    for seed in range(20):
        u, y = closed_loop(system, 1500, seed, gain, 0.5, 0.3)
        poles.append(wb.linear_models.subspace_model(log_of(u, y), "u", "y", 1, horizon=12).A[0, 0])
    assert np.std(poles) < 0.1
    assert abs(np.mean(poles) - 0.9) < 4 * np.std(poles) / np.sqrt(20)


def test_an_unstable_predictor_is_replaced_by_the_stable_one_of_the_same_noise_spectrum():
    gain, covariance = 3.0 * K, np.array([[1.0, 0.3], [0.3, 0.5]])
    gain[0, 0] = 2.5
    assert np.abs(np.linalg.eigvals(A - gain @ CY)).max() > 1
    (*_, renewed), spread = _with_stable_predictor((A, B, CY, np.zeros((2, 2)), gain), covariance)
    assert np.abs(np.linalg.eigvals(A - renewed @ CY)).max() < 1
    for z in np.exp(1j * np.array([0.1, 1.0, 3.0])):
        old, new = (np.eye(2) + CY @ np.linalg.solve(z * np.eye(3) - A, held) for held in (gain, renewed))
        np.testing.assert_allclose(new @ spread @ new.conj().T, old @ covariance @ old.conj().T, rtol=1e-9)


def test_markov_parameters_are_those_of_python_control_and_give_the_system_back():
    rng = np.random.default_rng(3)
    u = rng.normal(size=800)
    plant = control.ss(A, B[:, :1], CY[:1], 0.2, PERIOD)
    y = control.forced_response(plant, inputs=u).outputs + 0.1 * rng.standard_normal(800)
    model = wb.linear_models.arx(log_of(u, y), "u", "y", na=0, nb=30, nk=0, offsets="none", initial="zero")
    markov = control.markov(y[np.newaxis], u[np.newaxis], m=30, dt=True)
    np.testing.assert_allclose(model.impulse_response(30)[:, 0], np.squeeze(markov), atol=1e-10)
    exact = np.array([plant.D, *(plant.C @ np.linalg.matrix_power(A, k) @ plant.B for k in range(20))])
    system, values = wb.linear.realize(exact, 3, PERIOD)
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(system.A)), POLES, atol=1e-9)
    assert values[3] < 1e-9 * values[0]


def test_a_log_that_is_too_short_and_an_order_beyond_the_horizon_are_refused():
    log = log_of_states(0.3, 0.0, count=25)
    with pytest.raises(ValueError, match="too few for past and future"):
        wb.linear_models.subspace_model(log, "u", "y")
    with pytest.raises(ValueError, match="must be at most 8, the horizon times the outputs; got 9"):
        wb.linear_models.subspace_model(log_of_states(0.3, 0.0, count=400), "u", "y", 9, horizon=4)
