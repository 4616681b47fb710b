"""The predictive law in the graph: its reference in NumPy, LQR where no limit acts, delays, and bad arguments."""

from dataclasses import replace

import numpy as np
import pytest

import workbench as wb
from workbench.design.linear import operating_point
from workbench.design.linear.linear_period import jump_of
from workbench.planning.linear_mpc import no_memory, solve_period

WEIGHTS = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]
STATES = ("x", "xd", "phi", "phid")


def cart_design(**options):
    plant = wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)
    limits = {"F": (-3.0, 3.0)} | options.pop("also", {})
    return wb.predictive_design(plant, 0.02, *WEIGHTS, options.pop("horizon", 20), limits=limits, **options)


def run_of(design, phi=0.2, step=0.5, until=1.0, **digital):
    plant = wb.CartPole(phi=phi)
    law = wb.ModelPredictive.of(plant, design, follow=("x",))
    reference = wb.Step("x", "m", step)
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law, reference=reference)
    return wb.simulate(loop.digital(0.02, **digital).step(1), until=until)


def readings(run):
    """States (K, 4) and forces (K,) of a run, at the instants of the computer."""
    return np.stack([run[name][0].ravel() for name in STATES], axis=1), run["F"][0].ravel()


@pytest.mark.heavy
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"sweeps": 1},
        {"horizon": 7},
        {"also": {"phi": (-0.1, 0.21)}, "soft_weight": 1e3},
        {"also": {"phi": (-0.1, 0.21)}},
        {"rate_limits": {"F": (-0.8, 0.8)}},
        {"also": {"phi": (-0.1, 0.21)}, "rate_limits": {"F": (-0.8, 0.8)}},
    ],
    ids=["as designed", "one sweep", "short", "soft limit", "hard limit", "rates", "hard limit and rates"],
)
def test_the_law_in_a_loop_is_the_splitting_in_numpy(options):
    design = cart_design(**options)
    x, forces = readings(run_of(design))
    numbers, memory = design.numbers, no_memory(design.numbers)
    extra = design.problem.B.shape[0] - 4
    sent = np.zeros(extra)
    target = np.r_[0.5, np.zeros(3 + extra)], np.zeros(1)
    for k in range(len(x) - 1):
        answer = solve_period(numbers, memory, np.r_[x[k], sent], target)
        memory, sent = answer.memory, answer.u[:extra] if extra else sent
        np.testing.assert_allclose(forces[k], answer.u[0], rtol=0, atol=1e-10)  # of some 10^4 roundings
    assert np.abs(forces).max() == pytest.approx(3.0)  # the limit acts


def test_columns_of_the_dual_matrix_and_passes_over_the_stages_are_one_sweep():
    plant, design = wb.CartPole(phi=0.2), cart_design()
    law = wb.ModelPredictive.of(plant, design)
    forces = [
        wb.simulate(
            wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=one).digital(0.02).step(1), until=1.0
        )["F"]
        for one in (law, replace(law, D=None))
    ]
    assert law.D is not None
    assert np.abs(forces[0]).max() == pytest.approx(3.0)  # the limit acts
    np.testing.assert_allclose(*forces, rtol=0, atol=1e-9)  # of some 10^4 roundings


def test_the_law_records_the_plan_that_it_follows():
    run = run_of(cart_design(sweeps=60), phi=0.05, step=0.1)
    times, x, forces = run["predicted_t"][0, 0], run["predicted_x"][0], run["predicted_F"][0]
    np.testing.assert_allclose(times, 0.02 * np.arange(21), rtol=1e-15)
    np.testing.assert_allclose(x[:, 0], run["x"][0].ravel(), rtol=0, atol=1e-12)  # a plan begins where the plant is
    np.testing.assert_array_equal(forces[:, 0], run["F"][0].ravel())
    assert np.abs(run["F"]).max() < 3.0
    ahead = np.abs(x[:-5, 5] - run["x"][0, 5:].ravel())
    assert ahead.max() < 2e-3  # m after five periods: the plan knows the linearised plant at angles of 0.05


@pytest.mark.heavy
@pytest.mark.parametrize("options", [{}, {"also": {"phi": (-0.1, 0.21)}}, {"rate_limits": {"F": (-0.8, 0.8)}}])
def test_where_no_limit_acts_the_law_is_lqr(options):
    design = cart_design(**options)
    x, forces = readings(run_of(design, phi=0.01, step=0.02))
    linear = -(x - [0.02, 0, 0, 0]) @ np.ravel(design.problem.K)[:4]
    assert np.abs(forces[:-1]).max() < 3.0
    np.testing.assert_allclose(forces[:-1], linear[:-1], rtol=0, atol=1e-9)  # as the issue of the law asks


