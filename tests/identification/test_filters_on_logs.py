"""The extended and the unscented filter of a log: beside the blocks in a loop, by hand, and with jittering times."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import expm

import workbench as wb
from tests.support.cases import heavy_but
from tests.support.filter_runs import run
from tests.support.observed import Oscillator, Pendulum, Swaying
from tests.support.plain_filters import extended, unscented
from workbench.blocks.loop import ClosedLoop, Instruments, open_loop
from workbench.blocks.loop.instruments import Sensor
from workbench.blocks.observers import ExtendedKalmanFilter, UnscentedKalmanFilter
from workbench.blocks.plants import DCMotor
from workbench.core import Ode, layout, rk4
from workbench.identification.datasets import Dataset
from workbench.identification.filters import (
    DiscreteModel,
    ParameterWalk,
    SigmaPoints,
    StochasticModel,
    extended_kalman_filter,
    kalman_filter,
    unscented_kalman_filter,
)

Q, P0 = np.diag([0.1, 0.2]), np.array([[1.0, 0.3], [0.3, 0.5]])
BOTH = pytest.mark.parametrize("solve", [extended_kalman_filter, unscented_kalman_filter])


@pytest.mark.parametrize(
    ("plant", "outputs", "block", "solve", "close"),
    [
        # Runge-Kutta steps of h / 4 of P' = A P + P A' + Q here, Simpson's rule there: both err by 1e-9 and less
        (Oscillator(p=0.0), ("p",), ExtendedKalmanFilter, extended_kalman_filter, 1e-8),
        (Oscillator(p=0.0), ("p",), UnscentedKalmanFilter, unscented_kalman_filter, 1e-8),
        (Pendulum(phi=0.1), ("omega", "height"), ExtendedKalmanFilter, extended_kalman_filter, 1e-6),
    ],
)
def test_the_filter_of_a_log_is_the_block_in_a_loop_with_the_same_samples(plant, outputs, block, solve, close):
    R = np.diag([0.02, 0.01])[: len(outputs), : len(outputs)]
    runs = run(plant, block(plant, Q, R, P0, 0.05, outputs, substeps=4))
    signals = {name: runs[f"plant.{name}"][0] for name in plant.states.names}
    if "height" in outputs:
        signals["height"] = 1 - np.cos(signals["phi"])
    signals["a"] = np.append(runs["hold.a"][0, 1:], runs["hold.a"][0, -1:])
    log = Dataset.of(runs.t, {name: samples.reshape(len(runs.t)) for name, samples in signals.items()})
    x0 = plant.states.default
    answer = solve(log, StochasticModel(open_loop(plant), Q, R, x0, P0), outputs=outputs, parts=4)
    hats = np.column_stack([runs[f"observer.{name}_hat"][0] for name in plant.states.names])
    np.testing.assert_allclose(answer.x_predicted, hats, rtol=0, atol=close)
    np.testing.assert_allclose(answer.P_predicted, runs["observer.P"][0], rtol=0, atol=close)


def jittering_log(N=80):
    rng = np.random.default_rng(6)
    t = np.cumsum(rng.uniform(0.01, 0.1, N))
    samples = {"a": rng.normal(size=N), "p": rng.normal(size=N)}
    samples["p"][10:15] = np.nan
    return Dataset.of(t, samples, {"a": "m/s^2", "p": "m"})


@BOTH
def test_jittering_times_are_met_as_by_exact_matrix_exponentials(solve):
    log, A, B = jittering_log(), np.array([[0.0, 1.0], [-4.0, -0.3]]), np.array([[0.0], [1.0]])
    answer = solve(log, StochasticModel(open_loop(Oscillator()), Q, [[0.1]], [0, 0], P0))
    lengths = np.append(np.diff(log.experiments[0].t), 0.01)
    blocks = [expm(np.block([[-A, Q], [np.zeros((2, 2)), A.T]]) * h) for h in lengths]
    Phi = np.array([block[2:, 2:].T for block in blocks])
    Qd = np.array([block[2:, 2:].T @ block[:2, 2:] for block in blocks])
    gamma = np.array([np.linalg.solve(A, (F - np.eye(2)) @ B) for F in Phi])
    exact = kalman_filter(
        *(log["p"], Phi, [[1, 0]], (Qd + np.swapaxes(Qd, 1, 2)) / 2, [[0.1]]),
        x0=[0, 0],
        P0=P0,
        B=gamma,
        u=log["a"],
    )
    # the steps are chosen so that half of them change no estimate by 1e-4 deviations, and their own error is 1/16 of it
    assert answer.discretisation_error < 1e-4
    np.testing.assert_allclose(answer.x, exact.x, rtol=0, atol=1e-5)
    np.testing.assert_allclose(answer.P, exact.P, rtol=0, atol=1e-5)
    np.testing.assert_allclose(answer.smooth().x, exact.smooth().x, rtol=0, atol=1e-5)
    assert answer.log_likelihood == pytest.approx(exact.log_likelihood, abs=1e-3)


def test_an_input_between_its_samples_is_held_or_a_straight_line():
    x, t, p = ca.SX.sym("x"), ca.SX.sym("t"), ca.SX.sym("p")
    ode = Ode.of("sum", layout(s="m"), layout(v="m/s"), (t, x, p), {"s": p}, {"y": x}, {"y": "m"})
    log = Dataset.of([0.0, 1.0, 4.0], {"v": [1.0, 3.0, 0.0], "y": 3 * [np.nan]})
    model = StochasticModel(ode, [[0.0]], [[1.0]], x0=[0.0], P0=[[1.0]])
    held = extended_kalman_filter(log, model, inputs=["v"])
    line = extended_kalman_filter(log, model, inputs=["v"], hold="linear")
    np.testing.assert_allclose(held.x[:, 0], [0.0, 1.0, 10.0], rtol=1e-14)
    np.testing.assert_allclose(line.x[:, 0], [0.0, 2.0, 6.5], rtol=1e-14)


def test_numbers_of_vectors_are_read_and_estimated_by_their_labels():
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p", 4)
    ports = (layout(q=("rad", [0.0, 0.0])), layout(K=("1/s", [1.0, 2.0]), tau=("rad/s", [0.0, 0.0])))
    ode = Ode.of("lags", *ports, (t, x, p), {"q": p[2:] - p[:2] * x}, {"y": x}, {"y": "rad"})
    times = np.linspace(0, 3, 301)
    y = np.stack([(1 - np.exp(-1.5 * times)) / 1.5, (1 - np.exp(-2 * times)) / 2], axis=1)
    log = Dataset.of(times, {"tau": np.ones((301, 2)), "y": y}, {"tau": "rad/s", "y": "rad"})
    walks = {"K[0]": ParameterWalk(1.0)}
    model = StochasticModel(ode, 1e-10 * np.eye(2), 1e-6 * np.diag([1, 2]), [0, 0], 1e-6 * np.eye(2), walks=walks)
    plain = extended_kalman_filter(log, model, inputs=["tau"])
    swapped = replace(model, R=1e-6 * np.diag([2, 1]))
    other = extended_kalman_filter(log, swapped, inputs=["tau"], outputs=["y[1]", "y[0]"])
    assert plain.states.labels == ("q[0]", "q[1]", "K[0]")
    assert other.outputs.labels == ("y[1]", "y[0]")
    assert plain.x[-1, 2] == pytest.approx(1.5, abs=1e-3)  # a deviation is 2e-4, and the log has no noise
    np.testing.assert_allclose(other.x, plain.x, rtol=0, atol=1e-12)  # the order of the sensors


def swing(x, sin):
    return [x[0] + 0.05 * x[1], x[1] + 0.05 * (-9.81 * sin(x[0]) - 0.3 * x[1])]


def swinging():
    rng = np.random.default_rng(9)
    y = np.sin(np.cos(2.8 * 0.05 * np.arange(40))) + rng.normal(0, 0.05, 40)
    ports = (layout(theta="rad", omega="rad/s"), layout(), layout(y=""))
    model = DiscreteModel.of(*ports, lambda x, u: swing(x, ca.sin), lambda x, u: [ca.sin(x[0])])
    return Dataset.of(np.arange(40.0), {"y": y}), model, y[:, None]


def compare(answer, wanted):
    before, after, smooth = wanted
    close = {"rtol": 0, "atol": 1e-11}  # the rounding of the plain form
    for x, P, (want_x, want_P) in (
        (answer.x_predicted, answer.P_predicted, zip(*before, strict=True)),
        (answer.x, answer.P, zip(*after, strict=True)),
        (answer.smooth().x, answer.smooth().P, zip(*smooth, strict=True)),
    ):
        np.testing.assert_allclose(x, np.array(want_x), **close)
        np.testing.assert_allclose(P, np.array(want_P), **close)


NOISES = {"Q": np.diag([1e-4, 1e-3]), "R": np.array([[0.0025]])}
START = {"x0": np.array([1.0, 0.0]), "P0": 0.1 * np.eye(2)}


def test_the_extended_filter_and_its_smoother_are_those_of_the_textbook():
    log, model, y = swinging()

    def F(x):
        return np.array([[1, 0.05], [-0.05 * 9.81 * np.cos(x[0]), 1 - 0.05 * 0.3]])

    wanted = extended(
        *(lambda x: np.array(swing(x, np.sin)), lambda x: np.sin(x[:1]), F, lambda x: np.array([[np.cos(x[0]), 0]])),
        *(*NOISES.values(), *START.values(), y),
    )
    compare(extended_kalman_filter(log, StochasticModel(model, **NOISES, **START)), wanted)


@pytest.mark.parametrize("weights", [(1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.8, 2.0, 0.5)])
def test_the_unscented_filter_and_its_smoother_are_those_of_the_textbook(weights):
    log, model, y = swinging()
    wanted = unscented(
        *(lambda x: np.array(swing(x, np.sin)), lambda x: np.sin(x[:1])),
        *(*NOISES.values(), *START.values(), y, *weights),
    )
    compare(unscented_kalman_filter(log, StochasticModel(model, **NOISES, **START), SigmaPoints(*weights)), wanted)


@BOTH
def test_steps_and_loops_with_a_computer_are_models_as_they_are(solve):
    plant, h = Pendulum(), 0.05
    step = rk4(open_loop(plant), h)
    t = h * np.arange(40)
    log = Dataset.of(t, {"a": np.sin(3 * t), "phi": 0.5 * np.cos(3 * t)}, {"a": "rad/s^2", "phi": "rad"})
    ports = (step.states, layout(a="rad/s^2"), layout(phi="rad"))
    values = dict(zip(step.parameters.names, step.parameters.default, strict=True))
    model = DiscreteModel.of(
        *ports,
        lambda x, u: step.F(0, x, ca.vertcat(*(u if name == "a" else value for name, value in values.items())), []),
        lambda x, u: x[0],
    )
    keys = {"Q": 1e-3 * np.eye(2), "R": [[1e-2]], "x0": [0.5, 0.0], "P0": P0}
    by_step, by_model = (solve(log, StochasticModel(of, **keys)) for of in (step, model))
    np.testing.assert_allclose(by_step.x, by_model.x, rtol=0, atol=1e-13)  # the order of the operations
    with pytest.raises(ValueError, match=r"samples at multiples of the step, 0.05 s, without a gap"):
        solve(Dataset.of(1.01 * t, {"a": t, "phi": t}), StochasticModel(step, **keys))


def test_signals_of_other_names_are_the_same_signals():
    log = jittering_log()
    t, model = log.experiments[0].t, StochasticModel(open_loop(Oscillator()), Q, [[0.1]], [0, 0], P0)
    other = Dataset.of(t, {"push": log["a"], "place": log["p"]}, {"push": "m/s^2", "place": "m"})
    renamed = extended_kalman_filter(other, model, signals={"push": "a", "place": "p"})
    np.testing.assert_array_equal(renamed.x, extended_kalman_filter(log, model).x)


def test_marked_samples_are_lost_samples():
    log = jittering_log()
    (experiment,) = log.experiments
    experiment.marks[20, experiment.signals.indices("p")] = True
    model = StochasticModel(open_loop(Oscillator()), Q, [[0.1]], [0, 0], P0)
    marked = extended_kalman_filter(log, model, parts=1)
    experiment.values[20, experiment.signals.indices("p")] = 1e9
    experiment.marks[20] = True
    assert np.isfinite(marked.innovations[:, 0]).sum() == 80 - 6
    again = extended_kalman_filter(log, model, parts=1)
    np.testing.assert_array_equal(again.x, marked.x)


def motor_log(seed, J=0.012, b=0.12):
    """A motor with other numbers than the default, under steps of its voltage, and its speed with noise."""
    rng = np.random.default_rng(seed)
    motor, h, N = DCMotor(J=J, b=b), 0.02, 1500
    step, v = rk4(open_loop(motor), h), np.repeat(rng.choice([-12.0, 12.0], N // 25), 25)
    p, x, omega = step.parameters.default.copy(), np.zeros(2), np.zeros(N)
    for k in range(N):
        omega[k] = x[0] + rng.normal(0, 0.02)
        p[-1] = v[k]
        x = np.array(step.F(k, x, p, [])).ravel()
    return Dataset.of(h * np.arange(N), {"v": v, "omega": omega}, {"v": "V", "omega": "rad/s"})


@pytest.mark.parametrize("solve", heavy_but([extended_kalman_filter, unscented_kalman_filter], extended_kalman_filter))
def test_parameters_are_estimated_with_the_state_and_carry_their_names(solve):
    motor = open_loop(DCMotor())
    walks = {"b": ParameterWalk(0.03**2), "J": ParameterWalk(0.004**2)}
    model = StochasticModel(motor, 1e-9 * np.eye(2), [[0.02**2]], x0=[0, 0], P0=1e-4 * np.eye(2), walks=walks)
    answer = solve(motor_log(3), model)
    assert answer.states.names == ("omega", "i", "b", "J")
    assert answer.states["J"].unit == "kg m^2"
    off = (answer.x[-1, 2:] - [0.12, 0.012]) / answer.deviations[-1, 2:]
    assert np.abs(off).max() < 3.3  # 99.9 % of a normal distribution
    assert (answer.deviations[-1, 2:] < 0.03 * answer.x[-1, 2:]).all()
    assert answer.consistency().is_consistent
    wrong = solve(motor_log(3), replace(model, walks={}))
    assert not wrong.consistency().is_consistent
    np.testing.assert_allclose(answer.smooth().x[0, 2:], answer.x[-1, 2:], rtol=1e-9)  # they are constant


def test_an_estimate_beyond_the_bounds_of_a_parameter_is_a_remark():
    t = 0.02 * np.arange(60)
    log = Dataset.of(t, {"v": 12 + 0 * t, "omega": -20 * t})
    walks = {"b": ParameterWalk(1.0)}
    model = StochasticModel(open_loop(DCMotor()), np.eye(2), [[1e-4]], [0, 0], np.eye(2), walks=walks)
    answer = extended_kalman_filter(log, model)
    assert any("'b' must be" in remark and "estimates are not" in remark for remark in answer.remarks)


def test_a_loop_with_its_computer_is_a_model_and_outputs_with_random_numbers_are_refused():
    block = ExtendedKalmanFilter(Oscillator(), Q, [[0.1]], P0, 0.05, ("p",))
    loop = ClosedLoop(Oscillator(), block, Swaying())
    digital = loop.digital(0.05, Instruments((Sensor("p", "m", 0.1, 0.0),)))
    n = digital.states.size
    log = Dataset.of(0.05 * np.arange(3), {"p": np.ones(3), "p_error": np.ones(3)})
    keys = {"Q": 1e-6 * np.eye(n), "R": [[0.1]], "x0": digital.states.default, "P0": 1e-6 * np.eye(n)}
    model = StochasticModel(digital, **keys)
    answer = extended_kalman_filter(log, model, outputs=["p"])
    hat = answer.states.labels.index("observer.p_hat")
    # the noise of the sensor moves the estimate of the loop, by its gain of K = 1 / 1.1
    assert answer.deviations[0, hat] < 2e-3 < 0.05 < np.sqrt(answer.P_predicted[1, hat, hat])
    with pytest.raises(ValueError, match="without random numbers, as v is their noise; those of p_error"):
        extended_kalman_filter(log, model, outputs=["p_error"])


def test_a_compass_is_unwrapped_and_a_filter_says_where_it_is_not():
    """A body turns by 20 rad, and its compass ends at pi."""
    t = np.arange(200) * 0.1
    heading = t + 0.02 * np.random.default_rng(3).standard_normal(t.size)
    compass = np.mod(heading + np.pi, 2 * np.pi) - np.pi
    compass[50] = np.nan
    log = wb.Dataset.of(t, {"heading": np.degrees(compass)}, {"heading": "deg"})
    ports = wb.layout(theta="deg", omega="deg/s"), wb.layout(), wb.layout(heading="deg")
    body = wb.filters.DiscreteModel.of(*ports, lambda x, u: [x[0] + 0.1 * x[1], x[1]], lambda x, u: [x[0]])
    model = wb.filters.StochasticModel(body, 1e-2 * np.eye(2), [[1.3]], x0=[0.0, 57.0], P0=100 * np.eye(2))
    for filtered in (wb.filters.extended_kalman_filter, wb.filters.unscented_kalman_filter):
        assert any("`log.unwrap(['heading'])`" in remark for remark in filtered(log, model).remarks)
        whole = filtered(log.unwrap(["heading"]), model)
        assert whole.remarks == ()
        errors = np.abs(whole.x[:, 0] - np.degrees(t)) / whole.deviations[:, 0]
        assert errors.max() < 4.5  # standard deviations, of 200 normal numbers
    assert log.unwrap(["heading"]).notes[-1] == "Full turns were added to heading at 3 jumps."
    with pytest.raises(ValueError, match=r"must name angles in rad, mrad, deg, .*; got \[V\]"):
        wb.Dataset.of(t, {"v": t}, {"v": "V"}).unwrap(["v"])
