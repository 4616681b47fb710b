"""The step of an equation with its metrics beside it, by several methods and through schedules of them."""

from functools import cache

import casadi as ca
import numpy as np
import pytest
from equations import decay, oscillator, staircase

from workbench.core import Sampled
from workbench.metrics import ise, measured, sampled_rmse, settling_time, total_variation
from workbench.metrics.accumulators import common_grid, final_values
from workbench.simulate import run, simulate
from workbench.simulate.stepping.schedule import Schedule, Segment

TIME = ca.SX.sym("time")


def values(ode, metrics, schedule):
    make = cache(lambda method, h: measured(ode, metrics, h, method))
    return {name: found[0, 0] for name, found in final_values(run(schedule, make, None, None), metrics).items()}


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("rkc3", 2), ("rkc10", 2)])
def test_an_integral_has_the_order_of_the_method_that_carries_it(method, order):
    a, T = 3.0, 2.0
    exact = (1 - np.exp(-2 * a * T)) / (2 * a)
    errors = []
    for h in (0.05, 0.025):
        runs = simulate(measured(decay(a), (ise(),), h, method), until=T, every=T)
        errors.append(abs(final_values(runs, (ise(),))["ISE"][0, 0] - exact))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)


def test_what_samples_sees_its_own_grid_through_steps_of_every_length():
    sample, T = 0.05, 2.0
    schedule = Schedule(0.25, (Segment("rk4", 50, 3), Segment("rkc5", 25, 2), Segment("rk4", 5, 3)))
    metrics = (total_variation(sample), sampled_rmse(sample))
    found = values(oscillator(), metrics, schedule)
    grid = np.linspace(0, T, 41)
    # rkc5 at 10 ms and modes of 2 rad/s: (0.02)^2 / 6 for half a second
    assert found["TV"] == pytest.approx(np.abs(np.diff(-2 * np.sin(2 * grid))).sum() / T, rel=1e-3)
    assert found["RMSE (43)"] == pytest.approx(np.sqrt(np.mean(np.cos(2 * grid) ** 2)), rel=1e-3)


@pytest.mark.parametrize("steps", [(5, 50), (50, 5), (5, 5)])
def test_a_jump_where_the_step_changes_finds_out_whether_the_last_one_was_settled(steps):
    schedule = Schedule(1.0, tuple(Segment("rk4", n, 1) for n in steps))
    away = ca.if_else(TIME < 1 - 1e-9, ca.SX(0), ca.SX(-1))
    there = ca.if_else(TIME < 1 - 1e-9, ca.SX(1), ca.SX(-1))
    assert values(staircase(away, (1.0, -1.0), 1.0), (settling_time(),), schedule)["settling time"] == np.inf
    assert values(staircase(there, (1.0, -1.0), 1.0), (settling_time(),), schedule)["settling time"] == 0


def test_a_sampled_loop_has_its_own_substeps_and_no_other_method():
    k, ode = ca.SX.sym("k"), decay()
    sampled = Sampled(ode, 0.1, k, ca.SX(0, 1), ode.x)
    assert measured(sampled, (ise(),), 0.05).substeps == 2
    with pytest.raises(ValueError, match=r"`measured\(method=...\)` of a sampled loop must be 'rk4', .*; got 'rkc5'"):
        measured(sampled, (ise(),), 0.05, "rkc5")


def test_a_method_that_there_is_not_is_refused_by_name():
    with pytest.raises(LookupError, match="There is no method 'euler'"):
        measured(decay(), (ise(),), 0.1, "euler")


@pytest.mark.parametrize(
    ("samples", "times", "grid"),
    [((), (1.0,), None), ((1e-3,), (50.0,), 1e-3), ((4e-3, 6e-3), (12.0,), 2e-3), ((0.3,), (1.0,), 0.1)],
)
def test_the_grid_of_several_metrics_is_their_longest_common_divisor(samples, times, grid):
    metrics = [sampled_rmse(sample, name=f"{sample}") for sample in samples]
    assert common_grid([ise(), *metrics], *times) == (grid and pytest.approx(grid, rel=1e-12))


def test_sample_times_without_a_common_divisor_are_refused():
    with pytest.raises(ValueError, match=r"that one step divides; got 0.1 s, 0.314159 s"):
        common_grid([total_variation(0.1)], np.pi / 10)
