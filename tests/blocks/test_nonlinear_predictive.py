"""The nonlinear predictive law: IPOPT, LQR, swing-up and tracking, bits, missing numbers, and bad arguments."""

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.nonlinear_laws import first_period, step_of
from workbench.blocks.laws.plant_stages import PlantStages
from workbench.design.matrices import DesignError

PERIOD, N = 0.02, 30
WEIGHTS = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
STATES = ("x", "xd", "phi", "phid")


def cart_design(horizon=N, limits=None, **options):
    rest = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    return wb.nonlinear_predictive_design(
        rest, PERIOD, *WEIGHTS, horizon, limits=limits or {"F": (-10.0, 10.0)}, **options
    )


def loop_of(law, reference=None, **start):
    plant = wb.CartPole(**start)
    return wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)


def by_ipopt(design, plant, x):
    """The inputs (N, nu) and the cost of the best plan from x, on the mesh of the law."""
    nx, nu = len(design.states), len(design.inputs)
    X, U, s, v = (ca.SX.sym("x", n, k) for n, k in ((nx, N + 1), (nu, N), (nx, 1), (nu, 1)))
    own = design.limits
    rows = (own.row_low, own.row_high, own.row_weight) if own.row_names else ((), (), ())
    after = ca.Function("F", [s, v], [PlantStages(plant, design.period, design.steps).after(ca.SX(0.0), s, v)])
    cost, defects = X[:, N].T @ design.P @ X[:, N], [X[:, 0] - x]
    for k in range(N):
        cost += X[:, k].T @ design.Q @ X[:, k] + U[:, k].T @ design.R @ U[:, k]
        for name, low, high, w in zip(own.row_names, *rows, strict=True):
            y = X[design.states.index(name), k]
            cost += w * (ca.fmax(y - high, 0) ** 2 + ca.fmax(low - y, 0) ** 2)
        defects.append(X[:, k + 1] - after(X[:, k], U[:, k]))
    program = {"x": ca.veccat(X, U), "f": cost, "g": ca.vertcat(*defects)}
    quiet = {
        "ipopt.print_level": 0,
        "print_time": 0,
        "ipopt.sb": "yes",
        "ipopt.tol": 1e-11,
        "ipopt.bound_relax_factor": 0.0,
    }
    low, high = (
        np.r_[np.full(X.numel(), sign * np.inf), np.tile(end, N)] for sign, end in ((-1, own.low), (1, own.high))
    )
    start = np.r_[np.tile(x, N + 1), np.zeros(nu * N)]
    answer = ca.nlpsol("exact", "ipopt", program, quiet)(x0=start, lbx=low, ubx=high, lbg=0.0, ubg=0.0)
    return np.array(answer["x"]).ravel()[X.numel() :].reshape(N, nu), float(answer["f"])


@pytest.mark.parametrize(
    ("x", "options"),
    [
        ([0.0, 0.0, 0.5, 0.0], {}),
        ([0.0, 0.0, 3.0, 0.0], {}),
        ([0.2, 0.0, -1.0, 2.0], {"steps": 2}),
        ([0.5, 0.0, 2.0, 1.0], {"limits": {"F": (-10.0, 10.0), "x": (-0.3, 0.6)}, "soft_weight": 1e3}),
    ],
    ids=["near", "far", "two steps a stage", "soft limit"],
)
def test_a_plan_that_has_converged_is_the_one_of_ipopt(x, options):
    design = cart_design(sweeps=15, iterations=80, **options)
    plan, memory = first_period(wb.NonlinearPredictive.of(wb.CartPole(), design), x)
    exact, cost = by_ipopt(design, wb.CartPole(), np.array(x))
    assert np.abs(exact).max() > 10.0 - 1e-6  # the limit acts
    np.testing.assert_allclose(plan, exact, rtol=0, atol=1e-6)  # as the issue of the law asks
    assert memory["cost"] == pytest.approx(cost, rel=1e-9)


