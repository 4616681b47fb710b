"""A number that is built into the C of a law can be edited there, and the law is then the one with that number."""

import re
import subprocess

import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import COMPILERS, WARNINGS, compiled, differing, needs_compiler
from tests.support.recorded_laws import LOOPS
from workbench.handover.c99.c_code import c_code
from workbench.handover.recording import record

LINE = re.compile(r"^( +const double (\w+) = )([^;]+)(; /\* ([\w.]+)(\[(\d+)(?:,\s*(\d+))?\])?[ *])", re.MULTILINE)

SYMMETRIC = re.compile(r"observer\.(Q|R|P)$")  # of which the loop takes no entry beside the diagonal alone


def motor_with_equal_gains():
    """A motor whose law has equal numbers under many names, 0 and 1 among them."""
    motor = wb.DCMotor()
    law = wb.PID2(motor.outputs, motor.inputs, Kp=10.0, Ki=10.0, Kd=1.0, N=10.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1)).digital(1e-3)


def arm_with_equal_slopes():
    """Two joints with one slope: equal numbers that are multiplied with the same."""
    return LOOPS["SMC"]()[0]


CASES = {"PID2": motor_with_equal_gains, "SMC": arm_with_equal_slopes, "EKF": lambda: LOOPS["EKF"]()[0]}


def built_in_numbers(source):
    """The lines of numbers that have names: the name in C and its label in the law."""
    return [
        (found[2], found[5], found[6] or "", found[3])
        for found in LINE.finditer(source)
        if found[8] is None or found[7] == found[8] or not SYMMETRIC.match(found[5])
    ]


class Edited:
    """The C of a law in which one number was edited in the text."""

    def __init__(self, code, variable, value):
        self.law, self.name, self.real, self.hardware = code.law, code.name, code.real, ()
        pattern = rf"(const double {re.escape(variable)} = )[^;]+;"
        self.source, count = re.subn(pattern, lambda found: f"{found[1]}{value!r};", code.source)
        self.header = code.header
        assert count == 1, variable

    def write(self, folder):
        """Write both files."""
        (folder / f"{self.name}.h").write_text(self.header)
        (folder / f"{self.name}.c").write_text(self.source)


def changed(value):
    """Another number like this one: no rounding is shared with it."""
    return value * 1.0009765625 + (0.01 if value == 0 else 0.0)


@needs_compiler
@pytest.mark.parametrize("name", ["PID2", "SMC", pytest.param("EKF", marks=pytest.mark.heavy)])
def test_a_number_edited_in_the_text_is_the_loop_with_that_number(name, tmp_path):
    sampled = CASES[name]()
    truths = LOOPS[name]()[1] if name in LOOPS else ()
    law = sampled.law("input", truths)
    code = c_code(law, "law")
    numbers = built_in_numbers(code.source)
    assert len(numbers) > 3
    for i, (variable, path, index, text) in enumerate(numbers):
        label = f"{path}{index}"
        place = law.parameters.labels.index(label)
        value = changed(float(text))
        assert float(text) == law.parameters.default[place]
        p = sampled.parameters.default.copy()
        p[sampled.parameters.labels.index(label)] = value
        run = record(sampled, law, 60, p=p)
        (folder := tmp_path / str(i)).mkdir()
        u, z, flags = compiled(Edited(code, variable, value), folder, options=("-O0",))(run.y, run.r)
        assert (differing(u, run.u), differing(z, run.memory(1, 60)), flags.max()) == (0, 0, 0), label


def test_equal_numbers_have_lines_of_their_own():
    source = c_code(motor_with_equal_gains().law(), "law").source
    lines = {path + index: text for _, path, index, text in built_in_numbers(source)}
    assert {lines[f"controller.{name}[0]"] for name in ("Kp", "Ki", "N")} == {"10.0"}
    assert lines["controller.b[0]"] == lines["controller.c[0]"] == "1.0"
    assert lines["controller.u0[0]"] == "0.0"


def test_the_file_says_how_to_change_a_number():
    text = " ".join(c_code(motor_with_equal_gains().law(), "law").source.replace(" * ", " ").split())
    assert "To change one, edit its line here" in text


@needs_compiler
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("precision", ["double", "single"])
def test_no_compiler_warns_of_an_edited_file(compiler, precision, tmp_path):
    code = c_code(motor_with_equal_gains().law(), "law", precision=precision)
    Edited(code, built_in_numbers(code.source)[0][0], 12.5).write(tmp_path)
    subprocess.run([compiler, "-O2", *WARNINGS, "-c", "law.c"], cwd=tmp_path, check=True, timeout=60)


@needs_compiler
def test_a_number_edited_in_single_precision_is_the_law_with_that_number(tmp_path):
    from workbench.handover.single.single_precision import single_precision

    sampled = motor_with_equal_gains()
    law = sampled.law()
    code, run = c_code(law, "law", precision="single"), record(sampled, law, 50)
    assert built_in_numbers(code.source)
    for i, (variable, path, index, text) in enumerate(built_in_numbers(code.source)):
        p = law.parameters.default.copy()
        p[law.parameters.labels.index(f"{path}{index}")] = value = changed(float(text))
        (folder := tmp_path / str(i)).mkdir()
        u, z, _ = compiled(Edited(code, variable, value), folder, options=("-O0",))(run.y, run.r)
        before = np.vstack([law.memory.default, z[:-1]])
        wanted = single_precision(law, np.arange(50), before, run.y, run.r, p)
        assert (differing(u, wanted.u), differing(z, wanted.z_next)) == (0, 0), path
