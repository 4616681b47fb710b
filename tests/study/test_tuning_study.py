"""The tunings of a study at the command line: searched once, stopped, gone on with, and what follows from them."""

import json
import os
import signal
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.support import warm_runs
from tests.support.stops import stopped
from tests.support.sweeps import sweep
from tests.support.tunings import tuning
from workbench.cli.script import Script
from workbench.engine.arithmetic import signature
from workbench.study.case_runs import run
from workbench.study.executors import ClusterError, on_threads
from workbench.study.ledger.store import FOLDER, chunks, open_ledger
from workbench.study.study import Results, Study
from workbench.study.tuning import checkpoint
from workbench.study.tuning.search import compile_tuning

SIGNED = signature("fused")

TUNED = """
from tests.support.tunings import DoubleIntegrator, quadratic, tuning
from workbench.engine.metrics import effort, ise
from workbench.engine.distributions import Uniform
from workbench.study.document.document import Paragraph, Section
from workbench.engine.factors import Factor
from workbench.study.run_and_sweep import Run
from workbench.study.uncertainty import MonteCarlo
from workbench.study.study import Case, Study
from workbench.study.run_and_sweep import Sweep

METRICS = (ise(), effort())
START = Factor("start", ("q",), Uniform(0.5, 1.5))

def sweeps(tuned):
    loop = tuned["pd"].best_equations(DoubleIntegrator())
    return (Sweep("held_out", Run(loop, METRICS, 20.0, h=0.02), (START,), MonteCarlo(1, 32, seed=3), runs_of_chunk=8),)

def cases(tuned):
    return (Case("step", "PD", Run(tuned["pd"].best_equations(DoubleIntegrator()), METRICS, 20.0, 1.0, 0.01)),)

def sections(results):
    return [Section("Found", (Paragraph(results.tuning("pd").note), Paragraph(results.sample("held_out").note)))]

print("started", flush=True)
study = Study(
    name="tuned", title="Tuned", question="?", method="By a search.", sections=sections, cases=cases, sweeps=sweeps,
    headlines=lambda results: [f"J = {results.tuning('pd').objective:.6f}"],
    tunings=(tuning(evaluations=EVALUATIONS),),
)
"""
GENERATIONS, HELD_OUT = 10, 4


@pytest.fixture
def tuned(tmp_path):
    """A study whose sweep and case follow from its tuning."""
    beside = Path(__file__).parents[1] / "support" / "tunings.py"
    (tmp_path / "tunings.py").write_text(beside.read_text(encoding="utf-8"), encoding="utf-8")
    (tmp_path / "tuned.py").write_text(TUNED.replace("EVALUATIONS", "80"), encoding="utf-8")
    return "tuned.py"


def acknowledged(stdout):
    return {line.split()[1]: line.split()[2] for line in stdout.splitlines() if line.startswith("ACK ")}


def digests(command, out="out"):
    return json.loads(command("results", out, "--digests").stdout)


def forget(folder, runs):
    """Remove the chunks of some runs from a ledger, and say how many there were."""
    files = list((folder / FOLDER).glob(f"*.{runs}.*.record"))
    for file in files:
        file.unlink()
    return len(files)


def test_a_study_tunes_then_sweeps_and_is_never_computed_twice(command, tuned, tmp_path):
    first = command("run", tuned, "--out", "out", "--ack")
    assert (first.exit_code, first.stdout.splitlines()[-2]) == (0, "J = 1.415162")
    told = first.stderr.splitlines()
    assert told[0].startswith("tuned: tuning, 88 runs: at most about")
    assert told[1].startswith("tuned: 32 runs: at most about")
    assert len(acknowledged(first.stdout)) == GENERATIONS + 1 + HELD_OUT + 1  # and the case
    assert digests(command) == acknowledged(first.stdout)
    page = (tmp_path / "out" / "index.html").read_bytes()
    again = command("run", tuned, "--out", "out", "--ack", "--workers", "1")
    assert (again.stderr, acknowledged(again.stdout)) == ("", {})
    assert (tmp_path / "out" / "index.html").read_bytes() == page
    anew = command("run", tuned, "--out", "out", "--ack", "--fresh", "--workers", "1")
    assert acknowledged(anew.stdout) == acknowledged(first.stdout)


