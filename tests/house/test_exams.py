"""The sitter of the exams: on the shared ones where they are, and on small ones made here."""

import math
import subprocess
import sys
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from tests.exams import ode as ode_exams
from tests.exams.__main__ import main
from tests.exams.graders import find, loaded
from tests.exams.sitter import sit
from tests.exams.tracing import UntraceableError, trace

ROOT = Path(__file__).parents[2]
EXAMS = ROOT.parent / "shared" / "exams"

PROBLEMS = """
import math
import numpy as np
from math import exp

class Plain:
    sin, cos, largest = math.sin, math.cos, max
    num = staticmethod(float)

step = lambda x: int(x > 0) - int(x < 0)

def spring(m):
    return lambda t, x: [x[1], -4 * m.sin(x[0]) / m.cos(0.0) - exp(-t)]

def decay(m):
    rate = m.cos
    return lambda t, x: [-x[0] * rate(0.0) * m.num('1')]

def ramp(m):
    return lambda t, x: [m.largest(x[0], 0.5)]

def drag(t, x):
    return [-step(x[0]) * min(abs(x[0]), 1.0) + max([0.0, math.tanh(t)])]

def rows(t, x):
    A = np.array([[0.0, 1.0], [-math.exp(-t), x[1] * x[1]]])
    return A @ np.array([x[0], np.sign(x[1])]) + np.sin(x)

def stuck(t, x):
    while x[0] > 0.5:
        x = x / 2
    return [-x[0]]

def relay(t, x):
    if x[0] > 0:
        u = -1.0
    elif x[0] < 0:
        u = 1.0
    else:
        u = 0.0
    return [u + 0.3 * t]

def pushed(t, x):
    return [(-1.0 if x[0] > 0 else 1.0) + 0.3 * t]

def saturated(t, x):
    def sat(z):
        if z > 1: return 1.0
        if z < -1: return -1.0
        return z
    return [-sat(x[0] / 0.4) - float(np.sign(x[0])) + np.where(t > 1, 1.0, 2.0)]

def guarded(t, x):
    return [-x[0] / abs(x[0]) if x[0] != 0 else 0.5, 1.0 if x[1] == 0 else x[0]]

def filled(t, x):
    rate = np.zeros(2)
    rate[0] = x[1]
    rate[1] = -np.square(x[0])
    A = np.array([[0.0, 1.0], [-1.0, 0.0]])
    A[1, 1] = np.cos(x[0])
    return rate + A @ x

def solved(t, x):
    M = np.array([[3 + 2 * np.cos(x[1]), 1 + np.cos(x[1])], [1 + np.cos(x[1]), 1.0]])
    right = np.array([-np.sin(x[0]), -t])
    K = np.linalg.inv(np.array([[2.0, 1.0], [0.0, 4.0]]))
    return np.linalg.solve(M, right) + np.linalg.inv(M) @ right + K.dot(x) + np.linalg.norm(x) * np.linalg.det(M)

def text(t, x):
    return [-x[0] + 'one']
"""

