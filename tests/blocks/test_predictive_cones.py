"""The predictive law with second-order cones in the graph: its reference in NumPy, kept cones, LQR, and C."""

from functools import cache

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import EACH_COMPILER, compiled, differing, needs_compiler, recorded
from workbench.handover.c99.c_files import c_code
from workbench.planning import no_memory, solve_period

STATES = ("p", "v")
THRUST = wb.ConeLimit(("T_x", "T_y"), "T_z", slope=0.25)  # 14 degrees about the vertical
GRAVITY = 98.1


@wb.block
class Lander(wb.Plant):
    """A mass of 10 kg under three thrusts and gravity; T_z stands first among the inputs."""

    p: np.ndarray = wb.initial(default=np.array([4.0, 2.0, 6.0]), unit="m", shape=("n",))
    v: np.ndarray = wb.initial(default=np.array([-1.0, 2.0, -1.5]), unit="m/s", shape=("n",))
    inputs = wb.layout(T_z="N", T_x="N", T_y="N")
    outputs = wb.layout(height="m")

    def rate(self, t, x, u):
        return {"p": x["v"], "v": ca.vertcat(u.T_x, u.T_y, u.T_z - GRAVITY) / 10}

    def measure(self, t, x):
        return {"height": x["p"][2]}


@cache
def design(*cones, horizon=8, sweeps=8):
    limits = {"T_z": (20.0, 120.0), "T_x": (-15.0, 40.0)}
    linear = wb.linearize(wb.open_loop(Lander()), t=0.0, x=np.zeros(6), u=[GRAVITY, 0.0, 0.0], at_rest=True)
    weights = np.diag([1.0, 1.0, 1.0, 0.1, 0.1, 0.1]), 1e-3 * np.eye(3)
    return wb.predictive_design(linear, 0.1, *weights, horizon, limits=limits, cones=cones or (THRUST,), sweeps=sweeps)


def loop_of(one, plant=None, **options):
    plant = plant or Lander()
    law = wb.ModelPredictive.of(plant, one, **options)
    return wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law)


def run_of(one, plant=None, until=4.0):
    return wb.simulate(loop_of(one, plant).digital(0.1).step(1), until=until)


def thrusts(run):
    return np.stack([np.asarray(run[name])[0].ravel() for name in ("T_z", "T_x", "T_y")], axis=1)


def states(run):
    return np.hstack([np.asarray(run[name])[0].reshape(-1, 3) for name in STATES])


SPEED = wb.ConeLimit(("v[0]", "v[1]", "v[2]"), offset=2.8)
GLIDE = wb.ConeLimit(("p[0]", "p[1]"), "p[2]", slope=1.0, offset=0.2)


@pytest.mark.heavy
@pytest.mark.parametrize("cones", [(THRUST,), (THRUST, SPEED), (GLIDE,)], ids=["thrust", "thrust, speed", "glide"])
def test_the_law_in_a_loop_is_the_splitting_in_numpy(cones):
    one = design(*cones)
    run = run_of(one, until=2.0)
    x, u = states(run), thrusts(run)
    memory, rows, closest = no_memory(one.numbers), one.problem.rows, -np.inf
    for k in range(len(x) - 1):
        answer = solve_period(one.numbers, memory, x[k])
        memory = answer.memory
        np.testing.assert_allclose(u[k], answer.u + [GRAVITY, 0, 0], rtol=0, atol=1e-8)  # of 10^4 roundings of 100 N
        y = rows.F @ x[k] + rows.E @ answer.u
        closest = max(closest, *(float(cone.excess(y)) for cone in rows.cones))
    assert closest > -1e-9  # a cone acts


def test_every_command_keeps_the_cone_and_its_limits_exactly():
    u = thrusts(run_of(design()))
    lateral = np.hypot(u[:, 1], u[:, 2])
    assert (lateral <= 0.25 * u[:, 0]).all()
    assert (lateral >= 0.25 * u[:, 0] * (1 - 1e-12)).sum() > 3  # at its edge, to rounding
    assert u[:, 0].min() >= 20.0
    assert u[:, 1].min() >= -15.0


def test_the_recorded_plan_keeps_the_cone_and_begins_with_the_command():
    run = run_of(design())
    plans = np.stack([np.asarray(run[f"predicted_{name}"])[0] for name in ("T_z", "T_x", "T_y")], axis=-1)
    np.testing.assert_allclose(plans[:, 0], thrusts(run), rtol=0, atol=1e-12)
    assert (np.hypot(plans[..., 1], plans[..., 2]) <= 0.25 * plans[..., 0]).all()


def test_where_no_limit_acts_the_law_is_lqr():
    one = design()
    run = run_of(one, Lander(p=np.array([0.05, 0.02, 0.1]), v=np.zeros(3)))
    linear = -states(run) @ one.problem.K.T + [GRAVITY, 0.0, 0.0]
    np.testing.assert_allclose(thrusts(run)[:-1], linear[:-1], rtol=0, atol=1e-9)


def test_the_linear_loop_at_rest_is_that_of_lqr():
    one, plant = design(horizon=2, sweeps=1), Lander(p=np.zeros(3), v=np.zeros(3))
    law = wb.StateFeedback.of(plant, one.problem.K, u0=[GRAVITY, 0.0, 0.0])
    linear = wb.ClosedLoop(plant, observer=wb.FullState.of(plant), controller=law)
    below = {"controller.worst": -1}  # the largest residual so far has a corner where none was yet
    loops = (
        wb.linear_loop(wb.DigitalLoop(loop_of(one, plant), 0.1), side=below),
        wb.linear_loop(wb.DigitalLoop(linear, 0.1)),
    )
    margins = [loop.margins()["T_x"].margins.phase_margin.value for loop in loops]
    assert margins[0] == pytest.approx(margins[1], rel=1e-9)  # two roads to one L


def test_the_numbers_of_a_cone_are_parameters_of_the_loop():
    names = loop_of(design()).digital(0.1).step(1).parameters.names
    assert {"controller.cones[0].slope", "controller.cones[0].offset", "controller.cones[0].centre"} <= set(names)


def test_a_safe_command_outside_the_cone_is_refused():
    with pytest.raises(ValueError, match="must keep the cone of T_x, T_y about T_z; it lies 5 outside"):
        loop_of(design(), safe_command={"T_z": 100.0, "T_x": 30.0, "T_y": 0.0})
    safe = loop_of(design(), safe_command={"T_z": 98.1, "T_x": 0.0, "T_y": 0.0}).controller.safe_command
    np.testing.assert_array_equal(safe, [98.1, 0.0, 0.0])


@needs_compiler
@pytest.mark.parametrize("compiler", EACH_COMPILER)
def test_c_has_the_bits_of_the_simulation(compiler, tmp_path):
    loop = loop_of(design()).digital(0.1)
    law = loop.law(truths=STATES)
    y, r, u, z = recorded(loop, law, 60, substeps=1)
    made, memory, flags = compiled(c_code(law, "lander"), tmp_path, compiler)(y, r)
    assert not flags.any()
    assert differing(made, u) == differing(memory, z) == 0
