"""The command `workbench live`: the page of a loop in a file, and what it refuses."""

import pytest

ERF = """
import casadi as ca
import workbench as wb
t, x, a = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("a")
odd = wb.Ode("odd", wb.layout(x="1"), wb.layout(a=("1", 1.0)), wb.layout(y="1"), t, x, a, ca.erf(a - x), x)
"""
FIRST = """
import workbench as wb
motor = wb.DCMotor()
law = wb.PID(motor.outputs, motor.inputs, Kp=100.0, Ki=200.0, low=-24.0, high=24.0)
loop = wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0, time=0.1))
alone = wb.open_loop(motor)
"""
RUNS = FIRST + "runs = {'PI': wb.simulate(wb.rk4(loop.ode(), 2e-3), until=0.4)}\n"


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        (RUNS, (), "'loop' until 0.4 s, at steps of 0.002 s."),
        pytest.param(
            *(RUNS, ("--until", "0.2", "--step", "1e-3"), "'loop' until 0.2 s, at steps of 0.001 s."),
            marks=pytest.mark.heavy,
        ),
        (FIRST, ("--loop", "alone", "--until", "0.2"), "'alone' until 0.2 s, at steps of 0.001 s."),
        (FIRST.replace("loop =", "first ="), ("--until", "0.2"), "'alone' until 0.2 s, at steps of 0.001 s."),
    ],
)
def test_the_command_writes_the_page_of_a_loop_in_a_file(command, tmp_path, text, words, said):
    (tmp_path / "motor.py").write_text(text, encoding="utf-8")
    done = command("live", "motor.py", *words)
    assert (done.exit_code, done.stderr) == (0, said + "\n")
    assert done.stdout == "The page is motor.html.\n"
    assert 'id="live"' in (tmp_path / "motor.html").read_text("utf-8")


def test_the_command_says_that_a_page_stays_printed(command, tmp_path):
    (tmp_path / "odd.py").write_text(ERF, encoding="utf-8")
    done = command("live", "odd.py", "--until", "1")
    assert done.exit_code == 0
    assert done.stderr.startswith("Nothing can be turned in this loop: The step of 'odd' has the operation ERF")
    assert "<script" not in (tmp_path / "odd.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("text", "words", "says"),
    [
        (
            "x = 1",
            (),
            "'motor.py' has no loop: it must define a `ClosedLoop`, an `Ode` or a `SampledSystem` by a name.",
        ),
        (FIRST, (), "`workbench live motor.py` needs a horizon, as the file has no runs: add `--until SECONDS`."),
        (FIRST, ("--loop", "loup"), "There is no 'loup' among the 2 loops in 'motor.py'. Did you mean 'loop'?"),
        (FIRST, ("--until", "0"), "`live(until=...)` must be a positive, finite number of seconds; got 0.0."),
        (RUNS, ("--step", "3e-3"), "`live(until=...)` must be a multiple of the step 0.003 s; got"),
        (FIRST, ("--until", "1", "--out", "none/a.html"), "`write('none/a.html')` must be in a folder that is there"),
        ("def", (), "motor.py, line 1: SyntaxError"),
        ("1 / 0", (), "motor.py, line 1: ZeroDivisionError: division by zero"),
    ],
)
def test_the_command_refuses_in_one_sentence(command, tmp_path, text, words, says):
    (tmp_path / "motor.py").write_text(text, encoding="utf-8")
    done = command("live", "motor.py", *words)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.startswith(f"workbench: {says}")
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.glob("*.html"))


@pytest.mark.parametrize("name", ["none.py", "."])
def test_the_command_refuses_a_file_that_is_none(command, name):
    done = command("live", name)
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
