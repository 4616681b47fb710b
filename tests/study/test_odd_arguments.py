"""Odd arguments that a fuzz found, each refused in one sentence that names the argument, or with the right answer."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
import scipy.linalg

import workbench as wb
from tests.support.tunings import tuning
from workbench.core import Entry
from workbench.core.shapes import Circle, Line
from workbench.core.validation.refusals import nearest
from workbench.engine.metrics.contract import Integral
from workbench.engine.step_choice import StepChoice
from workbench.study.document.figure import Tiles
from workbench.study.evidence import bisect, compare, pair_samples
from workbench.study.evidence.largest_setting import LoopTrial
from workbench.study.tuning.search import tune
from workbench.study.uncertainty.designs import MorrisDesign, OneAtATime
from workbench.study.uncertainty.effects import Tornado, morris, tornado

ELEMENTS = [
    wb.Saturation("v", -1.0, 1.0),
    wb.FirstOrder("v", 0.1),
    wb.RateLimit("v", -1.0, 1.0, 0.1),
    wb.PadeDelay("v", 0.1, 2),
    wb.DeadZone("v", -1.0, 1.0),
    wb.Quantiser("v", 0.1),
    wb.Backlash("v", 0.1),
    wb.Backlash("v", 0.1, 0.1),
]
NOISES = [wb.GaussMarkov("v", [0.1, 0.2], 0.1), wb.SecondOrderNoise("v", 0.1, 1.0, 1.0), wb.RandomWalk("v", 0.1)]


def by_class(thing):
    return type(thing).__name__


def memory(element, size):
    layout = element.memory(Entry("v", np.zeros(size)))
    return dict(layout.view(layout.symbols()))


@pytest.mark.parametrize("method", ["output", "rate", "update"])
@pytest.mark.parametrize("element", ELEMENTS, ids=by_class)
def test_an_element_takes_one_column_and_the_memory_of_its_size(element, method):
    call, z = getattr(element, method), memory(element, 2)
    for shape in ((1, 2), (2, 2)):
        with pytest.raises(ValueError, match=rf"\.{method}\(v=\.\.\.\)` must have shape \({shape[0]}, 1\)"):
            call(z, ca.SX.sym("v", *shape))
    for size in (0, 1, 3) if z else ():
        with pytest.raises(ValueError, match=rf"\.{method}\(z=\.\.\.\)` must hold '\w+' in shape .*; got \(2, "):
            call(z, ca.SX.sym("v", size))
    for name in z:
        with pytest.raises(LookupError, match=f"must hold the whole memory, {name}; got no '{name}'"):
            call({}, ca.SX.sym("v", 2))


def test_an_element_has_a_number_for_each_of_its_signal():
    lag = wb.FirstOrder("v", [0.1, 0.2])
    for call in (lambda: lag.memory(Entry("v", np.zeros(3))), lambda: lag.output({}, ca.SX.sym("v", 3))):
        with pytest.raises(
            ValueError,
            match=r"^`FirstOrder\(time_constant=\.\.\.\)` of 'v' must be one number, .* which has 3; got 2\.$",
        ):
            call()


def test_a_backlash_without_a_time_constant_has_no_rate():
    play = wb.Backlash("v", 0.1)
    with pytest.raises(ValueError, match=r"^`Backlash\.rate\(\.\.\.\)` needs a `time_constant`: .* by `update`\.$"):
        play.rate(memory(play, 1), ca.SX.sym("v"))


@pytest.mark.parametrize("noise", NOISES, ids=by_class)
def test_a_noise_takes_a_column_for_each_of_its_states(noise):
    right = [ca.SX.sym("w", noise.size)] * len(noise.states)
    for odd in ((), right[1:], [*right, right[0]], [ca.SX.sym("w", 3)] * len(right)):
        for name, call in {
            "start(w": lambda odd=odd: noise.start(odd),
            "after(z": lambda odd=odd: noise.after(odd, right, 0.1),
            "after(w": lambda odd=odd: noise.after(right, odd, 0.1),
        }.items():
            with pytest.raises(ValueError) as error:
                call()
            assert f".{name}=...)` must be a column of shape ({noise.size}, 1) for each state, noise" in str(
                error.value
            )
    for period in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"\.after\(period=\.\.\.\)` must be a positive, finite number of seconds"):
            noise.after(right, right, period)


def test_a_path_of_noise_has_no_more_instants_than_the_memory_holds():
    with pytest.raises(ValueError, match=r"^`path\(count=\.\.\.\)` must be a whole number from 2 to 50000000, "):
        NOISES[0].path(0.1, 10**12, np.random.default_rng(1))


@pytest.mark.parametrize("moved", [1.0, [], np.zeros((1, 2)), np.zeros((1, 1, 1))])
def test_a_tornado_has_a_bar_for_each_output_factor_and_level(moved):
    with pytest.raises(ValueError, match=r"^`Tornado\(moved_outputs=\.\.\.\)` must have shape \(1, 1, 2\), .*; got \("):
        Tornado(("a",), ("f",), (0.0, 1.0), [1.0], moved, {})


def test_the_effects_on_one_output_are_those_on_it_again():
    design = MorrisDesign(2, trajectories=4, levels=4, seed=1)
    effects = morris(design, design.points(), ["a", "b"])["a"]
    assert effects["a"] is effects
    with pytest.raises(LookupError, match="There is no 'b' among the 1 outputs"):
        effects["b"]
    once = OneAtATime(2, (0.1, 0.9))
    bars = tornado(once, once.points(), ["a", "b"])["a"]
    assert bars["a"] is bars


def test_a_measurement_has_arrays_that_fit_one_another():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    found = wb.measure(loop.ode(), [wb.rmse()], until=0.1, h=0.01)
    for name, odd in {
        "values": 5e-324,
        "t": [],
        "diverged_at": [np.nan] * 2,
        "errors": np.zeros((1, 1)),
        "limits": [],
        "half_diverged_at": [1.0, 2.0],
    }.items():
        with pytest.raises(ValueError, match=r"^`Measurement\(\w+=\.\.\.\)` must have shape .* of \d+ runs, .*; got "):
            replace(found, **{name: odd})
    for odd in ([-1], [1]):
        with pytest.raises(ValueError, match=r"^`Measurement\(looked_at=\.\.\.\)` must be numbers of the 1 runs"):
            replace(found, looked_at=odd)


@pytest.mark.parametrize("number", [np.longdouble(1), np.float16(1), np.ones(2, dtype=np.longdouble)[0]])
def test_a_number_of_any_precision_is_a_place_in_a_drawing(number):
    assert Circle((number, number), number).centre.shape == (2, 1)
    assert Line([(0.0, 0.0), np.array([number, number])]).points.shape == (2, 2)


@pytest.mark.parametrize("period", [0.1, 1.0, 3.0, 4.0, 10.0, 1e3, 1e300])
def test_the_noise_of_any_period_is_that_of_the_lyapunov_equation(period):
    """Without `exp(-A period)`, which of a stable system overflows: A X + X A' + Q = 0, X = Phi X Phi' + Qd."""
    ode, R = wb.open_loop(wb.DCMotor()), [[1e-2]]
    A = np.array(wb.linearize(ode, 0.0, [0.0, 0.0]).A)
    X, Phi = scipy.linalg.solve_continuous_lyapunov(A, -np.eye(2)), scipy.linalg.expm(A * min(period, 1e3))
    found = wb.steady_kalman(ode, Q=np.eye(2), R=R, period=period)
    C = np.array([[1.0, 0.0]])
    prior = scipy.linalg.solve_discrete_are(Phi.T, C.T, X - Phi @ X @ Phi.T, R)
    K = prior @ C.T / (C @ prior @ C.T + R)
    np.testing.assert_allclose(found.K, K, rtol=1e-9)  # of two solvers on well-conditioned matrices


def test_a_period_over_which_an_unstable_state_overflows_is_refused():
    with pytest.raises(
        ValueError, match=r"^`steady_kalman\(period=\.\.\.\)` must be a period over which .*; got 1e\+06 s"
    ):
        wb.steady_kalman(wb.open_loop(wb.CartPole()), Q=np.eye(4), R=np.eye(2), period=1e6)


def motor_loop():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))


def limits(**others):
    loop = motor_loop()
    given = {
        "loop": lambda T: wb.DigitalLoop(loop, T),
        "metrics": lambda T: [wb.rmse()],
        "limits": {"RMSE": 0.25},
        "until": 0.2,
        "longest_step": 5e-3,
    }
    return wb.LoopLimits(**given | others)


def raises(*_):
    raise KeyError("odd\nlines")


@pytest.mark.parametrize("field", ["loop", "metrics"])
def test_a_function_of_a_setting_that_raises_is_named(field):
    with pytest.raises(
        ValueError, match=rf"^`LoopLimits\({field}=\.\.\.\)\(0\.01\)` must give .*; it raised KeyError: "
    ):
        limits(**{field: raises}).at(0.01)


@pytest.mark.parametrize("limit", [0.0, -1.0, np.nan, np.inf, 1e-320])
def test_a_limit_is_finite_and_above_zero(limit):
    with pytest.raises(ValueError, match=r"^`LoopLimits\(limits=\.\.\.\)` must be finite numbers above zero"):
        limits(limits={"RMSE": limit})


def test_a_share_of_the_least_limit_is_not_met():
    assert not limits(limits={"RMSE": 1e-307}).at(0.01).keeps_limits


@pytest.mark.parametrize("settings", [(), (0.4, 0.1), (0.0, 1.0), (np.nan,), (1.0, np.inf)])
def test_settings_are_refused_in_the_words_of_the_call(settings):
    with pytest.raises(
        ValueError, match=r"^`largest_setting\(settings=\.\.\.\)` must be one value or several, positive"
    ):
        wb.largest_setting(limits(), settings)


@pytest.mark.parametrize("between", [raises, lambda low, high: "x", lambda low, high: high, lambda low, high: np.nan])
def test_what_lies_between_two_values_is_a_number_between_them(between):
    must = r"^`bisect\(between=\.\.\.\)\(1, 2\)` must give a value between the two, or None; it "
    with pytest.raises(ValueError, match=must):
        bisect(lambda x: x < 1.5, 1.0, 2.0, between=between)


def test_runs_that_are_not_there_are_named():
    loop = motor_loop()
    found = wb.measure(loop.ode(), [wb.rmse()], until=0.1, h=0.01)
    for odd in ([-1], [1], [0, 0]):
        with pytest.raises(
            ValueError, match=r"^`only\(runs\)` takes numbers of the 1 runs in rising order, .*; got \["
        ):
            found.only(odd)
    with pytest.raises(LookupError, match=r"^`Score\.pair` of 'RMSE' is of the first run, and there is none\.$"):
        _ = found.only([]).score("RMSE").pair


def test_a_choice_has_a_method_that_there_is():
    with pytest.raises(
        ValueError, match=r"^`StepChoice\(method=\.\.\.\)` is one of 'rk4', 'stabilised', 'restarted'; got 'x'"
    ):
        StepChoice(0.1, "x", 1e-3, 1e-4, "RMSE", 4.0, 1.0, 3)


@pytest.mark.parametrize("evaluate", [float, len, raises, lambda *_: "x", lambda *_: [], lambda *_: [None]])
def test_what_evaluates_a_tuning_gives_its_chunks(evaluate):
    with pytest.raises(
        ValueError, match=r"^`tune\(evaluate=\.\.\.\)` must give a chunk for each of 1 sweeps; it (gave|raised) "
    ):
        tune(tuning(), evaluate)


def test_flags_of_tiles_are_truths():
    shades = np.zeros((1, 1))
    for odd in (ca.SX(0, 1), [ca.SX.sym("a")], "x", [[True], [True, False]]):
        with pytest.raises(ValueError, match=r"^`Tiles\(has_frame=\.\.\.\)` must be True, False, or an array of shape"):
            Tiles("a", ((("x",),),), shades, has_frame=odd)


def test_an_integral_is_of_one_signal_at_least():
    metric = Integral("I", "1", "about nothing", lambda t, y: t, lambda value, horizon: value, signals=())
    with pytest.raises(ValueError, match=r"^The metric 'I' has no signal: name at least one"):
        metric.of(wb.open_loop(wb.DCMotor()))


def test_a_trial_has_an_error_for_each_share():
    with pytest.raises(
        ValueError, match=r"^`LoopTrial\(errors=\.\.\.\)` must be errors of the shapes of the shares, \{\}; got"
    ):
        LoopTrial({}, {"RMSE": [0.1]})


def test_no_runs_of_a_measurement_have_no_accuracy():
    found = wb.measure(motor_loop().ode(), [wb.rmse()], until=0.1, h=0.01, tolerance=1e-3).only([])
    assert found.summary
    assert found.check is not None


def test_a_comparison_has_no_more_than_a_million_resamples():
    draws = dict(zip("ab", np.random.default_rng(1).random((2, 50)), strict=True))
    with pytest.raises(
        ValueError, match=r"^`compare\(resamples=\.\.\.\)` must be a whole number from 100 to 1000000; got"
    ):
        compare(pair_samples(draws, metric="error", unit="rad"), resamples=2**31)


def test_a_long_side_is_shown_in_short():
    with pytest.raises(ValueError, match=r"^`linearize\(side=\.\.\.\)` must be 'above', 'below' or a mapping") as error:
        wb.linearize(wb.open_loop(wb.DCMotor()), 0.0, [0.0, 0.0], side="x" * 10**5)
    assert len(str(error.value)) < 200


def test_names_that_are_no_text_are_near_to_none():
    assert nearest("x", [1, None]) == ""
