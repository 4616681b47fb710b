"""Bad input through the front door: one line on stderr, exit status 2, and no half-written report."""

import os
import sys

import pytest

ARM = """
import numpy as np
from workbench.arms.laws import ArmPID
from workbench.core import rk4
from workbench.blocks.loop import ClosedLoop
from workbench.arms.observers import ArmFullState
from workbench.arms.manipulator import Manipulator
from workbench.arms.mechanics import Link, PlanarArm, paper_arm
from workbench.arms.mechanics.planar_arm import PointMass
from workbench.blocks.signals import Sines
from workbench.engine import simulate
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Study

def loop():
    controller = ArmPID(Kp=[60.0, 60.0], Ki=[0.0, 0.0], Kd=[1.0, 1.0])
    reference = Sines("q", "rad", amplitude=[1.0, 1.0], frequency=[1.0, 1.0])
    return ClosedLoop(Manipulator(paper_arm(), q=[0.0, 0.0]), ArmFullState(2), controller, reference)
"""
LINE = ARM.count("\n") + 1

BAD_NUMBERS = [
    ("PointMass({}, 1.0)", "`PointMass(mass=...)`"),
    ("PointMass(1.0, {})", "`PointMass(length=...)`"),
    ("rk4(loop().ode(), {})", "`rk4(h=...)`"),
    ("Run(loop(), (), h={}, until=1.0, every=0.1)", "`Run(h=...)`"),
    ("Run(loop(), (), h=0.1, until={}, every=0.1)", "`Run(until=...)`"),
    ("simulate(rk4(loop().ode(), 0.1), until={})", "`simulate(until=...)`"),
]


def refused(done, tmp_path, *words):
    """One line on stderr, exit status 2, and nothing but the script in the folder."""
    assert done.exit_code == 2, done.output
    assert done.stdout == ""
    assert done.stderr.startswith("workbench: ")
    assert done.stderr.count("\n") == 1
    for word in words:
        assert word in done.stderr
    assert not list(tmp_path.rglob("*partial*"))
    assert not list(tmp_path.rglob("index.html"))


@pytest.mark.parametrize("number", ["-1.0", "0.0", "float('nan')", "float('inf')", "'heavy'"])
@pytest.mark.parametrize(("call", "word"), BAD_NUMBERS)
def test_a_mass_length_step_or_horizon_that_is_none_is_refused(command, script, tmp_path, call, word, number):
    refused(
        command("run", script(f"{ARM}{call.format(number)}\n")),
        tmp_path,
        f"study.py, line {LINE}: {word}",
        SAID[number],
    )


SAID = {"-1.0": "-1", "0.0": "0", "float('nan')": "nan", "float('inf')": "inf", "'heavy'": "'heavy'"}


OTHER_NUMBERS = [
    ("ArmPID(Kp=[-1.0], Ki=[0.0], Kd=[1.0])", "`ArmPID(Kp=...)` must be"),
    ("ArmPID(Kp=[np.nan], Ki=[0.0], Kd=[1.0])", "`ArmPID(Kp=...)` must be"),
    ("ArmPID(Kp=[np.inf], Ki=[0.0], Kd=[1.0])", "`ArmPID(Kp=...)` must be"),
    ("ArmPID(Kp='stiff', Ki=[0.0], Kd=[1.0])", "`ArmPID(Kp=...)` must be"),
    ("ArmPID(Kp=[1.0, 2.0], Ki=[0.0], Kd=[1.0, 1.0])", "`ArmPID(Ki=...)` must be an array of shape (n = 2)"),
    ("Manipulator(paper_arm(), q=[0.0, 0.0, 0.0])", "`Manipulator(q=...)` must be an array of shape (n = 2)"),
    ("Manipulator(paper_arm(), q=[0.0, np.nan])", "`Manipulator(q=...)` must be finite"),
    ("Link([1.0, 2.0], 1.0, 0.5)", "`Link(mass=...)` must be a single number"),
    ("PlanarArm(())", "at least one `Link`"),
    ("PlanarArm(paper_arm().links, zero='dwon')", "Did you mean 'down'?"),
    ("PlanarArm(paper_arm().links, gravity=-9.81)", "`PlanarArm(gravity=...)` must be"),
    ("loop().ode().parameters.pack({'controller.Kpp': [1.0, 1.0]})", "Did you mean 'controller.Kp'?"),
    ("loop().ode().parameters.pack({'plant.arm.links[0].mass': -1.0})", "'plant.arm.links[0].mass' must be"),
    ("ArmPID(Kp=[1.0], Ki=[1.0], Kd=[1.0], gama=1.0)", "gama"),
    (
        "Study('../up', 'T', 'Q?', 'M.', sections=lambda results: [])",
        "`Study(name)` must be made of a-z",
    ),
    ("Study('a/b', 'T', 'Q?', 'M.', sections=lambda results: [])", "`Study(name)` must be made of a-z"),
    ("Study('', 'T', 'Q?', 'M.', sections=lambda results: [])", "`Study(name)` must be made of a-z"),
    ("1 / 0", "ZeroDivisionError: division by zero"),
    ("{}['key']", "KeyError: 'key'"),
    ("raise ValueError('two\\nlines')", "two lines"),
]