@pytest.mark.heavy
@pytest.mark.parametrize(
    "options",
    [{"horizon": 20}, {"horizon": 5, "sweeps": 2, "also": {"phi": (-0.1, 0.21)}}],
    ids=["inputs", "hard limit"],
)
def test_linear_answers_at_rest_are_those_of_lqr(options):
    design, plant = cart_design(**options), wb.CartPole()
    laws = wb.ModelPredictive.of(plant, design), wb.StateFeedback.of(plant, np.array(design.problem.K)[:, :4])
    loops = [wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law) for law in laws]
    predictive, linear = (wb.linear_loop(wb.DigitalLoop(one, 0.02)) for one in loops)
    omega = np.array([0.3, 3.0, 30.0])
    # the law takes its first input from a product of LQR's rows, which rounds in another order
    np.testing.assert_allclose(*(one.response(omega, "L").values for one in (predictive, linear)), rtol=1e-12)
    assert predictive.corner_signals == ()
    computers = [one.digital(0.02, inputs=True) for one in loops]
    models = [wb.linearize(one, 0.0, one.states.default, at_rest=True) for one in computers]
    places = [[one.states.labels.index(f"plant.{name}") for name in STATES] for one in computers]
    A = [model.A[np.ix_(place, place)] for model, place in zip(models, places, strict=True)]
    np.testing.assert_allclose(*A, rtol=0, atol=1e-14)  # of gains of size 10, by two orders of the same products


@pytest.mark.parametrize("also", [{}, {"phi": (-0.1, 0.21)}], ids=["inputs", "hard limit"])
def test_the_derivatives_of_a_period_in_which_limits_act_are_those_of_central_differences(also):
    plant = wb.CartPole()
    law = wb.ModelPredictive.of(plant, cart_design(horizon=5, sweeps=1, modes=1, also=also))
    computer = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law).digital(0.02, inputs=True)
    x = computer.states.pack({f"plant.{name}": 0.1 * (k + 1) for k, name in enumerate(STATES)})[0]
    x[computer.states.slice("controller.plan")] += np.linspace(0.1, 0.5, law.horizon * law.low.shape[0])
    jump, p, h = jump_of(computer), computer.parameters.default, 1e-6
    steps = [(jump.rate_at(1.0, x + h * e, p) - jump.rate_at(1.0, x - h * e, p)) / (2 * h) for e in np.eye(len(x))]
    A = np.array(jump.A(1.0, x, p))
    assert jump.rate_at(1.0, x, p)[computer.states.slice("controller.residual")] > 0.1  # sweeps are made
    np.testing.assert_allclose(A, np.transpose(steps), rtol=0, atol=1e-6)  # of slopes up to 160: rounding 1e-14 / h


def test_a_law_at_rest_on_its_limit_is_refused_by_name():
    plant = wb.DCMotor()
    rest = operating_point(wb.open_loop(plant), {"v": 1.0})
    model = wb.linearize(wb.open_loop(plant), 0.0, rest.x, u=rest.u, at_rest=True)
    design = wb.predictive_design(model, 0.05, np.eye(2), [[0.1]], 5, limits={"v": (0.0, 1.0)}, sweeps=2, modes=1)
    law = wb.ModelPredictive.of(plant, design)
    loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law)
    with pytest.raises(ValueError, match=r"has a corner at this state.*one piece|jumps by"):
        wb.linear_loop(wb.DigitalLoop(loop, 0.05), values={"plant.omega": rest.x[0], "plant.i": rest.x[1]})


@pytest.mark.heavy
def test_more_sweeps_come_nearer_to_the_exact_law():
    errors = []
    for sweeps in (1, 3, 30):
        design = cart_design(sweeps=sweeps)
        x, forces = readings(run_of(design, phi=-0.15, step=2.0))
        exact = [design.exact.first_move(row - [2.0, 0, 0, 0])[0] for row in x[:-1]]
        errors.append(np.abs(forces[:-1] - exact).max())
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-6


def test_a_law_knows_the_inputs_that_are_on_their_way():
    def cost(design):
        x, forces = readings(run_of(design, phi=0.1, step=0.1, until=3.0, delay=True))
        return np.sum(((x - [0.1, 0, 0, 0]) ** 2) @ np.diag(WEIGHTS[0])) + 0.1 * np.sum(forces**2)

    assert cost(cart_design(delay=0.02)) < 0.99 * cost(cart_design())


def test_the_residual_says_how_far_a_plan_is_from_done():
    run = run_of(cart_design(sweeps=2))
    residual = run.x[0, :, run.step.states.slice("controller.residual")].ravel()
    assert residual.max() > 1e-2
    assert residual[-1] < residual.max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"also": {"y": (0.0, 1.0)}}, "There is no 'y' among the 5 states, inputs and outputs of the plant"),
        ({"also": {"F": (1.0, -1.0)}}, "must have its low end below its high end; 'F' has 1 and -1"),
        ({"also": {"F": (1.0, 3.0)}}, "must leave the rest of the plant inside; that of 'F' lies 1 outside"),
        ({"also": {"F": (np.nan, 3.0)}}, r"predictive_design\(limits={'F': ...}\)` must hold two numbers"),
        ({"horizon": 1, "delay": 0.04}, "from 3 to 1000, above the delay"),
    ],
)
def test_bad_designs_are_refused_in_one_sentence(change, message):
    with pytest.raises((ValueError, LookupError), match=message):
        cart_design(**change)


def test_a_design_for_another_plant_is_refused():
    with pytest.raises(ValueError, match="a design for the plant's own signals, omega, i; it is for x, xd, phi, phid"):
        wb.ModelPredictive.of(wb.DCMotor(), cart_design())
    with pytest.raises(ValueError, match="must be the result of `predictive_design`"):
        wb.ModelPredictive.of(wb.CartPole(), np.eye(4))