def test_an_iteration_from_the_same_state_never_raises_the_cost():
    x, costs = [0.3, -1.0, 2.5, -3.0], []
    for iterations in (1, 2, 3, 5, 8, 13):
        law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(iterations=iterations, sweeps=2))
        costs.append(first_period(law, x)[1]["cost"])
    assert all(after <= before * (1 + 1e-8) for before, after in pairwise(costs))  # NEARLY
    assert costs[-1] < 0.95 * costs[0]


def test_a_plan_costs_no_more_than_the_law_behind_the_horizon_from_the_first_period_on():
    design = cart_design()
    law = wb.NonlinearPredictive.of(wb.CartPole(), design)
    for phi in (0.3, 0.5, 0.7):
        x, cost = np.array([0.0, 0.0, phi, 0.0]), 0.0
        after = PlantStages(wb.CartPole(), PERIOD, 1).after
        s, v = ca.SX.sym("s", 4), ca.SX.sym("v")
        move = ca.Function("F", [s, v], [after(ca.SX(0.0), s, v)])
        state = x
        for _ in range(N):
            u = np.clip(-design.K @ state, -10.0, 10.0)
            cost += state @ design.Q @ state + u @ design.R @ u
            state = np.array(move(state, u)).ravel()
        cost += state @ design.P @ state
        assert first_period(law, x)[1]["cost"] <= cost * (1 + 1e-8)


@pytest.mark.parametrize("steps", [1, 3])
def test_the_jacobians_of_a_stage_at_rest_are_those_of_the_design(steps):
    design, plant = cart_design(steps=steps), wb.CartPole()
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u")
    slopes = ca.Function("slopes", [x, u], PlantStages(plant, PERIOD, steps).after_with_slopes(ca.SX(0.0), x, u))
    after, A, B = (np.array(part) for part in slopes(np.zeros(4), 0.0))
    np.testing.assert_allclose(after, 0.0, atol=1e-15)
    np.testing.assert_allclose(A, design.A, rtol=0, atol=1e-14)
    np.testing.assert_allclose(B, design.B, rtol=0, atol=1e-14)


@pytest.mark.parametrize("steps", [1, 2])
def test_the_jacobians_along_a_motion_are_those_of_its_steps(steps):
    plant = wb.CartPole()
    x, u, t, stages = ca.SX.sym("x", 4), ca.SX.sym("u"), ca.SX(0.3), PlantStages(plant, 0.1, steps)
    one = ca.Function("one", [x, u], stages.after_with_slopes(t, x, u))
    end = stages.after(t, x, u)
    other = ca.Function("other", [x, u], [end, ca.jacobian(end, x), ca.jacobian(end, u)])
    for mine, theirs in zip(one([0.1, 1.0, 2.0, -3.0], 5.0), other([0.1, 1.0, 2.0, -3.0], 5.0), strict=True):
        np.testing.assert_allclose(np.array(mine), np.array(theirs), rtol=0, atol=1e-13)


def test_where_no_limit_acts_at_a_rest_the_law_is_lqr():
    design = cart_design()
    law = wb.NonlinearPredictive.of(wb.CartPole(), design, follow=("x",))
    x = 1e-4 * np.array([1.0, -2.0, 0.5, 1.0])  # the rest of a sine at 1e-4 is 1e-12
    u = first_period(law, x + [0.7, 0.0, 0.0, 0.0], [0.7])[0][0]
    np.testing.assert_allclose(u, -design.K @ x, rtol=0, atol=1e-9)  # as the issue of the law asks


def test_a_linear_plant_gets_lqr_from_everywhere():
    plant = wb.OdePlant.of(lambda t, x, u: [x[1], u[0] - x[1]], states=("x:m", "v:m/s"), inputs=("a:m/s^2",))
    rest = wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(2), at_rest=True)
    design = wb.nonlinear_predictive_design(rest, 0.1, np.eye(2), [[0.1]], 12)
    law = wb.NonlinearPredictive.of(plant, design)
    x = np.array([30.0, -4.0])
    plan, memory = first_period(law, x)
    np.testing.assert_allclose(plan[0], -design.K @ x, rtol=1e-12)
    assert memory["cost"] == pytest.approx(x @ design.P @ x, rel=1e-12)


