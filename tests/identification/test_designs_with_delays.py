"""Designs of experiments for unknown delays: slopes against differences, errors against another program, refusals."""

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import workbench as wb
from workbench.core import Entry, Layout
from workbench.identification.experiments.design_problem import InputSchedule, problem_of

MOTOR = wb.open_loop(wb.DCMotor())
NOISE = {"omega": 0.01, "i": 0.05}
LIMITS = {"v": (-12.0, 12.0), "omega": (-0.5, 0.5), "rate of omega": (-20.0, 20.0), "rate of v": (-200.0, 200.0)}
DELAY = 0.033  # s: not a multiple of the period


@pytest.mark.parametrize("criterion", ["D", "A"])
def test_slopes_of_criterion_and_margins_are_differences_with_an_unknown_delay(criterion):
    schedule = InputSchedule.of(2.0, 0.05, 1.0, 2, None)
    free, first = ["J", "delay of v", "R"], {"delay of v": DELAY}
    problem = problem_of(MOTOR, free, ["v"], ["omega", "i"], NOISE, LIMITS, schedule, criterion, "linear", first)
    c, rng = np.array([[0.5, 3.0, -1.0, 2.0, 0.7]]), np.random.default_rng(3)
    step = 1e-5 * rng.standard_normal(c.shape)  # of a central difference, whose error goes with its square
    response, goal = problem.response, problem.criterion.goal
    slope = np.sum(response.pull_back(c, goal)[1] * step)
    change = (response.pull_back(c + step, goal)[0] - response.pull_back(c - step, goal)[0]) / 2
    assert slope == pytest.approx(change, rel=1e-5)
    before, after = response.margins(c - step), response.margins(c + step)
    places = np.argwhere(np.isfinite(before))[::7]
    changes = (after[tuple(places.T)] - before[tuple(places.T)]) / 2
    assert response.margin_slopes(c, places) @ step.ravel() == pytest.approx(changes, rel=1e-5, abs=1e-12)
    commanded = response.basis @ c.T  # the limits of v are those of the command, up to its last sample
    assert response.margins(c)[:, 0].min() == pytest.approx((12.0 - np.abs(commanded).max()) / 24.0, rel=1e-9)


def test_expected_errors_of_a_delay_are_those_of_differences_of_another_program():
    """A motor whose voltage acts late: the same errors by motions of SciPy at delays and numbers a little apart."""
    asked = {"limits": {"v": (-12.0, 12.0)}, "until": 2.0, "every": 0.02, "harmonics": 3, "starts": 1, "hold": "linear"}
    free, first = ["J", "R", "delay of v"], {"delay of v": DELAY}
    design = wb.design_experiment(MOTOR, free, ["v"], ["omega", "i"], noise=NOISE, start=first, **asked)
    t, v = design.table("v")
    noise = list(NOISE.values())

    def late_motion(J, R, delay):
        ode = wb.open_loop(wb.DCMotor(J=J, R=R))
        p = ode.parameters.default.copy()

        def rate(s, x):
            p[-1] = np.interp(s - delay, t, v)
            return ode.rate_at(s, x, p)

        knots = np.unique(np.concatenate([t, (t + delay)[t + delay < t[-1]]]))
        x, rows = ode.states.default, [ode.states.default]
        for begin, end in pairwise(knots):
            x = solve_ivp(rate, (begin, end), x, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
            rows.append(x)
        return np.array(rows)[np.searchsorted(knots, t)] / noise

    centre, columns = np.array([0.01, 1.0, DELAY]), []
    for i, size in enumerate((1e-6, 1e-4, 1e-5)):
        move = size * np.eye(3)[i]
        columns.append(((late_motion(*(centre + move)) - late_motion(*(centre - move))) / 2 / size).ravel())
    J = np.column_stack(columns)
    errors = np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    # the differences over 10 us have an error of 1e-6, and the steps one of 1e-3 at most by the certificate
    assert list(design.standard_errors.values()) == pytest.approx(errors, rel=1e-3)
    assert design.certificate.is_passed
    assert np.abs(v).max() <= 12.0
    assert design.intervals()["delay of v"][0] < DELAY < design.intervals()["delay of v"][1]


def test_a_delay_of_an_input_that_an_output_shows_is_refused():
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 2)
    entries = Layout((Entry("a", np.array(1.0), "1/s"), Entry("u", np.array(0.0), "V")))
    states = Layout((Entry("x", np.array(0.0), "m"),))
    ode = wb.Ode.of("direct", states, entries, (t, x, p), {"x": -p[0] * x + p[1]}, {"y": x + p[1]}, {"y": "m"})
    asked = {"noise": {"y": 0.1}, "limits": {"u": (-1.0, 1.0)}, "until": 2.0, "every": 0.1, "hold": "linear"}
    with pytest.raises(ValueError, match="an output has 'u' itself in it"):
        wb.design_experiment(ode, ["a", "delay of u"], ["u"], ["y"], start={"delay of u": 0.2}, **asked)
