"""A schedule of methods and steps, run by a batch."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest
from equations import explosion, oscillator

from workbench.core import Entry, Layout, Ode, rk4, with_quadrature
from workbench.core.stabilised import stepper
from workbench.simulate import simulate
from workbench.simulate.stepping.pilot import choose
from workbench.simulate.stepping.schedule import Schedule, Segment, run


def maker(ode):
    return cache(lambda method, h: stepper(method)(ode, h))


def relaxation() -> Ode:
    """x' = -rate (x - sin t) + cos t from 1, and z' = x^2: x = sin t + exp(-rate t), fast at first and slow behind."""
    states, parameters = Layout((Entry("x", np.ones(1)),)), Layout((Entry("rate", np.array(500.0)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    rates = {"x": -p * (x - ca.sin(t)) + ca.cos(t)}
    ode = Ode.of("relaxation", states, parameters, (t, x, p), rates, {"e": x})
    return with_quadrature(ode, {"ise": x**2})


def relaxed(rate, t):
    """x and the integral of x^2 in closed form."""
    mixed = (1 - np.exp(-rate * t) * (np.cos(t) + rate * np.sin(t))) / (1 + rate**2)
    ise = t / 2 - np.sin(2 * t) / 4 + 2 * mixed + (1 - np.exp(-2 * rate * t)) / (2 * rate)
    return np.sin(t) + np.exp(-rate * t), ise


RATES = np.linspace(300.0, 600.0, 21)[:, np.newaxis]
STARTS = np.column_stack([np.ones(21), np.zeros(21)])
RELAXATION = maker(relaxation())


@cache
def chosen(tolerance):
    return choose(RELAXATION, RATES[::3], STARTS[::3], 2.0, tolerance, cell=0.1)


def test_one_segment_of_rk4_is_the_simulation_at_that_step():
    ode = oscillator()
    p, x0 = np.array([[2.0], [3.0]]), np.array([[1.0, 0.0], [0.5, 0.1]])
    runs = run(Schedule(0.5, (Segment("rk4", 50, 4),)), maker(ode), p, x0, every=1)
    same = simulate(rk4(ode, 0.01), p, x0, until=2.0, every=0.5)
    np.testing.assert_array_equal(runs.x, same.x)
    np.testing.assert_array_equal(runs.t, same.t)


def test_time_goes_on_from_segment_to_segment():
    segments = (Segment("rk4", 100, 3), Segment("rkc5", 40, 2), Segment("rkc10", 20, 1), Segment("rk4", 50, 4))
    schedule = Schedule(0.2, segments)
    assert schedule.cells == 10
    assert schedule.until == pytest.approx(2.0)
    x = run(schedule, maker(relaxation()), np.array([[20.0]]), np.array([[1.0, 0.0]])).x[0, -1]
    # order 2 at a step of 5 ms and modes of 20 1/s: some 1e-4
    np.testing.assert_allclose(x, relaxed(20.0, 2.0), rtol=1e-3)


def test_the_half_of_a_schedule_takes_every_step_twice():
    schedule = Schedule(0.2, (Segment("rk4", 5, 3), Segment("rkc5", 4, 2)))
    assert schedule.halved == Schedule(0.2, (Segment("rk4", 10, 3), Segment("rkc5", 8, 2)))


def test_equal_neighbours_are_one_segment_and_a_line_says_when_and_how():
    schedule = Schedule.of(0.1, [("rk4", 10), ("rk4", 10), ("rkc5", 10), ("rkc5", 20)])
    assert schedule.segments == (Segment("rk4", 10, 2), Segment("rkc5", 10, 1), Segment("rkc5", 20, 1))
    assert str(schedule).splitlines()[:2] == ["0 to 0.2 s: rk4, 10 ms", "0.2 to 0.3 s: rkc5, 10 ms"]


def test_states_kept_on_the_way_change_no_bit_of_the_end():
    schedule = chosen(1e-3).schedule
    ends = [run(schedule, RELAXATION, RATES, STARTS, every=every).x[:, -1] for every in (None, 1, 5)]
    np.testing.assert_array_equal(ends[0], ends[1])
    np.testing.assert_array_equal(ends[0], ends[2])


def test_a_run_is_the_same_alone_and_in_any_company():
    schedule = chosen(1e-3).schedule
    whole = run(schedule, RELAXATION, RATES, STARTS).x
    order = np.random.default_rng(3).permutation(21)
    np.testing.assert_array_equal(run(schedule, RELAXATION, RATES[order], STARTS[order]).x, whole[order])
    for i in (0, 8, 20):
        alone = run(schedule, RELAXATION, RATES[i : i + 1], STARTS[i : i + 1]).x
        np.testing.assert_array_equal(alone[0], whole[i])


def test_a_run_that_diverges_is_marked_with_its_step_and_leaves_its_neighbours_alone():
    schedule = Schedule(0.25, (Segment("rk4", 250, 3), Segment("rkc5", 250, 5)))
    starts = np.array([[1.0], [0.2], [0.3]])
    runs = run(schedule, maker(explosion()), np.zeros((3, 0)), starts, every=1)
    # x = 1 / (1 - t) ends at t = 1; Runge-Kutta steps over it within a few steps of 1 ms
    np.testing.assert_array_equal(runs.diverged, [True, False, False])
    assert runs.diverged_at[0] == pytest.approx(1.0, abs=0.02)
    assert np.isnan(runs.x[0, 5:]).all()
    calm = run(schedule, maker(explosion()), np.zeros((2, 0)), starts[1:], every=1)
    np.testing.assert_array_equal(runs.x[1:], calm.x)
    # 1 / (1 / x0 - 2), at order 2
    np.testing.assert_allclose(runs.x[1:, -1, 0], 1 / (1 / starts[1:, 0] - 2), rtol=1e-4)


def test_what_looks_at_samples_sees_each_once_in_whatever_segment():
    extra = Layout((Entry("count", np.zeros(())), Entry("sum", np.zeros(()))))

    def make(method, h):
        step, z = stepper(method)(relaxation(), h), extra.symbols()
        sample = ca.fmod(step.rule.k, round(0.01 / h)) == 0
        return step.extended(extra, z, z + ca.if_else(sample, ca.vertcat(1, step.rule.k * h), 0))

    schedule = Schedule(0.1, (Segment("rk4", 100, 3), Segment("rkc5", 20, 2), Segment("rkc10", 10, 5)))
    runs = run(schedule, cache(make), np.array([[50.0]]), np.array([[1.0, 0.0, 0.0, 0.0]]))
    count, total = runs.x[0, -1, 2:]
    assert count == 100
    # 0 + 0.01 + ... + 0.99
    assert total == pytest.approx(49.5, rel=1e-12)


@pytest.mark.parametrize("every", [3, 19, 21])
def test_kept_times_that_are_no_cells_are_refused(every):
    with pytest.raises(
        ValueError, match=r"`run\(every=...\)` must be a number of cells that divides the schedule's 20"
    ):
        run(chosen(1e-3).schedule, RELAXATION, RATES, STARTS, every=every)


def test_one_row_serves_all_and_defaults_serve_where_there_is_none():
    schedule = Schedule(0.5, (Segment("rk4", 50, 2), Segment("rkc5", 50, 2)))
    make, p = maker(oscillator()), np.array([[2.0], [3.0]])
    one = run(schedule, make, p, np.array([[1.0, 0.0]])).x
    np.testing.assert_array_equal(one, run(schedule, make, p, np.tile([1.0, 0.0], (2, 1))).x)
    np.testing.assert_array_equal(one, run(schedule, make, p, None).x)


def test_progress_goes_by_the_operations_that_are_done():
    seen: list[float] = []
    schedule = Schedule(0.5, (Segment("rk4", 50, 2), Segment("rkc10", 100, 1), Segment("rk4", 50, 1)))
    make = maker(oscillator())
    run(schedule, make, None, None, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == pytest.approx(1.0)
    # the cheap half of the horizon is less than half of the work
    few, many = (make(m, 0.01).operations for m in ("rk4", "rkc10"))
    assert any(share == pytest.approx(100 * few / (150 * few + 100 * many)) for share in seen)


@pytest.mark.parametrize(
    ("p", "x0", "says"),
    [
        (np.ones((2, 3)), None, r"takes one row per run: \(B, 1\)\. Got \(2, 3\)"),
        (None, np.ones((2, 5)), r"takes one row per run: \(B, 2\)\. Got \(2, 5\)"),
        (np.array([[-1.0]]), None, "omega"),
        (np.array([[np.nan]]), None, "omega"),
        (None, np.array([[np.inf, 0.0]]), "plant.q"),
        (np.ones((2, 1)), np.ones((3, 2)), "got 2 rows of p and 3 rows of x0"),
        (np.ones((0, 1)), None, "needs at least one run; got no rows"),
    ],
)
def test_rows_are_refused_as_a_simulation_refuses_them(p, x0, says):
    with pytest.raises(ValueError, match=says):
        run(Schedule(0.5, (Segment("rk4", 5, 2),)), maker(oscillator()), p, x0)


def test_what_needs_too_much_memory_or_time_is_refused_before_the_start():
    p, make = np.full((1_000_000, 1), 2.0), maker(oscillator())
    with pytest.raises(ValueError, match=r"would need 29\.8 GB of memory"):
        run(Schedule(0.5, (Segment("rk4", 5, 1000),)), make, p, None, every=1)
    with pytest.raises(ValueError, match=r"would take about \d+ hours of one processor for 1000000 runs"):
        run(Schedule(0.5, (Segment("rkc5", 1, 1), Segment("rk4", 500_000, 1000))), make, p, None)


def test_a_noisy_step_goes_through_no_schedule():
    step = rk4(oscillator(), 0.1)
    noisy = replace(step, rule=replace(step.rule, w=ca.SX.sym("w")))
    with pytest.raises(ValueError, match=r"`run\(make=...\)` must make steps without noise"):
        run(Schedule(0.1, (Segment("rk4", 1, 2),)), lambda method, h: noisy, None, None)


@pytest.mark.parametrize("bad", [{"steps": 0}, {"cells": -1}, {"steps": 2.0}, {"cells": True}])
def test_a_segment_of_no_steps_or_cells_is_refused(bad):
    with pytest.raises(ValueError, match=r"`Segment\((steps|cells)=...\)` must be a (positive )?whole number; got"):
        Segment(**({"method": "rk4", "steps": 1, "cells": 1} | bad))
