"""What the reference integrator cannot run or continue is refused by name, with the time."""

import casadi as ca
import numpy as np
import pytest

from tests.support.equations import decay, oscillator
from tests.support.reference_runs import run
from workbench.core import Entry, Layout, Ode, rk4
from workbench.core.numbers import Bounds
from workbench.engine.reference import reference_of_function, reference_run

# Surfaces that the state never leaves


@pytest.mark.parametrize(
    "rate",
    [
        lambda t, x: [ca.sign(x[1]), 0],
        lambda t, x: [ca.if_else(x[1] <= 0, 1, 2), 0],
        lambda t, x: [-x[0] + ca.sign(x[1]), -x[1]],
    ],
)
def test_a_state_that_stays_where_each_side_has_its_own_rate_is_refused(rate):
    with pytest.raises(ValueError, match=r"t = 0 s, where the state stays on x\[1\] = 0, where each side has a rate"):
        run(rate, [0.0, 0.0], 1.0)


# Refusals

REFUSED = [
    (lambda t, x: [ca.sign(x[0])], [0.0], "t = 0 s.*more than one side.*not unique"),
    (lambda t, x: [-ca.sign(x[0]) + ca.sign(x[0]) * ca.sign(x[0] + 0 * t) / 2], [1.0], "t = 2 s.*not affine"),
    (lambda t, x: [x[1], -2 * ca.sign(x[0]) - ca.sign(x[1])], [1.0, 0.0], "t = 4.4614.*accumulate.*not determined"),
    (lambda t, x: [x[1], x[2], -ca.sign(x[0])], [0.0, 0.0, 0.0], "t = 0 s.*first two derivatives"),
    (lambda t, x: [x[0] ** 2], [1.0], r"t = 1\.0000.*finite escape"),
    (lambda t, x: [1000 * x[0]], [1.0], "finite escape"),
    (lambda t, x: [-ca.sign(x[0] + 5) * ca.sqrt(ca.fabs(x[0]) - 0.5)], [1.0], "rate is not finite"),
    (lambda t, x: [ca.log(x[0])], [-1.0], "t = 0 s, where the rate is not finite"),
    (lambda t, x: [-1 / x[0]], [1.0], "t = 0.49.*no step is short enough|rate is not finite"),
    (lambda t, x: [ca.if_else(x[0] == 0, 1, 0)], [1.0], "'eq'.*has none"),
    (lambda t, x: [ca.fmod(x[0], 2)], [1.0], "'fmod'"),
    (lambda t, x: [ca.if_else(x[0], 1, 0)], [1.0], "'if_else of a number'"),
    (lambda t, x: [*(-ca.sign(x[i]) for i in range(6))], [1.0] * 6, "t = 1 s.*6 surfaces at once"),
]


@pytest.mark.parametrize(("rate", "x0", "words"), REFUSED)
def test_what_cannot_be_continued_is_refused_by_name_with_the_time(rate, x0, words):
    with pytest.raises(ValueError, match=words):
        run(rate, x0, 6.0)


def test_a_run_that_needs_too_many_steps_says_how_far_it_came():
    with pytest.raises(ValueError, match="t = .* s, after 50 steps: allow more with `max_steps`"):
        reference_run(oscillator(), times=[1000.0], max_steps=50)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"times": []}, "times"),
        ({"times": [1.0, 1.0]}, "increase"),
        ({"times": [-1.0, 1.0]}, "from 0 on"),
        ({"times": [1.0, np.nan]}, "finite"),
        ({"times": "soon"}, "soon"),
        ({"rtol": 1e-15}, "double precision"),
        ({"rtol": "fine"}, "fine"),
        ({"atol": 0.0}, "positive"),
        ({"atol": [1e-9] * 3}, r"shape \(1,\)"),
        ({"method": "euler"}, "explicit"),
        ({"max_steps": 0}, "max_steps"),
        ({"p": [1.0, 2.0]}, r"reference\(p=...\)"),
        ({"p": [-1.0]}, "'omega'"),
        ({"x0": [np.nan]}, "finite"),
    ],
)
def test_arguments_that_are_not_as_they_must_be_are_refused(options, words):
    states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("omega", np.ones(()), "", Bounds(low=0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    ode = Ode.of("one", states, parameters, (t, x, p), {"x": -p * x}, {})
    with pytest.raises(ValueError, match=words):
        reference_run(ode, **{"times": [1.0], **options})


def test_what_is_no_equation_is_refused_with_the_way_to_one():
    with pytest.raises(ValueError, match="must be an `Ode`; got"):
        reference_run(rk4(decay(), 0.1), times=[1.0])
    with pytest.raises(ValueError, match=r"`reference_of_function\(f=...\)` must be a function; got 3.0"):
        reference_of_function(3.0, [1.0], times=[1.0])


def test_a_plain_function_is_refused_where_it_has_no_finite_rate():
    with pytest.raises(ValueError, match="each of the 2 states"):
        reference_of_function(lambda t, x: [1.0], [1.0, 2.0], times=[1.0])
    with pytest.raises(ValueError, match="finite escape"):
        reference_of_function(lambda t, x: x**2, [1.0], times=[2.0])
    with pytest.raises(ValueError, match="t = 0 s, where the rate is not finite"):
        reference_of_function(lambda t, x: x * np.nan, [1.0], times=[2.0])


def test_an_exception_of_a_plain_function_is_told_with_the_time():
    def breaks(t, x):
        return [1 / 0] if t > 1 else -x

    with pytest.raises(
        ValueError, match=r"stops at t = .*, where the function raised ZeroDivisionError: division"
    ) as e:
        reference_of_function(breaks, [1.0], times=[2.0])
    assert isinstance(e.value.__cause__, ZeroDivisionError)


@pytest.mark.parametrize("options", [{"times": []}, {"rtol": 2.0}, {"atol": 0.0}, {"method": "x"}, {"max_steps": 0}])
def test_a_refusal_names_the_function_that_was_called(options):
    with pytest.raises(ValueError, match=rf"`reference_of_function\({next(iter(options))}=...\)`"):
        reference_of_function(lambda t, x: -x, [1.0], **{"times": [1.0], **options})
    with pytest.raises(ValueError, match=r"`reference_of_function\(x0=...\)` must have shape \(1,\).*got \(0,\)"):
        reference_of_function(lambda t, x: -x, [], times=[1.0])
