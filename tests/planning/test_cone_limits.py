"""Second-order cones among the limits: the nearest point, the exact solution beside a peer, the design, bad input."""

from functools import cache

import numpy as np
import pytest

import workbench as wb
from workbench.design.matrices import DesignError
from workbench.planning import (
    MpcConflictError,
    MpcLimits,
    exact_mpc,
    mpc_problem,
    no_memory,
    plan_gap,
    sampled_loss,
    solve_period,
    splitting_numbers,
    terminal_set,
)
from workbench.planning.linear_mpc.cone_limits import StageCone
from workbench.planning.linear_mpc.conic_solution import cone_directions

H = 0.05
A = np.block([[np.eye(3), H * np.eye(3)], [np.zeros((3, 3)), np.eye(3)]])
B = np.vstack([H**2 / 2 * np.eye(3), H * np.eye(3)]) / 10.0  # a lander of 10 kg
NAMES = ("x", "y", "z", "xd", "yd", "zd"), ("T_x", "T_y", "T_z")
THRUST = wb.ConeLimit(("T_x", "T_y"), "T_z", slope=0.25, offset=0.25 * 98.1)
CONES = [
    StageCone("cone", (2, 0), 1, 0.4, 0.7, np.array([0.1, -0.2])),
    StageCone("ball", (0, 1, 3), None, 0.0, 1.2, np.array([0.3, 0.0, -0.1])),
]


def lander(horizon=10, cones=(THRUST,), **limits):
    own = {"inputs": ([-10.0, -10.0, -108.1], [105.0, 105.0, 6.9])} | limits
    return mpc_problem(A, B, 1e3 * np.eye(6), np.eye(3), horizon, MpcLimits(**own, cones=cones), names=NAMES)


def peer(problem, x):
    """Clarabel's status, objective and inputs, of the problem in states and inputs."""
    cp = pytest.importorskip("cvxpy")
    (nx, nu), N, rows = problem.B.shape, problem.horizon, problem.rows
    states, inputs = cp.Variable((nx, N + 1)), cp.Variable((nu, N))
    of_cones = {place for cone in rows.cones for place in cone.rows}
    cost, keeps = cp.quad_form(states[:, N], problem.P), [states[:, 0] == x]
    for k in range(N):
        cost += cp.quad_form(states[:, k], problem.Q) + cp.quad_form(inputs[:, k], problem.R)
        keeps.append(states[:, k + 1] == problem.A @ states[:, k] + problem.B @ inputs[:, k])
        y = rows.F @ states[:, k] + rows.E @ inputs[:, k]
        for i in set(range(rows.count)) - of_cones:
            keeps += [y[i] >= rows.low[i]] if np.isfinite(rows.low[i]) else []
            keeps += [y[i] <= rows.high[i]] if np.isfinite(rows.high[i]) else []
        for cone in rows.cones:
            radius = cone.offset + (0 if cone.axial is None else cone.slope * y[cone.axial])
            keeps.append(cp.norm(y[list(cone.lateral)] - cone.centre) <= radius)
    posed = cp.Problem(cp.Minimize(cost), keeps)
    posed.solve(solver=cp.CLARABEL, tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10)
    return posed.status, posed.value, inputs.value.T


GLIDE = wb.ConeLimit(("x", "y"), "z", slope=0.8, offset=1.0)
SPEED = wb.ConeLimit(("xd", "yd", "zd"), offset=2.5)
BALL = wb.ConeLimit(("T_x", "T_y", "T_z"), offset=20.0, centre=(1.0, 0.0, -2.0))


@pytest.mark.parametrize("cones", [(THRUST,), (BALL,), (THRUST, GLIDE), (THRUST, GLIDE, SPEED)])
def test_the_exact_solution_is_that_of_a_peer_and_has_its_certificate(cones):
    exact, rng = exact_mpc(lander(8, cones)), np.random.default_rng(1)
    active = set()
    for _ in range(6):
        x = rng.normal(size=6) * [1.0, 1.0, 1.0, 0.8, 0.8, 0.8]
        x[2] = np.hypot(x[0], x[1]) + abs(x[2])
        answer, (status, objective, inputs) = exact.solve(x), peer(exact.problem, x)
        assert status == "optimal"
        assert answer.certificate.is_passed
        assert answer.objective == pytest.approx(objective, rel=1e-7)  # a thousand times the peer's tolerance
        np.testing.assert_allclose(answer.u, inputs, rtol=0, atol=2e-2)  # N, where the cost is flat to the peer
        active |= {name for name, _ in answer.active_limits}
    assert any(name.startswith("cone of") for name in active)


