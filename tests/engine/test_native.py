"""The compiled march against CasADi's machine, and against itself in other company."""

import casadi as ca
import numpy as np
import pytest

from tests.support.cases import heavy_but
from tests.support.equations import decay, explosion, oscillator, turning, with_next
from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import simulate
from workbench.engine.job import Job
from workbench.engine.kernel.graph import Level
from workbench.engine.kernel.lowering import lower
from workbench.engine.kernel.plan import KernelPlan, graph_of
from workbench.engine.metrics import rmse, step_with_metrics, total_variation

pytest.importorskip("llvmlite")  # there is no wheel of it for some platforms, where CasADi's machine serves

from studies.paper import laws as paper_laws
from workbench.engine.kernel import native

LOOPS = {law: paper_laws.rival("FS", law) for law in paper_laws.RIVALS} | {
    "AOSMC-RGS": paper_laws.proposed_repaired("FS"),
    "AOSMC-RGS on square waves": paper_laws.proposed_repaired("SS"),
}


@pytest.mark.parametrize("law", heavy_but(LOOPS, "PID", "SMC"))
def test_the_compiled_loop_follows_casadis_machine(law):
    step = step_with_metrics(LOOPS[law].ode(), (rmse(), total_variation(1e-3)), 1e-4)
    compiled, casadi = (simulate(step, until=0.2, every=0.05, engine=e) for e in ("native", "casadi"))
    scale = 1 + np.abs(casadi.x).max(axis=1, keepdims=True)
    # rounding, carried through 2,000 steps of a loop whose fastest mode is 3e4 1/s and stable
    assert (np.abs(compiled.x - casadi.x) / scale).max() < 1e-11


def job(step, runs):
    return Job(step, np.zeros((runs, step.parameters.size)), 1, 0, np.arange(runs))


