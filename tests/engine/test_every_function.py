"""Every function that a user may write in a law arrives, with one meaning and the same bits on all machines."""

import math

import numpy as np
import pytest

import workbench as wb
from tests.support.cases import heavy_but
from workbench.engine.machines.further_elementary_functions import DOUBLE
from workbench.engine.machines.machine import MachineNumber
from workbench.engine.machines.numpy_spelling import Arrays

FUNCTIONS = {
    "ceil": lambda x: np.ceil(3 * x),
    "arctan": lambda x: np.arctan(x),
    "arcsin": lambda x: np.arcsin(0.9 * np.tanh(x)),
    "arccos": lambda x: np.arccos(0.9 * np.tanh(x)),
    "sinh": lambda x: np.sinh(x),
    "cosh": lambda x: np.cosh(x),
    "arcsinh": lambda x: np.arcsinh(x),
    "arccosh": lambda x: np.arccosh(1.5 + x * x),
    "arctanh": lambda x: np.arctanh(0.9 * np.tanh(x)),
    "log1p": lambda x: np.log1p(x * x),
    "expm1": lambda x: np.expm1(x),
    "hypot": lambda x: np.hypot(x, x - 1.3),
    "copysign": lambda x: np.copysign(x + 0.3, x - 1.0),
}


@wb.block
class Written(wb.Controller):
    """v = k f(e) + z, z' = e, with e = omega_ref - omega and a function f of NumPy."""

    k: float = wb.parameter(default=0.7, unit="V")
    z: float = wb.initial(default=0.0, unit="rad")
    function: str = "arctan"

    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        e = ref.omega - est.omega
        return {"v": self.k * FUNCTIONS[self.function](e) + z.z}

    def rate(self, t, z, est, ref):
        return {"z": ref.omega - est.omega}


@wb.block
class EveryFunction(wb.Controller):
    """v = k e + z, z[j+1] = z[j] + e / 10; and of each function of NumPy its value at e, which the law remembers."""

    k: float = wb.parameter(default=0.7, unit="V s/rad")

    memory = wb.layout(z="V", **dict.fromkeys(FUNCTIONS, "1"))
    reads = follows = wb.layout(omega="rad/s")
    drives = wb.layout(v="V")

    def command(self, t, z, est, ref):
        return {"v": self.k * (ref.omega - est.omega) + z.z}

    def update(self, t, z, est, ref):
        e = ref.omega - est.omega
        return {"z": z.z + 0.1 * e} | {name: function(e) for name, function in FUNCTIONS.items()}


MACHINES = [["numpy", "gcc-O0"], ["gcc-O2", "clang-O2", "browser"]]


@pytest.fixture(scope="module")
def all_functions():
    """A motor with the law of every function, which runs once in a hundredth of a second and reads with noise."""
    motor = wb.DCMotor()
    loop = wb.ClosedLoop(motor, controller=EveryFunction(), reference=wb.Sines("omega", "rad/s", 2.0, 3.0))
    return loop.digital(0.01, wb.Instruments.of(motor, noise={"omega": 0.3}))


@pytest.mark.parametrize("targets", heavy_but(MACHINES, MACHINES[0]), ids=" ".join)
def test_every_function_of_a_law_has_the_bits_of_its_loop_on_every_machine(all_functions, targets):
    """The memory is compared at each instant: a difference names the entry, and so the function."""
    result = wb.replay(all_functions, periods=200, targets=targets)
    ran = [each for each in result.results if each.ran]
    assert [each.first for each in ran] == [""] * len(ran)
    assert {each.memories for each in ran} == {0}


def test_every_function_of_a_law_in_python_has_the_bits_too(all_functions, tmp_path):
    import importlib.util

    from workbench.handover.recording import record

    (path,) = wb.export(all_functions, "python", tmp_path, name="law")
    spec = importlib.util.spec_from_file_location("written_law", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    run, law = record(all_functions, all_functions.law(), 300), module.Law()
    names = run.law.memory.names
    for k, wanted in enumerate(run.memory(1, run.periods)):
        commands = law.step({"omega": run.y[k, 0]}, {"omega": run.r[k, 0]})
        assert commands["v"].hex() == float(run.u[k, 0]).hex()
        differing = [n for n, value in zip(names, wanted, strict=True) if law.memory[n].hex() != float(value).hex()]
        assert not differing, k


@pytest.mark.parametrize("function", FUNCTIONS)
def test_the_kernels_agree_with_casadi(function):
    ode = wb.ClosedLoop(
        wb.DCMotor(), controller=Written(function=function), reference=wb.Step("omega", "rad/s", 1.0)
    ).ode()
    step = wb.rk4(ode, 0.01)
    states = {a: wb.simulate(step, until=1.0, arithmetic=a).x[0, -1] for a in ("fused", "portable")}
    x = step.states.default
    for k in range(100):
        x = np.asarray(step.F(k, x, step.parameters.default, [])).ravel()
    for found in states.values():
        np.testing.assert_allclose(found, x, rtol=1e-11, atol=1e-12)  # a hundred steps of some roundings


SPECIAL = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 5e-324, -5e-324, 1e-310, 1e308, -1e308, 2.0, -2.0, 0.5]
OF_NUMPY = {"asinh": np.arcsinh, "acosh": np.arccosh, "atanh": np.arctanh}


@pytest.mark.parametrize("fused", [True, False])
@pytest.mark.parametrize("name", DOUBLE.functions)
def test_special_numbers_are_those_of_c99(name, fused):
    x = [np.array(SPECIAL)] if name not in ("hypot", "copysign") else [g.ravel() for g in np.meshgrid(SPECIAL, SPECIAL)]
    with np.errstate(all="ignore"):
        wanted = OF_NUMPY.get(name, getattr(np, name, None))(*x)
        got = np.asarray(DOUBLE.functions[name](*(MachineNumber(Arrays(fused), part) for part in x)).value)
    np.testing.assert_array_equal(np.isnan(got), np.isnan(wanted))
    numbers = ~np.isnan(wanted)
    np.testing.assert_allclose(got[numbers], wanted[numbers], rtol=4e-16, atol=5e-324)
    np.testing.assert_array_equal(np.signbit(got[numbers]), np.signbit(wanted[numbers]))