@pytest.mark.parametrize(("call", "word"), OTHER_NUMBERS)
def test_what_a_script_gets_wrong_is_said_with_its_line(command, script, tmp_path, call, word):
    refused(command("run", script(f"{ARM}{call}\n")), tmp_path, f"study.py, line {LINE}: ", word)


def test_a_study_file_that_is_missing_is_refused_with_the_nearest(command, script, tmp_path):
    script(name="a1_paper.py")
    refused(command("run", "a1_papper.py"), tmp_path, "There is no study file 'a1_papper.py'", "'a1_paper.py'?")
    refused(command("run", "nowhere/at/all.py"), tmp_path, "There is no study file 'nowhere/at/all.py'.")
    refused(command("run", tmp_path), tmp_path, "is a folder without a `study.py`")


def test_a_syntax_error_is_named_with_its_line(command, tmp_path):
    (tmp_path / "study.py").write_text("x = 1\ny = (\n", encoding="utf-8")
    refused(command("run", "study.py"), tmp_path, "study.py, line 2: SyntaxError: '(' was never closed")


def test_a_syntax_error_in_a_file_beside_is_named_with_that_file(command, script, tmp_path):
    (tmp_path / "broken_beside.py").write_text("def\n", encoding="utf-8")
    refused(command("run", script("import broken_beside\n")), tmp_path, "broken_beside.py, line 1: SyntaxError")


@pytest.mark.parametrize("content", [b"\x00\x01", b"caf\xe9 = 1\n", b"PK\x03\x04"])
def test_a_file_that_is_no_text_is_refused(command, tmp_path, content):
    (tmp_path / "study.py").write_bytes(content)
    refused(command("run", "study.py"), tmp_path, "study.py")


def test_a_script_without_a_study_is_refused(command, tmp_path):
    (tmp_path / "study.py").write_text("x = 1\n", encoding="utf-8")
    refused(command("run", "study.py"), tmp_path, "'study.py' has no study")
    (tmp_path / "study.py").write_text("study = 'mine'\n", encoding="utf-8")
    refused(command("run", "study.py"), tmp_path, "`study` in 'study.py' must be a `Study`; got 'mine'.")


def test_a_script_that_ends_by_itself_is_refused(command, script, tmp_path):
    refused(command("run", script("import sys\nsys.exit(3)\n")), tmp_path, "ended by itself, with status 3")


def test_an_error_in_the_sections_is_said_with_its_line(command, script, tmp_path):
    more = "\nfrom dataclasses import replace\nstudy = replace(study, sections=lambda results: results['no', 'case'])\n"
    lines = (tmp_path / script()).read_text(encoding="utf-8") + more
    (tmp_path / "study.py").write_text(lines, encoding="utf-8")
    where = f"study.py, line {lines.count(chr(10))}: There is no 'no: case' among the 0 cases"
    refused(command("run", "study.py"), tmp_path, where)


