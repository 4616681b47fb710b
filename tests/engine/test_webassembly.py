"""A plan becomes a module that a browser runs, with the bits of the portable arithmetic."""

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.paper.comparison import comparison
from tests.support.wasm_runs import Kernel, unpacked
from workbench.core import runge_kutta_step
from workbench.core.equations import equations_of
from workbench.engine.kernel import llvm, webassembly
from workbench.engine.kernel.plan import KernelPlan
from workbench.engine.metrics.measured_equation import MeasuredEquation
from workbench.report.live.marches import Modules, evaluation, march
from workbench.study.knob import Knob

POSITIONS = 200
STEPS = 240  # with which two hundred positions of seven laws take seconds; each bit of a step decides the next ones
STRANGE = """
declare double @fmin(double, double)
define double @f(double %x) {
  %y = call double @fmin(double %x, double 1.0)
  ret double %y
}"""


def bits(numbers):
    return np.ascontiguousarray(numbers).view(np.uint64)


def opened(step, stride, rows):
    modules = Modules()
    plain = march(step, stride, modules)
    return Kernel(unpacked(next(iter(modules.packed_modules.values()))), plain, rows)


def turned(step, rng):
    """Rows of parameters with every positive number of the loop between half and twice its own, as knobs turn them."""
    p = np.tile(step.parameters.default, (POSITIONS, 1))
    return p * np.where(p > 0, rng.uniform(0.5, 2.0, p.shape), 1.0)


LIGHT = ("SMC", "AOSMC-RGS")  # a law without a memory, and the one with a state observer


@pytest.mark.parametrize(
    "case",
    [case if case.law in LIGHT else pytest.param(case, marks=pytest.mark.heavy) for case in comparison("FS")],
    ids=lambda case: case.law,
)
def test_a_browser_computes_the_bits_of_the_portable_arithmetic_at_two_hundred_positions_of_all_knobs(case):
    step = MeasuredEquation.of(equations_of(case.run.loop, case.name), case.run.metrics).step(case.run.h)
    kernel = opened(step, STEPS // 2, rows=2)
    p = turned(step, np.random.default_rng(18))
    until = STEPS * step.h
    wanted = wb.simulate(step, p, until=until, every=until / 2, arithmetic="portable").x[:, 1:]
    got = np.stack([kernel.run(row, step.states.default, rows=2) for row in p])
    assert np.isfinite(wanted).mean() > 0.99
    # a state that is not finite has no bits worth comparing: simulate writes NaN from there on
    same = (bits(got) == bits(wanted)) | ~np.isfinite(wanted)
    assert same.all()


def test_noise_and_a_computers_period_have_the_same_bits_too():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
    computer = loop.digital(0.01, wb.Instruments.of(motor, noise={"omega": 1e-2}))
    step = computer.step()
    kernel = opened(step, 10, rows=20)
    wanted = wb.simulate(step, until=2.0, every=0.1, seed=5, arithmetic="portable").x[0, 1:]
    assert step.noises
    assert (bits(kernel.run(step.parameters.default, step.states.default, 20, seed=5)) == bits(wanted)).all()


def test_a_row_may_be_longer_than_a_table_of_time():
    step = MeasuredEquation.of(equations_of(comparison("FS")[2].run.loop, "smc"), ()).step(1e-4)
    wanted = wb.simulate(step, until=0.5, every=0.5, arithmetic="portable").x[0, 1:]
    assert (bits(opened(step, 5000, 1).run(step.parameters.default, step.states.default, 1)) == bits(wanted)).all()


def test_outputs_are_made_from_the_states_of_a_kept_time():
    step = MeasuredEquation.of(equations_of(comparison("FS")[0].run.loop, "aosmc"), ()).step(1e-4)
    runs = wb.simulate(step, until=0.1, every=0.01, arithmetic="portable")
    tau = step.outputs.slice("tau")
    kernel = opened(evaluation(step, step.rule.output[tau]), 1, rows=1)
    for row in (0, 4, 10):
        x = np.concatenate([runs.x[0, row], np.zeros(2)])
        got = kernel.run(step.parameters.default, x, 1, begin=100 * row)[0]
        assert (got[: step.states.size] == runs.x[0, row]).all()
        # CasADi's machine takes this platform's sine, and rounds in another order
        assert got[step.states.size :] == pytest.approx(runs["tau"][0, row], rel=1e-9)


def test_the_module_imports_its_memory_alone():
    step = MeasuredEquation.of(equations_of(comparison("FS")[4].run.loop, "fuzzy"), ()).step(1e-4)
    code = webassembly.compile_plan(KernelPlan.of_step(step, ()))
    imports = dict(webassembly._sections(code))[webassembly.IMPORTS]
    assert [*webassembly._imports(imports)] == [webassembly.MEMORY]
    assert len(code) < 150_000


def test_code_that_would_need_a_function_of_the_browser_is_refused_by_its_name():
    with pytest.raises(ValueError, match=r"nothing but memory in a browser; its code needs env\.fmin"):
        webassembly.callable_module(llvm.object_for(STRANGE, webassembly.TRIPLE, webassembly.FEATURES))


def test_a_loop_that_no_graph_can_hold_is_refused_in_one_sentence():
    x = ca.SX.sym("x")
    ode = wb.Ode(
        "odd", wb.layout(x="1"), wb.layout(), wb.layout(), ca.SX.sym("t"), x, ca.SX(0, 1), ca.erf(x), ca.SX(0, 1)
    )
    with pytest.raises(ValueError, match="has the operation ERF"):
        march(wb.rk4(ode, 0.1), 1, Modules())


def test_a_knob_knows_its_places_its_range_and_its_bounds():
    step = MeasuredEquation.of(equations_of(comparison("FS")[2].run.loop, "smc"), ()).step(1e-3)
    phi = Knob("phi", "controller.phi", 1e-3, 0.5, log=True)
    assert [step.parameters.labels[i] for i in phi.places(step)] == ["controller.phi"]
    assert phi.unit(step) == "rad/s"
    assert Knob("all of K", "controller.K", 0.5, 2.0, share=True).unit(step) == "1"
    with pytest.raises(ValueError, match="'phi' goes from -1 to 1, too far"):
        Knob("phi", "controller.phi", -1.0, 1.0).places(step)
    with pytest.raises(ValueError, match="0 < low < high; got 0 and 1"):
        Knob("phi", "controller.phi", 0.0, 1.0, log=True)
    with pytest.raises(ValueError, match="low < high; got 2 and 1"):
        Knob("phi", "controller.phi", 2.0, 1.0)


@pytest.mark.parametrize("method", ["stabilised", "restarted"])
def test_a_method_that_pilots_choose_has_the_same_bits_in_a_browser(method):
    flow = equations_of(comparison("FS")[2].run.loop, "smc")
    step = runge_kutta_step(flow, 5e-4, method)
    wanted = wb.simulate(step, until=0.5, every=0.05, arithmetic="portable").x[0, 1:]
    p, x0 = step.parameters.default, step.states.default
    assert (bits(opened(step, 100, 10).run(p, x0, 10)) == bits(wanted)).all()
