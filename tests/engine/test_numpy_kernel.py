"""The march in NumPy, against the compiled one and CasADi's."""

import casadi as ca
import numpy as np
import pytest

from studies.paper import laws as paper_laws
from tests.support.arms import arm_instruments
from tests.support.cases import heavy_but
from tests.support.compilers import NATIVE, WITHOUT, needs_llvmlite
from tests.support.equations import with_next
from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import arithmetic, simulate
from workbench.engine.kernel import numpy_kernel
from workbench.engine.metrics import rmse, step_with_metrics, total_variation

LOOPS = {law: paper_laws.rival("FS", law) for law in paper_laws.RIVALS} | {
    "AOSMC-RGS": paper_laws.proposed_repaired("FS")
}
METRICS = (rmse(), total_variation(1e-3))


ARITHMETICS = ["fused", "portable"]


def same_bits(one, other):
    assert one.arithmetic == other.arithmetic
    assert np.isfinite(one.x).all()
    np.testing.assert_array_equal(one.x.view(np.uint64), other.x.view(np.uint64))


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("law", heavy_but(LOOPS, "PID", "SMC"))
def test_numpy_and_the_compiled_march_have_the_same_bits(law, arithmetic):
    # in company, with a number that varies: values made once a run, once a step, and in the loop
    ode = LOOPS[law].ode()
    step = step_with_metrics(ode, METRICS, 1e-3)
    p = ode.parameters.pack({"plant.arm.links[1].mass": np.linspace(0.9, 1.1, 3)})
    span = {"until": 0.01, "every": 0.002, "arithmetic": arithmetic}
    same_bits(*(simulate(step, p, engine=engine, **span) for engine in ("numpy", "native")))


@needs_llvmlite
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_noise_has_the_same_bits_in_numpy(arithmetic):
    noisy = LOOPS["PID"].digital(2e-3, arm_instruments(2, noise_q=1e-4, noise_qd=1e-2)).step(2)
    same_bits(*(simulate(noisy, until=0.02, arithmetic=arithmetic, engine=e, seed=5) for e in ("numpy", "native")))


