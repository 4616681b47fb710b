"""Odd works at the command line: each refused in one sentence with exit status 2, and no report that says otherwise."""

from dataclasses import dataclass

import numpy as np
import pytest

import workbench as wb
from workbench.study.study_works import Work, WorkError, compile_work

STUDY = """
import datetime, sys
import numpy as np
import workbench as wb

FACTOR = 1.0

def scaled(item):
    return FACTOR * item

def stops(item):
    sys.exit(0)

def fails(item):
    raise KeyError("odd\\nlines")

def nests(item):
    held = []
    held.append(held)
    return held

def masks(item):
    return np.ma.array([1.0, 2.0], mask=[True, False])

def sections(results):
    return [wb.Section("A", (wb.Paragraph(f"The sum is {sum(results.work('odd')):g}."),))]

study = wb.Study("odd", "T", "Q?", "M.", sections, works=WORKS)
"""


def study(folder, works, name="study.py"):
    (folder / name).write_text(STUDY.replace("WORKS", works), encoding="utf-8")


def sentence(done):
    assert done.exit_code == 2, done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize(
    ("function", "says"),
    [
        ("stops", "The work 'odd' ends the study by itself at 1, by SystemExit: 0: return an answer."),
        ("fails", "The work 'odd' fails at 1: KeyError: 'odd"),
        ("nests", "must give plain data, and at 1 the answer holds itself, or has parts more than 100 deep"),
        ("masks", "must give plain data, and at 1 the answer is an array that is masked in part: fill it"),
    ],
)
def test_an_odd_item_ends_the_study_with_one_sentence_and_without_a_report(command, tmp_path, function, says):
    study(tmp_path, f"(wb.Work('odd', {function}, over=(1,)),)")
    done = command("run", "study.py", "--out", "out")
    assert says in sentence(done)
    assert not (tmp_path / "out" / "index.html").exists()


def test_a_study_that_was_edited_is_computed_again_and_every_verb_says_so(command, tmp_path):
    study(tmp_path, "(wb.Work('odd', scaled, over=(1.0, 2.0)),)")
    assert command("run", "study.py", "--out", "out").exit_code == 0
    script = tmp_path / "study.py"
    script.write_text(script.read_text().replace("FACTOR = 1.0", "FACTOR = 2.0"), encoding="utf-8")
    for verb in ("status", "results"):
        assert "has changed since it was run" in command(verb, "out").stdout
    done = command("run", "study.py", "--out", "out")
    assert "2 chunks in 'out' are of other samples or equations than the study has now" in done.stderr
    assert "The sum is 6." in (tmp_path / "out" / "index.html").read_text(encoding="utf-8")


def test_a_ledger_of_another_version_is_said_to_be_one_and_computed_again(command, tmp_path):
    study(tmp_path, "(wb.Work('odd', scaled, over=(1.0, 2.0)),)")
    assert command("run", "study.py", "--out", "out").exit_code == 0
    for record in (tmp_path / "out" / "ledger").glob("*.record"):
        record.write_bytes(record.read_bytes().replace(b"workbench record 2", b"workbench record 1", 1))
    for verb in ("status", "results"):
        assert "its head is damaged or of another version: a study has one as soon as" in sentence(command(verb, "out"))
    done = command("run", "study.py", "--out", "out")
    assert done.exit_code == 0
    assert "or another version of the workbench has written them" in done.stderr
    assert "2 of 2 items of work" in command("status", "out").stdout


@pytest.mark.parametrize("verb", ["status", "results", "report"])
@pytest.mark.parametrize(
    ("place", "says"), [("nowhere", "There is no folder 'nowhere'"), (".", "There is no ledger in '.'")]
)
def test_a_verb_without_a_ledger_says_so(command, verb, place, says):
    assert says in sentence(command(verb, place))


@pytest.mark.parametrize(
    ("samples", "says"),
    [("0", "must be a positive whole number; got 0."), ("3", "is for sweeps, and the study 'odd' has none")],
)
def test_samples_are_of_sweeps(command, tmp_path, samples, says):
    study(tmp_path, "(wb.Work('odd', scaled, over=(1.0,)),)")
    assert says in sentence(command("run", "study.py", "--out", "out", "--samples", samples))


def nothing(item):
    return None


def given(item):
    return ANSWERS[item]


def fails(item):
    raise KeyError("odd")


class Sulky:
    def __repr__(self):
        raise RuntimeError("no")


@dataclass(frozen=True)
class Sulking:
    held: object


ANSWERS = {
    "long": np.longdouble(1),
    "long complex": np.clongdouble(1),
    "span": np.timedelta64(1, "s"),
    "deep": None,
    "sulky": Sulky(),
}
for _ in range(200):
    ANSWERS["deep"] = [ANSWERS["deep"]]


@pytest.mark.parametrize("word", list(ANSWERS))
def test_an_answer_that_a_record_would_change_is_refused(word):
    work = Work("w", nothing, over=(word,))
    odd = compile_work(work)
    object.__setattr__(work, "function", given)
    with pytest.raises(WorkError, match=r"^The work 'w' must give plain data, and at .* the answer "):
        odd.chunk(0, 1)


@pytest.mark.parametrize("answer", [5, "float", Sulky(), [float], {"x": float}])
def test_the_answer_of_a_work_is_a_type(answer):
    with pytest.raises(
        ValueError, match=r"^`Work\('w', answer=\.\.\.\)` must be a type or a type hint, as `float` is; got"
    ):
        wb.Work("w", nothing, over=(1,), answer=answer)


def test_an_item_takes_no_thousand_years():
    with pytest.raises(
        ValueError, match=r"^`Work\('w', seconds=\.\.\.\)` must be at most 1e\+09 s, thirty years; got 1e\+300"
    ):
        wb.Work("w", nothing, over=(1,), seconds=1e300)


@pytest.mark.parametrize(
    "item",
    [
        np.array([None, "x"]),
        np.ma.array([1.0, 2.0], mask=[True, False]),
        ANSWERS["deep"],
    ],
    ids=["objects", "masked", "deep"],
)
def test_an_item_whose_contents_cannot_be_seen_is_refused_in_one_line(item):
    with pytest.raises(ValueError, match=r"^`Work\('w', \.\.\.\)` at .*cannot be seen") as error:
        compile_work(Work("w", nothing, over=(item,)))
    assert str(error.value).isprintable()


def test_an_item_without_words_is_shown_by_its_class():
    work = compile_work(Work("w", fails, over=(Sulking(Sulky()),)))
    with pytest.raises(WorkError, match=r"^The work 'w' fails at Sulking\(\.\.\.\): KeyError: 'odd'\.$"):
        work.chunk(0, 1)


@pytest.mark.parametrize("name", ["", "S\n", "\x1b[2J", "x" * 201])
@pytest.mark.parametrize("field", ["scenario", "law"])
def test_a_case_has_names_that_can_be_printed(field, name):
    run = wb.Run(wb.open_loop(wb.DCMotor()), (wb.effort("omega"),), until=1.0)
    with pytest.raises(ValueError, match=rf"^`Case\({field}=\.\.\.\)` must be a name, at most 200 characters"):
        wb.Case(**{"scenario": "S", "law": "law", "run": run, field: name})
