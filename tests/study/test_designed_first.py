"""Works that a study lists come first: its cases and sweeps may follow from their answers."""

import json

import pytest

from workbench.cli.script import Script
from workbench.study.executors import ClusterError
from workbench.study.ledger.store import chunks
from workbench.study.study import Study
from workbench.study.study_works import Work

DESIGNED = """
from dataclasses import dataclass
from pathlib import Path
import workbench as wb

@dataclass(frozen=True)
class Gain:
    Kp: float

def design(poles: float) -> Gain:
    with Path("designed.txt").open("a") as file:
        file.write(f"{poles}\\n")
    return Gain(poles / 10)

def loop(gain):
    motor = wb.DCMotor()
    law = wb.PID(motor.outputs, motor.inputs, Kp=gain.Kp)
    return wb.ClosedLoop(motor, controller=law, reference=wb.Step("omega", "rad/s", 1.0))

METRICS = (wb.effort("omega"),)

def cases(found):
    return tuple(
        wb.Case("step", f"Kp = {gain.Kp:g}", wb.Run(loop(gain), METRICS, until=1.0, every=0.1, h=0.01))
        for gain in found["gains"]
    )

def sweeps(found):
    friction = wb.Factor("friction", ("plant.b",), wb.Uniform(0.05, 0.2))
    run = wb.Run(loop(found["gains"][0]), METRICS, until=1.0, h=0.01)
    return (wb.Sweep("held_out", run, (friction,), wb.SobolDesign(1, 8)),)

def largest(numbers) -> float:
    return max(numbers)

def sections(results):
    names = ", ".join(outcome.case.law for outcome in results.outcomes)
    return [wb.Section("Laws", (wb.Paragraph(f"{names}; {len(results.sample('held_out'))} runs."),))]

study = wb.Study(
    name="designed", title="Designed", question="?", method="By a design.", sections=sections,
    headlines=lambda results: [f"{len(results.outcomes)} laws, {results.work('gains')[1].Kp:g}"],
    works=(wb.Work("gains", design, over=(5.0, 20.0)),), cases=cases, sweeps=sweeps,
)
"""


@pytest.fixture
def designed(tmp_path):
    """A study that designs gains, and runs loops with them."""
    (tmp_path / "designed.py").write_text(DESIGNED, encoding="utf-8")
    return tmp_path / "designed.py"


def test_cases_and_sweeps_are_made_from_what_the_works_answered_which_are_computed_once(command, designed, tmp_path):
    first = command("run", "designed.py", "--out", "out")
    assert first.exit_code == 0, first.output
    assert first.stdout.splitlines()[0] == "2 laws, 2"
    assert "Kp = 0.5, Kp = 2; 24 runs." in (tmp_path / "out/index.html").read_text(encoding="utf-8")
    again = command("run", "designed.py", "--out", "out")
    assert again.stdout == first.stdout
    assert sorted((tmp_path / "designed.txt").read_text(encoding="utf-8").split()) == ["20.0", "5.0"]
    status = command("status", "out").stdout
    assert "gains: 2 of 2 items of work." in status
    assert "held_out: 24 of 24 runs" in status
    assert "Nothing is missing." in status


def test_a_design_that_changes_makes_the_runs_that_follow_from_it_again(command, designed, tmp_path):
    command("run", "designed.py", "--out", "out")
    before = set(json.loads(command("results", "out", "--digests").stdout))
    designed.write_text(DESIGNED.replace("poles / 10", "poles / 5"), encoding="utf-8")
    assert command("run", "designed.py", "--out", "out").stdout.splitlines()[0] == "2 laws, 4"
    now = set(json.loads(command("results", "out", "--digests").stdout))
    assert len(now - before) == len(before) == 5  # two gains, two cases and a sweep


def test_a_worker_of_a_cluster_finds_the_sweeps_from_the_answers(command, designed, tmp_path):
    command("run", "designed.py", "--out", "out")
    held = tuple((c.name, c.head, c.data) for c in chunks(tmp_path / "out"))
    (sweep,) = Script.of(designed, None, (), held)()
    assert {sweep.name(*ends) for ends in sweep.chunks} <= {name for name, _, _ in held}
    with pytest.raises(ClusterError, match="A worker asks in a work for 'gains/item/"):
        Script.of(designed, None, (), tuple(one for one in held if not one[0].startswith("gains/")))()


def test_cases_that_follow_from_nothing_are_refused():
    words = ("name", "Title", "Question?", "Method.", lambda results: ())
    for works in ((), lambda results: (Work("gains", gain, over=(1.0,)),)):
        with pytest.raises(ValueError, match="is a function of what the tunings found, and this study has none"):
            Study(*words, cases=lambda found: (), works=works)


def gain(poles: float) -> float:
    """A gain from its poles."""
    return poles / 10