def probe(expression):
    """A step that turns (x, y) into (x, f(x, y))."""
    states = Layout((Entry("x", np.zeros(1)), Entry("y", np.zeros(1))))
    x = states.symbols()
    ode = Ode.of("probe", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": 0 * x[0], "y": x[0]}, {"e": x[0]})
    step = rk4(ode, 1.0)
    return with_next(step, ca.vertcat(step.rule.x[0], expression(*ca.vertsplit(step.rule.x), step.rule.k)))


OPERATIONS = {
    "sum, difference, product": lambda x, y, k: (x + y) * (x - y) - x * y + k,
    "division": lambda x, y, k: x / (y + 7) - 1 / (2 + x**2),
    "powers": lambda x, y, k: x**3 + y**-2 + (2 + y) ** 0.3,
    "sine and cosine of sums": lambda x, y, k: ca.sin(x + y) + ca.cos(x - y) * ca.sin(x) - ca.cos(y) + ca.tan(x / 9),
    "exp, log, tanh, sqrt": lambda x, y, k: ca.exp(x / 5) + ca.log(9 + y) + ca.tanh(x * y) + ca.sqrt(9 + x),
    "arc tangent": lambda x, y, k: ca.atan2(x, y) + ca.atan2(-y, x),
    "corners": lambda x, y, k: (
        ca.fabs(x) + ca.sign(y) + ca.floor(3 * x) + ca.fmod(7 * x, 3) + ca.fmin(x, y) * ca.fmax(x, 1)
    ),
    "truths": lambda x, y, k: ca.if_else(ca.logic_or(x < y, ca.logic_and(x == 2, y != 1)), x, ca.if_else(y >= 0, 3, y)),
    "constants as truths": lambda x, y, k: (
        ca.logic_or(x > 0, -1) * y + ca.if_else(ca.logic_and(y, 2.0), 2.0, -1.0) * 2.0
    ),
    "negative bases": lambda x, y, k: ca.floor(x) ** ca.floor(y) + (-2.0) ** ca.floor(y) + ca.floor(y) ** 0,
    "remainders": lambda x, y, k: ca.fmod(x, y) + ca.fmod(-3 * x, 0.1) + ca.fmod(y, 1e9),
    "smaller and larger of what is none": lambda x, y, k: ca.fmin(ca.sqrt(x), 2) + ca.fmax(y, ca.log(x)),
    "not": lambda x, y, k: ca.logic_not(x <= y) + 2 * ca.logic_not(x),
}


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("name", OPERATIONS)
def test_an_operation_means_what_it_means_to_casadi_and_has_the_same_bits_everywhere(name, arithmetic):
    step = probe(OPERATIONS[name])
    rng = np.random.default_rng(3)
    starts = np.vstack([rng.uniform(-6, 6, (500, 2)), [[2.0, 1.5], [0.0, 3.0], [1.0, 1.0], [-2.0, -0.5]]])

    def result(engine, name):
        return simulate(step, x0=starts, until=1.0, engine=engine, arithmetic=name).x[:, 1, 1]

    numpy = result("numpy", arithmetic)
    # a few roundings of numbers of size 40 at most
    np.testing.assert_allclose(numpy, result("casadi", "casadi"), rtol=1e-13, atol=1e-13)
    pytest.importorskip("llvmlite", reason=WITHOUT)
    np.testing.assert_array_equal(numpy.view(np.uint64), result("native", arithmetic).view(np.uint64))


@pytest.mark.parametrize("engine", ["numpy", NATIVE])
def test_the_arc_tangent_knows_every_quadrant_axis_and_sign_of_zero(engine):
    step = probe(lambda x, y, k: ca.atan2(x, y))
    special = [0.0, -0.0, 1.0, -1.0, 1e300, -1e300, 1e-300]
    starts = np.array([[y, x] for y in special for x in special])
    angles = np.linspace(-np.pi, np.pi, 4001)
    starts = np.vstack([starts, 5 * np.column_stack([np.sin(angles), np.cos(angles)])])
    got = simulate(step, x0=starts, until=1.0, engine=engine).x[:, 1, 1]
    exact = np.arctan2(starts[:, 0], starts[:, 1])
    # four units in the last place
    np.testing.assert_allclose(got, exact, rtol=9e-16, atol=0)
    np.testing.assert_array_equal(np.signbit(got), np.signbit(exact))


def test_the_lots_of_the_march_change_no_bit(monkeypatch):
    step = step_with_metrics(LOOPS["ASMC"].ode(), METRICS, 1e-3)
    starts = np.tile(step.states.default, (7, 1)) + 0.01 * np.arange(7)[:, np.newaxis]
    whole = simulate(step, x0=starts, until=0.01, every=0.005, engine="numpy").x
    for size in (1, 3, 1000):
        monkeypatch.setattr(numpy_kernel, "RUNS_AT_ONCE", size)
        again = simulate(step, x0=starts, until=0.01, every=0.005, engine="numpy").x
        np.testing.assert_array_equal(again, whole, err_msg=f"{size} at once")


def test_without_a_compiler_one_run_and_many_have_the_bits_of_casadi(monkeypatch):
    def missing(name):
        raise ImportError("No module named 'llvmlite'")

    monkeypatch.setattr(arithmetic, "native", missing)
    step = step_with_metrics(LOOPS["PID"].ode(), METRICS, 1e-3)
    few, many = (np.tile(step.states.default, (n, 1)) for n in (3, 100))
    for starts in (few, many):
        chosen = simulate(step, x0=starts, until=0.02)
        np.testing.assert_array_equal(chosen.x, simulate(step, x0=starts, until=0.02, engine="casadi").x)
    with pytest.raises(ValueError, match=r"engine='native'\)` cannot run here: No module named 'llvmlite'\."):
        simulate(step, until=0.02, engine="native")


@pytest.mark.parametrize("engine", ["numpy", NATIVE])
def test_a_sawtooth_and_a_counter_of_whole_periods_jump_where_they_should(engine):
    states = Layout((Entry("x", np.zeros(4)),))
    x = states.symbols()
    ode = Ode.of("probe", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": 0 * x}, {"e": x[0]})
    step = rk4(ode, 1.0)
    k, q = step.rule.k, ca.SX([49.0, 0.1, 3.0, 7.0])
    saw = ca.vertcat(ca.floor(k / q[0]), ca.fmod(k * 1e-3, q[1]), ca.fmod(k * 0.01, 0.3), ca.floor(k / q[3] + 0.5))
    # steps of states that are parameters to the kernel: the quotient must not come from a reciprocal
    step = with_next(step, saw + 0 * step.rule.x)
    got, true = (simulate(step, until=5000.0, engine=e).x[0, 1:] for e in (engine, "casadi"))
    np.testing.assert_allclose(got, true, rtol=0, atol=1e-13)


@pytest.mark.parametrize("engine", ["numpy", NATIVE])
def test_the_logarithm_of_a_number_without_a_full_mantissa_is_right(engine):
    step = probe(lambda x, y, k: ca.log(x))
    starts = np.column_stack([[5e-324, 1e-310, 2.3e-308, 1e-300], np.zeros(4)])
    got = simulate(step, x0=starts, until=1.0, engine=engine).x[:, 1, 1]
    np.testing.assert_allclose(got, np.log(starts[:, 0]), rtol=4e-16)
