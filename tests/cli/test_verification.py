"""`workbench verify`: a file of printed equations, a verdict a line, and bad files in one sentence."""

import json
import subprocess
import sys

import pytest

import workbench as wb
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import CATALOGUE, robot
from workbench.cli.derive import text_of

RIGHT = """# the arm of section 5
M[1,1] = m_1*l_1^2 + m_2*(l_1^2 + l_2^2 + 2*l_1*l_2*cos(q_2))
M_12 = M_21 = m_2*(l_2^2 + l_1*l_2*cos(q_2))
M_22 = m_2*l_2^2
C = [[-h*qd_2, -h*(qd_1 + qd_2)], [h*qd_1, 0]]
h = m_2*l_1*l_2*sin(q_2)
G = [(m_1 + m_2)*g*l_1*sin(q_1) + m_2*g*l_2*sin(q_1 + q_2), m_2*g*l_2*sin(q_1 + q_2)]
"""
# Equations (2) to (4) of the AOSMC-RGS paper, where (3) prints M[1,2] for C[1,2].
PAPER = r"""
\begin{equation}
M(q) = \begin{bmatrix}
 m_1 l_1^2 + m_2\left(l_1^2 + l_2^2 + 2 l_1 l_2 \cos q_2\right) & m_2 (l_2^2 + l_1 l_2 \cos q_2) \\
 m_2 (l_2^2 + l_1 l_2 \cos q_2) & m_2 l_2^2
\end{bmatrix}, \label{eq:2}
\end{equation}
\begin{align}
C(q,\dot q) &= \begin{bmatrix}
   -m_2l_1l_2 s_2\dot q_2 & m_2 (l_2^2 + l_1 l_2 \cos q_2) \\ m_2 l_1 l_2 s_2 \dot{q}_1 & 0 \end{bmatrix} \\
G(q) &= \begin{pmatrix} (m_1+m_2) g l_1 \sin q_1 + m_2 g l_2 \sin(q_1+q_2) \\ m_2 g l_2 \sin(q_1+q_2) \end{pmatrix}
\end{align}
\[ s_2 = \sin q_2 \]
"""


@pytest.fixture
def verify(command, tmp_path):
    """Write a file and hold it against an arm."""

    def call(said, name="paper.txt", robot="paper-arm"):
        (tmp_path / name).write_bytes(said if isinstance(said, bytes) else said.encode())
        return command("verify", name, "--robot", robot)

    return call


def test_right_equations_are_a_line_each_and_exit_0(verify):
    done = verify(RIGHT)
    labels = ["M[1,1]", "M[1,2]", "M[2,1]", "M[2,2]", "C[1,1]", "C[1,2]", "C[2,1]", "C[2,2]", "G[1]", "G[2]"]
    lines = [f"{label:8} same" for label in labels]
    assert done.stdout.splitlines() == [*lines, "10 of 10 printed entries are proved right, 0 differ."]
    assert (done.exit_code, done.stderr) == (0, "")


def test_the_paper_is_wrong_in_c12_and_the_details_say_how(verify):
    done = verify(PAPER, "paper.tex")
    assert done.exit_code == 1
    assert done.stdout.splitlines()[5:14] == [
        "C[1,2]   differs",
        "  printed  m_2*(l_2^2 + l_1*l_2*cos(q_2))",
        "  right    -m_2*l_1*l_2*(qd_1 + qd_2)*sin(q_2)",
        "  seen     1.5403 for 0 at q = (0.5, 1), qd = (1, -1), nominal parameters",
        "  replay   M, C, G = dynamics.matrices((0.5, 1), (1, -1))",
        "  units    it is in kg m^2, where kg m^2/s is right",
        "  torque   C qd is wrong as well",
        "  slip     this is M[1,2], printed in another place",
        "C[2,1]   same",
    ]
    assert done.stdout.endswith("9 of 10 printed entries are proved right, 1 differs.\n")


def test_another_factorisation_of_the_torque_is_told_from_a_wrong_one(verify):
    done = verify("C = [[0, -h*(2*qd_1 + qd_2)], [h*qd_1, 0]]\nh = m_2*l_1*l_2*sin(q_2)")
    assert done.exit_code == 1
    assert done.stdout.count("C qd is right all the same: another factorisation of it") == 2
    assert "slip" not in done.stdout
    assert (
        "C is another factorisation of the right torque; M' - 2C is not skew with it, as at q = (0.5, 1)" in done.stdout
    )
    assert "6 of the 10 entries of M, C and G are not printed, and not judged." in done.stdout


def test_of_a_row_of_c_that_is_printed_in_part_the_torque_is_open(verify):
    done = verify("C_11 = -2*m_2*l_1*l_2*sin(q_2)*qd_2")
    assert "torque   this row of C is not printed in full, so whether C qd is right is open" in done.stdout