def test_only_the_generations_that_are_missing_are_computed(command, tuned, tmp_path):
    first = acknowledged(command("run", tuned, "--out", "out", "--ack").stdout)
    lost = forget(tmp_path / "out", "24-32") + forget(tmp_path / "out", "72-80")
    again = acknowledged(command("run", tuned, "--out", "out", "--ack").stdout)
    assert len(again) == lost >= 2
    assert again.items() <= first.items()
    assert digests(command) == first


def test_the_status_counts_the_generations_and_what_is_still_to_come(command, tuned, tmp_path):
    command("run", tuned, "--out", "out")
    said = command("status", "out").stdout.splitlines()
    assert said[0] == f"pd_step: 80 of 80 runs in 10 of 10 chunks, 0 failed; {SIGNED}."
    assert said[1:3] == [
        f"pd_step_half: 8 of 8 runs in 1 of 1 chunks, 0 failed; {SIGNED}.",
        f"held_out: 32 of 32 runs in 4 of 4 chunks, 0 failed; {SIGNED}.",
    ]
    assert said[3].startswith("cases: 1 of 1 runs in 1 of 1 chunks, 0 failed")
    assert said[4].endswith("Nothing is missing.")


def test_the_report_comes_again_from_the_ledger_or_says_what_to_do(command, tuned, tmp_path):
    command("run", tuned, "--out", "out")
    pages = {name: (tmp_path / "out" / name).read_bytes() for name in ("index.html", "runs/pd_step.csv")}
    for name in pages:
        (tmp_path / "out" / name).unlink()
    assert command("report", "out", "--study", tuned).stderr == ""
    assert {name: (tmp_path / "out" / name).read_bytes() for name in pages} == pages
    assert forget(tmp_path / "out", "72-80") == 1
    done = command("report", "out", "--study", tuned)
    assert done.exit_code == 2
    said = "The tunings in 'out' are not complete: `workbench run tuned.py --out out` computes them.\n"
    assert done.stderr == f"workbench: {said}"


def test_every_point_of_a_search_is_in_a_table(command, tuned, tmp_path):
    command("run", tuned, "--out", "out")
    table = pd.read_csv(tmp_path / "out" / "runs" / "pd_step.csv")
    assert len(table) == 80
    objective = table["ISE[e] [rad^2 s]"] + 20 * table["effort[tau] [N m]"] ** 2
    best = pd.read_csv(tmp_path / "out" / "runs" / "pd_step_half.csv").iloc[0]
    assert best["Kp"] == table["Kp"][np.argmin(objective)]


def test_the_samples_of_sweeps_that_follow_can_be_chosen(command, tuned):
    done = command("run", tuned, "--out", "out", "--samples", "16")
    assert "tuned: 16 runs: at most" in done.stderr
    assert command("run", tuned, "--out", "out", "--samples", "0").stderr.startswith("workbench: `--samples` must be")


def test_too_long_a_search_is_refused_before_it_begins(command, tuned, tmp_path):
    (tmp_path / tuned).write_text(TUNED.replace("EVALUATIONS", str(8 * 10**8)), encoding="utf-8")
    done = command("run", tuned, "--out", "out")
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "or say `--yes`" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.heavy
@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
def test_a_search_that_was_killed_and_stopped_goes_on_and_ends_as_if_it_had_not_been(command, tuned, tmp_path):
    until_settled = TUNED.replace("EVALUATIONS", "480, seeds=(0, 1), settle=0.4")
    (tmp_path / tuned).write_text(until_settled, encoding="utf-8")
    got = {}
    for sign, status in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGINT, 130)):
        with warm_runs.start(["run", tuned, "--out", "out", "--ack"], tmp_path) as process:
            lines = [process.stdout.readline() for _ in range(4)]  # "started", and three generations
            out, said = stopped(process, sign)
        found = acknowledged("".join(lines) + out)
        assert process.returncode == status
        assert not got.keys() & found.keys()
        got |= found
    held = len(digests(command))
    assert said.splitlines()[-1].startswith(f"workbench: stopped; {held} chunks are kept in 'out'. The same command")
    lines = command("status", "out").stdout.splitlines()
    assert lines[0] == f"pd_step: {8 * held} of at most 960 runs in {held} of at most 120 chunks, 0 failed; {SIGNED}."
    assert lines[1].startswith("pd_step_half: 0 of at most 16 runs in 0 of at most 1 chunks")
    assert lines[-1].endswith("Its command goes on with the rest.")
    done = command("run", tuned, "--out", "out", "--ack")
    assert "tuned: tuning, at most 976 runs: " in done.stderr
    rest = acknowledged(done.stdout)
    assert not got.keys() & rest.keys()
    whole = acknowledged(command("run", tuned, "--out", "whole", "--ack").stdout)
    assert digests(command) == digests(command, "whole") == whole
    assert (got | rest).items() <= whole.items()
    runs = 8 * sum(name.startswith("pd_step/") for name in whole)
    assert 2 * 192 <= runs < 960  # some search has settled before its 480 evaluations, and none before 0.4 of them
    assert command("status", "out").stdout.startswith(f"pd_step: {runs} of {runs} runs in {runs // 8} of {runs // 8} ")
    tables = (tmp_path / out / "runs" / "held_out.csv" for out in ("out", "whole"))
    assert next(tables).read_bytes() == next(tables).read_bytes()


