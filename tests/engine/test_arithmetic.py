"""An arithmetic is a name for bits: the same in both kernels, on every machine, in whatever follows a run."""

import hashlib
import os
import platform
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from tests.support.cases import heavy_but
from tests.support.equations import decay, oscillator
from workbench.core import Entry, Layout, Ode, rk4
from workbench.engine import arithmetic, simulate
from workbench.engine.arithmetic import advance_states
from workbench.engine.kernel.lowering import lower
from workbench.engine.kernel.plan import KernelPlan, graph_of
from workbench.engine.metrics import measure, rmse

GRAPH = ["fused", "portable"]


def zoo():
    """Three states that meet every operation of a graph."""
    states, parameters = Layout((Entry("x", np.zeros(3)),)), Layout((Entry("p", np.array([0.75, 1.5])),))
    t, x, p = ca.SX.sym("t"), states.symbols(), parameters.symbols()
    a, b, c = ca.vertsplit(x)
    bend = ca.fmin(a, b) * ca.fmax(c, 0.25) + ca.sign(b) * ca.floor(2 * c) / 8 + ca.fmod(3 * a, 0.7)
    smooth = ca.atan2(a, 1 + b**2) - ca.exp(-(c**2)) + ca.log(2 + ca.fabs(a)) - ca.sqrt(1 + b**2) + (2 + c**2) ** 0.3
    turn = ca.tanh(c) - ca.sin(a + p[0] * t) - ca.cos(a) * b * p[1] - ca.sin(p[0] * t) / p[1]
    way = ca.if_else(ca.logic_or(a < b, ca.logic_and(c <= 0, ca.logic_not(a == 1))), c, ca.if_else(b != 0, a, b)) * b
    rates = {"x": ca.vertcat(b, turn, smooth + bend + way)}
    return Ode.of("zoo", states, parameters, (t, x, p), rates, {"x": x})


def noisy(step):
    """The same step with a state beside it that is driven by noise."""
    walk = Layout((Entry("walk", np.zeros(2)),))
    rule = replace(step.rule, w=ca.SX.sym("w", 2))
    now = walk.symbols()
    return replace(step, rule=rule).with_memory(walk, now, now + rule.w * ca.cos(rule.x[0]))


STARTS = np.array([[0.5, -0.25, 0.125, 0.0, 0.0], [2.0, 0.0, -1.5, 0.0, 0.0], [-3.0, 1.0, 0.375, 1.0, -1.0]])
STEP = noisy(rk4(zoo(), 2.0**-7))
SPAN = {"x0": STARTS, "until": 40 * 2.0**-7, "every": 10 * 2.0**-7, "seed": 7}


@cache
def digest(name, engine, span=40):
    runs = simulate(STEP, arithmetic=name, engine=engine, **SPAN | {"until": span * STEP.h})
    assert np.isfinite(runs.x).all()
    return hashlib.sha256(runs.x.tobytes()).hexdigest()[:16]


# The second version meets switches, of which there is none here.
BITS = {
    (name, version): digest
    for name, digest in (("fused", "c1c9f183141d30f0"), ("portable", "97ad58b06e7ac51b"))
    for version in (1, 2)
}


@pytest.mark.parametrize("engine", heavy_but(["numpy", "native"], "native"))
@pytest.mark.parametrize("name", GRAPH)
def test_the_bits_of_an_arithmetic_change_with_its_version_alone(name, engine):
    if engine == "native":
        pytest.importorskip("llvmlite")
    found = digest(name, engine)
    assert BITS.get((name, arithmetic.VERSION)) == found, (
        f"The bits of '{name}' are others, {found}: raise `VERSION` in workbench/engine/arithmetic.py, so that no "
        "ledger mixes them with those it has, and write them down here."
    )


WITHOUT = """
import sys
sys.modules["llvmlite"] = None
import numpy as np
from tests.engine import test_arithmetic as here
from workbench.engine import arithmetic, simulate
print(*(here.digest(name, None, 10) for name in here.GRAPH))
print(arithmetic.default_for(here.STEP), simulate(here.STEP, **here.SPAN).arithmetic)
many = np.tile(here.STARTS, (50, 1))
print(simulate(here.STEP, x0=many, until=here.STEP.h).arithmetic)
"""


