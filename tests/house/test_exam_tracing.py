"""Functions of the exams as graphs: what is traced, and what is left to the plain function."""

import math
import sys

import casadi as ca
import numpy as np
import pytest

from tests.exams import ode as ode_exams
from tests.exams.graders import find, loaded
from tests.exams.tracing import UntraceableError, trace


def test_a_traced_function_is_the_plain_one(exam):
    (grader,) = find(exam())
    with loaded(grader) as one:
        problems = sys.modules["problems"]
        spring, drag = problems.spring(problems.Plain), problems.drag
        ode = trace(spring, [1.0, 0.0], one.modules)
        jump = trace(drag, [1.0], one.modules)
        ramp = trace(problems.ramp(problems.Plain), [1.0], one.modules)
    assert [ramp.rate_at(0.0, [x])[0] for x in (0.2, 0.7)] == [0.5, 0.7]
    np.testing.assert_allclose(ode.rate_at(0.3, [0.4, 2.0]), [2.0, -4 * math.sin(0.4) - math.exp(-0.3)], rtol=1e-15)
    for x in (-3.0, -0.5, 0.0, 0.5, 3.0):
        np.testing.assert_allclose(jump.rate_at(0.3, [x]), drag(0.3, [x]), rtol=1e-15)
    assert isinstance(drag(0.3, [1.0])[0], float)


def test_a_function_written_with_arrays_is_traced_too(exam):
    with loaded(find(exam())[0]) as one:
        rows = sys.modules["problems"].rows
        ode = trace(rows, [1.0, -0.5], one.modules)
    x = np.array([0.4, -2.0])
    expected = [-1 + math.sin(0.4), -math.exp(-0.3) * 0.4 - 4 + math.sin(-2.0)]
    np.testing.assert_allclose(rows(0.3, x), expected, rtol=1e-14)
    np.testing.assert_allclose(ode.rate_at(0.3, x), expected, rtol=1e-14)


@pytest.mark.parametrize("name", ["relay", "saturated", "guarded", "filled", "solved"])
def test_conditions_arrays_that_are_filled_and_linear_algebra_are_traced(exam, name):
    with loaded(find(exam())[0]) as one:
        plain = getattr(sys.modules["problems"], name)
        size = 1 if name in ("relay", "saturated") else 2
        ode = trace(plain, np.full(size, 0.5), one.modules)
    for x in [*np.random.default_rng(1).normal(size=(20, size)), np.zeros(size) + (name == "solved")]:
        np.testing.assert_allclose(ode.rate_at(0.7, x), np.ravel(plain(0.7, x)), rtol=1e-12, atol=1e-13)  # rounding


def test_a_condition_is_a_surface_to_the_reference_mode(exam):
    with loaded(find(exam())[0]) as one:
        pushed = sys.modules["problems"].pushed
        run = ode_exams.Candidate(one).integrate(pushed, [0.5], [2.0, 4.0], 1e-9, 1e-9)
    # held at zero until 0.3 t = 1, then x' = 0.3 t - 1
    np.testing.assert_allclose(run[:, 0], [0.0, 0.15 * 16 - 4 + 1 / 0.6], atol=1e-9)


def test_a_way_that_the_reference_mode_refuses_is_left_to_the_plain_function(exam):
    # three ways on one surface, the middle one for zero alone: no law of sliding, and none is needed here
    with loaded(find(exam())[0]) as one:
        run = ode_exams.Candidate(one).integrate(sys.modules["problems"].relay, [-1.0], [0.5], 1e-9, 1e-9)
    np.testing.assert_allclose(run, [[-1 + 0.5 + 0.15 * 0.25]], atol=1e-9)


def test_a_loop_until_a_number_is_small_is_not_traced(exam):
    with loaded(find(exam())[0]) as one, pytest.raises(UntraceableError, match="asks more than 64 questions"):
        trace(sys.modules["problems"].stuck, [1.0], one.modules)


def test_too_many_ways_are_not_traced(exam):
    def many(t, x):
        return [sum(1.0 if x[0] > i else 0.0 for i in range(9))]

    with pytest.raises(UntraceableError, match="more than 256 ways"):
        trace(many, [1.0], [])
    assert not ca.SX.__bool__(ca.SX(0))


def test_a_function_with_a_hidden_memory_is_not_taken_for_its_graph():
    calls = []

    def drifting(t, x):
        calls.append(t)
        return [-x[0] + len(calls)]

    with pytest.raises(UntraceableError, match="other numbers"):
        trace(drifting, [1.0], [])