def test_an_output_folder_below_a_file_is_refused_before_the_run(command, script, tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    for out in ("file", "file/below", "file/below/it"):
        refused(command("run", script(), "--out", out), tmp_path, "file")
    assert (tmp_path / "file").read_text(encoding="utf-8") == ""


def test_an_output_folder_with_something_else_in_it_is_left_alone(command, script, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work", encoding="utf-8")
    refused(command("run", script(), "--out", "mine"), tmp_path, "mine")
    assert (tmp_path / "mine" / "thesis.tex").read_text(encoding="utf-8") == "years of work"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_an_unwritable_output_folder_is_refused(command, script, tmp_path):
    (tmp_path / "locked").mkdir(mode=0o500)
    refused(command("run", script(), "--out", "locked/report"), tmp_path, "locked")


@pytest.mark.parametrize("size", [0, 2000, 20_000])
def test_a_full_disk_leaves_no_half_written_report(command, script, tmp_path, monkeypatch, size):
    import resource

    study = script()
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        done = command("run", study)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert done.exit_code == 2, done.stderr
    assert done.stderr.startswith("workbench: ")
    assert "File too large" in done.stderr
    assert done.stderr.count("\n") == 1
    assert {path.name for path in tmp_path.rglob("*")} <= {"study.py", "reports"}


def test_a_robot_that_is_not_in_the_catalogue_is_refused_with_the_nearest(command, tmp_path):
    refused(command("derive", "planar-2"), tmp_path, "There is no 'planar-2' among the 12 robots", "Did you mean")
    refused(
        command("derive", "../x"),
        tmp_path,
        "There is no file '../x'; a robot is an arm of the catalogue or a URDF file.",
    )


def test_a_format_that_does_not_exist_is_refused(shell):
    done = shell("derive", "paper-arm", "--format", "word")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "'text', 'latex', 'typst', 'mathml', 'python', 'casadi', 'c'" in done.stderr


ANSWERS = [
    ("sections=lambda results: None", "must be a tuple of `Section`; got None"),
    ("sections=lambda results: Section('T', ())", "must be a tuple of `Section`; got a `Section`"),
    ("sections=lambda results: [Section('T', (Paragraph(CrossReference('no')),))]", "There is no 'no' among"),
    ("sections=lambda results: [Section('T', ('text',))]", "wrap text in `Paragraph(...)`"),
    ("sections=lambda results: exit(0)", "ended the study by itself, with status 0"),
    ("headlines=lambda results: exit(0)", "ended the study by itself, with status 0"),
    ("headlines=lambda results: 'It runs.'", "must be a tuple of `str`; got 'It runs.'"),
    ("headlines=lambda results: results['a', 'b']", "There is no 'a: b' among the 0 cases"),
]


@pytest.mark.parametrize(("change", "word"), ANSWERS)
def test_an_answer_that_is_none_is_said_with_its_line(command, script, tmp_path, change, word):
    from_document = "from workbench.study.document.document import CrossReference\nfrom dataclasses import replace"
    text = f"{(tmp_path / script()).read_text(encoding='utf-8')}\n{from_document}\nstudy = replace(study, {change})\n"
    (tmp_path / "study.py").write_text(text, encoding="utf-8")
    refused(command("run", "study.py"), tmp_path, f"study.py, line {text.count(chr(10))}: ", word)


def test_a_case_that_fails_is_said_with_its_name_and_its_line(command, script, tmp_path):
    loop = "\nclass Loop:\n    def ode(self, name):\n        raise ValueError('no gain')\n"
    more = "from dataclasses import replace\nfrom workbench.study import Case, Run\n"
    case = "study = replace(study, cases=(Case('FS', 'SMC', Run(Loop(), (), 1.0, 0.1, 0.05)),))\n"
    text = (tmp_path / script()).read_text(encoding="utf-8") + loop
    (tmp_path / "study.py").write_text(text + more + case, encoding="utf-8")
    refused(command("run", "study.py"), tmp_path, f"study.py, line {text.count(chr(10))}: FS: SMC: no gain")


def test_a_folder_that_cannot_take_the_report_is_refused_before_the_run(command, script, tmp_path):
    late = "\nfrom dataclasses import replace\nstudy = replace(study, sections=lambda results: 1 / 0)\n"
    text = (tmp_path / script()).read_text(encoding="utf-8") + late
    (tmp_path / "study.py").write_text(text, encoding="utf-8")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("years of work", encoding="utf-8")
    refused(command("run", "study.py", "--out", "mine"), tmp_path, "'thesis.tex' from elsewhere")
    if os.path.isdir("/proc/self"):
        refused(command("run", "study.py", "--out", "/proc/x"), tmp_path, "The report cannot go to '/proc/x'")
