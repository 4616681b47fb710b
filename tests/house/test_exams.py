"""The sitter of the exams: on the shared ones where they are, and on small ones made here."""

import subprocess
import sys

import pytest

from tests.exams.__main__ import main
from tests.exams.graders import find, loaded
from tests.exams.sitter import sit
from tests.exams.tracing import trace
from tests.support.small_exams import ROOT


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
