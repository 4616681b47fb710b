"""The verb `export` and `wb.export`: from a file to a header, and one clear sentence where that cannot be."""

import inspect
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import workbench as wb
from tests.support.c_runs import COMPILERS, WARNINGS, needs_compiler
from tests.support.law_files import FILE


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "motor.py").write_text(FILE)
    return tmp_path


@needs_compiler
def test_a_header_in_one_command(folder, shell):
    done = shell("export", "motor.py", "--loop", "computer", "--name", "motor_law", "--out", "code")
    assert (done.returncode, done.stdout) == (0, "Written: code/motor_law.h, code/motor_law.c.\n")
    header = (folder / "code" / "motor_law.h").read_text()
    command = "with: workbench export motor.py --loop computer --name motor_law --out code."
    assert command in " ".join(header.replace(" * ", " ").split())
    assert "Limits of v: -12 to 12 V." in header
    subprocess.run([COMPILERS[0], *WARNINGS, "-c", "motor_law.c"], cwd=folder / "code", check=True, timeout=60)


def test_a_case_of_a_study_at_a_period(command, folder):
    done = command("export", "motor.py", "--case", "speed: PI", "--period", "0.005", "--name", "pi")
    assert done.exit_code == 0, done.stderr
    assert "#define PI_PERIOD 0.005" in (folder / "pi" / "pi.h").read_text()


def test_a_header_in_single_precision_states_what_it_loses(command, folder):
    done = command("export", "motor.py", "--loop", "computer", "--precision", "single", "--name", "law")
    assert done.exit_code == 0, done.stderr
    header = " ".join((folder / "law" / "law.h").read_text().replace(" * ", " ").split())
    assert re.search(r"single precision .* at most [\d.e-]+ V", header), header
    assert "float omega;" in header


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("motor.py",), "'loop' is in continuous time: say how often the computer runs it, as `--period 0.001`."),
        (("nothing.py",), "There is no study file 'nothing.py'."),
        (("motor.py", "--loop", "computer", "--name", "int"), "`name` must be an identifier of C"),
        (("motor.py", "--loop", "computer", "--safe", "v"), "`--safe` must be a command and a number"),
        (("motor.py", "--loop", "computer", "--safe", "v=13"), "within the limits of the command"),
        (("motor.py", "--loop", "computer", "--safe", "w=0"), "'w'"),
        (("motor.py", "--loop", "computer", "--truth", "d"), "'d'"),
        (("motor.py", "--loop", "lop", "--period", "0.1"), "'lop'"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(command, folder, words, sentence):
    done = command("export", *words)
    assert done.exit_code == 2
    assert sentence in done.stderr
    assert done.stderr.count("\n") == 1
    assert [path.name for path in folder.iterdir() if path.name != "__pycache__"] == ["motor.py"]


def test_a_period_at_which_the_loop_is_lost_is_exported_with_a_warning(command, folder):
    done = command("export", "motor.py", "--loop", "loop", "--period", "2", "--name", "slow")
    assert done.exit_code == 0
    assert "Warning: in a simulation of the loop with this law, every 2 s, a number is not finite" in done.stderr
    assert "Note: in a simulation of the loop" in (folder / "slow" / "slow.h").read_text()


def test_a_folder_that_is_not_ours_is_left_as_it_is(command, folder):
    (folder / "code").mkdir()
    (folder / "code" / "law.c").write_text("int mine;")
    done = command("export", "motor.py", "--loop", "computer", "--name", "law", "--out", "code")
    assert done.exit_code == 2
    assert "'code/law.c' was not written by an export" in done.stderr
    assert (folder / "code" / "law.c").read_text() == "int mine;"
    assert [path.name for path in (folder / "code").iterdir()] == ["law.c"]


@pytest.mark.parametrize(("form", "option"), [("python", "precision"), ("fmi2", "safe"), ("casadi", "parameters")])
def test_an_option_that_a_form_does_not_take_is_refused(form, option):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=1.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    value = {"precision": "single", "safe": {"v": 1.0}, "parameters": "settable"}[option]
    with pytest.raises(ValueError, match=rf"takes no `{option}`"):
        wb.export(loop.digital(0.1), form, **{option: value})


def test_an_unknown_form_is_refused_with_the_nearest():
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=1.0)
    loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))
    with pytest.raises(LookupError, match=r"'fmi'.*Did you mean 'fmi"):
        wb.export(loop.digital(0.1), "fmi")


def test_the_three_lines_of_the_readme_lead_from_a_study_to_a_header(tmp_path, monkeypatch):
    root = Path(__file__).parents[2]
    text = (root / "README.md").read_text(encoding="utf-8")
    lines = re.search(r"(    import workbench as wb\n    loop = wb\.load.*\n    wb\.export.*\n)", text)[1]
    (tmp_path / "studies").mkdir()
    shutil.copy(root / "studies" / "own_law.py", tmp_path / "studies")
    (tmp_path / "three.py").write_text(inspect.cleandoc(lines))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "__study__", raising=False)
    runpy.run_path("three.py")
    assert "#define PI_LAW_PERIOD 0.01" in (tmp_path / "pi_law" / "pi_law.h").read_text()
