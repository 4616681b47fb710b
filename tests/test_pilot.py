"""A few runs choose the schedule of a batch."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from equations import decay, explosion
from test_schedule import RATES, RELAXATION, STARTS, chosen, maker, relaxed

from workbench.core import Entry, Layout, Ode, rk4
from workbench.simulate.stepping.pilot import cheapest, choose, pilot_rows
from workbench.simulate.stepping.schedule import run


def relay() -> Ode:
    """x' = -sign(x - sin(3 t) / 2), which switches for ever."""
    states = Layout((Entry("x", np.ones(1)),))
    t, x = ca.SX.sym("t"), states.symbols()
    rates = {"x": -2 * ca.sign(x - ca.sin(3 * t) / 2)}
    return Ode.of("relay", states, Layout(), (t, x, ca.SX(0, 1)), rates, {"e": x})


def test_a_fast_start_gets_small_steps_and_what_is_slow_behind_it_a_stabilised_method():
    schedule = chosen(1e-3).schedule
    first, last = schedule.segments[0], schedule.segments[-1]
    assert schedule.h(first) <= schedule.h(last) / 10
    assert last.method in ("rkc5", "rkc10")
    # 2.785 / 600 s is all that rk4 could do
    assert schedule.h(last) > 2.785 / 600


@pytest.mark.parametrize("tolerance", [3e-2, 1e-3, 1e-5])
def test_the_chosen_schedule_meets_its_tolerance_on_a_closed_form(tolerance):
    choice = chosen(tolerance)
    assert choice.error <= tolerance
    x = run(choice.schedule, RELAXATION, RATES, STARTS).x[:, -1]
    exact = np.column_stack(relaxed(RATES[:, 0], 2.0))
    assert np.abs(x / exact - 1).max() <= tolerance


def test_a_smaller_tolerance_costs_more_operations():
    def cost(choice):
        each = ((s.steps * s.cells, RELAXATION(s.method, choice.schedule.h(s))) for s in choice.schedule.segments)
        return sum(steps * step.operations for steps, step in each)

    costs = [cost(chosen(tolerance)) for tolerance in (3e-2, 1e-3, 1e-5)]
    assert costs == sorted(costs)
    assert costs[2] > 1.5 * costs[0]


def test_no_step_is_beyond_the_stability_limit():
    # at rest: no error would tell that 5 ms is too long for rk4 at 600 1/s
    choice = choose(maker(decay(600.0)), np.array([[600.0]]), np.zeros((1, 1)), 1.0, 0.5, methods=["rk4"])
    assert all(choice.schedule.h(segment) <= 2.785 / 600 for segment in choice.schedule.segments)


def test_every_step_divides_the_grid_of_the_metrics():
    choice = choose(maker(decay(1.0)), np.array([[1.0]]), np.ones((1, 1)), 1.2, 1e-2, grid=4e-3)
    ratios = [4e-3 / choice.schedule.h(segment) for segment in choice.schedule.segments]
    np.testing.assert_allclose(ratios, np.round(ratios), rtol=1e-9)
    assert choice.schedule.until == pytest.approx(1.2)


def test_the_pilot_does_not_depend_on_the_order_of_the_batch():
    rng = np.random.default_rng(0)
    p, x0 = rng.random((40, 3)), np.zeros((40, 2))
    order = rng.permutation(40)
    picked = pilot_rows(p, x0, 8)[0]
    np.testing.assert_array_equal(picked, pilot_rows(p[order], x0[order], 8)[0])
    assert len(picked) == 8
    assert all((row == p).all(axis=1).any() for row in picked)


def test_a_batch_smaller_than_the_pilot_is_its_own():
    p, x0 = np.array([[3.0], [1.0], [2.0]]), np.zeros((3, 1))
    assert sorted(pilot_rows(p, x0)[0].ravel()) == [1, 2, 3]
    assert len(pilot_rows(np.ones((1, 1)), np.zeros((1, 1)))[0]) == 1


def test_the_choice_says_what_it_found():
    text = str(chosen(1e-3))
    assert "tolerance 0.001, told by 7 pilot runs" in text
    assert "0 to 0.1 s: rk4" in text


