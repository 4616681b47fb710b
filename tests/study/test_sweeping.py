"""The sweeps of a study at the command line: run, stopped, gone on with, reported again, and handed on."""

import os
import re
import signal
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from tests.support import warm_runs
from tests.support.compilers import ARITHMETIC, SLOW
from tests.support.samples import made_sample
from tests.support.stops import stopped
from tests.support.swept_studies import SWEPT, acknowledged, digests, forget
from workbench.cli.script import load
from workbench.engine.arithmetic import signature
from workbench.study import cost, execution
from workbench.study.ledger.chunk import chunk_of
from workbench.study.ledger.store import FOLDER, About, LedgerError, SweepAbout, file_of, opened
from workbench.study.run_options import Order
from workbench.study.run_tables import table_of


@pytest.fixture
def swept(tmp_path):
    """A study with one sweep of five chunks."""
    (tmp_path / "swept.py").write_text(SWEPT, encoding="utf-8")
    return "swept.py"


def test_every_chunk_is_acknowledged_once_with_the_digest_that_is_held(command, swept, tmp_path):
    first = command("run", swept, "--out", "out", "--ack")
    assert first.exit_code == 0
    assert len(acknowledged(first.stdout)) == 5
    assert digests(command) == acknowledged(first.stdout)
    page = (tmp_path / "out" / "index.html").read_bytes()
    second = command("run", swept, "--out", "out", "--ack")
    assert (second.exit_code, acknowledged(second.stdout)) == (0, {})
    assert (tmp_path / "out" / "index.html").read_bytes() == page


def test_what_it_takes_is_told_before_it_starts(command, swept):
    done = command("run", swept, "--out", "out", "--workers", "1")
    cost = "swept: 40 runs: at most about 1 s on 1 threads, 200 MB of memory, 1 MB on the disk.\n"
    assert done.stderr == "".join(SLOW) + cost


def test_only_what_is_missing_is_done_and_begun_anew_where_that_is_asked(command, swept, tmp_path):
    first = acknowledged(command("run", swept, "--out", "out", "--ack").stdout)
    forget(tmp_path / "out", 2, 3)
    again = command("run", swept, "--out", "out", "--ack")
    assert len(acknowledged(again.stdout)) == 2
    assert "3 of 5 chunks are there already" in again.stderr
    assert digests(command) == first
    assert acknowledged(command("run", swept, "--out", "out", "--ack", "--fresh").stdout) == first


def test_chunks_that_an_edited_study_does_not_use_are_said_and_kept(command, swept, tmp_path):
    command("run", swept, "--out", "out")
    (tmp_path / swept).write_text(SWEPT.replace("seed=3", "seed=4"), encoding="utf-8")
    said = "5 chunks in 'out' are of other samples or equations than the study has now: they are kept, and not used"
    assert said in command("run", swept, "--out", "out").stderr
    assert len(digests(command)) == 10
    assert said not in command("run", swept, "--out", "out", "--fresh").stderr
    assert len(digests(command)) == 5


def test_a_study_edited_within_a_second_is_the_edited_one(swept, tmp_path):
    script, time = tmp_path / swept, 1e9
    os.utime(script, (time, time))
    assert load(script).sweeps[0].design.seed == 3
    script.write_text(SWEPT.replace("seed=3", "seed=4"), encoding="utf-8")
    os.utime(script, (time, time))
    assert load(script).sweeps[0].design.seed == 4


def test_samples_replace_those_of_the_study_and_stand_in_the_command(command, swept, tmp_path):
    done = command("run", swept, "--samples", "16", "--out", "out")
    assert "16 runs." in done.stdout
    assert "workbench run swept.py --samples 16 --out out" in (tmp_path / "out" / "index.html").read_text("utf-8")
    assert len(digests(command)) == 2
    assert "40 runs." in command("run", swept, "--out", "out").stdout  # with the two chunks that are there
    assert len(digests(command)) == 5


def test_a_sweep_whose_design_has_no_number_of_samples_keeps_its_points_and_that_is_said(command, swept, tmp_path):
    fixed = SWEPT.replace("import MonteCarlo", "import MonteCarlo, OneAtATime").replace(
        "    ),),\n)\n",
        """    ), Sweep(
        "swings", Run(Decay(), (iae(),), 2.0, h=0.01), (Factor("rate", ("rate",), Uniform(0.5, 3.0)),), OneAtATime(1),
    ),),\n)\n""",
    )
    (tmp_path / "both.py").write_text(fixed, encoding="utf-8")
    done = command("run", "both.py", "--samples", "16", "--out", "out")
    assert "16 runs." in done.stdout
    assert "`--samples` changes nothing of 'swings': their designs have no number of samples." in done.stderr
    assert (tmp_path / "out" / "runs" / "swings.csv").read_text("utf-8").count("\n") == 3 + 1  # and the heads
    (tmp_path / "swings.py").write_text(fixed.replace("MonteCarlo(1, 40, seed=3)", "OneAtATime(1)"), encoding="utf-8")
    refused = command("run", "swings.py", "--samples", "16", "--out", "none")
    assert refused.exit_code == 2
    assert "cannot change the study 'swept': the designs of its sweeps, 'decay', 'swings', have no" in refused.stderr
    assert not (tmp_path / "none").exists()


