"""Fits: the numbers come back, their errors are those of the theory, and what speaks against a fit is said."""

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete
from scipy.stats import binom

import workbench as wb
from tests.support.motor_logs import FREE, MOTOR, START, TRUE, UNITS, T, V, X, log, motion, steps
from workbench.core import Ode, layout
from workbench.identification.estimation import fit, identifiability, simulate_log
from workbench.identification.estimation.input_record import MeasuredInput
from workbench.identification.estimation.output_model import OutputModel
from workbench.identification.estimation.unknown_numbers import NumberSource


def test_a_log_without_noise_gives_its_parameters_back():
    found = fit(MOTOR, log(T, V, X), FREE, start=START)
    for name in FREE:
        assert found.values[name] == pytest.approx(
            TRUE[name], rel=1e-7
        )  # an estimate keeps still to 1e-8 at half a step
    assert found.is_exact
    assert found.certificate.is_passed
    assert found.warnings == ()


def test_modes_much_faster_than_the_samples_are_fitted_and_told():
    """The current settles in a hundredth of a period, where Runge-Kutta steps of a sixteenth of it diverge."""
    t, v = steps(61, 5, 0.1)
    starts = {"J": 0.013, "R": 1.2, "L": 7e-4}
    fast = {"J": 0.01, "R": 1.0, "L": 1e-3}
    run = wb.open_loop(wb.DCMotor(L=fast["L"]))
    data = log(t, v, motion(t, v, L=fast["L"]))
    found = fit(run, data, tuple(fast), start=starts)
    for name, value in fast.items():
        assert found.values[name] == pytest.approx(value, rel=1e-6), name
    assert identifiability(run, data, tuple(fast), ["omega", "i"]).is_complete


def test_a_system_without_inputs_is_fitted_from_its_free_motion():
    """Prey and hunters after Lotka and Volterra, by another program."""
    x, t, p = ca.SX.sym("x", 2), ca.SX.sym("t"), ca.SX.sym("p", 2)
    states, own = layout(n=("", 12.0), q=("", 4.0)), layout(a=("1/s", 0.8), d=("1/s", 0.3))
    rate = ca.vertcat(p[0] * x[0] - 0.1 * x[0] * x[1], 0.05 * x[0] * x[1] - p[1] * x[1])
    ode = Ode("prey", states, own, layout(prey="", hunters=""), t, x, p, rate, x)
    run = solve_ivp(
        lambda s, z: [0.9 * z[0] - 0.1 * z[0] * z[1], 0.05 * z[0] * z[1] - 0.5 * z[1]],
        (0, 20), [12.0, 4.0], "DOP853", np.linspace(0, 20, 101), rtol=1e-11, atol=1e-12,
    )  # fmt: skip
    log = wb.Dataset.of(run.t, {"prey": run.y[0], "hunters": run.y[1]}, {"prey": "1", "hunters": "1"})
    found = fit(ode, log, ("a", "d"), hold_out=0.0)
    assert found.values == pytest.approx({"a": 0.9, "d": 0.5}, rel=1e-7)
    assert identifiability(ode, log, ("a", "d"), ["prey"]).is_complete


def test_small_smooth_residuals_are_searched_for_a_better_minimum():
    """The single search ends at residuals of 1e-5 of the spread, which no sensor has; the log is explained exactly."""

    def rate(t, x, u, p, m):
        first = p.c1 * u[0] - p.a2 * x[0], p.c2 * x[0] + u[0] - p.a3 * x[1]
        return [*first, 2 * x[1] - p.a4 * x[2], x[2] + x[0] - p.a5 * x[3]]

    t = np.arange(161) * 0.1
    u = np.repeat(np.random.default_rng(4).uniform(-1, 1, (2, 21))[1], 8)[: t.size]
    A = np.array([[-2.0, 0, 0, 0], [0.4, -3.0, 0, 0], [0, 2.0, -1.5, 0], [1.0, 0, 1.0, -0.7]])
    Ad, Bd, *_ = cont2discrete((A, np.array([[0.6], [1.0], [0.0], [0.0]]), np.eye(4), np.zeros((4, 1))), 0.1)
    x = np.zeros((t.size, 4))
    for k in range(t.size - 1):
        x[k + 1] = Ad @ x[k] + Bd[:, 0] * u[k]
    starts = layout(a2=("", 1.0), a3=("", 4.5), a4=("", 0.75), a5=("", 1.05), c1=("", 0.3), c2=("", 0.6))
    plant = wb.OdePlant.of(rate, ("x1", "x2", "x3", "x4"), ("u",), ("x4",), p=starts, x0=np.zeros(4))
    log = wb.Dataset.of(t, {"u": u, "x4": x[:, 3]}, {"u": "1", "x4": "1"})
    found = fit(wb.open_loop(plant), log, starts.names, hold_out=0.0)
    assert found.is_exact
    assert found.end.shooting == "a random start"
    assert found.values["a3"] == pytest.approx(3.0, rel=1e-6)  # the only lag that no other can stand for


