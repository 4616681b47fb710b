"""A number that is built into the C of a law can be edited there, and the law is then the one with that number."""

import re
import subprocess

import numpy as np
import pytest

import workbench as wb
from tests.support.c_runs import EACH_COMPILER, WARNINGS, compiled, differing, needs_compiler
from tests.support.recorded_laws import LOOPS
from workbench.handover.c99.c_files import c_code
from workbench.handover.recording import record

LINE = re.compile(r"^( +const double (\w+) = )([^;]+)(; /\* ([\w.]+)(\[(\d+)(?:,\s*(\d+))?\])?[ *])", re.MULTILINE)

SYMMETRIC = re.compile(r"observer\.(Q|R|P)$")  # of which the loop takes no entry beside the diagonal alone


def motor_with_equal_gains():
    """A motor whose law has equal numbers under many names, 0 and 1 among them."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=10.0, Ki=10.0, Kd=1.0, N=10.0, low=-24.0, high=24.0)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1)).digital(1e-3)


def arm_with_equal_slopes():
    """Two joints with one slope: equal numbers that are multiplied with the same."""
    return LOOPS["SMC"]()[0]


CASES = {"motor PID": motor_with_equal_gains, "SMC": arm_with_equal_slopes, "EKF": lambda: LOOPS["EKF"]()[0]}


def built_in_numbers(source):
    """The lines of numbers that have names: the name in C and its label in the law."""
    return [
        (found[2], found[5], found[6] or "", found[3])
        for found in LINE.finditer(source)
        if found[8] is None or found[7] == found[8] or not SYMMETRIC.match(found[5])
    ]


class Edited:
    """The C of a law in which numbers were edited in the text."""

    def __init__(self, code, values):
        self.law, self.name, self.real, self.hardware = code.law, code.name, code.real, ()
        self.source, self.header = code.source, code.header
        for variable, value in values.items():
            pattern = rf"(const double {re.escape(variable)} = )[^;]+;"
            self.source, count = re.subn(pattern, lambda found, value=value: f"{found[1]}{value!r};", self.source)
            assert count == 1, variable

    def write(self, folder):
        """Write both files."""
        (folder / f"{self.name}.h").write_text(self.header)
        (folder / f"{self.name}.c").write_text(self.source)


def changed(code, p):
    """Another number for each one of a text, no two alike even where they were; the same are written to their `p`."""
    values, labels = {}, code.law.parameters.labels
    for i, (variable, path, index, text) in enumerate(built_in_numbers(code.source), 1):
        place = labels.index(f"{path}{index}")
        assert float(text) == code.law.parameters.default[place]
        values[variable] = p[place] = float(text) * (1 + i / 4096) + (i / 4096 if float(text) == 0 else 0.0)
    assert len(values) > 3
    return values


@needs_compiler
@pytest.mark.parametrize("name", CASES)
def test_numbers_edited_in_the_text_are_the_loop_with_those_numbers(name, tmp_path):
    sampled = CASES[name]()
    truths = LOOPS[name]()[1] if name in LOOPS else ()
    law = sampled.law("input", truths)
    code, own, p = c_code(law, "law"), law.parameters.default.copy(), sampled.parameters.default.copy()
    values = changed(code, own)
    for label, value in zip(law.parameters.labels, own, strict=True):
        p[sampled.parameters.labels.index(label)] = value
    run = record(sampled, law, 60, p=p)
    u, z, flags = compiled(Edited(code, values), tmp_path, options=("-O0",))(run.y, run.r)
    assert (differing(u, run.u), differing(z, run.memory(1, 60)), flags.max()) == (0, 0, 0)
    assert differing(u, record(sampled, law, 60).u)


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
@pytest.mark.parametrize("compiler", EACH_COMPILER)
@pytest.mark.parametrize("precision", ["double", "single"])
def test_no_compiler_warns_of_an_edited_file(compiler, precision, tmp_path):
    code = c_code(motor_with_equal_gains().law(), "law", precision=precision)
    Edited(code, {built_in_numbers(code.source)[0][0]: 12.5}).write(tmp_path)
    subprocess.run([compiler, "-O2", *WARNINGS, "-c", "law.c"], cwd=tmp_path, check=True, timeout=60)


@needs_compiler
def test_numbers_edited_in_single_precision_are_the_law_with_those_numbers(tmp_path):
    from workbench.handover.single.single_precision import single_precision

    sampled = motor_with_equal_gains()
    law = sampled.law()
    code, run, p = c_code(law, "law", precision="single"), record(sampled, law, 50), law.parameters.default.copy()
    edited = Edited(code, changed(code, p))
    u, z, _ = compiled(edited, tmp_path, options=("-O0",))(run.y, run.r)
    before = np.vstack([law.memory.default, z[:-1]])
    wanted = single_precision(law, np.arange(50), before, run.y, run.r, p)
    assert (differing(u, wanted.u), differing(z, wanted.z_next)) == (0, 0)
