"""The command line: its verbs, what they print, and how they end."""

import os
import subprocess
import sys
import time

import pytest

from tests.support import warm_runs
from tests.support.compilers import needs_llvmlite
from tests.support.stops import stopped
from workbench import __version__, study
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import robot
from workbench.cli import export
from workbench.cli.derive import text_of
from workbench.handover import law_export

HEAVY = ("casadi", "control", "numpy", "scipy", "matplotlib", "pandas", "rich", "typst", "jinja2", "workbench.core")


def test_help_imports_nothing_heavy():
    code = f"import sys, workbench.cli.command; print([name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_forms_that_help_lists_are_those_that_are_written():
    assert tuple(law_export.FORMS) == export.FORMS


def test_the_version_is_that_of_the_package(command):
    assert command("--version").output == f"workbench, version {__version__}\n"


def test_a_study_becomes_a_report_below_the_current_folder(command, script, tmp_path):
    done = command("run", script())
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "It runs.",
        f"The report is {os.path.join('reports', 'small', 'index.html')}, "
        f"and {os.path.join('reports', 'small', 'report.pdf')}.",
    ]
    page = (tmp_path / "reports" / "small" / "index.html").read_text(encoding="utf-8")
    assert "workbench run study.py" in page
    assert (tmp_path / "reports" / "small" / "report.pdf").read_bytes().startswith(b"%PDF")


def test_the_folder_of_the_report_can_be_chosen_and_a_report_in_it_is_replaced(command, script, tmp_path):
    for title in ("First", "Second"):
        assert command("run", script(title=title), "--out", "there/report").exit_code == 0
    page = (tmp_path / "there" / "report" / "index.html").read_text(encoding="utf-8")
    assert "Second" in page
    assert "First" not in page
    assert "workbench run study.py --out there/report" in page
    assert os.listdir(tmp_path / "there") == ["report"]


def test_an_output_folder_above_the_current_one_is_the_users_own_choice(command, script, tmp_path, monkeypatch):
    (tmp_path / "below").mkdir()
    file = tmp_path / script()
    monkeypatch.chdir(tmp_path / "below")
    assert command("run", file, "--out", "../chosen").exit_code == 0
    assert (tmp_path / "chosen" / "index.html").is_file()