def test_a_delay_an_offset_a_scale_and_an_initial_state_come_back_too():
    x = motion(T, V, x0=(3.0, 0.0), delay=0.013)
    x = np.column_stack([1.1 * x[:, 0], x[:, 1] + 0.2])
    found = fit(
        MOTOR,
        log(T, V, x),
        ("J", "R", "delay of v", "offset of i", "scale of omega", "omega(0)"),
        start={"J": 0.013},
    )
    expected = {"J": TRUE["J"], "R": TRUE["R"], "delay of v": 0.013, "offset of i": 0.2, "scale of omega": 1.1}
    for name, value in {**expected, "omega(0)": 3.0}.items():
        assert found.values[name] == pytest.approx(value, rel=1e-6), name


@pytest.mark.parametrize("hold", ["hold", "linear"])
def test_derivatives_by_every_kind_of_number_are_differences_of_outputs(hold):
    data = log(T, V, X)
    source = NumberSource(
        MOTOR, MOTOR.parameters.default, np.array([[0.5, 0.0]]), ("log",), ("v",), {"omega": "rad/s", "i": "A"}, {}
    )
    numbers = source.numbers((*FREE, "delay of v", "scale of omega", "offset of i", "omega(0)"))
    pairs = (("omega", "omega"), ("i", "i"))
    p = MOTOR.parameters.default
    model = OutputModel(
        MOTOR, data, (MeasuredInput("v", "v", hold),), pairs, numbers, p, np.zeros((1, 2)), (0.01,), (0.0,)
    )
    z = model.starts + np.array([0, 0, 0, 0, 0.0037, 0.2, 0.1, 0.0])  # a delay that is no multiple of the period
    _, J = model.derivatives(z, 0)
    for i in range(len(z)):
        d = 1e-6 * max(abs(z[i]), 0.01) * np.eye(len(z))[i]
        difference = (model.values((z + d)[None], 0)[0] - model.values((z - d)[None], 0)[0]) / (2 * d[i])
        assert np.abs(J[:, :, i] - difference).max() < 1e-6 * np.abs(difference).max(), numbers[i].name


def test_an_offset_alone_has_the_error_of_a_mean():
    sigma, sample = 0.3, log(T, V, X, noise=0.3)
    found = fit(MOTOR, sample, ("offset of omega",), noise={"omega": sigma, "i": sigma}, hold_out=0.0)
    expected = np.mean(sample["omega"] - X[:, 0])
    assert found.values["offset of omega"] == pytest.approx(expected, abs=1e-3 * sigma)  # outputs by Runge-Kutta steps
    assert found.standard_errors["offset of omega"] == pytest.approx(sigma / np.sqrt(len(T)), rel=1e-9)


def shares_that_hold(count, known):
    """For each parameter how often its 95 % interval holds it."""
    t, v = steps(81, 3)
    x, hits = motion(t, v), []
    for seed in range(count):
        noise = {"omega": 0.3, "i": 0.3} if known else None
        found = fit(MOTOR, log(t, v, x, 0.3, seed), FREE, noise=noise, hold_out=0.0)
        hits.append([low <= TRUE[name] <= high for name, (low, high) in found.intervals().items()])
    return np.mean(hits, axis=0)