def test_the_cheapest_sum_within_a_tolerance_is_that_of_all_choices():
    rng = np.random.default_rng(5)
    costs = np.array([1.0, 2.0, 4.0])
    # halving errors along a convex curve, for which an equal worth of errors is exact but for the last cell
    errors = rng.uniform(0.5, 1.5, 5) / np.array([[1.0], [4.0], [16.0]])
    every = np.stack(np.meshgrid(*[range(3)] * 5, indexing="ij"), -1).reshape(-1, 5)
    for tolerance in (4.0, 2.0, 1.0, 0.5):
        picked = cheapest(costs, errors, tolerance)
        sums = errors[every, np.arange(5)].sum(axis=1)
        best = costs[every].sum(axis=1)[sums <= tolerance].min()
        assert errors[picked, np.arange(5)].sum() <= tolerance
        assert best <= costs[picked].sum() <= best + 2


def test_a_pilot_run_that_diverges_tells_nothing():
    starts = np.array([[1.0], [0.1], [0.2]])
    choice = choose(maker(explosion()), np.zeros((3, 0)), starts, 2.0, 1e-4)
    assert choice.runs == 2


def test_a_pilot_of_which_no_run_stays_finite_is_refused():
    with pytest.raises(ValueError, match="up to 2 s at steps down to 5e-06 s: the loop runs away, or"):
        choose(maker(explosion()), np.zeros((1, 0)), np.ones((1, 1)), 2.0, 1e-2)


def test_a_tolerance_that_no_step_reaches_is_refused_with_what_is_reached():
    with pytest.raises(ValueError, match=r"`choose\(tolerance=1e-09\)` is not reached: steps down to 5e-05 s leave"):
        choose(maker(relay()), np.zeros((1, 0)), np.ones((1, 1)), 2.0, 1e-9, cell=0.1, methods=["rk4"])


def good(**changes):
    make = maker(decay())
    arguments = {"make": make, "p": np.ones((2, 1)), "x0": np.ones((2, 1)), "until": 1.0, "tolerance": 1e-2}
    return choose(**(arguments | changes))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"tolerance": 0}, r"`choose\(tolerance=...\)` must be a positive, finite number; got 0"),
        ({"tolerance": -1e-3}, r"`choose\(tolerance=...\)` must be a positive, finite number; got -0.001"),
        ({"tolerance": np.nan}, r"`choose\(tolerance=...\)` must be a positive, finite number; got nan"),
        ({"tolerance": "small"}, r"`choose\(tolerance=...\)` must be a number; got 'small'"),
        ({"until": 0.0}, r"`choose\(until=...\)` must be a positive, finite number of seconds; got 0"),
        ({"until": np.inf}, r"`choose\(until=...\)` must be a positive, finite number of seconds; got inf"),
        ({"cell": -0.1}, r"`choose\(cell=...\)` must be a positive, finite number of seconds; got -0.1"),
        ({"cell": 0.3}, r"`choose\(until=...\)` must be a multiple of the cell 0.3 s; got 1 s"),
        ({"grid": 0.3}, r"`choose\(until=...\)` must be a multiple of the grid 0.3 s; got 1 s"),
        ({"cell": 0.1, "grid": 0.03}, r"`choose\(cell=...\)` must be a multiple of the grid 0.03 s; got 0.1"),
        ({"p": np.ones((0, 1)), "x0": np.ones((0, 1))}, r"of pilots; got shapes \(0, 1\), \(0, 1\)"),
        ({"x0": np.ones((3, 1))}, r"of pilots; got shapes \(2, 1\), \(3, 1\)"),
        ({"methods": []}, r"`choose\(methods=...\)` must be a tuple of at least 1 `str`; got none"),
    ],
)
def test_what_makes_no_choice_is_refused_in_one_sentence(changes, says):
    with pytest.raises(ValueError, match=says):
        good(**changes)


def test_a_method_that_there_is_not_is_refused_by_name():
    with pytest.raises(LookupError, match="There is no method 'euler'"):
        good(methods=["rk4", "euler"])


def test_a_noisy_step_is_refused():
    step = rk4(decay(), 0.1)
    noisy = replace(step, rule=replace(step.rule, w=ca.SX.sym("w")))
    with pytest.raises(ValueError, match=r"`choose\(make=...\)` must make steps without noise"):
        good(make=lambda method, h: replace(noisy, h=h))


@pytest.mark.parametrize("x0", [np.ones((3, 5)), np.ones((3, 0)), np.ones((3, 2), dtype=object)])
def test_pilot_rows_of_another_width_are_refused_before_anything_marches(x0):
    p = np.zeros((3, 0))
    with pytest.raises(ValueError, match=r"`choose\(x0=...\)`"):
        choose(lambda method, h: rk4(explosion(), h), p, x0, 1.0, 1e-3)
