"""The package of ROS 2 around the C of a law: compiled and run against stubs of its headers, as no ROS 2 is here."""

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from law_forms import bits, record

import workbench as wb
from studies.paper.laws import proposed_repaired
from workbench.handover.c_code import c_code
from workbench.handover.ros2 import ros2

STUBS = Path(__file__).parent / "ros2_stubs"
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
needs_gcc = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("gcc") is None, reason="g++ is not installed: apt-get install g++"
)


@cache
def paper():
    """The law of the paper with noise and limits."""
    loop = proposed_repaired("FS")
    return record(loop, 1e-3, 500, wb.Instruments.of(loop.plant, noise={"q": 1e-4}, limit={"tau": (-80.0, 80.0)}))


@cache
def motor():
    """A PID law of a motor, with a limit that its safe command keeps."""
    motor = wb.DCMotor()
    law = wb.PID2(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    return record(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)), 0.01, 200)


def built(files, folder):
    """The controller and a manager of it as a program."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    (source,) = (name for name in files if re.fullmatch(r"src/\w+\.c", name))
    (controller,) = (name for name in files if name.endswith(".cpp"))
    compile_c = ["gcc", "-std=c99", "-O2", "-ffp-contract=off", *WARNINGS, "-c", source, "-o", "law.o"]
    subprocess.run(compile_c, check=True, timeout=60, cwd=folder)
    flags = ["-std=c++17", "-O0", *WARNINGS, "-Iinclude", "-Isrc", f"-I{STUBS}"]
    command = ["g++", *flags, controller, STUBS / "manager.cpp", "law.o", "-o", "manager"]
    subprocess.run(command, check=True, timeout=60, cwd=folder)
    return folder / "manager"


def managed(program, run, rows, *arguments, silent=0, rate=None):
    """The commands, (n + 1, commands), of which the last ones come after deactivation, and what was said."""
    rate = round(1 / run.law.period) if rate is None else rate
    command = [program, str(rate), str(run.law.references.size), str(silent), *arguments]
    data = np.ascontiguousarray(rows, dtype=float).tobytes()
    done = subprocess.run(command, input=data, capture_output=True, timeout=60)
    said = done.stderr.decode().splitlines()
    return done.returncode, np.frombuffer(done.stdout).reshape(-1, run.law.commands.size), said


def rows_of(run):
    return np.hstack([run.readings, run.references])


@needs_gcc
@pytest.mark.parametrize("record_of", [paper, motor])
def test_the_controller_has_the_bits_of_the_simulation(record_of, tmp_path):
    run = record_of()
    code, commands, _ = managed(built(ros2(c_code(run.law, "law")), tmp_path), run, rows_of(run))
    assert code == 0
    np.testing.assert_array_equal(bits(commands[:-1]), bits(run.commands))


@needs_gcc
def test_the_controller_asks_for_the_interfaces_that_are_named(tmp_path):
    run = paper()
    named = {"q": ("joint1/position", "joint2/position"), "tau": ["joint1/effort", "joint2/effort"]}
    program = built(ros2(c_code(run.law, "law"), interfaces=named), tmp_path)
    _, _, said = managed(program, run, rows_of(run)[:1])
    assert said[:6] == [
        *("state joint1/position", "state joint2/position", "state law/d_0", "state law/d_1"),
        *("command joint1/effort", "command joint2/effort"),
    ]
    readme = (tmp_path / "README.md").read_text()
    assert "| `joint2/position` | reading q[1] [rad] |" in readme
    assert "stubs of their headers alone" in " ".join(readme.split())


@needs_gcc
def test_what_is_safe_is_commanded_before_a_reference_after_the_end_and_where_a_reading_is_no_number(tmp_path):
    run = motor()
    rows = rows_of(run)[:6].copy()
    rows[4, 0] = np.inf
    program = built(ros2(c_code(run.law, "law", safe={"v": 1.5})), tmp_path)
    _, commands, said = managed(program, run, rows, silent=2)
    np.testing.assert_array_equal(commands[[0, 1, 4, 6], 0], 1.5)
    assert np.all(commands[[2, 3, 5], 0] != 1.5)
    assert "flags 1: the safe command" in said
    assert "flags 0: all is well again" in said
    assert "~/references takes 1 numbers, and got 2." in said


@needs_gcc
def test_another_update_rate_is_refused(tmp_path):
    run = motor()
    program = built(ros2(c_code(run.law, "law")), tmp_path)
    for rate in (0, 99, 1000):
        code, _, said = managed(program, run, rows_of(run), rate=rate)
        assert code == 4
        assert f"The law was made for 0.01 s a period, an update rate of 100 Hz; this controller has {rate}." in said


@needs_gcc
def test_parameters_that_can_be_set_are_parameters_of_the_node(tmp_path):
    run = motor()
    program = built(ros2(c_code(run.law, "law", parameters="settable")), tmp_path)
    _, commands, _ = managed(program, run, rows_of(run))
    np.testing.assert_array_equal(bits(commands[:-1]), bits(run.commands))
    _, other, _ = managed(program, run, rows_of(run), "controller_Kp=50.0")
    assert (other[:-1] != run.commands).any()
    code, _, said = managed(program, run, rows_of(run), "controller_Kp=50.0,60.0")
    assert code == 3
    assert "The parameter controller_Kp has 1 numbers; got 2." in said


def test_the_files_of_the_package_agree_in_its_name():
    files = ros2(c_code(motor().law, "Motor_law"))
    package = ElementTree.fromstring(files["package.xml"])
    assert package.findtext("name") == "motor_law_controller"
    depends = [part.text for part in package.findall("depend")]
    assert f"ament_target_dependencies(motor_law_controller {' '.join(depends)})" in files["CMakeLists.txt"]
    plugin = ElementTree.fromstring(files["Motor_law_controller.xml"])
    assert plugin.find("class").get("type") == "motor_law_controller::Controller"
    assert "PLUGINLIB_EXPORT_CLASS(motor_law_controller::Controller," in files["src/Motor_law_controller.cpp"]
    assert all("control-workbench" in text for text in files.values())


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"package": "Arm"}, ValueError, "small letters"),
        ({"package": "a__b"}, ValueError, "small letters"),
        ({"package": 3}, ValueError, "must be text"),
        ({"interfaces": {"omega": "speed"}}, ValueError, "1 interface, each as 'joint1/position'"),
        ({"interfaces": {"omega": 'a/b", "c'}}, ValueError, "1 interface, each as"),
        ({"interfaces": {"omega": ("a/b", "a/c")}}, ValueError, "1 interface, each as"),
        ({"interfaces": {"omeha": "a/b"}}, LookupError, "omega"),
    ],
)
def test_a_name_that_cannot_be_one_is_refused(arguments, error, words):
    with pytest.raises(error, match=words):
        ros2(c_code(motor().law, "law"), **arguments)


def test_an_interface_that_comes_twice_is_refused():
    with pytest.raises(ValueError, match="'a/b' came more often"):
        ros2(c_code(paper().law, "law"), interfaces={"q": ("a/b", "a/b")})