def test_the_law_alone_swings_up_a_pole_from_any_start():
    law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(40))
    loop = loop_of(law, phi=np.pi).digital(PERIOD)
    rng = np.random.default_rng(3)
    starts = {"plant.phi": np.r_[np.pi, rng.uniform(-np.pi, np.pi, 15)], "plant.phid": rng.uniform(-3.0, 3.0, 16)}
    run = wb.simulate(loop.step(1), x0=loop.states.pack(starts), until=4.0)
    assert np.abs(run.x[:, -1, :4]).max() < 1e-2
    assert np.abs(run.x[:, :, run.step.states.slice("hold.F")]).max() == 10.0


def test_a_planned_motion_is_followed_within_limits_that_its_feedback_passes():
    plant = wb.CartPole(phi=np.pi)
    ode, up = wb.open_loop(plant), dict.fromkeys(STATES, 0.0)
    swing = wb.plan(ode, 2.0, cost="energy", end=up, limits={"F": (-4.0, 4.0), "x": (-1.0, 1.0)})
    near = wb.planning.trajectory_lqr(swing, *WEIGHTS, P1=wb.lqr(wb.linearize(ode, 0.0, np.zeros(4)), *WEIGHTS).X)
    reference = wb.PlannedReference(swing.motion, rest_inputs=[0.0])
    limits = wb.Instruments.of(plant, limit={"F": (-5.0, 5.0)})
    rng, misses = np.random.default_rng(0), dict[str, np.ndarray]()
    starts = {"plant.phi": np.pi + rng.uniform(-1.0, 1.0, 32), "plant.phid": rng.uniform(-5.0, 5.0, 32)}
    for name, law in (
        ("plans", wb.NonlinearPredictive.of(plant, cart_design(40, {"F": (-5.0, 5.0)}), preview=reference)),
        ("feeds back", wb.TrajectoryFeedback(near.states, near.inputs, near.gains)),
    ):
        loop = loop_of(law, reference, phi=np.pi).digital(PERIOD, limits)
        run = wb.simulate(loop.step(1), x0=loop.states.pack(starts), until=4.0)
        misses[name] = np.abs(run.x[:, -1, :4]).max(axis=1) > 0.05
    assert not misses["plans"].any()
    assert misses["feeds back"].any()


def test_a_run_on_the_plan_sends_the_inputs_of_the_plan():
    plant = wb.CartPole(phi=np.pi)
    up = dict.fromkeys(STATES, 0.0)
    swing = wb.plan(wb.open_loop(plant), 2.0, cost="energy", end=up, limits={"F": (-6.0, 6.0)})
    reference = wb.PlannedReference(swing.motion, rest_inputs=[0.0])
    law = wb.NonlinearPredictive.of(plant, cart_design(20), preview=reference)
    run = wb.simulate(loop_of(law, reference, phi=np.pi).digital(PERIOD).step(4), until=2.0)
    assert np.abs(run["e_phi"]).max() < 0.02  # held inputs are no straight lines
    window = run.x[0, :, run.step.states.slice("controller.window")]
    assert window.shape == (101, 5 * 21)
    np.testing.assert_array_equal(window[1:, :100], window[:-1, 5:])


def test_a_reference_of_formulas_is_previewed_without_a_window():
    reference = wb.Step("x", "m", 0.5)
    law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(), preview=reference)
    assert "window" not in law.memory
    run = wb.simulate(loop_of(law, reference).digital(PERIOD).step(1), until=4.0)
    assert abs(run["x"][0, -1, 0] - 0.5) < 1e-3


def test_a_missing_number_gets_the_safe_command_and_the_plan_waits():
    law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(10), safe_command={"F": 1.5})
    step = step_of(law)
    x = np.array([0.1, 0.0, 0.2, 0.0])
    _, z = step(0.0, law.memory.default, x, [])
    u, after = step(PERIOD, z, [0.1, np.nan, 0.2, 0.0], [])
    assert float(u) == 1.5
    waits = np.array(z).ravel()
    waits[law.memory.slice("bad_periods")] = 1.0
    np.testing.assert_array_equal(np.array(after).ravel(), waits)
    u, after = step(PERIOD, z, x, [])
    assert np.isfinite(np.array(after)).all()
    assert float(u) != 1.5