def test_an_entry_that_another_misprint_makes_wrong_is_not_blamed(verify):
    done = verify("C = [[-2*h*qd_2, -h*qd_1], [h*qd_1, 0]]\nh = m_2*l_1*l_2*sin(q_2)")
    said = "torque   this entry is right in another factorisation of C qd, once C[1,2] is corrected"
    assert (done.stdout.count(said), done.stdout.count("slip")) == (1, 1)


def test_values_that_differ_late_are_printed_to_the_digit_that_differs(verify):
    assert "seen     1.0000001 for 1 at" in verify("M_22 = m_2*l_2^2 + 1e-7*m_1").stdout


@pytest.mark.heavy
def test_a_right_side_too_long_for_the_eye_is_not_printed(verify):
    said = "right    longer than can be compared by eye; see `workbench derive`"
    done = verify("M_11 = 0\nM_66 = 0\nG_2 = 0", robot="ur5")
    assert done.stdout.count(said) == 1  # of M[1,1]; G[2] and M[6,6] are short without the robot's zeros
    assert len(done.stdout.splitlines()) < 30
    assert max(map(len, done.stdout.splitlines())) < 160


def test_the_numbers_that_were_taken_as_given_are_said(verify):
    done = verify("M_22 = m_2*c_2^2 + I_2", robot="planar-2r")
    assert done.exit_code == 0
    assert "Taken as given: links[0].offset = 0, links[1].offset = 0." in done.stdout


def test_what_is_neither_proved_nor_refuted_is_never_called_right(verify):
    done = verify("M_22 = m_2*l_2^2*sqrt(l_1^2)/l_1")
    assert done.exit_code == 0
    assert "M[2,2]   same as far as is seen: not refuted in 400 samples" in done.stdout
    assert "0 of 1 printed entries are proved right, 0 differ.\n1 could be neither proved nor refuted." in done.stdout


def test_a_file_with_a_backslash_is_latex_whatever_its_name(verify):
    assert verify(PAPER, "paper.txt").exit_code == 1
    assert verify(r"M_{22} = m_2 l_2^{2}", "paper").exit_code == 0
    assert verify("M_22 = m_2*l_2^2  # not \\frac{}{}").exit_code == 0


def test_a_paper_may_declare_its_own_letters_and_angles(verify):
    said = r"""
        l_{c1} = \text{links[0].com}, \; l_{c2} = \mathtt{links[1].com}, \quad \theta_{12} = \theta_1 + \theta_2
        \begin{eqnarray*}
        M_{22} &=& I_2 + m_2 l_{c2}^{2} \\
        M_{12} &=& M_{22} + m_2 l_1l_{c2} \cos\theta_2 \\
        G_2    &=& m_2 g l_{c2} \sin\theta_{12}
        \end{eqnarray*}
        C_{21} = m_2 l_1 l_{c2}\sin(\theta_2)\dot\theta_1"""
    done = verify(b"\xef\xbb\xbf" + said.encode().replace(b"\n", b"\r\n"), "paper.tex", "planar-2r")
    assert (done.exit_code, done.stderr) == (0, "")
    assert "4 of 4 printed entries are proved right, 0 differ." in done.stdout


def test_a_verdict_has_a_colour_on_a_terminal(verify):
    from click.testing import CliRunner

    from workbench.cli.command import cli

    verify(PAPER, "paper.tex")
    done = CliRunner().invoke(cli, ["verify", "paper.tex", "--robot", "paper-arm"], color=True)
    assert "\x1b[32mM[1,1]   same\x1b[0m" in done.stdout
    assert "\x1b[31mC[1,2]   differs\x1b[0m" in done.stdout


def test_a_file_that_is_not_there_or_no_text_or_no_robot_is_one_sentence(verify, command):
    done = command("verify", "nowhere.txt", "--robot", "paper-arm")
    assert (done.exit_code, done.stderr) == (
        2,
        "workbench: There is no file 'nowhere.txt'; name a file of equations, .txt or .tex.\n",
    )
    done = verify(b"\xff\xfe\x00")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "no text in UTF-8" in done.stderr
    done = verify("M_22 = m_2", robot="paperarm")
    assert (done.exit_code, "Did you mean 'paper-arm'?" in done.stderr) == (2, True)
    done = verify(b"M_22 = m_2" + b" " * 300_000)
    assert (done.exit_code, "at most 50000 characters" in done.stderr) == (2, True)


