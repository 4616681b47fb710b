"""A law in other forms: a module of Python, a CasADi function, the matrices of a linear one."""

import ast
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import rival
from tests.support.c_runs import compiled, differing, needs_compiler, recorded
from tests.support.law_forms import Record, agree, flat, of, pid, record, replayed
from workbench.blocks.loop import AbstractController, ClosedLoop
from workbench.core import Entry, Layout, block, layout, parameter
from workbench.handover.c99.c_files import c_code
from workbench.handover.programs.casadi_law import casadi_law
from workbench.handover.programs.linear_law import as_control
from workbench.handover.programs.python_law import python_law
from workbench.handover.wrappers.ros2 import ros2
from workbench.handover.wrappers.simulink import simulink

MOTOR = wb.DCMotor()
STEP = wb.Step("omega", "rad/s", 1.0)


def test_python_and_the_simulation_have_the_same_bits(tmp_path):
    """Behind instruments, in a Python of its own; every law on exact readings is in tests/testing."""
    loop = rival("FS", "PID")
    instruments = wb.Instruments.of(loop.plant, noise={"q": 1e-4}, quantum={"q": 1e-4}, limit={"tau": (-80.0, 80.0)})
    run = record(loop, 1e-3, 100, instruments, delay=True)
    assert len(run.commands) == 100
    agree(run, replayed(run, python_law(run.law), tmp_path))


def test_a_law_with_settings_of_ones_own_has_the_bits_of_that_law(tmp_path):
    """What a module is given at its start is what the law is made with."""
    soft, hard = (pid(Tt=1.0, low=-limit, high=limit, anti_windup="back-calculation") for limit in (5.0, 20.0))
    run, other = record(soft, 0.01, 200), record(hard, 0.01, 200)
    settings = of(run.law.parameters, run.law.parameters.default)
    agree(run, replayed(run, python_law(other.law), tmp_path, settings))


@block
class Odd(AbstractController):
    """A law of all operations: quotients by zero and functions at their edges are part of it."""

    reads = follows = layout(omega="rad/s")
    drives = layout(v="V")
    gain: float = parameter(2.0, unit="V s/rad")

    def command(self, t, z, est, ref):
        """A voltage."""
        e, w = 40.0 * (ref.omega - est.omega), est.omega
        wild = (
            ca.fmod(e, 0.7) + ca.atan2(e, w) + ca.tanh(e) + ca.exp(-e * e) + ca.log(1.0 + e * e) + ca.sqrt(ca.fabs(e))
        )
        signs = ca.sign(e) + ca.floor(3.0 * e) + ca.if_else(ca.logic_and(e > 0.1, w < 0.9), e, -w) + (w == 0)
        edges = ca.if_else(w == 0, 0.0, ca.fmin(1.0 / w, 5.0)) + ca.fmax(
            ca.logic_not(e > w), ca.logic_or(e > 1, w > 0.5)
        )
        return {"v": self.gain * (wild + signs + edges) + ca.sin(t) * (t != 0.02)}


def test_every_operation_has_the_same_bits_in_python(tmp_path):
    run = record(ClosedLoop(MOTOR, controller=Odd(), reference=STEP), 0.01, 300)
    assert run.law.uses_time
    agree(run, replayed(run, python_law(run.law), tmp_path))


def test_the_module_of_python_gives_what_is_safe_where_a_number_is_not_finite(tmp_path):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=1.0, Ki=2.0)
    run = record(ClosedLoop(MOTOR, controller=law, reference=STEP), 0.01, 4)
    run.readings[1], run.references[2] = np.nan, np.inf
    told = replayed(run, python_law(run.law, safe={"v": 3.0}), tmp_path)
    assert [flags for *_, flags in told] == [0, 1, 2, 0]
    assert told[1][0] == told[2][0] == of(run.law.commands, np.array([3.0]))
    assert told[0][1] == told[1][1] == told[2][1]  # the memory waits


def test_the_module_of_python_takes_a_safe_command_of_several_numbers_as_c_does():
    law, safe = rival("FS", "PID").digital(1e-3).law("built in"), {"tau": [0.5, -0.25]}
    assert '"tau": [0.5, (-0.25)],' in python_law(law, safe=safe)
    assert c_code(law, "law", safe=safe).safe.tolist() == safe["tau"]


def test_text_from_outside_stays_text_in_every_form():
    law = record(pid(), 0.01, 1).law
    bad = 'x"""\nimport os\n*/ // --> \\ $name %s {0}'
    with pytest.raises(ValueError, match=r"must be a unit, as 'N m/\(rad s\)' is"):
        Entry('o"mega', np.zeros(1), bad)
    odd = Layout((Entry('o"mega', np.zeros(1), 'x"""\nimport os\n--> \\ $name %s {0}'),))
    for each in (law.with_name(bad), replace(law, notes=(bad,)), replace(law, readings=odd)):
        for text in (python_law(each), casadi_law(each), as_control(each)):
            assert not [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.alias) and node.name == "os"]
        for files in (ros2(c_code(each, "law")), simulink(c_code(each, "law"))):
            for name, text in files.items():
                assert name in ("law.c", "law.h", "src/law.c", "src/law.h") or "\nimport os" not in text
                assert text.count("/*") == text.count("*/"), name


@needs_compiler
def test_python_and_c_answer_alike_to_what_is_not_finite(tmp_path):
    """Time goes on meanwhile: the reference is built in."""
    sampled = rival("FS", "ASMC").digital(1e-3)
    run = Record(sampled.law("built in"), *recorded(sampled, sampled.law("built in"), 20))
    run.readings[4, 1], run.readings[7, 0], run.readings[9, 2] = np.nan, -np.inf, 1.7e308
    u, z, flags = compiled(c_code(run.law, "law"), tmp_path)(run.readings, run.references)
    told = replayed(run, python_law(run.law), tmp_path)
    assert [each for *_, each in told] == flags.tolist()
    assert set(flags) == {0, 1, 4}
    assert differing(np.array([flat(run.law.commands, commands) for commands, *_ in told]), u) == 0
    assert differing(np.array([flat(run.law.memory, memory) for _, memory, _ in told]), z) == 0


def test_the_casadi_function_has_truths_and_choices():
    law, scope = ClosedLoop(MOTOR, controller=Odd(), reference=STEP).digital(0.01).law(), {}
    exec(casadi_law(law), scope)
    same_function(scope["law"], law)


def same_function(function, law):
    random = np.random.default_rng(2)
    for k in range(20):
        z, y, r = (random.normal(size=port.size) for port in (law.memory, law.readings, law.references))
        ours, theirs = (f(k, z, y, r, law.parameters.default) for f in (function, law.F))
        for a, b in zip(ours, theirs, strict=True):
            np.testing.assert_allclose(np.array(a), np.array(b), rtol=1e-13, atol=1e-13)
