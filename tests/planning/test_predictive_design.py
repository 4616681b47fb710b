"""The design of a predictive law: what it derives and from which sample, limits by name, claims, and bad input."""

from functools import cache

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import workbench as wb
from tests.support.predictive_problems import cart_pole, peer_answer
from workbench.design.linear import operating_point
from workbench.design.matrices import DesignError
from workbench.planning import exact_loops, exact_mpc, no_memory, solve_period
from workbench.planning.linear_mpc.dual_recursion import tracking_gains
from workbench.planning.linear_mpc.limit_sample import limit_samples
from workbench.planning.linear_mpc.splitting_tuning import admm_numbers
from workbench.planning.linear_mpc.sweep_choice import choose_sweeps

NO = np.inf
PHI = ([-NO, -NO, -0.1, -NO], [NO, NO, 0.1, NO])
WEIGHTS = np.diag([10.0, 1.0, 10.0, 1.0]), [[0.1]]


@cache
def cart():
    return wb.linearize(wb.open_loop(wb.CartPole()), t=0.0, x=np.zeros(4), at_rest=True)


@cache
def tank():
    plant = wb.open_loop(wb.QuadrupleTank())
    point = operating_point(plant, {"h_1": 12.4, "h_2": 12.7})
    return wb.linearize(plant, 0.0, point.x, u=point.u, at_rest=True)


def design(**options):
    limits = {"F": (-3.0, 3.0)} | options.pop("also", {})
    Q, R = options.pop("Q", WEIGHTS[0]), options.pop("R", WEIGHTS[1])
    return wb.predictive_design(cart(), 0.02, Q, R, options.pop("horizon", 20), limits=limits, **options)


def tank_design(**options):
    limits = {"v_1": (0.0, 6.0), "v_2": (0.0, 6.0)} | options.pop("also", {})
    return wb.predictive_design(tank(), 5.0, np.diag([1, 1, 0.01, 0.01]), 0.1 * np.eye(2), 12, limits=limits, **options)


@pytest.mark.parametrize(
    "options",
    [{}, {"rates": (-1.0, 1.0)}, {"states": PHI}, {"states": PHI, "rates": (-1.0, 1.0)}],
    ids=["inputs", "rates", "hard limit", "hard limit and rates"],
)
def test_derived_sweeps_follow_the_exact_law_from_starts_that_were_no_part_of_the_sample(options):
    problem = cart_pole(**options)
    exact = exact_mpc(problem)
    numbers, evidence = choose_sweeps(exact, limit_samples(exact, 4), 1e-2)
    assert evidence.largest_error <= 1e-2
    assert evidence.active_share > 0.2
    starts = np.random.default_rng(5).uniform(-1, 1, (12, 4)) * [0.15, 0.1, 0.05, 0.2]
    starts = np.hstack([starts, np.zeros((12, len(problem.A) - 4))])
    states, moves = exact_loops(exact, starts, 12)
    memory, errors = no_memory(numbers, len(states)), []
    for k in range(12):
        answer = solve_period(numbers, memory, states[:, k])
        memory = answer.memory
        errors.append(np.abs(answer.u - moves[:, k]) / 6.0)
    assert np.max(errors) < 5e-2  # five times the accuracy: the sample is a sample
    assert np.sqrt(np.mean(np.square(errors))) < 1e-2


@pytest.mark.parametrize("options", [{"rates": (-1.0, 1.0)}, {"states": PHI}])
def test_derived_sweeps_come_near_to_the_first_moves_of_a_peer(options):
    problem = cart_pole(**options)
    exact = exact_mpc(problem)
    numbers, _ = choose_sweeps(exact, limit_samples(exact, 4), 1e-3)
    x, memory = np.array([-0.12, 0.0, 0.02, 0.1, *[0.0] * (len(problem.A) - 4)]), no_memory(numbers)
    for _ in range(15):
        answer = solve_period(numbers, memory, x)
        peer = peer_answer(problem, x)
        assert peer is not None
        assert np.abs(answer.u - peer[0]).max() < 3e-2  # five times the accuracy, in N of a span of 6 N
        memory, x = answer.memory, problem.A @ x + problem.B @ answer.u