HOSTILE = {
    "attribute.txt": "M[1,1] = m_1.__class__.__mro__",
    "import.txt": "M[1,1] = __import__('os').system('touch pwned')",
    "lambda.txt": "M[1,1] = (lambda: open('pwned', 'w'))()",
    "tower.txt": "M[1,1] = 9^9^9^9",
    "power.txt": "M[1,1] = m_1^999999999",
    "powers.txt": "M[1,1] = ((((m_1+l_1+g+l_2)^16+l_1)^16+l_1)^16)^16",
    "wide.txt": "M[1,1] = " + "*".join(f"(m_1+{k}*l_1+m_2+l_2+sin(q_1)+cos(q_2))" for k in range(12)),
    "waves.txt": "M[1,1] = " + "*".join(f"(sin({k}*q_1)+cos({k}*q_2))" for k in range(1, 9)) + "*(m_1+m_2)^16",
    "brackets.txt": "M[1,1] = " + "(" * 5000 + "m_1" + ")" * 5000,
    "minus.txt": "M[1,1] = " + "-" * 5000 + "m_1",
    "doubling.txt": "a_0 = m_1 + l_1\n"
    + "".join(f"a_{i} = a_{i - 1}*(a_{i - 1} + 1)\n" for i in range(1, 40))
    + "G_1 = a_39",
    "unknown.txt": "M[1,1] = mm_1*l_1^2",
    "comma.txt": "M[1,1] = 1,5*m_1",
    "letters.txt": "M[1,1] = " + "m" * 40_000,
    "huge.txt": "M[1,1] = 1e99999999*m_1",
    "digits.txt": "M[1,1] = " + "9" * 40_000,
    "zero.txt": "M[1,1] = m_1/(l_1 - l_1)",
    "nul.txt": "M[1,1] = m_1\0",
    "input.tex": r"M_{11} = \input{/etc/passwd}",
    "write.tex": r"\write18{touch pwned} M_{11} = m_1",
    "index.tex": r"M_{11} = m_{\input{/etc/passwd}}",
    "def.tex": r"\def\x{m_1} M_{11} = \x",
    "csname.tex": r"\csname input\endcsname{x}",
    "fractions.tex": r"M_{11} = " + r"\frac{1}{" * 2000 + "m_1" + "}" * 2000,
    "dots.tex": r"M_{11} = " + r"\dot" * 5000 + "{q}_1",
    "open.tex": r"M = \begin{bmatrix} 1 & 2 \\ 3",
    "spaces.tex": r"\a" + " " * 40_000 + r"\b",
    "names.tex": r"M_{11} = " + "mglq" * 10_000,
    "braces.tex": r"M_{11} = {\a" + " " * 40_000 + "}_1",
    "end.tex": "M_{11} = m_1\\",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_input_is_one_sentence_with_its_place(verify, tmp_path, name):
    done = verify(HOSTILE[name], name)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f"workbench: {name}: ")
    assert done.stderr.count("\n") == 1
    assert len(done.stderr) < 400
    assert [file.name for file in tmp_path.iterdir()] == [name]


TIMED = """
import json, re, sys, time
from workbench.arms.dynamics import Dynamics
from workbench.arms.mechanics import paper_arm
from workbench.cli.printed_comparison import findings
from pathlib import Path
arm, worst = Dynamics.of(paper_arm()), 0.0
for name, said in json.load(sys.stdin).items():
    Path(name).write_text(said)
    start = time.process_time()
    try:
        findings(Path(name), arm)
    except ValueError:
        pass
    worst = max(worst, time.process_time() - start)
# not getrusage, whose peak is at first that of the process which this one was forked from
peak = int(re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())[1])
print(json.dumps([worst, peak / 1024]))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the peak of memory is read from /proc")
def test_hostile_input_is_refused_within_two_seconds_and_500_megabytes(tmp_path):
    call = [sys.executable, "-c", TIMED]
    said = json.dumps(HOSTILE)
    done = subprocess.run(call, input=said, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=120)
    seconds, megabytes = json.loads(done.stdout)
    assert seconds < 2
    assert megabytes < 500
    assert not (tmp_path / "pwned").exists()


# Equations that take seconds to read: of the longest three one is enough, with the others for all tests.
LONG = ("planar-6r", "panda", "ur5", "scara", "planar-4r")
READ_WITH_ALL = ("panda", "scara", "planar-4r")


@pytest.mark.parametrize(
    "robot",
    [
        *(name for name in CATALOGUE if name not in LONG),
        *(pytest.param(name, marks=pytest.mark.heavy) for name in READ_WITH_ALL),
    ],
)
def test_what_derive_prints_is_read_back_and_found_right(verify, robot):
    printed = text_of(Dynamics.of(wb.robot(robot), robot), "text")
    done = verify(printed, robot=robot)
    assert (done.exit_code, done.stderr) == (0, "")
    entries = (2 * wb.robot(robot).dof + 1) * wb.robot(robot).dof
    assert done.stdout.count(" same\n") == entries


@pytest.mark.heavy
def test_a_long_sheet_with_one_sign_changed_is_not_called_right(verify):
    printed = text_of(Dynamics.of(robot("ur5"), "ur5"), "text")
    place = printed.rindex(" - ")
    done = verify(f"{printed[:place]} + {printed[place + 3 :]}", robot="ur5")
    assert (done.exit_code, done.stdout) == (2, "")
