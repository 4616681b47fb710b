"""Polynomial models by prediction errors: gradients, minima, intervals, offsets, initial values and refusals."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import binom

import workbench as wb
from tests.support.linear_logs import PERIOD, log_of, loop, structure_of
from workbench.identification.linear_models.gauss_newton import squares_at
from workbench.identification.linear_models.prediction_errors import Predictor, Record


def test_the_gradient_of_the_squares_is_exact_with_initial_values_a_constant_and_two_inputs_removed():
    rng = np.random.default_rng(2)
    structure = wb.linear_models.PolynomialStructure(na=1, nb=(2, 1), nc=1, nd=1, nf=(1, 2), nk=(1, 2))
    records = tuple(Record(rng.normal(size=80), rng.normal(size=(2, 80))) for _ in range(2))
    predictor = Predictor(structure, records, initial=True, constant=True)
    theta = 0.3 * rng.uniform(-1, 1, structure.size)
    errors, h = predictor.errors(theta), 1e-6
    for place, step in enumerate(np.eye(structure.size)):
        slope = (squares_at(predictor, theta + h * step) - squares_at(predictor, theta - h * step)) / (2 * h)
        # central differences with h = 1e-6: h^2 and rounding / h, relative to slopes about 10
        assert 2 * errors.J[:, place] @ errors.e == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_standard_errors_of_output_error_allow_for_coloured_noise():
    """With the formula for white noise they would be a third of the scatter."""
    estimates, spreads = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        u = np.repeat(rng.choice([-1.0, 1.0], 80), 10)
        v = lfilter([1.0], [1.0, -0.9], 0.2 * rng.standard_normal(800))
        y = lfilter([0.0, 0.5], [1.0, -0.8], u) + v
        model = wb.linear_models.output_error(log_of(u, y), "u", "y", nb=1, nf=1, starts=0)
        estimates.append(model.theta)
        spreads.append(list(model.standard_errors.values()))
    ratio = np.std(estimates, axis=0) / np.mean(spreads, axis=0)
    # the scatter of 40 values is known to 11 %, at four standard deviations to 45 %; an autoregressive model adds some
    assert (ratio > 0.55).all()
    assert (ratio < 1.5).all()


def test_without_noise_the_parameters_come_back_with_offsets_delays_two_inputs_and_two_experiments():
    rng = np.random.default_rng(5)
    parts = []
    for name in ("first", "second"):
        u = rng.normal(size=(200, 2))
        x = lfilter([0, 0, 1.0, 0.5], [1, -0.8], u[:, 0]) + lfilter([0, -0.7], [1, -1.2, 0.5], u[:, 1])
        y = x[50:] + 3.0  # the first samples are past: the record does not begin at rest
        t = PERIOD * np.arange(150)
        parts.append(wb.Dataset.of(t, {"u": u[50:] + [1.0, 2.0], "y": y}, {"u": "V", "y": "rad"}, name=name))
    log = parts[0].with_experiments(parts[1])
    model = wb.linear_models.output_error(
        log, ["u[0]", "u[1]"], "y", nb=(2, 1), nf=(1, 2), nk=(2, 1), offsets="estimate"
    )
    wanted = {"b1[0]": 1.0, "b2[0]": 0.5, "b1[1]": -0.7, "f1[0]": -0.8, "f1[1]": -1.2, "f2[1]": 0.5}
    assert model.parameters == pytest.approx(wanted, abs=1e-8)  # rounding, times a conditioning of 1e4 or so
    assert model.fit.simulation == pytest.approx(100, abs=1e-6)
    gains = np.array([1.5 / 0.2, -0.7 / 0.3])
    assert model.y0[0] == pytest.approx(3.0 + gains @ (model.u0 - [1.0, 2.0]), abs=1e-7)


def test_the_state_space_answers_as_the_polynomials_do_and_its_names_and_point_are_those_of_the_log():
    import control

    _, u, y = loop("ARMAX", 600, 6)
    model = wb.linear_models.armax(log_of(u + 2.0, y + 1.0), "u", "y", na=2, nb=2, nc=2)
    system, noise = model.to_ss(), model.noise_model()
    assert (system.input_labels, system.output_labels, system.dt) == (["u"], ["y"], PERIOD)
    assert (system.u0[0], system.y0[0]) == (model.u0[0], model.y0[0])
    omega = np.array([0.1, 1.0, 10.0])
    z = np.exp(1j * omega * PERIOD)
    A, B, C = (np.polyval(p[::-1], 1 / z) for p in (model.polynomials.A, model.polynomials.B[0], model.polynomials.C))
    np.testing.assert_allclose(system(z), B / A, rtol=1e-12)
    np.testing.assert_allclose(noise(z), C / A, rtol=1e-12)
    np.testing.assert_allclose(model.frequency_response(omega).values, B / A, rtol=1e-12)
    response = control.impulse_response(control.ss(system), PERIOD * np.arange(8)).outputs
    np.testing.assert_allclose(model.impulse_response(8)[:, 0] / PERIOD, response, atol=1e-12)
    assert wb.stability_margins(0.05 * system).stable


def test_the_region_of_a_response_is_the_scatter_of_the_models():
    values, spreads = [], []
    for seed in range(40):
        _, u, y = loop("ARMAX", 400, 300 + seed)
        model = wb.linear_models.armax(log_of(u, y), "u", "y", na=2, nb=2, nc=2, starts=0)
        held = model.frequency_response(np.array([0.5, 5.0]))
        values.append(held.values)
        spreads.append(held.gain_errors)
    ratio = np.std(np.abs(values), axis=0) / np.mean(spreads, axis=0)
    np.testing.assert_allclose(ratio, 1, atol=0.45)  # four standard deviations of the scatter of 40


def test_a_continuous_model_is_that_of_the_plant_or_is_refused_with_the_reason():
    motor = wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0])
    sampled = wb.c2d(motor, PERIOD)
    rng = np.random.default_rng(7)
    u, x, y = rng.normal(size=300), np.zeros(2), np.zeros(300)
    for k in range(300):
        y[k], x = (sampled.C @ x)[0], sampled.A @ x + sampled.B[:, 0] * u[k]
    delayed = np.concatenate([np.zeros(2), y[:-2]])
    model = wb.linear_models.arx(log_of(u, delayed), "u", "y", na=2, nb=2, nk=3, offsets="none")
    continuous, delays = model.to_continuous()
    np.testing.assert_allclose(np.sort(continuous.poles()), np.sort(motor.poles()), rtol=1e-6)  # no noise
    assert delays == pytest.approx([2 * PERIOD])
    with pytest.raises(wb.linear.DesignError, match="pole at z = 0"):
        wb.d2c(model.to_ss())
    negative = wb.linear_models.arx(log_of(u, lfilter([0, 1.0], [1, 0.6], u)), "u", "y", na=1, nb=1)
    with pytest.raises(wb.linear.DesignError, match=r"a pole at z = -0\.6"):
        negative.to_continuous()


def test_orders_are_chosen_by_a_hold_out_and_by_criteria_and_a_structure_that_cannot_be_fitted_is_named():
    system, u, y = loop("ARMAX", 1200, 8)
    fit, holdout = log_of(u, y).split(0.4)
    structures = [
        wb.linear_models.PolynomialStructure(na=n, nb=(min(n, 2),), nc=nc) for n in (1, 2, 3) for nc in (0, 2)
    ]
    structures.append(wb.linear_models.PolynomialStructure(na=300, nb=(300,)))
    selection = wb.linear_models.select_orders(fit, "u", "y", structures, holdout, starts=0)
    assert selection.best("BIC").structure == structure_of(system)
    best = selection.best()
    assert best.holdout.prediction_rmse == min(model.holdout.prediction_rmse for model in selection.models)
    assert len(selection.refusals) == 1
    assert "twice as many samples" in selection.refusals[0]
    table = selection.to_frame()
    assert len(table) == 6
    assert table.loc[table.BIC.idxmin(), "white"]


def test_a_model_of_another_system_is_told_by_the_test_of_its_input():
    rng = np.random.default_rng(9)
    u = rng.normal(size=1000)
    y = lfilter([0, 0.5, 0.3, -0.4], [1, -0.8], u) + 0.3 * rng.standard_normal(1000)
    poor = wb.linear_models.output_error(log_of(u, y), "u", "y", nb=1, nf=1)
    good = wb.linear_models.output_error(log_of(u, y), "u", "y", nb=3, nf=1)
    assert not poor.residual_tests()[1].is_passed
    assert all(test.is_passed for test in good.residual_tests())


def test_the_tests_of_residuals_fail_a_right_model_as_seldom_as_they_say():
    probabilities = []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        u = rng.normal(size=300)
        y = lfilter([0, 0.5], [1, -0.8], u) + 0.3 * lfilter([1.0], [1, -0.8], rng.standard_normal(300))
        tests = wb.linear_models.arx(log_of(u, y), "u", "y", na=1, nb=1).residual_tests(15)
        probabilities.append([test.probability for test in tests])
    share = np.mean(np.array(probabilities) < 0.05, axis=0)
    low, high = binom.ppf([0.0005, 0.9995], 100, 0.05) / 100
    assert (share >= low).all()
    assert (share <= high).all()


def test_a_root_of_the_noise_model_at_the_unit_circle_is_held_there_and_said():
    rng = np.random.default_rng(10)
    u = rng.normal(size=400)
    e = rng.standard_normal(401)
    y = lfilter([0, 0.5], [1, -0.8], u) + 0.3 * np.diff(e)  # C = 1 - q^-1
    model = wb.linear_models.box_jenkins(log_of(u, y), "u", "y", nb=1, nf=1, nc=1, nd=0, offsets="none")
    assert model.at_limit
    assert "held at the unit circle" in model.summary
    assert model.polynomials.radius() < 1
    assert abs(model.parameters["b1"] - 0.5) < 4 * model.standard_errors["b1"]


T = PERIOD * np.arange(200)
U = np.random.default_rng(11).normal(size=200)
Y = lfilter([0, 0.5], [1, -0.8], U)
NAN = np.where(np.arange(200) == 70, np.nan, U)
GAP = np.concatenate([T[:100], T[100:] + 5.0])


@pytest.mark.parametrize(
    ("t", "u", "y", "said"),
    [
        (T, NAN, Y, "1 of 'u' in 'log' are missing or marked, the first (missing) at 7 s"),
        (GAP, U, Y, "needs a constant period"),
        (T[::-1], U, Y, "needs times that rise"),
        (T, np.ones(200), Y, "'u' is constant"),
        (T[:3], U[:3], Y[:3], "samples for"),
    ],
)
def test_a_log_that_a_linear_model_cannot_take_is_refused_by_name(t, u, y, said):
    log = wb.Dataset.of(t.copy(), {"u": u, "y": y}, {"u": "V", "y": "rad"})
    with pytest.raises(ValueError) as refused:
        wb.linear_models.arx(log, "u", "y", na=1, nb=1)
    assert said in str(refused.value)


def test_parameters_that_the_data_do_not_tell_are_named():
    u = np.sin(2.0 * T)  # one sine tells two numbers
    with pytest.raises(ValueError, match=r"the data do not tell b\d"):
        wb.linear_models.arx(log_of(u, lfilter([0, 0.5], [1], u)), "u", "y", na=0, nb=4)
