"""Every function that a user may write in a law arrives, with one meaning and the same bits on all machines."""

import math

import numpy as np
import pytest

import workbench as wb
from workbench.simulate.kernel.arrays import Arrays
from workbench.simulate.kernel.further_functions import DOUBLE
from workbench.simulate.kernel.target_operations import Number

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


def loop_with(function):
    """A motor with that law, which runs once in a hundredth of a second."""
    loop = wb.ClosedLoop(wb.DCMotor(), controller=Written(function=function), reference=wb.Step("omega", "rad/s", 1.0))
    return loop.digital(0.01)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_law_of_numpys_functions_has_the_bits_of_its_loop_on_every_machine(function):
    result = wb.replay(loop_with(function), periods=400, targets=("numpy", "gcc-O0", "gcc-O2", "clang-O2", "browser"))
    ran = [each for each in result.results if each.ran]  # NumPy is always there
    assert [each.first for each in ran] == [""] * len(ran)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_a_law_in_python_has_the_bits_too(function, tmp_path):
    import importlib.util

    from workbench.handover.recording import record

    sampled = loop_with(function)
    (path,) = wb.export(sampled, "python", tmp_path, name="law")
    spec = importlib.util.spec_from_file_location("written_law", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    run, law = record(sampled, sampled.law(), 200), module.Law()
    for k in range(run.periods):
        commands = law.step({"omega": run.y[k, 0]}, {"omega": run.r[k, 0]})
        assert commands["v"].hex() == float(run.u[k, 0]).hex()


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
        got = np.asarray(DOUBLE.functions[name](*(Number(Arrays(fused), part) for part in x)).value)
    np.testing.assert_array_equal(np.isnan(got), np.isnan(wanted))
    numbers = ~np.isnan(wanted)
    np.testing.assert_allclose(got[numbers], wanted[numbers], rtol=4e-16, atol=5e-324)
    np.testing.assert_array_equal(np.signbit(got[numbers]), np.signbit(wanted[numbers]))
