"""The sweeps of a study at the command line: run, stopped, gone on with, reported again, and handed on."""

import os
import re
import signal
import sys

import pytest

from tests.support import warm_runs
from tests.support.cases import heavy_but
from tests.support.compilers import SLOW
from tests.support.stops import stopped
from tests.support.swept_studies import SWEPT, acknowledged, digests, forget
from workbench.cli.script import load
from workbench.study import execution
from workbench.study.ledger.store import FOLDER, LedgerError, file_of, open_ledger
from workbench.study.run_options import StudyOptions


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
    with open_ledger(tmp_path / "out"):
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
@pytest.mark.parametrize("stop", heavy_but([signal.SIGINT, signal.SIGTERM], signal.SIGINT))
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

    order = StudyOptions(tmp_path / swept, acknowledge=overwrite)
    told = pytest.raises(LedgerError, match="has been damaged: the same command computes it again")
    with told, execution.execute(study, tmp_path / "out", order):
        pass
    with execution.execute(study, tmp_path / "out", StudyOptions(tmp_path / swept)) as (_, results):
        assert len(results.samples[0]) == 40