def test_a_plan_without_a_finite_cost_is_made_anew():
    law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(10), safe_command={"F": 0.0})
    step = step_of(law)
    _, z = step(0.0, law.memory.default, [0.1, 0.0, 0.2, 0.0], [])
    u, after = step(PERIOD, z, [0.0, 1e99, 0.0, 1e99], [])
    assert float(u) == 0.0
    empty = np.zeros(law.memory.size)
    empty[law.memory.slice("bad_periods")] = 1.0
    np.testing.assert_array_equal(np.array(after).ravel(), empty)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"limits": {"y": (0.0, 1.0)}}, "There is no 'y' among the 5 states, inputs and outputs of the plant"),
        ({"limits": {"F": (1.0, -1.0)}}, "must have its low end below its high end; 'F' has 1 and -1"),
        ({"limits": {"F": (1.0, 3.0)}}, "must leave the rest of the plant inside; 'F' rests at 0"),
        ({"limits": {"x": (-1.0, 1.0)}}, "must have a weight for the limit of 'x', as limits of states"),
        ({"horizon": 0}, r"nonlinear_predictive_design\(horizon=...\)` must be"),
        ({"P": np.diag([1.0, 1.0, 1.0, -1.0])}, "P"),
    ],
)
def test_bad_designs_are_refused_in_one_sentence(change, message):
    with pytest.raises((ValueError, LookupError, DesignError), match=message):
        cart_design(**change)


def test_a_design_for_another_plant_is_refused():
    with pytest.raises(ValueError, match="a design for the plant's own signals, omega, i; it is for x, xd, phi, phid"):
        wb.NonlinearPredictive.of(wb.DCMotor(), cart_design())
    with pytest.raises(ValueError, match="must be the result of `nonlinear_predictive_design`"):
        wb.NonlinearPredictive.of(wb.CartPole(), np.eye(4))


def test_bad_references_and_safe_commands_are_refused():
    plant, design = wb.CartPole(), cart_design()
    motion = wb.plan(wb.open_loop(plant), 1.0, cost="energy", end={"x": 0.1}).motion
    with pytest.raises(ValueError, match="must go on behind its end, as the law plans beyond it; it ends at 1 s"):
        wb.NonlinearPredictive.of(plant, design, preview=wb.PlannedReference(motion))
    with pytest.raises(ValueError, match="with the size and unit of the model"):
        wb.NonlinearPredictive.of(plant, design, preview=wb.Step("x", "mm", 1.0))
    with pytest.raises(ValueError, match="must be one of them alone"):
        wb.NonlinearPredictive.of(plant, design, follow=("x",), preview=wb.Step("x", "m", 1.0))
    with pytest.raises(LookupError, match="no 'y' among"):
        wb.NonlinearPredictive.of(plant, design, follow=("y",))
    with pytest.raises(ValueError, match="must keep the limits of 'F', -10 and 10; got 11"):
        wb.NonlinearPredictive.of(plant, design, safe_command={"F": 11.0})
    with pytest.raises(ValueError, match="must name each input; 'F' is missing"):
        wb.NonlinearPredictive.of(plant, design, safe_command={})


def test_a_run_records_the_plan_of_the_period_before():
    law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(10))
    run = wb.simulate(loop_of(law, phi=0.2).digital(PERIOD).step(1), until=0.4)
    x, u, times = (run[f"predicted_{name}"][0] for name in ("phi", "F", "t"))
    np.testing.assert_allclose(times[0], PERIOD * np.arange(10), rtol=1e-15)
    assert (
        np.abs(x[1:, 0] - run["phi"][0, 1:].ravel()).max() < 1e-3
    )  # rad: the model takes one step a period, as the run
    assert np.abs(u[10:, 0] - run["F"][0, 10:].ravel()).max() < 0.1  # N: near the rest a plan changes little
    assert np.abs(x[:-1, 1:] - x[1:, :-1]).max() < 0.2  # rad: one plan continues another
