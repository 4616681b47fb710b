"""The files in other languages, each filled in and held against the tools of its own language."""

import json
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.support.browsers import needs_node
from tests.support.digital_laws import arm_law, motor_law
from tests.support.targets_here import needs, needs_cortex_m, needs_gcc
from workbench.core.templates import fill, template_text
from workbench.handover.c99.c_files import c_code
from workbench.handover.export_folder import write_files
from workbench.handover.fmi.archive import fmu
from workbench.handover.targets import cortex_m, harness
from workbench.handover.targets.compilers import write_files as write_sources
from workbench.handover.targets.fmu_importer import BEGINS, CALLS
from workbench.handover.targets.soft_doubles import SOFT_DOUBLES_FILE, WRAPS, soft_doubles
from workbench.handover.wrappers.ros2 import ros2

ROOM = Path(__file__).parents[2] / "workbench" / "handover" / "templates"
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
# Where each file is held against its language: here, or where a law in it is compiled and run.
HERE = {
    "targets": ("platform.h", "hosted_platform.c", "harness.c.j2", "cortex_m_platform.c", "cortex_m_board.ld")
    + ("soft_doubles.c", "march.js", "importer.py.j2"),
    "fmi": ("model.h.j2", "instance.h", "fmi2.c", "fmi3.c"),
    "ros2": ("package.xml.j2", "plugin.xml.j2", "CMakeLists.txt.j2"),
}
ELSEWHERE = {
    "c99": ("guards.h",),  # test_texts_in_c, and wherever a law is compiled
    "functions": ("functions.c.j2", "functions.py.j2", "casadi_functions.py.j2"),  # test_array_functions
    "ros2": ("controller.hpp.j2", "controller.cpp.j2", "README.md.j2"),  # test_ros2
    "simulink": ("s_function.c.j2", "build.m.j2"),  # test_simulink
    "vectors": ("vectors.h.j2", "check.c.j2"),  # test_test_vectors
}


def test_no_file_of_another_language_is_left_out():
    files = {str(path.relative_to(ROOM)) for path in ROOM.rglob("*") if path.is_file()}
    assert files == {f"{room}/{name}" for table in (HERE, ELSEWHERE) for room in table for name in table[room]}


LAWS = {
    "with a reference": lambda: motor_law().law(),
    "without one": lambda: motor_law().law("built in"),
    "of many memories": lambda: arm_law().law(),
}


@cache
def code(key, real="double"):
    return c_code(LAWS[key](), "law", precision=real)


@needs_gcc
@pytest.mark.parametrize("real", ["double", "single"])
@pytest.mark.parametrize("key", LAWS)
def test_the_program_around_a_law_compiles_without_a_warning(key, real, tmp_path):
    write_sources({**harness.program(code(key, real)), harness.PLATFORM: harness.hosted_platform()}, tmp_path)
    for source in (harness.MAIN, harness.PLATFORM):
        subprocess.run(["gcc", *STRICT, "-O2", "-c", source], cwd=tmp_path, check=True, timeout=60)


@needs_cortex_m
def test_the_start_of_a_board_and_its_memory_compile_and_link_without_a_warning(tmp_path):
    files = {**harness.program(code("with a reference")), **cortex_m.board_files(), SOFT_DOUBLES_FILE: soft_doubles()}
    write_sources(files, tmp_path)
    sources = [name for name in files if name.endswith(".c")]
    options = ("-std=gnu99", "-Wall", "-Wextra", "-Werror", *cortex_m.STANDARD[3:], *cortex_m.M4F)
    bare = ("-nostartfiles", "-T", cortex_m.LAYOUT, "-Wl,--no-warn-rwx-segments", "-Wl,--fatal-warnings")
    compiler = f"{cortex_m.PREFIX}gcc"
    subprocess.run([compiler, *options, *bare, *WRAPS, *sources, "-o", "law.elf"], cwd=tmp_path, check=True, timeout=60)


@needs_gcc
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_runtime_of_an_fmu_compiles_without_a_warning(version, tmp_path):
    unit = fmu(LAWS["with a reference"](), version, "law", compiler="")
    for path, content in unit.files.items():
        (tmp_path / Path(path).name).write_bytes(content)
    for prefix in ((), (f"-DFMI{version[0]}_FUNCTION_PREFIX=law_",)):
        command = ["gcc", *STRICT, "-O2", *prefix, "-c", f"fmi{version[0]}.c", "-o", "fmi.o"]
        subprocess.run(command, cwd=tmp_path, check=True, timeout=60)
        names = subprocess.run(["nm", "-g", "fmi.o"], cwd=tmp_path, check=True, timeout=60, capture_output=True).stdout
        assert (b" T law_fmi" in names, b" T fmi" in names) == (bool(prefix), not prefix)


@needs_node
def test_node_reads_the_march(tmp_path):
    (tmp_path / "march.js").write_text(template_text("workbench.handover", "targets/march.js"), encoding="utf-8")
    subprocess.run(["node", "--check", "march.js"], cwd=tmp_path, check=True, timeout=60)


@pytest.mark.parametrize("version", CALLS)
def test_python_reads_the_importer(version):
    script = fill("workbench.handover", "targets/importer.py.j2", **CALLS[version], begin=BEGINS[version])
    check = "import ast, json, sys; ast.parse(json.load(sys.stdin))"
    subprocess.run([sys.executable, "-c", check], input=json.dumps(script), text=True, check=True, timeout=60)


PACKAGES = ("controller_interface", "pluginlib", "rclcpp", "rclcpp_lifecycle", "realtime_tools", "std_msgs")
AMENT = """function(ament_target_dependencies)
endfunction()
function(pluginlib_export_plugin_description_file room file)
  if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    message(FATAL_ERROR "no ${file}")
  endif()
endfunction()
function(ament_package)
endfunction()
"""


@needs("cmake", "g++")
def test_cmake_configures_the_package_of_ros_2_without_a_warning(tmp_path):
    write_files(tmp_path / "package", ros2(code("with a reference")))
    for name in (*PACKAGES, "ament_cmake"):
        at = tmp_path / "stubs" / name
        at.mkdir(parents=True)
        (at / f"{name}Config.cmake").write_text(AMENT if name == "ament_cmake" else "", encoding="utf-8")
    stubs = [f"-D{name}_DIR={tmp_path / 'stubs' / name}" for name in (*PACKAGES, "ament_cmake")]
    command = [shutil.which("cmake"), "-Werror=dev", *stubs, "-S", "package", "-B", "build"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_xml_of_a_package_of_ros_2_is_read_back_with_the_name_of_a_law_as_it_is():
    name = 'PID of <b> & "O\'Brien" {{ 7 * 7 }}'
    files = ros2(c_code(LAWS["with a reference"]().with_name(name), "law"))
    written = name.replace('"', "'")  # a string of C may hold it
    manifest, plugin = (ElementTree.fromstring(files[file]) for file in ("package.xml", "law_controller.xml"))
    assert manifest.findtext("description") == f"{written}: a control law as a controller of ros2_control."
    assert [depend.text for depend in manifest.iter("depend")] == list(PACKAGES)
    assert plugin.findtext("class/description") == written
