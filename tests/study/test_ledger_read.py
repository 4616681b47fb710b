"""What is read of a ledger at the command line: how far a study is, its report again, and its runs as files."""

import os
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from tests.support.compilers import ARITHMETIC, SLOW
from tests.support.samples import made_sample
from tests.support.swept_studies import SWEPT, digests, forget
from workbench.engine.arithmetic import signature
from workbench.study import study_cost
from workbench.study.ledger.chunk import chunk_of
from workbench.study.ledger.store import StudyRecord, SweepRecord, open_ledger
from workbench.study.run_tables import table_of


def test_the_status_says_how_far_a_study_is(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    head = f"decay: 40 of 40 runs in 5 of 5 chunks, 0 failed; {signature(ARITHMETIC)}.\n"
    assert command("status", "out").stdout == f"{head}The study is 'swept' in 'swept.py'. Nothing is missing.\n"
    forget(tmp_path / "out", 2)
    left = f"decay: 32 of 40 runs in 4 of 5 chunks, 0 failed; {signature(ARITHMETIC)}.\n"
    assert command("status", "out").stdout.startswith(left)


def test_a_report_is_written_again_from_the_ledger_and_the_study_that_is_named(command, swept, tmp_path):
    command("run", swept, "--out", "out", "--samples", "16")
    pages = {name: (tmp_path / "out" / name).read_bytes() for name in ("index.html", "report.pdf", "runs/decay.csv")}
    for name in pages:
        (tmp_path / "out" / name).unlink()
    done = command("report", "out", "--study", swept)
    assert (done.exit_code, done.stderr) == (0, "".join(SLOW))
    assert {name: (tmp_path / "out" / name).read_bytes() for name in pages} == pages


@pytest.mark.parametrize("words", [["report"], ["results"], ["results", "--digests"], ["status"]])
def test_to_read_a_folder_runs_nothing_of_it(command, swept, tmp_path, words):
    command("run", swept, "--out", "out")
    (tmp_path / swept).write_text("open('ran', 'w').close()", encoding="utf-8")
    done = command(words[0], "out", *words[1:])
    assert done.exit_code == (2 if words == ["report"] else 0)
    assert not (tmp_path / "ran").exists()
    if words == ["report"]:
        assert "names 'swept.py', which is not run unasked: if you trust it, add `--study swept.py`" in done.stderr


def test_a_report_is_written_again_of_what_was_too_much_without_being_asked_for(command, swept, monkeypatch):
    monkeypatch.setattr(study_cost, "PATIENCE", 1e-9)
    assert "or say `--yes`" in command("run", swept, "--out", "out").stderr
    assert command("run", swept, "--out", "out", "--yes").exit_code == 0
    assert command("report", "out", "--study", swept).exit_code == 0


def test_what_results_left_unfinished_does_not_stand_in_the_way(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    (tmp_path / "out" / "runs" / "decay.mat.part").touch()
    assert command("run", swept, "--out", "out").exit_code == 0


HOSTILE = "\x1b]0;owned\x07\u202e"


@pytest.mark.parametrize("words", [["status"], ["results"], ["report"]])
def test_no_word_of_a_folder_reaches_the_terminal_as_more_than_text(command, tmp_path, words):
    sweep = SweepRecord(f"../../{HOSTILE}", 3, HOSTILE, (HOSTILE,))
    with open_ledger(tmp_path / "out") as ledger:
        ledger.describe(StudyRecord(HOSTILE, f"../{HOSTILE}.py", None, (sweep,)))
    said = command(*words, "out")
    shown = said.stdout + said.stderr
    assert shown
    assert not {"\x1b", "\x07", "\u202e"} & set(shown)


def table(**changes):
    """The record of a table of two runs, with a word or an array of it changed."""
    numbers = {
        "t": np.ones(1),
        "factor_values": np.ones((2, 1)),
        "values": np.ones((2, 1, 1)),
        "again": np.zeros(1, int),
    }
    numbers |= {"errors": np.ones((1, 1, 1)), "limits": np.ones(1), "diverged_at": np.full(2, np.nan)}
    columns = (("IAE", 0, "rad s"),)
    one = table_of(made_sample("decay", ("rate",), columns, h=0.1, seed=0, fingerprint="f", **numbers))
    arrays = {name: changes.pop(name, array) for name, array in one.arrays().items()}
    return chunk_of(
        "table/decay", arrays, {name: value for name, value in (one.content | changes).items() if name != "arrays"}
    )


def results_of(command, out, record):
    with open_ledger(out) as ledger:
        ledger.describe(StudyRecord("swept", "swept.py", None, (SweepRecord("decay", 2, signature("fused"), ()),)))
        ledger.write_durably(record)
    return command("results", "out")


def test_a_table_of_a_ledger_becomes_a_file_below_its_folder(command, tmp_path):
    assert results_of(command, tmp_path / "out", table()).exit_code == 0
    assert (tmp_path / "out" / "runs" / "decay.csv").read_text("utf-8").startswith("run,rate,IAE[0] [rad s],")


@pytest.mark.parametrize(
    "change",
    [
        {"name": "../../x"},
        {"name": "/tmp/x"},
        {"name": 3},
        {"factors": 3},
        {"columns": [["IAE", 0]]},
        {"columns": [["IAE", "a", "", "e"]]},
        {"h": "x"},
        {"seed": None},
        {"t": np.ones((1, 1))},
        {"drawn": np.ones((2, 2))},
        {"values": np.ones((3, 1, 1))},
        {"looked_at": np.array([7.0])},
        {"looked_at": np.array([-1.0])},
        {"looked_at": np.array([np.nan])},
        {"errors": np.ones((2, 1, 1))},
        {"limits": np.ones(2)},
        {"diverged_at": np.ones(())},
    ],
)
def test_a_table_that_is_none_is_refused_in_a_sentence_and_writes_nothing(command, tmp_path, change):
    done = results_of(command, tmp_path / "out", table(**change))
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "The record 'table/decay' is no table of runs" in done.stderr
    assert not (tmp_path / "out" / "runs").exists()


@pytest.mark.parametrize("arrays", [{}, {"diverged_at": np.ones(())}, {"diverged_at": np.ones((2, 2))}])
def test_a_chunk_that_holds_something_else_is_refused_in_a_sentence(command, swept, tmp_path, arrays):
    command("run", swept, "--out", "out")
    (name, *_) = digests(command)
    with open_ledger(tmp_path / "out") as ledger:
        ledger.write_durably(chunk_of(name, arrays))
    assert command("status", "out").exit_code == 0
    done = command("run", swept, "--out", "out")
    assert (done.exit_code, done.stderr.count("\n")) == (2, len(SLOW) + 1)
    assert f"The chunk '{name}' does not hold the runs of its name" in done.stderr


def test_results_of_a_run_that_did_not_end_are_not_those_of_the_run_before(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    (tmp_path / swept).write_text(SWEPT.replace("until=2.0", "until=2.0 / 0"), encoding="utf-8")
    assert command("run", swept, "--out", "out").exit_code == 2
    assert "decay.csv: 40 runs" in command("results", "out").stdout  # that run had no word
    (tmp_path / swept).write_text(
        SWEPT.replace("(iae(), ise())", "(iae(), wrong)").replace("class Decay", WRONG), "utf-8"
    )
    assert command("run", swept, "--out", "out").exit_code == 2
    assert command("results", "out").stdout == "decay is not complete: `workbench status out` says how far it is.\n"


WRONG = """
def finish(integral, horizon):
    raise ValueError("no value")

from dataclasses import replace
wrong = replace(ise(), finish=finish)

class Decay"""


def test_a_report_of_a_study_that_lacks_chunks_is_refused(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    forget(tmp_path / "out", 2, 3)
    done = command("report", "out", "--study", swept)
    assert (done.exit_code, done.stdout.splitlines()[-1]) == (2, "started")
    said = "workbench: 2 of 5 chunks are missing in 'out': `workbench run swept.py --out out` computes them.\n"
    assert done.stderr == "".join(SLOW) + said


def test_the_runs_come_as_csv_with_the_report_and_as_mat_where_asked(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    table = pd.read_csv(tmp_path / "out" / "runs" / "decay.csv")
    assert list(table.columns) == [
        "run",
        "rate",
        "IAE[e] [s]",
        "IAE[e] (error) [s]",
        "ISE[e] [s]",
        "ISE[e] (error) [s]",
        "diverged at [s]",
    ]
    rate = table["rate"].to_numpy()
    # RK4 at 10 ms: below 1e-8 of the value
    np.testing.assert_allclose(table["IAE[e] [s]"], (1 - np.exp(-2 * rate)) / rate, rtol=1e-7)
    assert table["IAE[e] (error) [s]"].notna().to_numpy().nonzero()[0].tolist() == [0, 16, 32]
    done = command("results", "out", "--format", "mat")
    assert done.stdout.startswith(os.path.join("out", "runs", "decay.mat") + ": 40 runs, 0 of them diverged; seed 0;")
    held = loadmat(tmp_path / "out" / "runs" / "decay.mat")
    np.testing.assert_array_equal(held["factors"][:, 0], rate)
    np.testing.assert_array_equal(held["metrics"][:, 0, 0], table["IAE[e] [s]"])
    assert held["metric_names"][1, 0].item() == "ISE[e] [s]"


def test_the_runs_come_as_parquet_where_its_library_is(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    done = command("results", "out", "--format", "parquet")
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        said = "workbench: Parquet needs the extra `data`: install `control-workbench[data]`, or take CSV or MAT.\n"
        assert (done.exit_code, done.stderr) == (2, said)
        return
    table = pd.read_parquet(tmp_path / "out" / "runs" / "decay.parquet")
    pd.testing.assert_frame_equal(table, pd.read_csv(tmp_path / "out" / "runs" / "decay.csv"))


def test_a_folder_without_a_ledger_has_no_digests_and_no_status(command, tmp_path):
    assert command("results", "nowhere", "--digests").stdout == "{}\n"
    done = command("status", "nowhere")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    (tmp_path / "empty").mkdir()
    assert "There is no ledger in 'empty'" in command("results", "empty").stderr


def test_a_study_whose_report_fails_keeps_its_ledger(command, swept, tmp_path):
    text = SWEPT.replace("results.sample('decay')", "results.sample('deccay')")
    (tmp_path / swept).write_text(text, encoding="utf-8")
    done = command("run", swept, "--out", "out")
    assert done.exit_code == 2
    assert "There is no 'deccay' among the 1 sweeps of this study. Did you mean 'decay'?" in done.stderr
    assert len(digests(command)) == 5


def test_the_verbs_of_a_ledger_import_nothing_heavy():
    heavy = ("casadi", "numpy", "scipy", "matplotlib", "pandas")
    code = f"import sys, workbench.cli.results; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