GRADER = """
'''Exam: grade_order(fixed, p); grade_batch(batch): batch(x0s, t1, n) for the problem 'decay'.'''
import math
import numpy as np
import problems as pr

def smooth():
    yield 'decay', pr.decay(pr.Plain), np.array([1.0]), [1.0, 2.0], np.array([[math.exp(-1.0)], [math.exp(-2.0)]])

def grade_adaptive(integrate, verbose=True):
    cases = []
    for name, f, x0, times, exact in smooth():
        error = float(np.abs(integrate(f, x0, times, 1e-8, 1e-8) - exact).max())
        print('the grader saw', name)
        outcome = 'pass' if error < LIMIT else 'FAIL'
        cases.append(dict(id=name, errors=[error], limits=[LIMIT], outcome=outcome))
    return dict(passed=all(case['outcome'] == 'pass' for case in cases), cases=cases)

def grade_order(fixed, p):
    cases = []
    for name, f, x0, times, exact in smooth():
        errors = [float(np.abs(fixed(f, x0, times[0], n) - exact[0]).max()) for n in (8, 16)]
        order = math.log2(errors[0] / errors[1])
        cases.append(dict(id=name, order=order, outcome='pass' if abs(order - p) < 0.1 else 'FAIL'))
    return dict(passed=all(case['outcome'] == 'pass' for case in cases), cases=cases)

def grade_discontinuous(sim):
    t, x = sim(pr.JUMP, np.array([1.0]), 1.0, 0.01, 'jump')
    ok = bool(np.isfinite(x).all()) and len(t) == 101
    return dict(passed=ok, cases=[dict(id='jump', dev_over_h=[0.5], bound=2.0, outcome='pass' if ok else 'FAIL')])

def grade_batch(batch):
    starts = np.array([[1.0], [2.0], [np.nan]])
    ends = batch(starts, 1.0, 50)
    differences = dict(alone=float(np.abs(ends[1] - batch(starts[1:2], 1.0, 50)[0]).max()), kept=float(len(ends) - 3))
    return dict(passed=all(value == 0 for value in differences.values()), diffs=differences)
"""


@pytest.fixture
def exam(tmp_path):
    """A folder with one exam of simulation; its limit, and the problem that jumps, as given."""

    def write(limit="1e-6", jump="drag", grader=GRADER, name="motion"):
        folder = tmp_path / "exams" / name
        folder.mkdir(parents=True)
        (folder / "problems.py").write_text(f"{PROBLEMS}\nJUMP = {jump}\n", encoding="utf-8")
        (folder / "grade.py").write_text(grader.replace("LIMIT", limit), encoding="utf-8")
        return tmp_path / "exams"

    return write


@pytest.mark.heavy
@pytest.mark.skipif(not EXAMS.exists(), reason="the exams are not beside this project")
def test_no_bar_of_the_shared_exams_is_missed():
    verdicts = list(sit(EXAMS))
    assert [verdict.line for verdict in verdicts if verdict.passed is False] == []
    sat = {verdict.line.partition(":")[0] for verdict in verdicts if verdict.passed}
    assert {"ode/smooth", "ode/order", "ode/discontinuous", "ode/batch", "ode/dre"} <= sat
    assert {"dynamics/urdf", "dynamics/bodies", "dynamics/planar"} <= sat
    assert {"equations/text", "equations/latex", "equations/both readings"} <= sat
    assert {"durability/survival", "plants/plants"} <= sat
    assert {"carex/care", "carex/dare", "carex/lyapunov", "carex/bad inputs"} <= sat
    assert {"carex/care in other units", "carex/dare in other units"} <= sat
    printed = [verdict.line for verdict in verdicts if verdict.line.startswith(("equations/text:", "equations/latex:"))]
    assert all("0 missed, 0 false alarms in " in line and "5 of 5 robots derived here" in line for line in printed)


PENDULUMS = """
'''Exam: two pendulums on one post, the second first; no URDF; M, G and the acceleration in closed form.'''
import numpy as np

def body(name, parent, mass, length):
    return dict(joint=name, type='R', parent=parent, axis=[0.0, 1.0, 0.0], placement_R=np.eye(3).tolist(),
                placement_p=[0.1, 0.0, 0.0], mass=mass, com=[0.0, 0.0, -length], inertia_com=np.zeros((3, 3)).tolist())

ARMS = {'one': [(2.0, 0.5)], 'two': [(2.0, 0.5), (3.0, 0.7)]}

def robots():
    return {name: dict(bodies=[body(f'j{i}', None, *arm) for i, arm in enumerate(arms)]) for name, arms in ARMS.items()}

def grade_robot(name, functions):
    m, l = np.array(ARMS[name]).T
    q, qd, tau = np.full((3, len(m)), 0.4) * [[1.0], [2.0], [3.0]]
    M, G = np.diag(m * l**2), m * 9.81 * l * np.sin(q)
    right = dict(M=(M, q), G=(G, q), ddq=((tau - G) / np.diag(M), q, qd, tau))
    errors = {key: np.abs(np.reshape(functions[key](*at), np.shape(x)) - x).max() for key, (x, *at) in right.items()}
    return {key: dict(outcome='pass' if e < LIMIT else 'FAIL', error=e, tol=LIMIT) for key, e in errors.items()}
"""