@pytest.mark.parametrize("cone", CONES, ids=["cone", "ball"])
def test_the_nearest_point_lies_in_the_cone_and_what_is_left_is_normal_to_it(cone):
    y = np.random.default_rng(0).normal(size=(500, 4))
    v = y.copy()
    cone.put_nearest(y, v)
    assert cone.excess(v).max() < 1e-14  # roundings of numbers up to ten
    other = np.random.default_rng(1).normal(size=(500, 4)) * 3
    cone.put_nearest(other.copy(), other)
    assert (((y - v)[:, None] * (other[None] - v[:, None])).sum(axis=-1)).max() < 1e-12
    assert 0.1 < (v == y).all(axis=1).mean() < 0.9
    again = v.copy()
    cone.put_nearest(v, again)
    np.testing.assert_allclose(again, v, rtol=0, atol=1e-13)


@pytest.mark.parametrize("cone", CONES, ids=["cone", "ball"])
def test_the_directions_of_a_cone_are_the_derivative_of_its_nearest_point(cone):
    rng, h = np.random.default_rng(3), 1e-6
    kinds = set()
    for _ in range(60):
        y = rng.normal(size=4) * 3
        off = np.zeros((4, 4))
        for direction, mu in cone_directions(cone, y):
            off[np.ix_(cone.rows, cone.rows)] += mu * np.outer(direction, direction)
        P = np.zeros((4, 4))
        for j in range(4):
            ends = []
            for sign in (1, -1):
                moved = y + sign * h * np.eye(4)[j]
                into = moved.copy()
                cone.put_nearest(moved, into)
                ends.append(into)
            P[:, j] = (ends[0] - ends[1]) / (2 * h)
        np.testing.assert_allclose(np.eye(4) - P, off, rtol=0, atol=1e-7)  # a central difference
        kinds.add(len(cone_directions(cone, y)))
    assert len(kinds) > 1


def test_from_inside_all_limits_the_answer_is_lqr():
    problem = lander()
    x = np.array([0.01, 0.0, 0.02, 0.0, 0.01, 0.0])
    answer = exact_mpc(problem).solve(x)
    np.testing.assert_allclose(answer.u[0], -problem.K @ x, rtol=0, atol=1e-12)
    assert answer.active_limits == ()


def test_a_state_that_no_input_can_save_is_refused():
    exact = exact_mpc(lander(6, (THRUST, GLIDE), states=([-5.0] * 3 + [-10.0] * 3, [5.0] * 3 + [10.0] * 3)))
    with pytest.raises(
        MpcConflictError, match="no input keeps the limits on .*cone of x, y about z from this"
    ) as refusal:
        exact.solve([4.9, 0.0, 4.9, 9.0, 0.0, 0.0])
    assert refusal.value.proof.margin > 0
    with pytest.raises(DesignError, match="neither an optimum nor a conflict of the limits can be certified"):
        exact.solve([4.0, 0.0, 0.0, 0.0, 0.0, 0.0])  # four metres beside the pad at its height


@wb.block
class Lander(wb.Plant):
    """A mass of 10 kg under three thrusts and gravity."""

    x: float = wb.initial(default=2.0, unit="m")
    z: float = wb.initial(default=3.0, unit="m")
    xd: float = wb.initial(default=0.0, unit="m/s")
    zd: float = wb.initial(default=-1.0, unit="m/s")
    inputs, outputs = wb.layout(T_x="N", T_z="N"), wb.layout(p="m")

    def rate(self, t, x, u):
        return {"x": x["xd"], "z": x["zd"], "xd": u["T_x"] / 10, "zd": u["T_z"] / 10 - 9.81}

    def measure(self, t, x):
        return {"p": x["x"]}


@cache
def hover():
    return wb.linearize(wb.open_loop(Lander()), t=0.0, x=np.zeros(4), u=[0.0, 98.1], at_rest=True)


def hover_design(**options):
    cones = options.pop("cones", (wb.ConeLimit(("T_x",), "T_z", slope=0.2),))
    limits = options.pop("limits", {"T_z": (0.0, 120.0)})
    return wb.predictive_design(hover(), 0.1, np.eye(4), 1e-3 * np.eye(2), 10, limits=limits, cones=cones, **options)


def test_a_cone_counts_from_the_rest_of_the_plant():
    (cone,) = hover_design().problem.rows.cones
    assert cone.offset == pytest.approx(0.2 * 98.1)
    assert (cone.inputs, cone.centre.tolist()) == ((0, 1), [0.0])