@pytest.mark.heavy
def test_without_a_compiler_a_named_arithmetic_has_the_same_bits_and_the_default_says_its_name():
    call = [sys.executable, "-c", WITHOUT]
    env = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(call, env=env, capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout.split() == [*(digest(name, "numpy", 10) for name in GRAPH), "casadi", "casadi", "casadi"]


def test_a_signature_holds_all_that_the_bits_depend_on():
    assert arithmetic.signature("fused") == f"fused {arithmetic.VERSION}"
    assert arithmetic.signature("portable") == f"portable {arithmetic.VERSION}"
    parts = arithmetic.signature("casadi").split()
    assert parts == ["casadi", ca.CasadiMeta.version(), platform.system(), platform.machine()]
    with pytest.raises(ValueError, match="is one of 'fused', 'portable', 'casadi'; got 'exact'"):
        arithmetic.signature("exact")


def unknown():
    """A step that no graph holds."""
    states = Layout((Entry("x", np.array([0.5])),))
    x = states.symbols()
    return rk4(Ode.of("odd", states, Layout(), (ca.SX.sym("t"), x, ca.SX(0, 1)), {"x": ca.erf(x)}, {"e": x}), 0.1)


@pytest.mark.parametrize(
    ("step", "names", "why"),
    [
        (
            STEP,
            {"arithmetic": "quick"},
            r"`simulate\(arithmetic=...\)` is one of 'fused', 'portable', 'casadi'; got 'quick'",
        ),
        (STEP, {"arithmetic": ["fused"]}, r"must be text or None; got \['fused'\]"),
        (STEP, {"arithmetic": "fused", "engine": "casadi"}, "that the engine has: 'casadi'. Leave one of the two"),
        (STEP, {"arithmetic": "casadi", "engine": "numpy"}, "that the engine has: 'portable' or 'fused'. Leave"),
        (unknown(), {"arithmetic": "portable"}, r"arithmetic='portable'\)` cannot run this step: .* the operation ERF"),
        (unknown(), {"engine": "numpy"}, r"engine='numpy'\)` cannot run this step: .* the operation ERF"),
    ],
)
def test_what_there_is_not_is_refused_by_name(step, names, why):
    with pytest.raises(ValueError, match=why):
        simulate(step, until=step.h, **names)


def test_a_step_that_no_graph_holds_has_casadis_arithmetic():
    assert arithmetic.default_for(unknown()) == "casadi"
    assert simulate(unknown(), until=1.0).arithmetic == "casadi"


def test_a_processor_that_fuses_nothing_compiles_the_portable_arithmetic(monkeypatch):
    llvm = pytest.importorskip("workbench.engine.kernel.llvm")
    monkeypatch.setattr(llvm, "has_fma", lambda: False)
    step = rk4(oscillator(), 0.01)
    assert arithmetic.default_for(step) == simulate(step, until=0.1).arithmetic == "portable"
    assert simulate(step, until=0.1, arithmetic="fused").arithmetic == "fused"  # by NumPy
    with pytest.raises(ValueError, match="cannot run here: this processor has no fused multiply-add"):
        simulate(step, until=0.1, arithmetic="fused", engine="native")


def test_the_code_of_the_portable_arithmetic_has_no_fused_product_and_no_call_of_a_library():
    plan = KernelPlan.of(graph_of(STEP), ())
    fused, portable = (
        {line.split("@")[1].split("(")[0] for line in lower(plan, 4, of).splitlines() if " call " in line}
        for of in (True, False)
    )
    assert fused - portable == {"llvm.fma.v4f64"}
    exact = ("llvm.sqrt", "llvm.fabs", "llvm.floor", "llvm.trunc", "llvm.copysign", "llvm.vector.reduce.or")
    assert all(name.startswith((*exact, "workbench_")) for name in portable)
    assert not any(flag in lower(plan, 4, False) for flag in ("contract", "fast", "reassoc", "fmuladd"))


def test_a_browser_needs_no_library_for_the_portable_arithmetic():
    llvm = pytest.importorskip("llvmlite.binding")
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    browser = llvm.Target.from_triple("wasm32-unknown-unknown").create_target_machine(opt=2, features="+simd128")
    module = llvm.parse_assembly(
        lower(KernelPlan.of(graph_of(STEP), ()), 2, False).replace('alignstack(64) "stackrealign"', "")
    )
    module.triple, module.data_layout = browser.triple, str(browser.target_data)
    assembly = browser.emit_assembly(module)
    assert "workbench_piece" in assembly
    assert "workbench_table" in assembly
    assert not [line for line in assembly.splitlines() if line.split()[:1] in (["call"], ["call_indirect"])]


@pytest.mark.parametrize("name", GRAPH)
def test_what_follows_a_run_has_its_arithmetic(name):
    runs = simulate(STEP, arithmetic=name, **SPAN)
    np.testing.assert_array_equal(advance_states(runs.job, runs.x[:, 2], 20, 20), runs.x[:, -1])


@pytest.mark.parametrize("name", ["portable", "casadi"])
def test_a_measurement_has_one_arithmetic_throughout(name):
    found = measure(decay(), [rmse()], until=1.0, h=0.01, arithmetic=name)
    chosen = measure(decay(), [rmse()], until=1.0, tolerance=1e-3, arithmetic=name)
    assert found.trajectories.arithmetic == chosen.trajectories.arithmetic == name
