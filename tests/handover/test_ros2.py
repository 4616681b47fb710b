"""The package of ROS 2 around the C of a law: compiled and run against stubs of its headers, as no ROS 2 is here."""

import shutil
import subprocess
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import workbench as wb
from studies.paper.laws import proposed_repaired, rival
from tests.support.c_runs import differing
from tests.support.cases import heavy_but
from tests.support.law_forms import record
from workbench.handover.c99.c_files import c_code
from workbench.handover.export_folder import write_files
from workbench.handover.wrappers.ros2 import ros2

STUBS = Path(__file__).parents[1] / "support" / "ros2_stubs"
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror")
needs_gcc = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("gcc") is None, reason="g++ is not installed: apt-get install g++"
)


@cache
def paper():
    """The law of the paper with noise and limits."""
    loop = proposed_repaired("FS")
    return record(loop, 1e-3, 200, wb.Instruments.of(loop.plant, noise={"q": 1e-4}, limit={"tau": (-80.0, 80.0)}))


@cache
def motor():
    """A PID law of a motor, with a limit that its safe command keeps."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0, low=-24.0, high=24.0)
    return record(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)), 0.01, 200)


@cache
def unlimited():
    """The same law without limits."""
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, Kd=10.0)
    return record(wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0)), 0.01, 20)


@cache
def sliding():
    """A law with its reference built in, which counts its periods."""
    return record(rival("FS", "SMC"), 1e-3, 200, reference="built in")


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """A function of a record, interfaces and options of the C: the controller with a manager of it as a program."""
    root = tmp_path_factory.mktemp("ros2")
    flags = ["-std=c++17", "-O0", *WARNINGS, f"-I{STUBS}"]

    def run(folder, *command):
        subprocess.run(command, check=True, timeout=60, cwd=folder)

    @cache
    def program(record_of, interfaces, **options):
        if not (root / "manager.o").exists():
            run(root, "g++", *flags, "-c", STUBS / "manager.cpp", "-o", "manager.o")
        code = c_code(record_of().law, "law", **{"safe": SAFE.get(record_of)} | options)
        folder = root / f"{record_of.__name__}{len(options)}"
        write_files(folder, ros2(code, interfaces=dict(interfaces)))
        run(folder, "gcc", "-std=c99", "-O2", "-ffp-contract=off", *WARNINGS, "-c", "src/law.c", "-o", "law.o")
        sources = ("src/law_controller.cpp", "law.o", root / "manager.o")
        run(folder, "g++", *flags, "-Iinclude", "-Isrc", *sources, "-o", "manager")
        return folder / "manager"

    return lambda record_of, interfaces=(), **options: program(record_of, interfaces, **options)


SAFE = {motor: {"v": 1.5}}
JOINTS = (("q", ("joint1/position", "joint2/position")), ("tau", ("joint1/effort", "joint2/effort")))


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
@pytest.mark.parametrize(
    ("record_of", "interfaces"), heavy_but([(paper, JOINTS), (motor, ()), (sliding, ())], (motor, ()))
)
def test_the_controller_has_the_bits_of_the_simulation(record_of, interfaces, programs):
    run = record_of()
    code, commands, _ = managed(programs(record_of, interfaces), run, rows_of(run))
    assert code == 0
    assert differing(commands[:-1], run.commands) == 0


@needs_gcc
@pytest.mark.heavy
def test_the_controller_asks_for_the_interfaces_that_are_named(programs):
    run, program = paper(), programs(paper, JOINTS)
    _, _, said = managed(program, run, rows_of(run)[:1])
    assert said[:6] == [
        *("state joint1/position", "state joint2/position", "state law/d_0", "state law/d_1"),
        *("command joint1/effort", "command joint2/effort"),
    ]
    readme = (program.parent / "README.md").read_text()
    assert "| `joint2/position` | reading q[1] [rad] |" in readme
    assert "stubs of their headers alone" in " ".join(readme.split())


@needs_gcc
def test_what_is_safe_is_commanded_before_a_reference_after_the_end_and_where_a_reading_is_no_number(programs):
    run = motor()
    rows = rows_of(run)[:6].copy()
    rows[4, 0] = np.inf
    _, commands, said = managed(programs(motor), run, rows, silent=2)
    np.testing.assert_array_equal(commands[[0, 1, 4, 6], 0], 1.5)
    assert np.all(commands[[2, 3, 5], 0] != 1.5)
    assert "flags 1: the safe command" in said
    assert "flags 0: all is well again" in said
    assert "~/references takes 1 numbers, and got 2." in said


@needs_gcc
def test_another_update_rate_is_refused(programs):
    run = motor()
    for rate in (0, 99, 1000):
        code, _, said = managed(programs(motor), run, rows_of(run), rate=rate)
        assert code == 4
        assert f"The law was made for 0.01 s a period, an update rate of 100 Hz; this controller has {rate}." in said


@needs_gcc
@pytest.mark.heavy
def test_parameters_that_can_be_set_are_parameters_of_the_node(programs):
    run, program = motor(), programs(motor, parameters="settable")
    _, commands, _ = managed(program, run, rows_of(run))
    assert differing(commands[:-1], run.commands) == 0
    _, other, _ = managed(program, run, rows_of(run), "controller_Kp=50.0")
    assert (other[:-1] != run.commands).any()
    code, _, said = managed(program, run, rows_of(run), "controller_Kp=50.0,60.0")
    assert code == 3
    assert "The parameter controller_Kp has 1 numbers; got 2." in said


@needs_gcc
@pytest.mark.heavy
def test_a_controller_of_single_precision_rounds_what_it_reads(programs):
    run = unlimited()
    _, commands, _ = managed(programs(unlimited, precision="single"), run, rows_of(run))
    np.testing.assert_array_equal(commands, commands.astype(np.float32))
    np.testing.assert_allclose(commands[:5], run.commands[:5], rtol=1e-4)


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
        ({"interfaces": {"omega": "speed"}}, ValueError, "1 interface, each as 'axis1/position'"),
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