def test_any_folder_of_robots_is_sat_through_its_bodies(exam, capsys):
    folder = exam(grader=PENDULUMS, limit="1e-13")
    assert main([str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "motion/urdf: there is no such robot"
    assert lines[1].startswith("motion/bodies: 2 of 2 robots, worst error ")
    assert lines[2].startswith("motion/planar: 1 of 1 robots")
    (folder / "motion" / "grade.py").write_text(PENDULUMS.replace("LIMIT", "1e-300").replace("9.81", "9.8"))
    assert main([str(folder)]) == 1
    assert "motion/bodies: MISSED, 0 of 2 robots" in capsys.readouterr().out


def test_an_exam_that_is_passed_is_a_line_with_its_figure_and_no_failure(exam, capsys):
    assert main([str(exam())]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 4
    assert lines[0].startswith("motion/smooth: 1 of 1, worst error ")
    assert lines[0].endswith(" of its limit")
    assert lines[1].startswith("motion/order: 1 of 1, worst order 0.0")
    assert lines[2:] == [
        "motion/discontinuous: 1 of 1, worst deviation 0.25 of its bound",
        "motion/batch: 2 of 2 bit-identical",
    ]


def test_a_bar_that_is_missed_is_named_and_fails(exam, capsys):
    assert main([str(exam(limit="1e-300"))]) == 1
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith("motion/smooth: MISSED, 0 of 1")
    assert first.endswith("failed: decay")


def test_the_graders_own_lines_are_shown_on_request_only(exam, capsys):
    folder = exam()
    main([str(folder)])
    assert "the grader saw" not in capsys.readouterr().out
    main([str(folder), "-v"])
    assert "the grader saw decay\n" in capsys.readouterr().out


def test_a_function_that_has_no_graph_fails_a_fixed_step_with_a_sentence(exam, capsys):
    assert main([str(exam(jump="stuck"))]) == 1
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "discontinuous" in line]
    assert "MISSED, 0 of 1" in line
    assert "its function has no graph" in line


RICCATI = """
'''Exam: X of a scalar equation; the second one is given a wrong reference if SPOILT.'''
def _case(name, n, outcome):
    return dict(id=name, n=n, seconds=0.1, outcome=outcome, forward=1e-16, forward_tol=1e-12)

def grade_care(solver):
    X = solver([[1.0]], [[1.0]], [[3.0]], [[1.0]])[0, 0]
    cases = [_case('one', 1, 'solved' if abs(X - 3) < 1e-15 else 'wrong')]
    cases.append(_case('two', 1, 'wrong' if SPOILT else 'solved'))
    counts = {}
    for case in cases: counts[case['outcome']] = counts.get(case['outcome'], 0) + 1
    return dict(counts=counts, total=2, passed='wrong' not in counts, cases=cases)

def grade_bad_inputs(solver):
    try: solver([[float('nan')]], [[1.0]], [[1.0]], [[1.0]])
    except ValueError as error: outcome = 'refused' if 'nan' in str(error) else 'crashed'
    else: outcome = 'wrong'
    return dict(counts={outcome: 1}, total=1, passed=outcome == 'refused', cases=[dict(id='nan', outcome=outcome)])
"""


@pytest.mark.parametrize(
    ("spoilt", "line"),
    [
        (False, "algebra/care: 2 of 2 solved, 0 refused, 0 wrong, worst error 0.0001 of its limit; n = 1 in 0.1 s"),
        (
            True,
            "algebra/care: MISSED, 1 of 2 solved, 0 refused, 1 wrong, worst error 0.0001 of its limit; n = 1 in 0.1 s; "
            "failed: two",
        ),
    ],
)
def test_an_exam_of_riccati_equations_is_sat_and_a_wrong_answer_misses_it(exam, spoilt, line):
    verdicts = list(sit(exam(grader=RICCATI.replace("SPOILT", str(spoilt)), name="algebra")))
    assert [verdict.line for verdict in verdicts] == [line, "algebra/bad inputs: 1 of 1 refused"]


def test_what_is_not_known_is_named_and_fails_nothing(tmp_path, capsys):
    for name in ("poetry", "other"):
        (tmp_path / name).mkdir()
    (tmp_path / "other" / "grade.py").write_text("raise SystemExit(3)\n", encoding="utf-8")
    assert main([str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "unknown: poetry (it has no grader)",
        "unknown: other (its grader asks for nothing that is known here)",
    ]


def test_a_grader_that_breaks_is_a_missed_bar(exam):
    (verdict,) = sit(exam(grader="def grade_order(fixed, p):\n    return 1 / 0\n"))
    assert verdict.passed is False
    assert verdict.line == "motion/order: MISSED, it broke: ZeroDivisionError: division by zero"


@pytest.mark.parametrize("word", ["sys.exit(3)", "sys.exit()"])
def test_a_grader_that_exits_does_not_end_the_sitting(exam, capsys, word):
    exam(grader=f"import sys\ndef grade_order(fixed, p):\n    {word}\n", name="early")
    assert main([str(exam())]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("early/order: MISSED, it broke: SystemExit")
    assert len(lines) == 5


def test_a_grader_that_is_no_python_is_missed_with_the_reason(exam, capsys):
    assert main([str(exam(grader="def (\n"))]) == 1
    assert capsys.readouterr().out.startswith("motion: MISSED, its grader cannot be read: SyntaxError: invalid syntax")


def test_a_folder_by_the_name_of_a_grader_is_none(exam, tmp_path, capsys):
    (tmp_path / "exams" / "odd" / "grade.py").mkdir(parents=True)
    assert main([str(exam())]) == 0
    assert capsys.readouterr().out.startswith("unknown: odd (it has no grader)")


def test_an_exam_that_asks_nothing_is_missed(exam, capsys):
    empty = "def grade_order(fixed, p): return dict(passed=True, cases=[])\n"
    assert main([str(exam(grader=empty + "def grade_batch(batch): return dict(passed=True)\n"))]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("motion/order: MISSED, 0 of 0")
    assert lines[1] == "motion/batch: MISSED, 0 of 0 bit-identical"


@pytest.mark.parametrize("jump", ["text", "lambda t, x: [x[0] if type(x[0]) is type(t) else None + 1]"])
def test_a_function_that_breaks_fails_its_own_case_only(exam, capsys, jump):
    assert main([str(exam(jump=jump))]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines if "MISSED" in line] == ["motion/discontinuous"]
    assert lines[2].startswith("motion/discontinuous: MISSED, 0 of 1")


def test_a_folder_without_exams_and_a_file_are_told_of_and_exit_2(tmp_path, capsys):
    assert main([str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"There is no exam below '{tmp_path}'.\n"
    (tmp_path / "grade.py").touch()
    assert main([str(tmp_path / "grade.py")]) == 2
    assert capsys.readouterr().err == f"'{tmp_path / 'grade.py'}' is a file: name the folder that holds the exams.\n"


@pytest.mark.heavy
def test_a_folder_that_is_not_there_is_one_sentence_and_exit_2(tmp_path):
    call = [sys.executable, "-m", "tests.exams", str(tmp_path / "nowhere")]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "There is no folder" in done.stderr


def test_graders_leave_nothing_behind(exam):
    modules, path = set(sys.modules), list(sys.path)
    (grader,) = find(exam())
    with loaded(grader) as one:
        problems = sys.modules["problems"]
        before = dict(vars(problems)), dict(vars(problems.Plain))
        trace(problems.spring(problems.Plain), [1.0, 0.0], one.modules)
        assert (dict(vars(problems)), dict(vars(problems.Plain))) == before
    list(sit(grader.file.parents[1]))
    assert not {name for name in set(sys.modules) - modules if name in ("problems", "grade")}
    assert sys.path == path


def test_a_traced_function_is_the_plain_one(exam):
    (grader,) = find(exam())
    with loaded(grader) as one:
        problems = sys.modules["problems"]
        spring, drag = problems.spring(problems.Plain), problems.drag
        ode = trace(spring, [1.0, 0.0], one.modules)
        jump = trace(drag, [1.0], one.modules)
        ramp = trace(problems.ramp(problems.Plain), [1.0], one.modules)
    assert [ramp.rate_at(0.0, [x])[0] for x in (0.2, 0.7)] == [0.5, 0.7]
    np.testing.assert_allclose(ode.rate_at(0.3, [0.4, 2.0]), [2.0, -4 * math.sin(0.4) - math.exp(-0.3)], rtol=1e-15)
    for x in (-3.0, -0.5, 0.0, 0.5, 3.0):
        np.testing.assert_allclose(jump.rate_at(0.3, [x]), drag(0.3, [x]), rtol=1e-15)
    assert isinstance(drag(0.3, [1.0])[0], float)


def test_a_function_written_with_arrays_is_traced_too(exam):
    with loaded(find(exam())[0]) as one:
        rows = sys.modules["problems"].rows
        ode = trace(rows, [1.0, -0.5], one.modules)
    x = np.array([0.4, -2.0])
    expected = [-1 + math.sin(0.4), -math.exp(-0.3) * 0.4 - 4 + math.sin(-2.0)]
    np.testing.assert_allclose(rows(0.3, x), expected, rtol=1e-14)
    np.testing.assert_allclose(ode.rate_at(0.3, x), expected, rtol=1e-14)


@pytest.mark.parametrize("name", ["relay", "saturated", "guarded", "filled", "solved"])
def test_conditions_arrays_that_are_filled_and_linear_algebra_are_traced(exam, name):
    with loaded(find(exam())[0]) as one:
        plain = getattr(sys.modules["problems"], name)
        size = 1 if name in ("relay", "saturated") else 2
        ode = trace(plain, np.full(size, 0.5), one.modules)
    for x in [*np.random.default_rng(1).normal(size=(20, size)), np.zeros(size) + (name == "solved")]:
        np.testing.assert_allclose(ode.rate_at(0.7, x), np.ravel(plain(0.7, x)), rtol=1e-12, atol=1e-13)  # rounding


def test_a_condition_is_a_surface_to_the_reference_mode(exam):
    with loaded(find(exam())[0]) as one:
        pushed = sys.modules["problems"].pushed
        run = ode_exams.Candidate(one).integrate(pushed, [0.5], [2.0, 4.0], 1e-9, 1e-9)
    # held at zero until 0.3 t = 1, then x' = 0.3 t - 1
    np.testing.assert_allclose(run[:, 0], [0.0, 0.15 * 16 - 4 + 1 / 0.6], atol=1e-9)


def test_a_way_that_the_reference_mode_refuses_is_left_to_the_plain_function(exam):
    # three ways on one surface, the middle one for zero alone: no law of sliding, and none is needed here
    with loaded(find(exam())[0]) as one:
        run = ode_exams.Candidate(one).integrate(sys.modules["problems"].relay, [-1.0], [0.5], 1e-9, 1e-9)
    np.testing.assert_allclose(run, [[-1 + 0.5 + 0.15 * 0.25]], atol=1e-9)


def test_a_loop_until_a_number_is_small_is_not_traced(exam):
    with loaded(find(exam())[0]) as one, pytest.raises(UntraceableError, match="asks more than 64 questions"):
        trace(sys.modules["problems"].stuck, [1.0], one.modules)


def test_too_many_ways_are_not_traced(exam):
    def many(t, x):
        return [sum(1.0 if x[0] > i else 0.0 for i in range(9))]

    with pytest.raises(UntraceableError, match="more than 256 ways"):
        trace(many, [1.0], [])
    assert not ca.SX.__bool__(ca.SX(0))


def test_a_function_with_a_hidden_memory_is_not_taken_for_its_graph():
    calls = []

    def drifting(t, x):
        calls.append(t)
        return [-x[0] + len(calls)]

    with pytest.raises(UntraceableError, match="other numbers"):
        trace(drifting, [1.0], [])


PLANTS = """
def falling(t, x, u, m):
    return [x[1], u[0] - m.sqrt(x[0])]

def load(folder, name):
    ports = dict(states=("p:m", "v:m/s"), inputs=("a:m/s^2",), outputs=("p",))
    at = dict(x=(3.0, 0.3), u=(2.0,), x0=(4.0, 0.0), Q=(1.0, 1.0), R=(1.0,), period=0.1, balance=True)
    return {"falling": dict(name="falling", f=falling, kept=[0, 1], **ports, **at)}, {"falling": REST}

def grade(solve, cases, reference):
    x = solve(cases["falling"])["x"]
    return ["falling: passed" if abs(x - reference["falling"]).max() < 1e-9 else f"falling: {x}"], True
"""


@pytest.mark.parametrize(("rest", "says"), [("[4, 0]", "1 of 1 passed"), ("[5, 0]", "MISSED, 0 of 1 passed; falling")])
def test_an_exam_of_plants_is_sat_case_by_case(tmp_path, rest, says):
    (tmp_path / "tanks").mkdir()
    (tmp_path / "tanks" / "grade.py").write_text(PLANTS.replace("REST", rest), encoding="utf-8")
    (tmp_path / "tanks" / "visible.json").write_text("{}", encoding="utf-8")
    (verdict,) = sit(tmp_path)
    assert verdict.line.startswith(f"tanks/plants: {says}")


DESIGNS = """
def load_designs(path):
    import json
    return json.load(open(path))

def grade_designs(solve, cases):
    right = [abs(float(solve(case)["gain_high"]) - case["gain_high"]) < 1e-12 for case in cases]
    lines = [f"{case['id']}: {'right' if good else 'wrong, missed gain_high'}" for case, good in zip(cases, right)]
    counts = {"margins": {"right": sum(right), **({"wrong": right.count(False)} if False in right else {})}}
    return dict(lines=lines, counts=counts, passed=all(right))
"""


@pytest.mark.parametrize(("gain", "says"), [("4", "1 of 1 right"), ("5", "MISSED, 0 of 1 right, 1 wrong; one: wrong")])
def test_an_exam_of_designs_has_a_part_for_each_kind_and_one_without_a_solver_is_not_sat(tmp_path, gain, says):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "grade.py").write_text(DESIGNS, encoding="utf-8")
    given = '"id": "one", "kind": "margins", "num": [0.5], "den": [1, -1], "dt": 1.0, "delay": 0.0'
    cases = f'[{{{given}, "gain_high": {gain}}}, {{"id": "two", "kind": "mu"}}]'
    (tmp_path / "figures" / "visible.json").write_text(cases, encoding="utf-8")
    verdicts = {verdict.line.partition(":")[0]: verdict for verdict in sit(tmp_path)}
    assert verdicts["figures/margins"].line.startswith(f"figures/margins: {says}")
    assert verdicts["figures/mu"].line == "figures/mu: not sat, it has no solver here"
    assert verdicts["figures/mu"].passed is None
