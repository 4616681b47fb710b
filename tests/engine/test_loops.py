"""Bounded loops in the graph: the same bits on every engine, no copies, and nothing done twice."""

import casadi as ca
import numpy as np
import pytest

from tests.support.compilers import needs_llvmlite
from tests.support.looped_laws import DrawnLoop, InCasadi, predictive_loop, results
from workbench.core import Entry, Layout, Ode, rk4
from workbench.core.bounded_loop import bounded_loop
from workbench.engine import simulate
from workbench.engine.kernel.plan import graph_of
from workbench.report.live.marches import Modules, march

ENGINES = ("numpy", "native")


def equation(seed):
    """x' of two states, made by a drawn loop from them and a parameter."""
    drawn = DrawnLoop(seed)
    states = Layout((Entry("a", np.array(0.4)), Entry("b", np.array(-0.7))))
    parameters = Layout((Entry("p", np.array(0.9)),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    made = [*results(drawn, InCasadi(), [x[0], x[1], p]), x[0] * p]
    rates = {"a": ca.sin(sum(made[::2], ca.SX(0.0))), "b": ca.cos(sum(made[1::2], ca.SX(0.0)))}
    return Ode.of("drawn", states, parameters, (t, x, p), rates, {})


def bits(run):
    return run.x.view(np.uint64)


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
def test_a_predictive_law_has_the_same_bits_in_numpy_and_compiled(arithmetic):
    step = predictive_loop().step(2)
    x0 = np.tile(step.states.default, (3, 1))
    x0[:, 2] += [0.0, 0.1, -0.2]
    span = {"until": 0.2, "every": 0.02, "arithmetic": arithmetic}
    numpy, native = (simulate(step, x0=x0, engine=engine, **span) for engine in ENGINES)
    np.testing.assert_array_equal(bits(numpy), bits(native))
    assert np.abs(native["F"]).max() == 3.0  # a limit acts
    casadi = simulate(step, x0=x0, until=0.2, every=0.02, arithmetic="casadi")
    np.testing.assert_allclose(casadi.x, native.x, rtol=0, atol=1e-9)  # of some 10^4 roundings, which the pole grows


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
@pytest.mark.parametrize("seed", range(10))
def test_a_drawn_loop_has_the_same_bits_in_numpy_and_compiled(seed, arithmetic):
    ode = equation(seed)
    p = ode.parameters.pack({"p": np.linspace(0.5, 1.5, 5)})
    span = {"until": 0.4, "every": 0.1, "arithmetic": arithmetic}
    numpy, native = (simulate(rk4(ode, 0.1), p, engine=engine, **span) for engine in ENGINES)
    np.testing.assert_array_equal(bits(numpy), bits(native))
    casadi = simulate(rk4(ode, 0.1), p, until=0.4, every=0.1, arithmetic="casadi")
    np.testing.assert_allclose(casadi.x, native.x, rtol=1e-10)  # of some 10^4 roundings


@needs_llvmlite
@pytest.mark.parametrize("size", [1, 3, 5])
def test_cutting_a_batch_of_loops_changes_no_bit(size):
    step = predictive_loop().step(1)
    x0 = np.tile(step.states.default, (11, 1))
    x0[:, 2] += np.linspace(-0.3, 0.3, 11)
    span = {"until": 0.2, "every": 0.1}
    whole = simulate(step, x0=x0, **span)
    parts = [simulate(step, x0=x0[i : i + size], **span).x for i in range(0, 11, size)]
    np.testing.assert_array_equal(np.concatenate(parts), whole.x)


@needs_llvmlite
def test_a_browser_has_the_bits_of_a_loop():
    pytest.importorskip("wasmtime")
    from tests.support.wasm_runs import Kernel, unpacked

    step, rows, modules = predictive_loop().step(1), 8, Modules()
    plain = march(step, 1, modules)
    kernel = Kernel(unpacked(next(iter(modules.packed_modules.values()))), plain, rows)
    run = simulate(step, until=rows * 0.02, every=0.02, arithmetic="portable")
    page = kernel.run(step.parameters.default, step.states.default, rows)
    np.testing.assert_array_equal(page.view(np.uint64), bits(run)[0, 1:])


def loops_of(graph):
    """The loops of a graph, the outer ones before those inside them."""
    own = [node.loop for node in graph.nodes if node.loop is not None]
    return [*own, *(inner for loop in own for inner in loops_of(loop.body))]


def test_rows_pass_from_loop_to_loop_without_a_copy():
    graph = graph_of(predictive_loop().step(1))
    for part in (graph, *(loop.body for loop in loops_of(graph))):
        assert not [node for node in part.nodes if node.op == "array"]


def test_what_changes_in_no_pass_is_made_before_a_loop():
    graph = graph_of(predictive_loop().step(1))
    sweep, back, forth = loops_of(graph)
    assert sweep.count == 3
    assert (back.backward, forth.backward) == (True, False)
    products = [node for node in back.body.nodes if node.op in ("mul", "fma", "fms", "fnma")]
    assert len(products) == 16 + 4 + 4 + 1  # closed' p, K' w, B' p and the inverse: A - B K is made once


def test_equal_loops_on_equal_values_are_one():
    graph = graph_of(predictive_loop().step(1))  # command and update both ask for the sweeps
    assert len([node for node in graph.nodes if node.op == "loop"]) == 1


@needs_llvmlite
def test_a_body_may_take_columns_without_entries():
    t, x = ca.SX.sym("t"), ca.SX.sym("x")

    def body(c, empty, row):
        return 0.5 * c + row + ca.sum1(empty), c

    end, rows = bounded_loop(3, body, x, ca.SX(0, 3), ca.SX([[1.0, 2.0, 3.0]]))
    ode = Ode.of(
        "empty", Layout((Entry("x", np.array(0.4)),)), Layout(()), (t, x, ca.SX(0, 1)), {"x": -end + ca.sum2(rows)}, {}
    )
    runs = [
        simulate(rk4(ode, 0.1), until=0.5, engine=engine, arithmetic="portable").x for engine in ("numpy", "native")
    ]
    np.testing.assert_array_equal(*runs)
    value = ca.Function("end", [x], [end])(0.4)
    assert float(value) == 0.5 * (0.5 * (0.5 * 0.4 + 1.0) + 2.0) + 3.0