def test_a_design_is_the_same_with_any_number_of_threads():
    designs = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            designs.append(tank_design())
    first, second = (one.numbers for one in designs)
    assert (first.sweeps, first.method) == (second.sweeps, second.method)
    for name in ("sigma", "W", "L", "Y"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert designs[0].evidence == designs[1].evidence


def test_two_passes_over_the_stages_are_the_dense_sweep_of_admm():
    problem = cart_pole(12, states=PHI, rates=(-1.0, 1.0), soft_weight=1e3)
    numbers = admm_numbers(exact_mpc(problem), 3.0, 30.0)
    sigma = numbers.sigma[: problem.rows.count]
    gains, inverses = tracking_gains(problem, sigma)
    (nx, nu), rows, N = problem.B.shape, problem.rows, problem.horizon
    loop, out, weight = problem.A - problem.B @ problem.K, rows.F - rows.E @ problem.K, 1 / (sigma + rows.softness)
    aims = np.random.default_rng(0).normal(size=(N, rows.count))
    p, moves = np.zeros(nx), np.zeros((N, nu))
    for k in reversed(range(N)):
        push = problem.B.T @ p + rows.E.T @ (weight * aims[k])
        moves[k] = inverses[k * nu : (k + 1) * nu] @ push
        p = loop.T @ p + out.T @ (weight * aims[k]) - gains[k * nu : (k + 1) * nu].T @ push
    x, y = np.zeros(nx), []
    for k in range(N):
        d = moves[k] - gains[k * nu : (k + 1) * nu] @ x
        y.append(out @ x + rows.E @ d)
        x = loop @ x + problem.B @ d
    y = np.array(y) + rows.softness * weight * (aims - np.array(y))
    np.testing.assert_allclose(y.ravel(), numbers.matrix @ aims.ravel(), rtol=0, atol=1e-10)  # sums of 36 terms


def test_limits_count_from_the_rest_of_the_plant():
    one = tank_design(also={"h_3": (0.5, 4.0)}, soft_weight=10.0)
    place = one.problem.rows.names.index("h_3")
    rest = tank().point.x0[2]
    np.testing.assert_allclose(
        [one.problem.rows.low[place], one.problem.rows.high[place]], [0.5 - rest, 4.0 - rest], rtol=0, atol=1e-12
    )
    assert one.problem.rows.low[0] == pytest.approx(-tank().point.u0[0])


@wb.block
class Slider(wb.Plant):
    p: float = wb.initial(default=-1.0, unit="m")
    v: float = wb.initial(default=0.0, unit="m/s")
    inputs, outputs = wb.layout(a="m/s^2"), wb.layout(z="m")

    def rate(self, t, x, u):
        return {"p": x["v"], "v": u["a"]}

    def measure(self, t, x):
        return {"z": x["p"] + 0.6 * x["v"]}


def test_an_output_keeps_the_limits_of_its_name():
    plant = Slider()
    model = wb.linearize(wb.open_loop(plant), t=0.0, x=[0.0, 0.0], at_rest=True)

    def largest(limits):
        one = wb.predictive_design(model, 0.1, np.diag([10.0, 0.0]), [[0.1]], 15, limits={"a": (-2.0, 2.0)} | limits)
        law = wb.ModelPredictive.of(plant, one)
        loop = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law)
        return wb.simulate(loop.digital(0.1).step(1), until=5.0)["z"].max()

    assert largest({}) > 0.05
    assert largest({"z": (-NO, 0.02)}) < 0.021  # a twentieth of the limit: the sweeps are not the exact law


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"Q": -np.eye(4)}, r"Q must be positive semidefinite"),
        ({"R": [[0.0]]}, r"R must be positive definite"),
        ({"rate_limits": {"x": (-1.0, 1.0)}}, r"There is no 'x' among the 1 inputs of the plant"),
        ({"rate_limits": {"F": (0.1, 1.0)}}, r"rate_limits=...\)` must leave the rest of the plant inside"),
        ({"rate_limits": {"F": (1.0, -1.0)}}, r"rate_limits={'F': ...}\)` must have its low end below"),
        ({"accuracy": 0.0}, r"accuracy=...\)` must be a finite number"),
        ({"sweeps": 0}, r"sweeps=...\)` must be a whole number"),
        ({"modes": -1}, r"modes=...\)` must be a whole number"),
        ({"soft_weight": -1.0, "also": {"phi": (-0.1, 0.1)}}, r"soft_weight=...\)` must be a weight above zero"),
        ({"offset_free": ("theta",)}, r"There is no 'theta' among"),
        ({"offset_free": ("x", "x")}, r"names of outputs, each once"),
        ({"horizon": 1, "delay": 0.04}, r"from 3 to 1000, above the delay"),
    ],
)
def test_bad_arguments_are_refused_in_one_sentence(change, message):
    with pytest.raises((ValueError, LookupError), match=message) as refusal:
        design(**change)
    assert "\n" not in str(refusal.value)


def test_an_accuracy_that_no_number_of_sweeps_reaches_is_refused():
    with pytest.raises(DesignError, match=r"no number of sweeps up to 100 .* errs by .* Ask for a larger `accuracy`"):
        design(also={"phi": (-0.1, 0.1)}, rate_limits={"F": (-0.5, 0.5)}, accuracy=1e-9, horizon=8)


def test_claims_say_what_is_proved_and_what_is_sampled():
    one = design()
    claims = {claim.name: claim for claim in one.claims}
    assert {"terminal set", "feasible forever", "hypotheses", "contraction", "accuracy", "cost"} == set(claims)
    assert "exact rational arithmetic" in claims["hypotheses"].statement
    assert len(claims["feasible forever"].hypotheses) == 3
    assert "sampled, not proved" in claims["accuracy"].source
    assert "sampled, not proved" in repr(one)
    rates = {claim.name: claim for claim in design(rate_limits={"F": (-1.0, 1.0)}).claims}
    assert "Nothing is claimed" in rates["no terminal set"].statement
    assert "contraction" not in rates


def test_sweeps_that_are_given_take_the_best_constants_for_their_number():
    few, many = (design(rate_limits={"F": (-1.0, 1.0)}, sweeps=count) for count in (3, 40))
    assert (few.numbers.sweeps, many.numbers.sweeps) == (3, 40)
    assert many.evidence.largest_error < few.evidence.largest_error


def test_designs_with_equal_sweeps_and_modes_are_laws_of_one_size():
    shapes = set()
    for weight in (1.0, 10.0):
        one = design(Q=np.diag([weight, 1.0, 10.0, 1.0]), sweeps=5, modes=2)
        shapes.add((one.numbers.sweeps, one.numbers.W.shape, one.numbers.method))
    assert shapes == {(5, (20, 2), "metric")}
