"""A step that pilot runs chose stands in the ledger: status, resume and workers do not choose again."""

import json
import re

import pytest

import workbench as wb
from workbench.study import compiled_sweep
from workbench.study.chosen_steps import ChosenSteps, kept_in
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.ledger.store import FOLDER
from workbench.study.tuning import Trial, Tuning
from workbench.study.tuning.search import compile_tuning
from workbench.study.uncertainty import MonteCarlo

CHOSEN = """
import workbench as wb
from workbench.study.uncertainty import MonteCarlo

run = wb.Run(wb.open_loop(wb.DCMotor(i=1.0)), (wb.effort("omega"),), until=1.0, tolerance=1e-3)
factors = (wb.Factor("b", ("b",), wb.Uniform(0.1, 0.2)),)

def sections(results):
    return [wb.Section("Runs", (wb.Paragraph(results.sample("motor").note),))]

study = wb.Study("chosen", "T", "Q?", "M.", sections, sweeps=(
    wb.Sweep("motor", run, factors, MonteCarlo(1, 16)),))
"""


@pytest.fixture
def asked(monkeypatch):
    """The number of times that a step is chosen."""
    calls, choose = [], compiled_sweep.step_for
    monkeypatch.setattr(compiled_sweep, "step_for", lambda *words, **how: calls.append(1) or choose(*words, **how))
    return calls


def sweep(**changes):
    run = {"until": 1.0, "tolerance": 1e-3, "metrics": (wb.effort("omega"),)} | changes
    loop = run.pop("loop", wb.open_loop(wb.DCMotor()))
    factors = (wb.Factor("b", ("b",), wb.Uniform(0.1, 0.2)),)
    return wb.Sweep("motor", wb.Run(loop, **run), factors, MonteCarlo(1, 16))


def test_a_step_is_chosen_once_for_all_that_it_is_chosen_for(asked):
    steps = ChosenSteps()
    with kept_in(steps):
        first = compile_sweep(sweep())
        again = compile_sweep(sweep())
    with kept_in(ChosenSteps(steps.chunks.values())):
        later = compile_sweep(sweep())
    assert len(asked) == 1
    assert first.h == again.h == later.h
    assert first.name(0, 8) == later.name(0, 8)
    compile_sweep(sweep())
    assert len(asked) == 2


CHANGES = [
    {"until": 2.0},
    {"tolerance": 1e-2},
    {"metrics": (wb.effort("omega"), wb.total_variation(1e-2, "omega"))},
    {"every": 0.5},
    {"seed": 3},
    {"loop": wb.open_loop(wb.DCMotor(J=0.02))},
]


@pytest.mark.parametrize("change", CHANGES, ids=str)
def test_another_run_has_its_step_chosen_anew(asked, change):
    with kept_in(ChosenSteps()):
        compile_sweep(sweep())
        compile_sweep(sweep(**change))
    assert len(asked) == 2


def test_trials_of_tunings_keep_their_steps_too(asked):
    declared = Tuning(
        "friction", (Trial("motor", sweep().run),), sweep().factors, lambda runs: runs["motor"].outputs("x"), 16, 8
    )
    with kept_in(ChosenSteps()):
        first, again = compile_tuning(declared), compile_tuning(declared)
    assert len(asked) == 1
    assert first.trials[0].h == again.trials[0].h


def test_a_resumed_study_takes_its_step_from_the_ledger(command, asked, tmp_path):
    (tmp_path / "chosen.py").write_text(CHOSEN, encoding="utf-8")
    assert command("run", "chosen.py", "--out", "out").exit_code == 0
    (record,) = (tmp_path / "out" / FOLDER).glob("step.*.record")
    assert re.fullmatch(r"step\.[0-9a-f]{32}\.record", record.name)
    assert json.loads(record.read_bytes().split(b"\n")[3])["choice"]
    assert command("run", "chosen.py", "--out", "out").exit_code == 0
    assert command("report", "out", "--study", "chosen.py").exit_code == 0
    assert len(asked) == 1
    assert "16 of 16 runs" in command("status", "out").stdout
    command("run", "chosen.py", "--out", "out", "--fresh")
    assert len(asked) == 2


@pytest.mark.heavy
def test_the_workers_of_a_cluster_are_told_the_step(cluster, command, tmp_path):
    address, worker, _ = cluster
    worker()
    (tmp_path / "chosen.py").write_text(CHOSEN, encoding="utf-8")
    done = command("run", "chosen.py", "--out", "out", "--cluster", address)
    assert done.exit_code == 0, done.output


def test_the_step_of_a_case_is_taken_from_the_ledger_too(command, asked, tmp_path):
    lines = CHOSEN.replace("sweeps=(", 'cases=(wb.Case("one", "motor", run),), sweeps=(').replace(
        '("motor").note', '("motor").name'
    )
    (tmp_path / "chosen.py").write_text(lines, encoding="utf-8")
    for _ in range(2):
        done = command("run", "chosen.py", "--out", "out")
        assert done.exit_code == 0, done.output
    assert len(list((tmp_path / "out" / FOLDER).glob("step.*.record"))) == len(asked) == 2
