"""The exam of sensitivity: on the shared one where it is, and on a small one made here."""

from pathlib import Path

import pytest

from tests.exams.__main__ import main
from tests.exams.graders import find, loaded
from tests.exams.sensitivity import PARTS

SHARED = Path(__file__).parents[3] / "shared" / "exams" / "sensitivity"

GRADER = """
import numpy as np
LIMIT = 0.02
SPREADS = [("unif", -1, 1), ("norm", 0, 2), ("lognorm", 0, 0.1), ("triang", 0, 1, 0.75)]
VARIANCES = np.array([1 / 3, 4, np.exp(0.01) * (np.exp(0.01) - 1), 1.8125 / 18 - 0.75 / 18])

def grade_sobol(run):
    r = run(lambda X: X.sum(axis=1), SPREADS, 1000, 3)
    errors = [float(np.abs(np.array(r[key]) - VARIANCES / VARIANCES.sum()).max()) for key in ("S1", "ST")]
    outcome = "pass" if max(errors) <= LIMIT and max(map(abs, r["S2"].values())) <= LIMIT else "FAIL"
    case = dict(id="sum", err_S1=errors[0], err_ST=errors[1], tol=LIMIT, outcome=outcome)
    return dict(passed=outcome == "pass", cases=[case])

def grade_morris(run):
    r = run(lambda X: X @ [1.0, -2.0], [("unif", 0, 1)] * 2, 20, 4, 1)
    worst = float(np.abs(np.array(r["mu"]) - [1, -2]).max()) / LIMIT
    outcome = "pass" if worst <= 1 else "FAIL"
    return dict(passed=outcome == "pass", cases=[dict(id="linear", worst_in_limits=worst, outcome=outcome)])

def grade_edges(run):
    try:
        run(lambda X: X[:, 0] * np.nan, [("unif", 0, 1)] * 2, 64, 1)
        outcome = "wrong"
    except ValueError:
        outcome = "refused"
    return dict(passed=outcome == "refused", cases=[dict(id="nan", outcome=outcome)])
"""


def exam(folder: Path, grader: str) -> Path:
    (folder / "exams" / "indices").mkdir(parents=True)
    (folder / "exams" / "indices" / "grade.py").write_text(grader, encoding="utf-8")
    return folder / "exams"


def test_indices_effects_and_refusals_are_sat_one_line_each(tmp_path, capsys):
    assert main([str(exam(tmp_path, GRADER))]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(",")[0] for line in lines] == [
        "indices/indices: 1 of 1",
        "indices/effects: 1 of 1",
        "indices/edges: 1 of 1",
    ]


def test_a_bar_that_is_missed_is_named(tmp_path, capsys):
    assert main([str(exam(tmp_path, GRADER.replace("LIMIT = 0.02", "LIMIT = 1e-300")))]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("indices/indices: MISSED, 0 of 1")
    assert lines[0].endswith("failed: sum")


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared exams are not here")
@pytest.mark.parametrize("part", PARTS)
def test_the_shared_exam_is_passed(part):
    (grader,) = find(SHARED)
    with loaded(grader) as one:
        passed, said = PARTS[part][1](one)
    assert passed, said


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared exams are not here")
def test_every_part_of_the_shared_exam_is_known():
    (grader,) = find(SHARED)
    assert {name for name in grader.functions if name.startswith("grade_")} == set(PARTS)
