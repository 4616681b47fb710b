"""The S-function around the C of a law: compiled and run against stubs of simstruc.h, as no MATLAB is here."""

import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import proposed_repaired, rival
from tests.support.c_runs import differing
from tests.support.cases import heavy_but
from tests.support.law_forms import record
from workbench.handover.c99.c_files import c_code
from workbench.handover.wrappers.simulink import simulink

STUBS = Path(__file__).parents[1] / "support" / "simulink_stubs"
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed: apt-get install gcc")


@cache
def paper():
    """The law of the paper with noise, limits and a delay."""
    loop = proposed_repaired("FS")
    instruments = wb.Instruments.of(loop.plant, noise={"q": 1e-4}, limit={"tau": (-80.0, 80.0)})
    return record(loop, 1e-3, 1000, instruments, delay=True)


@cache
def motor(high=24.0):
    """A PID law of a motor: numbers without a shape."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=high and -high, high=high)
    return record(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)), 0.01, 200)


@cache
def sliding():
    """A law with its reference built in, which counts its periods."""
    return record(rival("FS", "SMC"), 1e-3, 200, reference="built in")


def built(code, folder):
    """The block as a program."""
    for name, text in simulink(code).items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [f"{code.name}_sfun.c", f"{code.name}.c"]
    flags = ["-std=c99", "-O2", "-ffp-contract=off", *WARNINGS, "-Wno-unused-function", f"-I{STUBS}"]
    subprocess.run(["gcc", *flags, *sources, "-o", "block"], check=True, timeout=60, cwd=folder)
    return folder / "block"


def simulated(block, rows, *arguments):
    """The outputs of the block, (n, outputs), and what it said: its period and offset."""
    data = np.ascontiguousarray(rows, dtype=float).tobytes()
    run = subprocess.run([block, *map(str, arguments)], input=data, capture_output=True, timeout=60, check=True)
    return np.frombuffer(run.stdout).reshape(len(rows), -1), run.stderr.decode().split()


@pytest.mark.parametrize("record_of", heavy_but([paper, motor, sliding], motor))
def test_the_block_has_the_bits_of_the_simulation(record_of, tmp_path):
    run = record_of()
    block = built(c_code(run.law, "law"), tmp_path)
    outputs, said = simulated(block, np.hstack([run.readings, run.references]))
    assert [float(word) for word in said] == [run.law.period, 0.0]
    assert len(run.commands) >= 200
    assert differing(outputs[:, :-1], run.commands) == 0
    assert not outputs[:, -1].any()  # the flags


def test_a_reset_block_begins_anew(tmp_path):
    run = paper()
    rows = np.hstack([run.readings, run.references])[:50]
    outputs, _ = simulated(built(c_code(run.law, "law"), tmp_path), np.vstack([rows, rows]), 50)
    assert differing(outputs[50:], outputs[:50]) == 0
    plain, _ = simulated(tmp_path / "block", np.vstack([rows, rows]))
    assert (plain[50:] != outputs[50:]).any()


def test_a_reading_that_is_no_number_raises_the_flag_and_gives_the_safe_command(tmp_path):
    run = motor()
    rows = np.hstack([run.readings, run.references])[:3]
    rows[1, 0] = np.nan
    outputs, _ = simulated(built(c_code(run.law, "law", safe={"v": 2.0}), tmp_path), rows)
    np.testing.assert_array_equal(outputs[:, 1], [0, 1, 0])
    assert outputs[1, 0] == 2.0


def test_parameters_that_can_be_set_are_those_of_the_dialog(tmp_path):
    run = motor()
    block = built(c_code(run.law, "law", parameters="settable"), tmp_path)
    rows = np.hstack([run.readings, run.references])
    texts = {}
    for entry in run.law.parameters.entries:
        values = run.law.parameters.default[run.law.parameters.slice(entry.name)]
        texts[entry.name] = f"{entry.size}:{','.join(map(repr, values.tolist()))}"
    outputs, _ = simulated(block, rows, -1, *texts.values())
    assert differing(outputs[:, :-1], run.commands) == 0
    other, _ = simulated(block, rows, -1, *(texts | {"controller.Kp": "1:50.0"}).values())
    assert (other[:, 0] != outputs[:, 0]).any()
    wrong = [block, "-1", *(texts | {"controller.Kp": "2:50.0,60.0"}).values()]
    refused = subprocess.run(wrong, input=b"", capture_output=True, timeout=60)
    assert refused.returncode == 2
    assert b"as many as law.h has" in refused.stderr


def test_a_block_of_single_precision_has_single_ports(tmp_path):
    run = motor(high=None)
    block = built(c_code(run.law, "law", precision="single"), tmp_path)
    outputs, _ = simulated(block, np.hstack([run.readings, run.references]))
    np.testing.assert_array_equal(outputs[:, 0], outputs[:, 0].astype(np.float32))
    np.testing.assert_allclose(outputs[:5, 0], run.commands[:5, 0], rtol=1e-4)


def test_the_files_say_against_what_they_were_compiled():
    files = simulink(c_code(motor().law, "law"))
    assert sorted(files) == ["law.c", "law.h", "law_build.m", "law_sfun.c"]
    assert "stubs of simstruc.h alone" in " ".join(files["law_sfun.c"].split())
    assert "mex CFLAGS='$CFLAGS -std=c99 -ffp-contract=off' law_sfun.c law.c" in files["law_build.m"]


def test_anything_but_c_is_refused():
    with pytest.raises(ValueError, match=r"simulink\(code=...\)"):
        simulink("law.c")