def test_what_a_settled_tuning_did_without_is_taken_off_what_is_to_come(tmp_path):
    first, second = (compile_tuning(tuning(name=name, evaluations=320, settle=0.3)) for name in ("one", "two"))
    told, said = [], []
    with open_ledger(tmp_path, fresh=False) as ledger:
        found, done = checkpoint.tune_in_ledger(
            (first, second),
            ledger,
            on_threads,
            lambda: lambda *state: told.append(state),
            describe=lambda sweeps: said.append(sweeps),
        )
        again = checkpoint.tune_in_ledger((first, second), ledger, on_threads, lambda: pytest.fail("it runs"))
    spared = 320 - found["one"].evaluations[0]
    assert spared > 0
    assert told[0][2] == 2 * (320 + 8)
    assert told[-1][2] == 2 * (320 + 8) - spared
    assert told[-1][0] == sum(found[name].evaluations[0] for name in ("one", "two")) + 2 * 8
    assert [(sweep.runs, sweep.at_most) for sweep in said[0]] == [(320, True), (8, True)] * 2
    runs = [runs for name in ("one", "two") for runs in (found[name].evaluations[0], 8)]
    assert [(sweep.runs, sweep.at_most) for sweep in done] == [(count, False) for count in runs]
    assert again[1] == done
    assert again[0]["two"].objectives.tobytes() == found["two"].objectives.tobytes()


def test_a_worker_finds_the_same_sweeps_from_the_chunks_of_the_tuning(command, tuned, tmp_path):
    command("run", tuned, "--out", "out")
    held = tuple((c.name, c.head, c.data) for c in chunks(tmp_path / "out") if c.name.startswith("pd_"))
    file = tmp_path / tuned
    (found,) = Script.of(file, None, (), held)()
    names = {found.name(*ends) for ends in found.chunks}
    assert names == {name for name in digests(command) if name.startswith("held_out/")}
    with pytest.raises(ClusterError, match="A worker asks in a tuning for 'pd_step/"):
        Script.of(file, None, (), held[1:])()


def test_a_study_refuses_what_would_be_one_file_twice_or_follows_from_nothing():
    words = ("name", "Title", "Question?", "Method.", lambda results: ())
    with pytest.raises(ValueError, match=r"distinct sweeps and trials; \['pd_step'\] came more than once"):
        Study(*words, tunings=(tuning(),), sweeps=(sweep(name="pd_step"),))
    with pytest.raises(ValueError, match="distinct tunings"):
        Study(*words, tunings=(tuning(), tuning()))
    with pytest.raises(ValueError, match="function of what the tunings found, and this study has none"):
        Study(*words, sweeps=lambda found: ())
    later = Study(*words, tunings=(tuning(),), cases=lambda found: (), sweeps=lambda found: [sweep()])
    assert [one.name for one in later.resolve({}).sweeps] == ["decay"]
    with pytest.raises(ValueError, match=r"take `study.resolve\(tuned\)`"):
        run(later)
    wrong = Study(*words, tunings=(tuning(),), sweeps=lambda found: sweep())
    with pytest.raises(ValueError, match=r"got a `Sweep`: one alone is written"):
        wrong.resolve({})


def test_a_tuning_that_is_not_there_is_named_with_the_nearest():
    with pytest.raises(LookupError, match="There is no 'dp' among the 0 tunings"):
        Results().tuning("dp")