@pytest.mark.parametrize(
    ("count", "known"),
    [
        (60, True),
        pytest.param(1000, True, marks=pytest.mark.release),
        pytest.param(1000, False, marks=pytest.mark.release),
    ],
)
def test_intervals_hold_the_truth_as_often_as_they_say(count, known):
    low, high = binom.ppf([0.0005, 0.9995], count, 0.95) / count
    shares = shares_that_hold(count, known)
    assert (shares >= low).all()
    assert (shares <= high).all()


def test_the_noise_of_each_sensor_is_estimated_by_itself():
    e = np.random.default_rng(5).standard_normal(X.shape) * [0.5, 0.02]
    found = fit(MOTOR, log(T, V, X + e), FREE, hold_out=0.0)
    assert found.noise["omega"] == pytest.approx(0.5, rel=0.2)  # 161 samples: 6 % of a standard deviation
    assert found.noise["i"] == pytest.approx(0.02, rel=0.2)


def test_what_a_speed_alone_cannot_tell_is_refused_by_name():
    data = wb.Dataset.of(T, {"v": V, "omega": X[:, 0]}, {"v": "V", "omega": "rad/s"})
    with pytest.raises(ValueError, match="cannot tell J, b, K, R, L apart"):
        fit(MOTOR, data, ("J", "b", "K", "R", "L"))
    answer = identifiability(MOTOR, data, ("J", "b", "K", "R", "L"), ["omega"])
    assert (answer.dimension, answer.is_complete) == (2, False)
    assert identifiability(MOTOR, data, ("J", "b"), ["omega"]).is_complete


def test_noise_that_is_not_in_the_log_is_said_first():
    found = fit(MOTOR, log(T, V, X, noise=0.3), FREE, noise={"omega": 0.3, "i": 300.0})
    assert found.warnings[0].startswith("The noise that was given does not explain 'i': the residuals are 0.00")
    assert "'omega'" not in found.warnings[0] + found.warnings[1]


def test_data_of_another_system_are_said_first():
    swinging = X + np.column_stack([np.sin(9 * T), np.zeros_like(T)])
    found = fit(MOTOR, log(T, V, swinging), FREE, noise={"omega": 0.1, "i": 0.1})
    assert found.warnings[0].startswith("The model does not explain 'omega'")
    t, v = steps(161, 8)
    strange = wb.Dataset.of(T, {"v": V, "omega": motion(t, v)[:, 0], "i": X[:, 1]}, UNITS)
    with pytest.raises(ValueError, match="^The model does not explain"):  # at the end of the search J matters no more
        fit(MOTOR, strange, FREE, noise={"omega": 0.1, "i": 0.1})


def test_samples_that_are_marked_or_missing_have_no_weight_and_nothing_is_dropped():
    spoiled = X.copy()
    spoiled[40] = 1e3
    spoiled[50, 0] = np.nan
    experiment = log(T, V, spoiled).experiments[0]
    marks = np.zeros_like(experiment.values, dtype=bool)
    marks[40, 1:] = True
    marked = wb.Dataset((type(experiment)("log", T, experiment.signals, experiment.values, marks),))
    with pytest.raises(ValueError, match="missing samples"):
        fit(MOTOR, marked, FREE)
    found = fit(MOTOR, marked, FREE, hold_out=0.0, answers={"missing samples": "the sensor lost one"})
    assert "missing samples: the sensor lost one" in found.warnings
    assert found.data.counts.tolist() == [159, 160]
    assert found.values["J"] == pytest.approx(TRUE["J"], rel=1e-7)


def test_two_experiments_share_parameters_and_have_initial_states_of_their_own():
    t, v = steps(81, 4)
    first, second = (log(t, v, motion(t, v, x0=(speed, 0.0))) for speed in (2.0, -1.0))
    both = first.with_experiments(wb.Dataset.of(t, {n: second[n] for n in UNITS}, UNITS, name="again"))
    found = fit(MOTOR, both, ("J", "R", "omega(0)"), start={"J": 0.02, "R": 0.7})
    assert found.values["omega(0) of log"] == pytest.approx(2.0, rel=1e-6)
    assert found.values["omega(0) of again"] == pytest.approx(-1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"free": ("j",)}, "There is no 'j'"),
        ({"free": ()}, "at least one unknown number"),
        ({"free": ("J", "J")}, "more than once"),
        ({"free": ("v",)}, "is an input and known"),
        ({"noise": {"omega": 0.1}}, "each output"),
        ({"hold_out": 1.0}, "below 1"),
        ({"start": {"J": -1.0}}, "J"),
        ({"signals": {"omega": "speed"}}, "There is no 'speed'"),
    ],
)
def test_what_cannot_be_fitted_is_refused_by_name(changes, words):
    arguments = {"free": FREE, **changes}
    with pytest.raises((ValueError, LookupError), match=words):
        fit(MOTOR, log(T, V, X), **arguments)


