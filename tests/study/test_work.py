"""Declared work: functions of a study's own, computed once an item, kept in the ledger, and read back to the bit."""

import json
import re

import numpy as np
import pytest

from workbench.study.definitions import Definitions
from workbench.study.ledger import answers
from workbench.study.ledger.chunk import parse_chunk
from workbench.study.ledger.store import FOLDER
from workbench.study.study_works import Work, compile_work

WORKED = """
from dataclasses import dataclass
from pathlib import Path
import numpy as np
import workbench as wb

@dataclass(frozen=True)
class Fit:
    gain: float
    poles: np.ndarray
    note: str | None = None

SCALE = 2.0

def fit(gain: float) -> Fit:
    with Path("computed.txt").open("a") as file:
        file.write(f"{gain}\\n")
    return Fit(SCALE * gain, np.array([gain, -0.0, np.nan, np.inf]) / 3)

def best(fits) -> int:
    return int(np.argmax([one.gain for one in fits]))

def works(results):
    return (wb.Work("best", best, over=(results.fits,)),)

study = wb.Study(
    name="worked", title="Worked", question="?", method="By working.",
    sections=lambda results: [wb.Section("Fits", (wb.Paragraph(str(results.work("fits")[1].gain)),))],
    headlines=lambda results: [f"{one.gain!r} {one.poles.tolist()}" for one in results.work("fits")],
    works=(wb.Work("fits", fit, over=(1.0, 0.1, 3.0)),),
)
"""


@pytest.fixture
def worked(tmp_path):
    """A study with works alone, which writes a line for each item that it computes."""
    (tmp_path / "worked.py").write_text(WORKED, encoding="utf-8")
    return tmp_path / "worked.py"


def computed(folder):
    """The items that were computed, sorted."""
    file = folder / "computed.txt"
    return sorted(map(float, file.read_text().split())) if file.exists() else []


def test_a_study_with_works_alone_has_a_ledger_and_computes_each_item_once(command, worked, tmp_path):
    first = command("run", "worked.py", "--out", "out", "--ack")
    assert (first.exit_code, computed(tmp_path)) == (0, [0.1, 1.0, 3.0]), first.output
    assert len(re.findall("^ACK fits/item/", first.stdout, re.MULTILINE)) == 3
    assert "3 items of works: about" in first.stderr
    assert "guess of 2 s for each of 3 items" in first.stderr
    again = command("run", "worked.py", "--out", "out")
    assert computed(tmp_path) == [0.1, 1.0, 3.0]
    assert again.stdout == re.sub("^ACK.*\n", "", first.stdout, flags=re.MULTILINE)
    assert command("status", "out").stdout.splitlines() == [
        "fits: 3 of 3 items of work.",
        "The study is 'worked' in 'worked.py'. Nothing is missing.",
    ]
    assert len(json.loads(command("results", "out", "--digests").stdout)) == 3
    assert "the answers of 'fits' to 3 items" in command("results", "out").stdout
    rows = json.loads((tmp_path / "out/runs/fits.json").read_text())
    assert rows[1]["item"] == "0.1"
    assert rows[1]["answer"] == {"gain": 0.2, "poles": [0.1 / 3, -0.0, "nan", "inf"], "note": None}
    assert command("report", "out", "--study", "worked.py").exit_code == 0
    assert command("run", "worked.py", "--out", "out", "--fresh").exit_code == 0
    assert computed(tmp_path) == [0.1, 0.1, 1.0, 1.0, 3.0, 3.0]


def test_a_record_that_is_missing_is_computed_again_and_no_other(command, worked, tmp_path):
    command("run", "worked.py", "--out", "out")
    files = sorted((tmp_path / "out" / FOLDER).glob("fits.item.*"))
    whole = files[0].read_bytes()
    files[0].unlink()
    assert "fits: 2 of 3 items of work." in command("status", "out").stdout
    refused = command("report", "out", "--study", "worked.py")
    assert refused.exit_code == 2
    assert "1 of 3 items of works are missing" in refused.stderr
    assert command("run", "worked.py", "--out", "out").exit_code == 0
    assert len(computed(tmp_path)) == 4
    assert files[0].read_bytes() == whole


@pytest.mark.parametrize("change", ["SCALE = 2.5", "np.inf]) / 7"])
def test_a_change_of_what_a_function_uses_is_computed_again(command, worked, tmp_path, change):
    command("run", "worked.py", "--out", "out")
    pattern = r"SCALE = 2\.0" if "SCALE" in change else r"np\.inf\]\) / 3"
    worked.write_text(re.sub(pattern, lambda found: change, WORKED), encoding="utf-8")
    done = command("run", "worked.py", "--out", "out")
    assert (done.exit_code, len(computed(tmp_path))) == (0, 6)
    assert "3 chunks in 'out' are of other samples or equations" in done.stderr


