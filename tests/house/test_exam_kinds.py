"""Each kind of exam, sat on a small one: robots, Riccati equations, plants and designs."""

import pytest

from tests.exams import design
from tests.exams.__main__ import main
from tests.exams.sitter import sit
from tests.support.small_exams import ROOT

EXAMS = ROOT.parent / "shared" / "exams"


def lines_that_pass(*folders):
    """The lines of the verdicts on some exams, none of which is missed."""
    verdicts = [verdict for folder in folders for verdict in sit(folder)]
    assert [verdict.line for verdict in verdicts if verdict.passed is False] == []
    return [verdict.line for verdict in verdicts if verdict.passed]


# Several tests, so that the workers share the exams.
needs_exams = pytest.mark.skipif(not EXAMS.exists(), reason="the exams are not beside this project")


@pytest.mark.heavy
@needs_exams
def test_no_bar_of_the_exam_of_designs_is_missed():
    assert len(lines_that_pass(EXAMS / "design")) >= 8


@pytest.mark.heavy
@needs_exams
def test_no_bar_of_the_exam_of_identification_is_missed():
    sat = {line.partition(":")[0] for line in lines_that_pass(EXAMS / "identify")}
    kinds = ("clean", "noisy", "models", "logs", "filters", "loops", "nees", "coverage")
    assert {f"identify/{kind}" for kind in kinds} <= sat


@pytest.mark.heavy
@needs_exams
def test_no_bar_of_the_exam_of_planning_is_missed():
    sat = {line.partition(":")[0] for line in lines_that_pass(EXAMS / "planning")}
    assert {f"planning/{kind}" for kind in ("plan", "conflict")} <= sat


@pytest.mark.heavy
@needs_exams
def test_no_bar_of_the_other_shared_exams_is_missed():
    own = ("design", "identify", "planning")
    folders = (path for path in sorted(EXAMS.iterdir()) if path.is_dir() and path.name not in own)
    lines = lines_that_pass(*folders)
    sat = {line.partition(":")[0] for line in lines}
    assert {"ode/smooth", "ode/order", "ode/discontinuous", "ode/batch", "ode/dre"} <= sat
    assert {"dynamics/urdf", "dynamics/bodies", "dynamics/planar"} <= sat
    assert {"equations/text", "equations/latex", "equations/both readings"} <= sat
    assert {"durability/survival", "plants/plants"} <= sat
    assert {"carex/care", "carex/dare", "carex/lyapunov", "carex/bad inputs"} <= sat
    assert {"carex/care in other units", "carex/dare in other units"} <= sat
    printed = [line for line in lines if line.startswith(("equations/text:", "equations/latex:"))]
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
def test_an_exam_of_designs_has_a_part_for_each_kind_and_one_without_a_solver_is_not_sat(
    tmp_path, monkeypatch, gain, says
):
    monkeypatch.delitem(design.ELSEWHERE, "mu")
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "grade.py").write_text(DESIGNS, encoding="utf-8")
    given = '"id": "one", "kind": "margins", "num": [0.5], "den": [1, -1], "dt": 1.0, "delay": 0.0'
    cases = f'[{{{given}, "gain_high": {gain}}}, {{"id": "two", "kind": "mu"}}]'
    (tmp_path / "figures" / "visible.json").write_text(cases, encoding="utf-8")
    verdicts = {verdict.line.partition(":")[0]: verdict for verdict in sit(tmp_path)}
    assert verdicts["figures/margins"].line.startswith(f"figures/margins: {says}")
    assert verdicts["figures/mu"].line == "figures/mu: not sat, it has no solver here"
    assert verdicts["figures/mu"].passed is None