def test_a_run_on_a_folder_that_is_being_written_is_refused_with_the_process(command, swept, tmp_path):
    with opened(tmp_path / "out"):
        done = command("run", swept, "--out", "out")
    assert done.exit_code == 2
    assert f"is being written by process {os.getpid()}, which began at" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--samples", "0"], "`--samples` must be a positive whole number; got 0."),
        (["--workers", "0"], "`--workers` must be a positive whole number; got 0."),
        (["--workers", "2", "--cluster", "127.0.0.1:9"], "`--workers` is for this machine, and the cluster at"),
        (["--samples", str(10**9)], "or say `--yes`"),
    ],
)
def test_what_makes_no_sense_or_is_too_much_is_refused_and_leaves_nothing(command, swept, tmp_path, words, said):
    done = command("run", swept, *words, "--out", "out")
    assert done.exit_code == 2
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("words", [["--samples", "8"], ["--workers", "2"], ["--cluster", "local"]])
def test_an_option_of_sweeps_is_refused_where_there_are_none(command, tmp_path, words):
    lines = ("from workbench.study.study import Study", 'study = Study("none", "t", "q", "m", lambda results: ())')
    (tmp_path / "none.py").write_text("\n".join(lines), encoding="utf-8")
    done = command("run", "none.py", *words, "--out", "out")
    assert done.exit_code == 2
    pieces = "sweeps" if words[0] == "--samples" else "sweeps, tunings and works"
    assert f"`{words[0]}` is for {pieces}, and the study 'none' has none" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_says_what_is_kept_and_loses_nothing(command, swept, tmp_path, stop):
    words = ["run", swept, "--out", "out", "--ack", "--samples", "16000"]
    with warm_runs.start(words, tmp_path) as process:
        while not (line := process.stdout.readline()).startswith("ACK "):
            assert line
        out, said = stopped(process, stop)
    got = acknowledged(line + out)
    assert process.returncode == 130
    last = said.splitlines()[-1]
    assert re.fullmatch(r"workbench: stopped; \d+ chunks are kept in 'out'. The same command goes on.*", last)
    assert got.items() <= digests(command).items()


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_a_study_that_was_killed_goes_on_and_ends_as_if_it_had_not_been(command, swept, tmp_path, monkeypatch):
    (tmp_path / "killed").mkdir()
    words = ["run", f"../{swept}", "--out", "out", "--ack"]
    with warm_runs.start(words, tmp_path / "killed") as process:
        lines = [process.stdout.readline() for _ in range(3)]  # "started", and two chunks
        process.send_signal(signal.SIGKILL)
        got = acknowledged("".join(lines) + process.communicate(timeout=60)[0])
    assert len(got) >= 2
    again, whole, kept = {}, {}, []
    for folder, found in (
        ("killed", again),
        ("whole", whole),
    ):  # the command is the same in both
        (tmp_path / folder).mkdir(exist_ok=True)
        monkeypatch.chdir(tmp_path / folder)
        found |= acknowledged(command("run", f"../{swept}", "--out", "out", "--ack").stdout)
        kept.append(digests(command))
    assert not got.keys() & again.keys()
    # a chunk may have been on the disk when the process was killed, but not yet acknowledged
    assert (got | again).items() <= whole.items()
    assert kept == [whole, whole]
    files = ("index.html", "report.pdf", "runs/decay.csv")
    for file in files:
        assert (tmp_path / "killed/out" / file).read_bytes() == (tmp_path / "whole/out" / file).read_bytes()


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
    monkeypatch.setattr(cost, "PATIENCE", 1e-9)
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
    sweep = SweepAbout(f"../../{HOSTILE}", 3, HOSTILE, (HOSTILE,))
    with opened(tmp_path / "out") as ledger:
        ledger.describe(About(HOSTILE, f"../{HOSTILE}.py", None, (sweep,)))
    said = command(*words, "out")
    shown = said.stdout + said.stderr
    assert shown
    assert not {"\x1b", "\x07", "\u202e"} & set(shown)


def table(**changes):
    """The record of a table of two runs, with a word or an array of it changed."""
    numbers = {"t": np.ones(1), "drawn": np.ones((2, 1)), "values": np.ones((2, 1, 1)), "again": np.zeros(1, int)}
    numbers |= {"errors": np.ones((1, 1, 1)), "limits": np.ones(1), "diverged_at": np.full(2, np.nan)}
    columns = (("IAE", 0, "rad s"),)
    one = table_of(made_sample("decay", ("rate",), columns, h=0.1, seed=0, fingerprint="f", **numbers))
    arrays = {name: changes.pop(name, array) for name, array in one.arrays().items()}
    return chunk_of(
        "table/decay", arrays, {name: value for name, value in (one.content | changes).items() if name != "arrays"}
    )


def results_of(command, out, record):
    with opened(out) as ledger:
        ledger.describe(About("swept", "swept.py", None, (SweepAbout("decay", 2, signature("fused"), ()),)))
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
    with opened(tmp_path / "out") as ledger:
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


def test_a_damaged_ledger_is_said_kept_and_mended(command, swept, tmp_path):
    first = acknowledged(command("run", swept, "--out", "out", "--ack").stdout)
    for file in (tmp_path / "out" / FOLDER).glob("decay.*.record"):
        file.write_bytes(file.read_bytes()[:200])
    assert digests(command) == {}
    done = command("run", swept, "--out", "out")
    assert done.exit_code == 0
    assert done.stderr.startswith("5 damaged records in the ledger of 'out' are put aside, and computed again")
    assert digests(command) == first


def test_a_chunk_that_is_overwritten_after_it_was_acknowledged_is_told_and_done_again(swept, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", list(sys.path))
    study = load(tmp_path / swept)

    def overwrite(chunk):
        (tmp_path / "out" / FOLDER / file_of(chunk.name)).write_bytes(bytes(500))

    order = Order(tmp_path / swept, acknowledge=overwrite)
    told = pytest.raises(LedgerError, match="has been damaged: the same command computes it again")
    with told, execution.execute(study, tmp_path / "out", order):
        pass
    with execution.execute(study, tmp_path / "out", Order(tmp_path / swept)) as (_, results):
        assert len(results.samples[0]) == 40


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
