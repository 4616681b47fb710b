"""The model with disturbances of inputs: its equations, and a nonlinear predictive law without offset."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.nonlinear_laws import first_period

PERIOD = 0.02
WEIGHTS = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]


def cart_design(**options):
    rest = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    return wb.nonlinear_predictive_design(rest, PERIOD, *WEIGHTS, 20, limits={"F": (-10.0, 10.0)}, **options)


def run_of(model, states, until, delay=0.0, **options):
    """A cart with a pole on a slope that pulls with 0.8 N, whose states an extended Kalman filter estimates."""
    plant = wb.DisturbedPlant(wb.CartPole(phi=0.2), by=wb.Constant("F", "N", -0.8))
    Q = np.diag([1e-6, 1e-2, 1e-6, 1e-2, 1.0][:states])
    observer = wb.ExtendedKalmanFilter(model, Q, 1e-6 * np.eye(2), P=1e-2 * np.eye(states), period=PERIOD)
    law = wb.NonlinearPredictive.of(model, cart_design(delay=delay, **options), follow=("x",))
    loop = wb.ClosedLoop(plant, observer=observer, controller=law, reference=wb.Step("x", "m", 0.3))
    return wb.simulate(loop.digital(PERIOD, delay=bool(delay)).step(2), until=until)


@pytest.mark.release  # half a minute each
@pytest.mark.parametrize("options", [{}, {"delay": PERIOD, "rate_limits": {"F": (-2.0, 2.0)}}], ids=["plain", "late"])
def test_a_constant_force_leaves_no_offset(options):
    run = run_of(wb.InputDisturbances(wb.CartPole()), 5, 20.0, **options)
    end = {name: float(run.x[0, -1, run.step.states.slice(name)][0]) for name in ("plant.x", "observer.d_F_hat")}
    assert end["plant.x"] == pytest.approx(0.3, abs=1e-6)  # as the issue of the law asks
    assert end["observer.d_F_hat"] == pytest.approx(-0.8, abs=1e-5)


@pytest.mark.heavy
def test_a_law_that_knows_no_disturbance_leaves_an_offset():
    run = run_of(wb.CartPole(), 4, 6.0)
    assert abs(run.x[0, -1, 0] - 0.3) > 0.02


def test_an_input_cancels_a_disturbance_at_a_rest_where_no_limit_acts():
    model, design = wb.InputDisturbances(wb.CartPole()), cart_design()
    law = wb.NonlinearPredictive.of(model, design)
    x = 1e-4 * np.array([1.0, -2.0, 0.5, 1.0])  # the rest of a sine at 1e-4 is 1e-12
    plan, memory = first_period(law, np.r_[x, 0.7])
    np.testing.assert_allclose(plan[0], -design.K @ x - 0.7, rtol=0, atol=1e-9)  # as the issue of the law asks
    assert memory["cost"] == pytest.approx(x @ design.P @ x, rel=1e-4)


def test_the_rate_is_that_of_the_plant_with_the_sum_of_inputs():
    plant = wb.CartPole()
    model = wb.InputDisturbances(plant)
    x, u = ca.SX.sym("x", 5), ca.SX.sym("u")
    rate = model.rate(0.0, model.states.view(x), wb.Signals({"F": u}))
    own = plant.rate(0.0, wb.Signals(plant.states.view(x[:4])), wb.Signals({"F": u + x[4]}))
    f = ca.Function("f", [x, u], [model.states.flatten(rate), plant.states.flatten(own)])
    mine, theirs = (np.array(part).ravel() for part in f([0.1, 0.2, 0.3, 0.4, 0.5], 0.6))
    np.testing.assert_array_equal(mine, np.r_[theirs, 0.0])


def test_a_plant_that_has_the_name_of_a_disturbance_is_refused():
    with pytest.raises(
        ValueError, match="must leave the name 'd_F' free for a disturbance; `InputDisturbances` has it"
    ):
        wb.InputDisturbances(wb.InputDisturbances(wb.CartPole()))
