"""The exam of printed equations on a small one made here; `test_exams.py` sits the shared one."""

import copy
import json

import pytest

from tests.exams import equations
from tests.exams.__main__ import main
from tests.exams.graders import find, loaded

GRADER = """
import json, os
def grade(check, verbose=True):
    cases = json.load(open(os.path.join(os.path.dirname(__file__), "cases.json")))["cases"]
    found = [(case["truth"], case["where"], check(case)) for case in cases]
    missed = [truth for truth, where, said in found if truth == "mismatch" != said["verdict"]]
    false = [truth for truth, where, said in found if truth != "mismatch" and truth != said["verdict"]]
    places = [where == said["where"] for truth, where, said in found if truth == "mismatch"]
    located = sum(places) / max(len(places), 1)
    passed = not missed and not false and located >= 0.95
    return dict(total=len(cases), missed=missed, false_alarms=false, located=located, passed=passed)
"""
# A point mass at the end of a telescope: q1 turns it from the vertical, q2 is its length.
TELESCOPE = {"M": [["J + w*q2**2", "0"], ["0", "w"]], "C": [["w*q2*qd2", "w*q2*qd1"], ["-w*q2*qd1", "0"]]}
TELESCOPE["G"] = ["w*g*q2*sin(q1)", "-w*g*cos(q1)"]
LATEX = {
    "M": r"\begin{bmatrix} J + w q_2^2 & 0 \\ 0 & w \end{bmatrix}",
    "C": r"\begin{bmatrix} w q_2 \dot{q}_2 & w q_2 \dot{q}_1 \\ -w q_2 \dot{q}_1 & 0 \end{bmatrix}",
    "G": r"\begin{bmatrix} w g q_2 \sin q_1 \\ -w g \cos q_1 \end{bmatrix}",
}
# The arm of two point masses, which is derived here.
ARM = {
    "M": [["l1**2*m1 + m2*(l1**2 + l2**2 + 2*l1*l2*cos(q2))", "m2*l2*(l2 + l1*cos(q2))"], ["", "m2*l2**2"]],
    "C": [["-h*qd2", "-h*(qd1 + qd2)"], ["h*qd1", "0"]],
    "G": ["g*l1*(m1 + m2)*sin(q1) + g*l2*m2*sin(q1 + q2)", "g*l2*m2*sin(q1 + q2)"],
}
ARM["M"][1][0] = ARM["M"][0][1]
ARM["C"] = [[entry.replace("h", "l1*l2*m2*sin(q2)") for entry in row] for row in ARM["C"]]


def case(robot="telescope", truth="match", where=None, **matrices):
    return {"id": where or truth, "robot": robot, "n": 2, "truth": truth, "where": where, "kind": "", **matrices}


CASES = [
    case(**TELESCOPE, latex=LATEX),
    case(
        truth="mismatch",
        where="C[2,1]",
        **(TELESCOPE | {"C": [TELESCOPE["C"][0], ["w*q2*qd1", "0"]]}),
        latex=LATEX | {"C": LATEX["C"].replace("-w", "w")},
    ),
    case(
        truth="match_dynamics_only",
        **(TELESCOPE | {"C": [["0", "2*w*q2*qd1"], TELESCOPE["C"][1]]}),
        latex=LATEX | {"C": r"\begin{bmatrix} 0 & 2 w q_2 \dot q_1 \\ -w q_2 \dot q_1 & 0 \end{bmatrix}"},
    ),
]


@pytest.fixture
def exam(tmp_path):
    """A folder with one exam of printed equations."""

    def write(cases=CASES, truth=None):
        folder = tmp_path / "exams" / "printed"
        folder.mkdir(parents=True)
        everything = {"params": {"J": 1.0}, "truth": truth or {"telescope": TELESCOPE}, "cases": cases}
        (folder / "cases.json").write_text(json.dumps(everything), encoding="utf-8")
        (folder / "grade.py").write_text(GRADER, encoding="utf-8")
        return tmp_path / "exams"

    return write


def test_robots_that_nobody_here_derives_are_judged_by_the_exams_own_equations(exam, capsys):
    assert main([str(exam())]) == 0
    figures = "0 missed, 0 false alarms in 3 cases, 100.0% located; 0 of 1 robots derived here"
    assert capsys.readouterr().out.splitlines() == [
        f"printed/text: {figures}",
        f"printed/latex: {figures}",
        "printed/both readings: text and LaTeX are the same entries in 3 of 3 cases",
    ]


def test_an_arm_that_can_be_derived_is_judged_by_what_was_derived(exam):
    (grader,) = find(exam([case("arm", **ARM)], {"arm": ARM}))
    with loaded(grader) as one:
        candidate = equations.Candidate(one)
        assert candidate.check(candidate.exam["cases"][0], "text") == {"verdict": "match", "where": None}
        assert candidate.derived == ["arm"]


@pytest.mark.heavy
def test_a_mistake_that_only_one_language_has_is_missed_in_that_language(exam, capsys):
    cases = copy.deepcopy(CASES)
    cases[0]["latex"]["G"] = LATEX["G"].replace(r"\sin", r"\cos")
    assert main([str(exam(cases))]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines if "MISSED" in line] == ["printed/latex", "printed/both readings"]
    assert "1 false alarms" in lines[1]


def test_an_exam_without_cases_is_missed(exam, capsys):
    assert main([str(exam([]))]) == 1
    assert all("MISSED" in line for line in capsys.readouterr().out.splitlines())
