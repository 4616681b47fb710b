"""Limits of changes and delays of inputs in the nonlinear predictive law: DAQP, IPOPT, LQR, the exact law, and bits."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import compiled, differing, needs_compiler, recorded
from tests.support.nonlinear_laws import first_period, step_of
from workbench.blocks.laws.plant_stages import PlantStages
from workbench.blocks.laws.stagewise_sweeps import StageRows, StageWeights, solve_stages
from workbench.handover.c99.c_files import c_code

PERIOD, N = 0.02, 20
NONE = 1e30
WEIGHTS = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
STATES = ("x", "xd", "phi", "phid")


def cart_design(horizon=N, **options):
    rest = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    options = {"limits": {"F": (-10.0, 10.0)}} | options
    return wb.nonlinear_predictive_design(rest, PERIOD, *WEIGHTS, horizon, **options)


def by_ipopt(design, plant, x, sent):
    """The inputs (N, nu) and the cost of the best plan from x, behind the inputs `sent`, oldest first."""
    nx, nu, own, d = len(design.states), len(design.inputs), design.limits, design.delay
    X, U, s, v = (ca.SX.sym("x", n, k) for n, k in ((nx, N + 1), (nu, N), (nx, 1), (nu, 1)))
    after = ca.Function("F", [s, v], [PlantStages(plant, design.period, design.steps).after(ca.SX(0.0), s, v)])
    inputs = ca.horzcat(ca.SX(ca.DM(np.reshape(sent, (nu, -1)))), U)
    late = inputs.shape[1] - N
    acting = inputs[:, late - d :]
    end = ca.vertcat(X[:, N], ca.vec(inputs[:, inputs.shape[1] - max(d, late) :]))
    cost, defects = end.T @ design.P @ end, [X[:, 0] - x]
    for k in range(N):
        cost += X[:, k].T @ design.Q @ X[:, k] + U[:, k].T @ design.R @ U[:, k]
        defects.append(X[:, k + 1] - after(X[:, k], acting[:, k]))
    changes = ca.vec(inputs[:, late:] - inputs[:, late - 1 : -1])
    rates = (own.rate_low, own.rate_high) if own.rate_low is not None else (np.full(nu, -NONE), np.full(nu, NONE))
    program = {"x": ca.veccat(X, U), "f": cost, "g": ca.vertcat(*defects, changes)}
    quiet = {"print_time": 0, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-11, "bound_relax_factor": 0.0}}
    low, high = (
        np.r_[np.full(X.numel(), sign * np.inf), np.tile(end, N)] for sign, end in ((-1, own.low), (1, own.high))
    )
    g_low, g_high = (np.r_[np.zeros(nx * (N + 1)), np.tile(end, N)] for end in rates)
    start = np.r_[np.tile(x, N + 1), np.zeros(nu * N)]
    answer = ca.nlpsol("exact", "ipopt", program, quiet)(x0=start, lbx=low, ubx=high, lbg=g_low, ubg=g_high)
    return np.array(answer["x"]).ravel()[X.numel() :].reshape(N, nu), float(answer["f"])


@pytest.mark.parametrize(
    "options",
    [{"rate_limits": {"F": (-2.0, 1.5)}}, {"delay": 0.04}, {"delay": 0.02, "rate_limits": {"F": (-2.0, 1.5)}}],
    ids=["rates", "delay", "both"],
)
@pytest.mark.parametrize("phi", [0.3, 2.5])
def test_a_plan_that_has_converged_is_the_one_of_ipopt(options, phi):
    design = cart_design(sweeps=15, iterations=60, **options)
    law = wb.NonlinearPredictive.of(wb.CartPole(), design)
    x, sent = np.array([0.0, 0.1, phi, 0.0]), np.array([3.0, -4.0])[: max(design.delay, 1)]
    z = law.memory.default.copy()
    z[law.memory.slice("sent")] = sent
    u, after = step_of(law)(0.0, z, x, [])
    memory = law.memory.unpack(np.array(after).ravel())
    plan = np.r_[float(u), memory["plan_u"][:-1]]
    exact, cost = by_ipopt(design, wb.CartPole(), x, sent)
    if "rate_limits" in options:
        changes = np.diff(exact.ravel(), prepend=sent[-1])
        assert min(changes.min() + 2.0, 1.5 - changes.max()) < 1e-7  # a limit of a change acts
    np.testing.assert_allclose(plan, exact.ravel(), rtol=0, atol=1e-6)  # as the issue of the law asks
    assert memory["cost"] == pytest.approx(cost, rel=1e-9)
    np.testing.assert_array_equal(memory["sent"], np.r_[sent[1:], float(u)])


def drawn_sweeps(seed, nx, nu, count, limit):
    """The inputs of the sweeps, those of DAQP, and the residual, of a drawn problem with limits of changes."""
    rng, stages = np.random.default_rng(seed), 12
    nz = nx + nu
    A0 = rng.normal(size=(nx, nx))
    A0 *= 1.1 / np.abs(np.linalg.eigvals(A0)).max()
    A, B = np.zeros((nz, nz)), np.vstack([rng.normal(size=(nx, nu)), np.eye(nu)])
    A[:nx, :nx] = A0
    Q, R = np.diag(np.r_[10 ** rng.uniform(-1, 1, nx), np.zeros(nu)]), np.diag(10 ** rng.uniform(-2, 0, nu))
    before, change = rng.uniform(-0.8, 0.8, nu), rng.uniform(0.1, 0.6, nu)
    x = [np.r_[3 * rng.normal(size=nx), before]]
    us = before + np.cumsum(rng.uniform(-0.05, 0.05, (stages, nu)), axis=0)
    for u in us:
        x.append(A @ x[-1] + B @ u)
    ones, none = np.ones(nu), ca.SX(0, 1)
    parts = [ca.SX(ca.DM(part)) for part in (Q, R, 5 * Q, -limit * ones, limit * ones)]
    weights = StageWeights(*parts, none, none, none, ca.SX(ca.DM(-change)), ca.SX(ca.DM(change)))
    columns = [np.concatenate([x[k], us[k], A.ravel("F"), B.ravel("F"), np.zeros(nz + nu)]) for k in range(stages)]
    rows = StageRows(ca.SX(ca.DM(np.array(columns).T)), ca.SX(ca.DM(x[-1])))
    v = ca.SX.sym("v", nu, stages)
    answer = solve_stages(weights, rows, v, 0 * v, ca.SX(2.0), count)
    mine, residual = ca.Function("sweeps", [v], [answer.v, answer.residual])(us.T)
    U, state, cost = ca.SX.sym("u", nu, stages), ca.SX(x[0]), 0
    for k in range(stages):
        cost += state.T @ Q @ state + U[:, k].T @ R @ U[:, k]
        state = A @ state + B @ U[:, k]
    moves = ca.vec(U - ca.horzcat(ca.SX(before), U[:, :-1]))
    program = {"x": ca.vec(U), "f": cost + state.T @ (5 * Q) @ state, "g": moves}
    most = np.tile(change, stages)
    exact = ca.qpsol("exact", "daqp", program)(lbx=-limit, ubx=limit, lbg=-most, ubg=most)["x"]
    return np.array(mine).T, np.array(exact).reshape(stages, nu), float(residual), (before, change)


@pytest.mark.heavy
@pytest.mark.parametrize(("limit", "least"), [(NONE, 22), (1.0, 14)], ids=["changes", "changes and inputs"])
def test_sweeps_that_settle_end_at_the_solution_of_daqp_and_all_keep_the_limits(limit, least):
    settled = acting = 0
    for nx, nu in ((2, 1), (4, 1), (4, 2), (3, 3)):
        for seed in range(6):
            mine, exact, residual, (before, change) = drawn_sweeps(seed, nx, nu, 40, limit)
            moves = np.abs(np.diff(mine, axis=0, prepend=before[None]))
            assert (moves < change + 1e-12).all()
            assert np.abs(mine).max() <= limit
            if residual < 1e-10:
                settled += 1
                acting += (moves > change - 1e-9).sum()
                np.testing.assert_allclose(mine, exact, rtol=0, atol=1e-6)  # DAQP keeps its limits to 1e-6
    assert settled >= least  # of 24; an input at both limits makes the cost to go a kink, at which sweeps can cycle
    assert acting > settled


def mass_and_rest():
    plant = wb.OdePlant.of(lambda t, x, u: [x[1], u[0]], states=("x:m", "v:m/s"), inputs=("a:m/s^2",))
    return plant, wb.linearize(wb.open_loop(plant), t=0.0, x=np.zeros(2), at_rest=True)


@pytest.mark.heavy
@pytest.mark.parametrize(
    "how", [{"rate_limits": {"a": (-0.3, 0.4)}}, {"delay": 0.2}, {"delay": 0.1, "rate_limits": {"a": (-0.3, 0.4)}}]
)
def test_the_law_of_a_linear_plant_is_the_exact_linear_law(how):
    plant, rest = mass_and_rest()
    settings = (0.1, np.diag([3.0, 1.0]), [[0.5]], 12)
    linear = wb.predictive_design(rest, *settings, limits={"a": (-1.0, 1.0)}, sweeps=1, **how)
    design = wb.nonlinear_predictive_design(rest, *settings, limits={"a": (-1.0, 1.0)}, sweeps=25, **how)
    step, law = step_of(wb.NonlinearPredictive.of(plant, design)), wb.NonlinearPredictive.of(plant, design)
    z, x, queue = law.memory.default, np.array([3.0, 0.5]), [0.0] * max(design.delay, 1)
    forces = []
    for k in range(30):
        u, z = step(0.1 * k, z, x, [])
        forces.append(float(u))
        last = queue[-1:] if "rate_limits" in how else []
        exact = linear.exact.first_move(np.r_[x, queue[: design.delay], last])[0]
        assert forces[-1] == pytest.approx(exact, abs=1e-6)  # the exact law keeps limits to 1e-7
        queue.append(forces[-1])
        acts = queue[-1 - design.delay]
        queue = queue[1:] if len(queue) > max(design.delay, 1) else queue
        x = np.array([x[0] + 0.1 * x[1] + 0.005 * acts, x[1] + 0.1 * acts])
    if "rate_limits" in how:
        changes = np.diff(forces, prepend=0.0)
        assert changes.min() == pytest.approx(-0.3, abs=1e-12)
        assert changes.max() < 0.4 + 1e-12


@pytest.mark.parametrize("how", [{"rate_limits": {"F": (-2.0, 2.0)}}, {"delay": 0.04}])
def test_where_no_limit_acts_at_a_rest_the_law_is_lqr(how):
    design = cart_design(**how)
    law = wb.NonlinearPredictive.of(wb.CartPole(), design)
    x = 1e-4 * np.array([1.0, -2.0, 0.5, 1.0])  # the rest of a sine at 1e-4 is 1e-12
    u = first_period(law, x)[0][0]
    tail = np.zeros(design.K.shape[1] - 4)
    np.testing.assert_allclose(u, -design.K @ np.r_[x, tail], rtol=0, atol=1e-9)  # as the issue of the law asks


def swing(design, **digital):
    plant = wb.CartPole(phi=np.pi)
    law = wb.NonlinearPredictive.of(plant, design, follow=("x",))
    reference = wb.Step("x", "m", 0.2)
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)
    return wb.simulate(loop.digital(PERIOD, **digital).step(1), until=6.0)


def test_a_swing_up_keeps_the_limits_of_changes_and_knows_the_inputs_on_their_way():
    run = swing(cart_design(40, rate_limits={"F": (-3.0, 3.0)}, delay=PERIOD), delay=True)
    forces = run.x[0, :, run.step.states.slice("hold.next")].ravel()
    assert np.abs(np.diff(forces)).max() == pytest.approx(3.0, abs=1e-9)
    assert np.abs(run.x[0, -1, :4] - [0.2, 0, 0, 0]).max() < 0.02


def test_a_law_that_knows_the_delay_costs_less():
    def cost(design):
        plant = wb.CartPole(phi=0.3)
        law = wb.NonlinearPredictive.of(plant, design)
        loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law)
        run = wb.simulate(loop.digital(PERIOD, delay=True).step(1), until=3.0)
        x = np.stack([run[name][0].ravel() for name in STATES], axis=1)
        return np.sum((x**2) @ np.diag(WEIGHTS[0])) + 0.1 * np.sum(run["F"] ** 2)

    assert cost(cart_design(delay=PERIOD)) < 0.97 * cost(cart_design())


def test_the_safe_command_keeps_the_limits_of_changes():
    design = cart_design(rate_limits={"F": (-1.0, 1.0)})
    law = wb.NonlinearPredictive.of(wb.CartPole(), design, safe_command={"F": 2.5})
    step, z, forces = step_of(law), law.memory.default, []
    for k in range(4):
        u, z = step(PERIOD * k, z, [np.nan, 0.0, 0.0, 0.0], [])
        forces.append(float(u))
    np.testing.assert_allclose(forces, [1.0, 2.0, 2.5, 2.5], rtol=1e-15)


@needs_compiler
def test_c_has_the_bits_of_the_simulation(tmp_path):
    plant = wb.CartPole(phi=2.5)
    law = wb.NonlinearPredictive.of(
        plant,
        cart_design(8, rate_limits={"F": (-3.0, 3.0)}, delay=2 * PERIOD),
        safe_command={"F": 0.0},
        fallback="last_good",
        residual_bound=0.1,
    )
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law).digital(PERIOD, delay=True)
    own = loop.law(truths=("xd", "phid"))
    y, r, u, z = recorded(loop, own, 30, substeps=1)
    made, memory, flags = compiled(c_code(own, "planned"), tmp_path)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0
    assert np.abs(np.diff(u[:, 0])).max() == pytest.approx(3.0, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"delay": 0.03}, r"delay=...\)` must be a whole number of periods of 0.02 s"),
        ({"delay": -0.02}, r"delay=...\)` must be a finite number of seconds, at least 0"),
        ({"delay": 0.4}, "must be below the horizon"),
        ({"rate_limits": {"x": (-1.0, 1.0)}}, "There is no 'x' among the 1 inputs of the plant"),
        ({"rate_limits": {"F": (0.5, 1.0)}}, "must leave the plant at rest, so that zero lies within"),
        ({"rate_limits": {"F": (1.0, -1.0)}}, "must have its low end below its high end"),
    ],
)
def test_bad_designs_are_refused_in_one_sentence(change, message):
    with pytest.raises((ValueError, LookupError), match=message):
        cart_design(**change)


def planned_swing():
    swing = wb.plan(
        wb.open_loop(wb.CartPole(phi=np.pi)),
        2.0,
        cost="energy",
        end=dict.fromkeys(STATES, 0.0),
        limits={"F": (-6.0, 6.0)},
    )
    return wb.PlannedReference(swing.motion, rest_inputs=[0.0])


@pytest.fixture(scope="module")
def reference():
    return planned_swing()


def test_an_input_that_acts_later_is_compared_with_the_planned_input_of_then(reference):
    law = wb.NonlinearPredictive.of(wb.CartPole(), cart_design(6, delay=2 * PERIOD), preview=reference)
    t = ca.SX.sym("t")
    at = ca.Function("at", [t], [ca.vertcat(*(ca.vec(part) for part in reference.at(t).values()))])
    window = law.memory["window"].default.reshape(7, 5 + 2)
    targets = ca.Function("r", [t], law._targets.at(t, ca.SX(0, 1), {}))
    for k in range(7):
        now, soon, later = (np.array(at(PERIOD * (k + j))).ravel() for j in range(3))
        r, s = targets(PERIOD * k)
        np.testing.assert_allclose(np.array(r).ravel(), np.r_[now[:4], now[4], soon[4]], rtol=0, atol=1e-12)
        assert float(s) == pytest.approx(later[4], abs=1e-12)
        np.testing.assert_allclose(window[k], np.r_[now, soon[4], later[4]], rtol=0, atol=1e-12)


def test_a_planned_motion_is_followed_through_a_delay(reference):
    misses = []
    for delay in (PERIOD, 0.0):
        plant = wb.CartPole(phi=np.pi)
        law = wb.NonlinearPredictive.of(plant, cart_design(20, delay=delay), preview=reference)
        loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)
        run = wb.simulate(loop.digital(PERIOD, delay=True).step(2), until=2.0)
        misses.append(np.abs(run["e_phi"]).max())
    assert misses[0] < 0.5 * misses[1]
