"""States that no step reads: a kernel makes them where it keeps a row, with the bits of a run that keeps each one."""

import casadi as ca
import numpy as np
import pytest

from tests.support.compilers import needs_llvmlite
from tests.support.looped_laws import predictive_loop
from workbench.core import Entry, Layout, Ode, rk4
from workbench.core.bounded_loop import bounded_loop
from workbench.engine import simulate
from workbench.engine.kernel.kept_rows import nodes_of_steps, states_of_rows
from workbench.engine.kernel.plan import KernelPlan

pytestmark = needs_llvmlite
NUMBERS = np.linspace(0.1, 1.2, 12)


def names_of_rows(step):
    plan = KernelPlan.of_step(step, ())
    return {step.states.labels[i].removesuffix("[0]") for i in states_of_rows(plan)}, plan


def test_estimates_that_are_held_are_made_in_rows_alone():
    step = predictive_loop().step(1)
    own, plan = names_of_rows(step)
    assert own >= {"hold.x_hat", "hold.xd_hat", "hold.phi_hat", "hold.phid_hat"}
    assert not own & {"plant.x", "plant.phi", "controller.y"}
    assert set(nodes_of_steps(plan)) < set(plan.inside)


@pytest.mark.parametrize("runs", [1, 3, 20])
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
def test_rows_have_the_same_bits_however_many_are_kept(runs, arithmetic):
    step = predictive_loop().step(1)
    x0 = np.tile(step.states.default, (runs, 1))
    x0[:, 2] += np.linspace(-0.2, 0.2, runs)
    each, few = (simulate(step, x0=x0, until=0.4, every=every, arithmetic=arithmetic).x for every in (0.02, 0.2))
    np.testing.assert_array_equal(each[:, ::10].view(np.uint64), few.view(np.uint64))


def system(rates, x, start):
    states = Layout(tuple(Entry(f"x{i}", np.array(value)) for i, value in enumerate(start)))
    named = {f"x{i}": rate for i, rate in enumerate(rates)}
    return rk4(Ode.of("loops", states, Layout(()), (ca.SX.sym("t"), x, ca.SX(0, 1)), named, {}), 0.1)


def same_bits(step):
    span = {"until": 1.0, "every": 0.5, "arithmetic": "portable"}
    numpy, native = (simulate(step, engine=engine, **span).x for engine in ("numpy", "native"))
    np.testing.assert_array_equal(numpy.view(np.uint64), native.view(np.uint64))
    return native


def test_loops_read_what_another_one_carries():
    x = ca.SX.sym("x", 2)
    (carried,) = bounded_loop(2, lambda c: (0.5 * c + x[0],), ca.vertcat(x, 0.3))
    first, _ = bounded_loop(3, lambda c, row: (c + row, c), ca.SX(0.0), carried.T)
    second, _ = bounded_loop(2, lambda c, row: (c - 0.2 * row, c), x[1], carried[1:].T)

    def inner(c, numbers):
        return (bounded_loop(3, lambda d, row: (0.5 * d + row,), c, numbers.T)[0],)

    (third,) = bounded_loop(2, inner, x[1], constants=(carried,))
    end = same_bits(system([-first, -second - third], x, (0.4, -0.7)))
    a, b, c = (0.25 * part + 1.5 * x[0] for part in (x[0], x[1], ca.SX(0.3)))
    twice = x[1]
    for part in (a, b, c, a, b, c):
        twice = 0.5 * twice + part
    plain = system([-(a + b + c), -(x[1] - 0.2 * (b + c)) - twice], x, (0.4, -0.7))
    np.testing.assert_allclose(end, simulate(plain, until=1.0, every=0.5).x, rtol=1e-12)  # of some 100 roundings


@pytest.mark.parametrize("runs", [1, 3])
@pytest.mark.parametrize("arithmetic", ["fused", "portable"])
def test_parameters_that_a_loop_reads_are_a_table_unless_they_vary(runs, arithmetic):
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 1), ca.SX.sym("p", 12)
    end, _ = bounded_loop(6, lambda c, row: (c + row[0] * ca.sin(row[1] * x), c), ca.SX(0.0), ca.reshape(p, 2, 6))
    states, parameters = (Layout((Entry(name, value),)) for name, value in (("x", np.array(0.4)), ("p", NUMBERS)))
    step = rk4(Ode.of("table", states, parameters, (t, x, p), {"x": -end}, {}), 0.1)
    values = step.parameters.pack({"p": np.tile(NUMBERS, (runs, 1))})
    values[:, 3] += np.arange(runs)
    plan = KernelPlan.of_step(step, () if runs == 1 else (3,))
    assert [*plan.entries_of_tables.values()] == ([list(range(12))] if runs == 1 else [])
    span = {"until": 1.0, "every": 0.5, "arithmetic": arithmetic}
    numpy, native = (simulate(step, values, engine=engine, **span).x for engine in ("numpy", "native"))
    np.testing.assert_array_equal(numpy.view(np.uint64), native.view(np.uint64))
    casadi = simulate(step, values, until=1.0, every=0.5, arithmetic="casadi").x
    np.testing.assert_allclose(native, casadi, rtol=1e-12)  # of some 100 roundings