FUNCTIONS = {
    "sin": (ca.sin, np.sin, np.linspace(-300, 300, 4001)),
    "cos": (ca.cos, np.cos, np.linspace(-300, 300, 4001)),
    "exp": (ca.exp, np.exp, np.linspace(-50, 50, 4001)),
    "tanh": (ca.tanh, np.tanh, np.linspace(-25, 25, 4001)),
    "log": (ca.log, np.log, np.logspace(-30, 30, 4001)),
    "sqrt": (ca.sqrt, np.sqrt, np.logspace(-30, 30, 4001)),
    "fabs": (ca.fabs, np.fabs, np.linspace(-3, 3, 101)),
    "sign": (ca.sign, np.sign, np.linspace(-3, 3, 101)),
    "floor": (ca.floor, np.floor, np.linspace(-3, 3, 101)),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_elementary_function_is_right_to_the_last_bits(name):
    symbolic, exact, points = FUNCTIONS[name]
    states = Layout((Entry("x", np.zeros(1)), Entry("y", np.zeros(1))))
    x = states.symbols()
    ode = Ode.of("probe", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": 0 * x[0], "y": x[0]}, {"e": x[0]})
    step = rk4(ode, 1.0)
    step = with_next(step, ca.vertcat(step.rule.x[0], symbolic(step.rule.x[0])))
    starts = np.column_stack([points, np.zeros_like(points)])
    y = simulate(step, x0=starts, until=1.0, engine="native").x[:, 1, 1]
    # four units in the last place of the result, or of one where the argument itself is rounded near a zero
    np.testing.assert_allclose(y, exact(points), rtol=9e-16, atol=3e-16 if name in ("sin", "cos") else 0)


@pytest.mark.parametrize("size", [1e5, 1e7, 1e9, 1e12])
def test_the_sine_of_a_large_angle_is_right_to_the_last_bits(size):
    angles = np.random.default_rng(4).uniform(-size, size, 4001)
    # NumPy's own sine and cosine are right to a unit in the last place at any angle
    for symbolic, exact in ((ca.sin, np.sin), (ca.cos, np.cos)):
        step = rk4(turning(0.0), 1.0)
        step = with_next(step, ca.vertcat(step.rule.x[0], symbolic(step.rule.x[0])))
        x = np.empty((4001, 2, 2))
        x[:, 0] = np.column_stack([angles, 0 * angles])
        native.march(job(step, 4001), x, lambda done: None)
        np.testing.assert_allclose(x[:, 1, 1], exact(angles), rtol=9e-16, atol=3e-16)


def test_an_angle_beyond_the_reduction_has_no_sine_rather_than_a_wrong_one():
    step = rk4(turning(0.0), 0.1)
    x = np.array([[[2e12, 0.0], [0.0, 0.0]]])
    native.march(job(step, 1), x, lambda done: None)
    assert np.isnan(x[0, 1, 1])


@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
@pytest.mark.parametrize("every", [None, 0.5, 20.0])
def test_a_run_beyond_the_reach_of_its_arithmetic_has_diverged_and_no_other_goes_on_with_it(every, arithmetic):
    # the angle passes 1e12 rad at t = 10
    step = rk4(turning(1e11), 1e-2)
    run = simulate(step, until=20.0, every=every, engine="native", arithmetic=arithmetic)
    assert run.diverged_at[0] == pytest.approx(10.0, abs=0.021)
    assert not np.isfinite(run.x[0, run.t >= run.diverged_at[0]]).any()
    assert not simulate(step, until=20.0, every=every, engine="casadi").has_diverged.any()


@pytest.mark.heavy
def test_a_bounded_run_is_not_called_diverged_when_its_angle_passes_a_million_radians():
    step = rk4(turning(1e4), 1e-3)
    compiled, casadi = (simulate(step, until=120.0, every=10.0, engine=e) for e in ("native", "casadi"))
    assert not compiled.has_diverged.any()
    # rounding of an angle of 1e6 rad, 1e-10, at each of a hundred thousand steps of a sum
    np.testing.assert_allclose(compiled.x, casadi.x, rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize("every", [None, 0.1, 2.0])
def test_the_time_of_divergence_does_not_depend_on_the_engine(every):
    step = rk4(explosion(), 1e-3)
    starts = np.array([[1.0], [0.1], [3.0]])
    compiled, casadi = (simulate(step, x0=starts, until=2.0, every=every, engine=e) for e in ("native", "casadi"))
    np.testing.assert_array_equal(compiled.diverged_at, casadi.diverged_at)


def test_a_stride_longer_than_a_call_of_the_engine_changes_no_bit():
    step = rk4(oscillator(), 1e-4)
    for engine in ("native", "casadi"):
        often, once = (simulate(step, until=5.0, every=every, engine=engine) for every in (1e-1, 5.0))
        np.testing.assert_array_equal(often.x[:, -1], once.x[:, -1])


def test_a_diverging_neighbour_in_the_same_vector_changes_no_bit():
    ode = explosion()
    step = rk4(ode, 1e-3)
    quiet = np.full((7, 1), 0.2)
    beside = simulate(step, x0=np.vstack([quiet, [[5.0]]]), until=1.0, every=0.1, engine="native")
    alone = simulate(step, x0=quiet, until=1.0, every=0.1, engine="native")
    np.testing.assert_array_equal(beside.x[:7], alone.x)
    assert beside.has_diverged[7]
    assert beside.diverged_at[7] == pytest.approx(0.2, abs=0.01)


def test_an_operation_that_no_kernel_knows_is_named_and_left_to_casadi():
    states = Layout((Entry("x", np.array([0.5])),))
    x = states.symbols()
    ode = Ode.of("odd", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": ca.erf(x)}, {"e": x})
    step = rk4(ode, 0.1)
    with pytest.raises(ValueError, match=r"cannot run this step: The step of 'odd' has the operation ERF"):
        simulate(step, until=1.0, engine="native")
    np.testing.assert_array_equal(simulate(step, until=1.0).x, simulate(step, until=1.0, engine="casadi").x)


def test_an_engine_of_another_name_is_refused():
    with pytest.raises(ValueError, match="is one of 'native', 'numpy', 'casadi'; got 'fast'"):
        simulate(rk4(decay(), 0.1), until=1.0, engine="fast")


def test_a_value_is_made_where_it_changes_and_no_further_in():
    ode = LOOPS["SMC"].ode()
    graph = graph_of(rk4(ode, 1e-3))
    varied = ode.parameters.indices("controller.phi")
    plan = KernelPlan.of(graph, varied)
    moving = graph.after("p", set(varied))
    assert all(graph.levels[place] is Level.PARAMETERS for place in plan.per_run)
    assert all(graph.levels[place] is Level.TIME and place not in moving for place in plan.per_step)
    assert all(graph.levels[place] is Level.STATE or place in moving for place in plan.inside)
    # the reference and the disturbance are functions of time, 1 / phi of a parameter: none is in the loop
    inside = [graph.nodes[place] for place in plan.inside]
    assert not any(node.op == "inv" and graph.nodes[node.operands[0]].op == "p" for node in inside)
    assert plan.lanes
    assert plan.table


def test_the_ir_has_no_call_but_to_intrinsics_and_its_own_functions():
    text = lower(KernelPlan.of(graph_of(rk4(LOOPS["RBF-ASMC"].ode(), 1e-3)), ()), 4)
    calls = {line.split("@")[1].split("(")[0] for line in text.splitlines() if " call " in line}
    assert calls
    assert all(name.startswith(("llvm.", "workbench_")) for name in calls)


def test_a_step_and_its_half_are_one_kernel():
    ode = LOOPS["AOSMC-RGS"].ode()
    metrics = (rmse(), total_variation(1e-3))
    texts = {lower(KernelPlan.of(graph_of(step_with_metrics(ode, metrics, h)), ()), 8) for h in (1e-4, 5e-5)}
    assert len(texts) == 1