def test_a_change_of_what_a_function_does_not_use_changes_nothing(command, worked, tmp_path):
    command("run", "worked.py", "--out", "out")
    worked.write_text(WORKED.replace('"Worked"', '"Another title"').replace("SCALE = 2.0", "# Two.\nSCALE = 2.0"))
    assert command("run", "worked.py", "--out", "out").exit_code == 0
    assert len(computed(tmp_path)) == 3


def test_works_may_follow_from_the_results(command, worked, tmp_path):
    late = WORKED.replace("works=(wb.Work", "works=lambda results: (wb.Work")
    worked.write_text(late, encoding="utf-8")
    assert command("run", "worked.py", "--out", "out").exit_code == 0
    assert "fits: 3 of 3 items of work." in command("status", "out").stdout
    again = command("run", "worked.py", "--out", "out")
    assert (again.exit_code, again.stderr, len(computed(tmp_path))) == (0, "", 3)


def test_an_error_in_an_item_names_the_work_and_the_item_and_keeps_the_others(command, worked, tmp_path):
    worked.write_text(WORKED.replace("    return Fit(", "    assert gain < 2, 'too large'\n    return Fit("))
    done = command("run", "worked.py", "--out", "out", "--workers", 1)
    assert done.exit_code == 2
    message = r"workbench: worked.py, line \d+: The work 'fits' fails at 3: AssertionError: too large.\n"
    assert re.fullmatch(message, done.stderr.splitlines(keepends=True)[-1])
    assert "fits: 2 of 3 items of work." in command("status", "out").stdout


def identity(item):
    return item


ANSWERS = [
    None,
    True,
    -3,
    0.1,
    -0.0,
    float("inf"),
    1 - 2j,
    "text",
    (1, 2.0, [3, ("x",)], {"b": 1, "a": (None,)}),
    np.array([[1.0, np.nan], [-0.0, np.inf]]),
    np.arange(6).reshape(2, 3),
    np.array([True, False]),
    np.array([complex(1, np.inf), -2.0]),
    np.array(2.5),
    np.empty((0, 3)),
    np.array([2**62 + 1]),
]


def same(a, b):
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    return type(a) is type(b) and repr(a) == repr(b)


@pytest.mark.parametrize("answer", ANSWERS, ids=repr)
def test_plain_data_come_back_to_the_bit(answer):
    chunk = answers.chunk_of_answer("work/item/0", "it", answer, {})
    assert same(answer, answers.answer_of(parse_chunk(bytes(chunk)), {}))


def test_nan_comes_back_as_the_quiet_one():
    chunk = answers.chunk_of_answer("work/item/0", "it", (np.nan, -np.nan, np.array([-np.nan])), {})
    first, second, third = answers.answer_of(parse_chunk(bytes(chunk)), {})
    assert np.array([first, second, *third]).tobytes() == np.full(3, np.nan).tobytes()


@pytest.mark.parametrize("answer", [object(), {1: 2}, {1, 2}, np.array([object()]), np.array(["a"]), b"bytes"])
def test_what_is_no_plain_data_is_refused(answer):
    with pytest.raises(answers.AnswerError):
        answers.chunk_of_answer("work/item/0", "it", (answer,), {})


def test_distinct_items_are_asked_for_and_names_depend_on_items_alone():
    names = compile_work(Work("w", identity, over=(1, 2.0, "3"))).names
    assert compile_work(Work("w", identity, over=("3", 1, 2.0))).names == (names[2], *names[:2])
    with pytest.raises(ValueError, match="distinct items; number 0 and 2 are the same"):
        compile_work(Work("w", identity, over=(1, 2.0, 1)))


def test_one_and_one_point_zero_are_two_items():
    assert len(set(compile_work(Work("w", identity, over=(1, 1.0, True, -0.0, 0.0))).names)) == 5


def test_a_function_within_another_one_is_refused():
    with pytest.raises(ValueError, match="must be a function at the top of a module"):
        Work("w", lambda item: item, over=(1,))


def opens(item):
    return open(item).read()


def test_a_function_that_reads_what_may_change_is_refused_by_name():
    with pytest.raises(ValueError, match=r"`Work\('w', ...\)` at 'a': 'test_work.opens' uses `open`"):
        compile_work(Work("w", opens, over=("a",)))


def test_the_digest_of_a_function_is_cheap_once_its_definitions_are_known():
    definitions = Definitions()
    assert definitions.digest(identity, 1) == Definitions().digest(identity, 1)
    assert definitions.digest(identity, 1) != definitions.digest(identity, 2)


@pytest.mark.heavy
def test_the_workers_of_a_cluster_give_the_same_records(cluster, command, worked, tmp_path):
    address, worker, _ = cluster
    worker()
    command("run", "worked.py", "--out", "here")
    there = command("run", "worked.py", "--out", "there", "--cluster", address)
    assert there.exit_code == 0, there.output
    files = [sorted((tmp_path / out / FOLDER).glob("fits.item.*")) for out in ("here", "there")]
    assert [file.name for file in files[0]] == [file.name for file in files[1]]
    assert [file.read_bytes() for file in files[0]] == [file.read_bytes() for file in files[1]]