def test_a_refusal_names_the_call_that_was_made():
    data, alone = log(T, V, X), wb.Dataset.of(T, {"omega": X[:, 0]}, {"omega": "rad/s"})
    plan = {"noise": {"omega": 0.01}, "limits": {"v": (-12.0, 12.0)}, "until": 4.0, "every": 0.05}
    for free, words in (((), "at least one"), (("J", "J"), "once"), (("v",), "is an input")):
        with pytest.raises(ValueError, match=rf"`identifiability\(free=...\)`.*{words}"):
            identifiability(MOTOR, data, free, ["omega"])
        with pytest.raises(ValueError, match=rf"`design_experiment\(free=...\)`.*{words}"):
            wb.design_experiment(MOTOR, free, ["v"], ["omega"], **plan)
    with pytest.raises(LookupError, match=r"outputs of `identifiability\(...\)`"):
        identifiability(MOTOR, data, ("offset of i",), ["omega"])
    with pytest.raises(ValueError, match=r"`identifiability\(dataset=...\)`.*none for 'v'.*by `start`"):
        identifiability(MOTOR, alone, ("J",), ["omega"])
    with pytest.raises(ValueError, match=r"`simulate_log\(dataset=...\)`.*none for 'v'.*by `values`"):
        simulate_log(MOTOR, alone, ["omega"])


def test_a_log_without_its_input_and_one_of_another_unit_are_refused():
    with pytest.raises(ValueError, match="none for 'v'"):
        fit(MOTOR, wb.Dataset.of(T, {"omega": X[:, 0]}), ("J",))
    with pytest.raises(ValueError, match="unit of 'omega'"):
        fit(MOTOR, wb.Dataset.of(T, {"v": V, "omega": X[:, 0]}, {"omega": "kg"}), ("J",))


def test_a_system_along_a_log_is_that_of_an_independent_solver():
    made = simulate_log(MOTOR, log(T, V, X), ["omega", "i"])
    for name, column in (("omega", X[:, 0]), ("i", X[:, 1])):
        # half the step changes it by 1e-6 at most, so the rest of a method of fourth order is 1e-7
        np.testing.assert_allclose(made[name], column, atol=1e-7 * np.abs(column).max())
    assert made.signals["omega"].unit == "rad/s"
    with pytest.raises(LookupError, match="speed"):
        simulate_log(MOTOR, log(T, V, X), ["speed"])


def test_a_closed_loop_is_fitted_to_what_it_shows_and_a_name_stands_for_its_only_number():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, 5.0, 20.0, None)
    loop = wb.ClosedLoop(motor, reference=wb.Constant("omega", "rad/s", 1.0), controller=law)
    run = wb.simulate(loop, until=2.0, every=0.02)
    data = wb.Dataset.of(run.t, {"omega": run["omega"][0, :, 0]}, {"omega": "rad/s"})
    found = fit(loop, data, ["plant.J", "plant.b"], start={"plant.J": 0.015})
    assert found.values["plant.J"] == pytest.approx(motor.J, rel=1e-4)  # the run keeps 1e-3 of its states at most


def test_a_plant_that_is_no_system_and_a_log_in_other_seconds_are_told_what_to_do():
    with pytest.raises(ValueError, match="open_loop"):
        fit(wb.DCMotor(), log(T, V, X), ("J",))
    with pytest.raises(ValueError, match="say whether its unit of time is s"):
        fit(MOTOR, log(1000 * T, V, X), ("J",))


def test_a_delay_that_is_none_is_estimated_beside_others():
    found = fit(MOTOR, log(T, V, X), ("J", "R", "delay of v"), start={"J": 0.012})
    assert abs(found.values["delay of v"]) < 1e-6  # s, of a period of 25 ms
    assert found.values["J"] == pytest.approx(TRUE["J"], rel=1e-4)
