"""Plans that cannot be: the limits at fault by name, and what is no plan at all."""

import numpy as np
import pytest

import workbench as wb
from workbench.planning import Phase, PlanConflictError

CAR = wb.open_loop(wb.OdePlant.of(lambda t, x, u: [x[1], u[0]], states=("x:m", "v:m/s"), inputs=("a:m/s^2",)))
REST = {"x": 0.0, "v": 0.0}


def conflict(*arguments, **named):
    """The items of the conflict of a plan, as text."""
    with pytest.raises(PlanConflictError) as error:
        wb.plan(*arguments, **named)
    return {str(item) for item in error.value.items}


def test_a_goal_that_is_too_far_for_the_time_names_the_goal_the_limit_and_the_time_and_no_innocent():
    limits = {"a": (-1.0, 1.0), "v": (-50.0, 50.0)}
    goal = {"start": REST, "end": {"x": 10.0}, "cost": "energy"}
    names = conflict(CAR, 1.0, limits=limits, **goal)
    assert names == {"a <= 1", "end of x = 10", "duration = 1", "start of x = 0", "start of v = 0"}
    # without any one of them there is a plan
    assert wb.plan(CAR, 5.0, limits=limits, **goal).certificate.is_passed
    assert wb.plan(CAR, 1.0, limits={"a": (-1.0, None), "v": (-50.0, 50.0)}, **goal).certificate.is_passed
    assert wb.plan(CAR, 1.0, limits=limits, **{**goal, "end": {}}).certificate.is_passed
    assert wb.plan(CAR, 1.0, limits=limits, **{**goal, "start": {"x": 0.0}}).certificate.is_passed


@pytest.mark.parametrize(
    ("named", "items"),
    [
        (
            {"start": {"x": 0.0, "v": 3.0}, "end": {"x": 9.0}, "limits": {"v": (-2.0, 2.0)}},
            {"start of v = 3", "v <= 2"},
        ),
        ({"start": REST, "end": {"v": 2.0}, "limits": {"v": (-1.0, 1.0)}}, {"end of v = 2", "v <= 1"}),
        ({"start": REST, "end": {"x": 1.0}, "limits": {"a": (1.0, -1.0)}}, {"a >= 1", "a <= -1"}),
    ],
)
def test_values_beyond_a_limit_and_limits_that_cross_are_named_alone(named, items):
    assert conflict(CAR, 8.0, cost="energy", **named) == items


@pytest.mark.heavy
def test_a_value_of_a_signal_at_the_end_is_named_where_it_cannot_be():
    sum_of_both = {"total": lambda t, x, u: x.x + x.v}
    limits = {"x": (-1.0, 1.0), "v": (-1.0, 1.0)}
    names = conflict(CAR, 5.0, start=REST, end={"total": 3.0}, signals=sum_of_both, limits=limits)
    assert names == {"end of total = 3", "x <= 1", "v <= 1"}


def test_a_duration_whose_ends_cross_is_named_alone():
    assert conflict(CAR, (5.0, 2.0), start=REST, end={"x": 1.0}) == {"duration >= 5", "duration <= 2"}


def test_a_stop_behind_a_wall_does_not_blame_the_time_though_long_intervals_could_hide_the_way():
    # 5 m/s and 1 m/s^2 need 12.5 m; in intervals of a minute the car would pass the wall and be back at the next node
    limits = {"a": (-1.0, 1.0), "v": (-20.0, 20.0), "x": (-1.0, 5.0)}
    names = conflict(CAR, (1.0, 50.0), start={"x": 0.0, "v": 5.0}, end=REST, limits=limits)
    assert names == {"a >= -1", "x <= 5", "start of x = 0", "start of v = 5", "end of v = 0"}


def test_an_unstable_plant_too_far_away_is_lost_whatever_its_goal_is():
    plant = wb.open_loop(wb.OdePlant.of(lambda t, x, u: [x[0] + u[0]], states=("x:",), inputs=("u:",)))
    names = conflict(plant, 10.0, start={"x": 5.0}, end={"x": 0.0}, limits={"u": (-4.0, 4.0)}, cost="energy")
    # x' > 0 from 5 on: only for a while can it end anywhere, and only a stronger input holds it
    assert {"u >= -4", "start of x = 5"} <= names
    assert "u <= 4" not in names


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: wb.plan(wb.DCMotor(), 1.0), "wb.open_loop"),
        (lambda: wb.plan(CAR), "a duration in s"),
        (lambda: wb.plan(CAR, (5.0, "a")), "a duration in s"),
        (lambda: wb.plan(CAR, -1.0), "positive"),
        (lambda: wb.plan(CAR, 1.0, phases=(Phase(1.0),)), "left out"),
        (lambda: wb.plan(CAR, 1.0, cost="tme"), "'time', 'energy'"),
        (lambda: wb.plan(CAR, 1.0, cost=lambda t, x, u: x.position), "position"),
        (lambda: wb.plan(CAR, 1.0, cost=lambda t, x, u: [x.x, x.v]), "one expression"),
        (lambda: wb.plan(CAR, 1.0, cost=wb.open_loop(wb.DCMotor()).x[0]), "alone"),
        (lambda: wb.plan(CAR, 1.0, limits={"b": (0, 1)}), "'b'"),
        (lambda: wb.plan(CAR, 1.0, limits={"a": 1.0}), "a pair"),
        (lambda: wb.plan(CAR, 1.0, limits={"a": (np.nan, 1.0)}), "a pair of numbers"),
        (lambda: wb.plan(CAR, 1.0, end={"x": np.inf}), "a finite number"),
        (lambda: wb.plan(CAR, 1.0, end={"y": 1.0}), "'y'"),
        (lambda: wb.plan(CAR, 1.0, values={"a": 1.0}), "leave an input"),
        (lambda: wb.plan(CAR, 1.0, values={"m": 1.0}), "'m'"),
        (lambda: wb.plan(CAR, 1.0, hold="linaer"), "Did you mean 'linear'"),
        (lambda: wb.plan(CAR, 1.0, intervals=2), "at least 4|from 4"),
        (lambda: wb.plan(CAR, 1.0, rate_limits={"a": (-1, 1)}, hold="zero"), "rate_limits"),
        (lambda: wb.plan(CAR, 1.0, periodic=("a",), hold="zero"), "periodic"),
        (lambda: wb.plan(CAR, 1.0, guess={"x": 1.0}), "even times"),
        (lambda: wb.plan(wb.ClosedLoop(*_loop()), 1.0), "inputs=True"),
    ],
)
def test_a_bad_argument_is_refused_in_a_sentence_that_names_it(call, words):
    with pytest.raises((ValueError, LookupError), match=words) as error:
        call()
    assert not isinstance(error.value, PlanConflictError)
    assert "\n" not in str(error.value)


def _loop():
    """The parts of a loop without a reference."""
    motor = wb.DCMotor()
    law = wb.StateFeedback(motor.states, motor.inputs, [[0.1, 0.1]], [0.0, 0.0], [0.0])
    return motor, wb.FullState.of(motor), law