def test_a_title_with_html_in_it_stays_a_title(command, script, tmp_path):
    assert command("run", script(title="<script>alert(1)</script> & <b>more</b>")).exit_code == 0
    page = (tmp_path / "reports" / "small" / "index.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "<b>more" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; &lt;b&gt;more" in page


def test_a_study_may_import_what_lies_beside_it(command, script, tmp_path):
    (tmp_path / "beside_the_study.py").write_text("X = 1\n", encoding="utf-8")
    done = command("run", script("from beside_the_study import X\n"))
    assert (done.exit_code, done.stderr) == (0, "")


def test_a_misspelt_verb_is_answered_with_the_nearest(shell):
    done = shell("rnu", "study.py")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "workbench: No such command 'rnu'. Did you mean 'run'?\n"


def test_a_verb_without_its_argument_is_refused_in_one_line(shell):
    done = shell("run")
    assert (done.returncode, done.stderr) == (2, "workbench: Missing argument 'STUDY'.\n")


def test_no_verb_at_all_shows_the_verbs(shell):
    done = shell()
    assert done.returncode == 2
    assert "derive" in done.stderr


def test_one_import_finds_all_that_a_study_is_written_with():
    for name in study.__all__:
        assert getattr(study, name).__name__ == name
    with pytest.raises(AttributeError, match="no attribute 'Sweeep'"):
        _ = study.Sweeep


def test_derive_prints_the_arm_of_the_paper(command):
    done = command("derive", "paper-arm")
    assert (done.exit_code, done.stderr) == (0, "")
    # (2) and (3) of the paper, the latter with its second entry put right
    assert "M_22 = m_2*l_2^2" in done.stdout
    assert "C_12 = -m_2*l_1*l_2*(qd_1 + qd_2)*sin(q_2)" in done.stdout
    assert "links[1].mass" in done.stdout


@pytest.mark.parametrize("form", ["text", "latex", "typst", "mathml", "python", "casadi", "c"])
def test_derive_prints_each_form(command, form):
    done = command("derive", "planar-3r", "--format", form)
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout == text_of(Dynamics.of(robot("planar-3r"), "planar-3r"), form) + "\n"


URDF = """<robot name="pendulum"><link name="base"/>
<link name="bob"><inertial><mass value="2"/><origin xyz="0 0 -0.5"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="pivot" type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint></robot>"""


def test_derive_reads_a_urdf_file_and_takes_its_numbers(command, tmp_path):
    (tmp_path / "pendulum.urdf").write_text(URDF, encoding="utf-8")
    done = command("derive", "pendulum.urdf", "--numbers")
    assert (done.exit_code, done.stderr) == (0, "")
    # 0.1 + 2 * 0.5^2, and 2 * 9.81 * 0.5
    assert done.stdout.splitlines()[2:] == ["M_1 = 0.6", "", "C_1 = 0", "", "G_1 = 9.81*sin(q_1)"]


@pytest.mark.parametrize("name", ["PENDULUM.URDF", "pendulum", "pendulum.xml"])
def test_a_urdf_file_is_opened_whatever_its_ending(command, tmp_path, name):
    (tmp_path / name).write_text(URDF, encoding="utf-8")
    done = command("derive", name, "--numbers")
    assert (done.exit_code, done.stderr) == (0, "")


@pytest.mark.parametrize("name", ["pendulum.xml", "arms/pendulum"])
def test_what_is_neither_a_file_nor_in_the_catalogue_is_told_what_a_robot_may_be(command, name):
    done = command("derive", name)
    said = f"workbench: There is no file '{name}'; a robot is an arm of the catalogue or a URDF file.\n"
    assert (done.exit_code, done.stderr) == (2, said)


def test_a_urdf_file_that_is_not_there_is_refused(shell):
    done = shell("derive", "there/is/none.urdf")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("workbench: There is no")


SLOW = """
import time
print("started", flush=True)
time.sleep(60)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_ctrl_c_ends_with_130_and_leaves_nothing(script, tmp_path):
    with subprocess.Popen(
        [sys.executable, "-m", "workbench", "run", script(SLOW)],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == "started\n"
        _, said = stopped(process)
    assert (process.returncode, said) == (130, "workbench: stopped; no report was written.\n")
    assert not (tmp_path / "reports").exists()


LONG = """
import casadi as ca
import numpy as np
from workbench.core import Entry, Layout, Ode
from workbench.engine.metrics import rmse
from workbench.study.run_and_sweep import Run
from workbench.study.study import Case, Results, Study

class Loop:
    def ode(self, name="loop"):
        states = Layout((Entry("q", np.ones(1)),))
        t, x = ca.SX.sym("t"), states.symbols()
        return Ode.of(name, states, Layout(), (t, x, ca.SX(0, 1)), {"q": -x}, {"e": x, "q": x, "q_ref": 0 * x})

print("started", flush=True)
study = Study(
    name="long", title="Long", question="?", method="Long.", sections=lambda results: [],
    cases=(Case("s", "law", Run(Loop(), (rmse(),), h=5e-6, until=1e5, every=100.0)),),
)
"""


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_ctrl_c_stops_a_simulation_that_runs(tmp_path):
    (tmp_path / "long.py").write_text(LONG, encoding="utf-8")
    with warm_runs.start(["run", "long.py"], tmp_path) as process:
        assert process.stdout.readline() == "started\n"
        time.sleep(1)  # well into the run, which takes minutes
        _, said = stopped(process)
    kept = "workbench: stopped; 0 chunks are kept in 'reports/long'. The same command goes on from there."
    assert (process.returncode, said.splitlines()[-1]) == (130, kept)
    assert not (tmp_path / "reports" / "long" / "index.html").exists()


@needs_llvmlite
def test_the_doctor_says_which_engine_serves_and_where_its_kernels_are(command, monkeypatch, tmp_path):
    from workbench.engine.kernel import llvm

    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "kernels"))
    assert str(tmp_path / "kernels") in command("doctor").stdout
    monkeypatch.setenv("WORKBENCH_CACHE", "off")
    assert "compiled anew in every process" in command("doctor").stdout
    monkeypatch.setattr(llvm, "has_fma", lambda: False)
    said = " ".join(command("doctor").stdout.split())
    assert "compiled in the portable arithmetic, as this processor has no fused multiply-add" in said


def test_the_doctor_names_what_is_broken_and_ends_with_1(command, monkeypatch):
    monkeypatch.setattr("workbench.cli.doctor.ENOUGH_DISK", 2**80)
    monkeypatch.setattr("typst.compile", lambda *args, **kwargs: b"")
    done = command("doctor")
    assert done.exit_code == 1
    wrong = [line for line in done.stdout.splitlines() if line.startswith("wrong")]
    assert [line.split()[1:3] for line in wrong] == [["typst", "renders"], ["free", "disk"]]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
@pytest.mark.parametrize("words", [["--help"], ["derive", "paper-arm"]])
def test_output_that_cannot_be_written_is_said_in_one_line(shell, words):
    with open("/dev/full", "w") as full:
        done = shell(*words, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert (done.returncode, done.stderr) == (2, "workbench: No space left on device.\n")