def test_the_designed_sweeps_follow_the_exact_law_and_keep_the_cone():
    design = hover_design()
    assert design.numbers.method == "admm"
    assert design.evidence.largest_error <= 1e-2
    assert design.evidence.active_share > 0.2
    assert "cone of T_x about T_z" in repr(design)
    memory, x, errors = no_memory(design.numbers), np.array([3.0, 2.0, 0.0, -1.0]), []
    for _ in range(30):
        answer = solve_period(design.numbers, memory, x)
        assert np.abs(answer.u[0]) <= 0.2 * (answer.u[1] + 98.1)  # exactly
        errors.append(np.abs(answer.u - design.exact.first_move(x)) / [48.0, 120.0])
        memory, x = answer.memory, design.problem.A @ x + design.problem.B @ answer.u
    assert np.max(errors) < 5e-2  # five times the accuracy: the sample is a sample


def test_in_the_terminal_ellipsoid_lqr_keeps_the_cone():
    for cones in ((THRUST,), (GLIDE,), (SPEED, BALL)):
        problem = lander(4, cones)
        ends, rng = terminal_set(problem), np.random.default_rng(2)
        x = rng.normal(size=(2000, 6))
        x *= np.sqrt(ends.level / np.einsum("bi,ij,bj->b", x, ends.P, x))[:, None]
        y = x @ (problem.rows.F - problem.rows.E @ ends.K).T
        for cone in problem.rows.cones:
            assert cone.excess(y).max() <= 0
        assert (y <= problem.rows.high).all()
        assert (y >= problem.rows.low).all()


def test_the_sampled_loss_knows_cones_and_the_gap_of_a_plan_refuses_them():
    design = hover_design()
    loss = sampled_loss(design.exact, design.numbers, [[1.0, 1.0, 0.0, 0.0]], 10)
    assert loss.worst_cost_loss < 1e-2
    assert loss.worst_violation < 1e-9  # of a span: inputs alone, which are kept exactly
    with pytest.raises(ValueError, match="must be for limits without cones"):
        plan_gap(design.exact, np.zeros(4), np.zeros(len(design.problem.low)))


def test_a_metric_refuses_cones():
    numbers = splitting_numbers(lander())
    with pytest.raises(ValueError, match="needs the numbers of ADMM for limits that are cones"):
        solve_period(numbers, no_memory(numbers), np.zeros(6))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"lateral": ("T_x", "T_x")}, "names of signals, each once"),
        ({"lateral": ()}, "names of signals, each once"),
        ({"slope": 0.0}, "above zero, the tangent of an angle"),
        ({"slope": -0.2}, r"slope=...\)` must be a finite number"),
        ({"axial": ""}, "0 for a ball, which has no axis"),
        ({"axial": "", "slope": 0.0}, "above zero, the radius of a ball"),
        ({"centre": (0.0, 1.0, 2.0)}, "lateral signals"),
        ({"offset": np.nan}, r"offset=...\)` must be a finite number"),
    ],
)
def test_bad_cones_are_refused_in_one_sentence(change, message):
    with pytest.raises(ValueError, match=message) as refusal:
        wb.ConeLimit(**({"lateral": ("T_x", "T_y"), "axial": "T_z", "slope": 0.2} | change))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"cones": (wb.ConeLimit(("T_y",), "T_z", slope=0.2),)}, "There is no 'T_y' among the 6 states and inputs"),
        ({"cones": (wb.ConeLimit(("x",), "T_z", slope=0.2),)}, "all inputs, or all states"),
        ({"cones": (wb.ConeLimit(("T_x",), "T_z", slope=0.2, offset=-50.0),)}, "it lies 30.38 outside of the cone of"),
        ({"cones": (wb.ConeLimit(("T_x",), offset=9.0), wb.ConeLimit(("T_x",), offset=8.0))}, "'T_x' stands in two"),
        (
            {"limits": {"T_x": (-9.0, 9.0)}, "cones": (wb.ConeLimit(("T_x",), "T_z", slope=1.0, centre=(10.0,)),)},
            "axis",
        ),
        ({"rate_limits": {"T_x": (-1.0, 1.0)}}, "must not limit both changes and cones of inputs"),
        ({"modes": 2}, "left out where a limit is a cone"),
        ({"cones": "T_x"}, "cones"),
    ],
)
def test_cones_that_cannot_be_posed_are_refused_in_one_sentence(change, message):
    with pytest.raises((ValueError, LookupError), match=message) as refusal:
        hover_design(**change)
    assert "\n" not in str(refusal.value)
