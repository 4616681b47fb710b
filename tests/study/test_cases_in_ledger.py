"""Cases in the ledger: no case is lost or computed twice, and those who only read the folder have them."""

import json

import pandas as pd
import pytest

from tests.support.swept_studies import acknowledged, digests
from workbench.cli.script import load
from workbench.study import case_runs
from workbench.study.ledger.store import FOLDER

CASES = """
import workbench as wb

MOTOR = wb.DCMotor()
METRICS = (wb.rmse(), wb.effort())


def loop(gain):
    law = wb.PID(MOTOR.outputs, MOTOR.inputs, Kp=gain, Ki=200.0)
    return wb.ClosedLoop(MOTOR, controller=law, reference=wb.Step("omega", "rad/s", 1.0))


def case(name, gain):
    return wb.Case("speed", name, wb.Run(loop(gain), METRICS, until=1.0, every=0.01, h=1e-3))


computer = wb.Case("computer", "slow", wb.Run(wb.DigitalLoop(loop(50.0), 0.01), METRICS, until=1.0, h=5e-3))
cases = (case("slow", 50.0), case("fast", 100.0), computer)
study = wb.Study(
    "motors", "T", "Q?", "M.", cases=cases,
    sections=lambda found: [wb.Section("All", (wb.side_by_side("t", "c", found.outcomes),))],
)
"""


@pytest.fixture
def motors(tmp_path):
    (tmp_path / "motors.py").write_text(CASES, encoding="utf-8")
    return "motors.py"


def page(tmp_path):
    return (tmp_path / "out" / "index.html").read_bytes()


def test_each_case_is_kept_once_and_none_is_computed_again(command, motors, tmp_path):
    first = command("run", motors, "--out", "out", "--ack")
    assert (first.exit_code, len(acknowledged(first.stdout)), first.stderr) == (0, 3, "")
    assert digests(command) == acknowledged(first.stdout)
    printed = page(tmp_path)
    again = command("run", motors, "--out", "out", "--ack")
    assert (acknowledged(again.stdout), page(tmp_path)) == ({}, printed)


def test_a_case_that_is_lost_is_computed_alone_and_to_the_same_bits(command, motors, tmp_path):
    whole = acknowledged(command("run", motors, "--out", "out", "--ack").stdout)
    printed = page(tmp_path)
    (lost, *_) = sorted((tmp_path / "out" / FOLDER).glob("cases.*"))
    lost.unlink()
    status = command("status", "out").stdout.splitlines()
    assert status[0].startswith("cases: 2 of 3 runs in 2 of 3 chunks, 0 failed; ")
    assert status[-1].endswith("Its command goes on with the rest.")
    again = acknowledged(command("run", motors, "--out", "out", "--ack").stdout)
    assert (len(again), again.items() <= whole.items(), page(tmp_path)) == (1, True, printed)
    assert command("status", "out").stdout.endswith("Nothing is missing.\n")


def test_a_report_of_cases_alone_comes_from_the_ledger_and_computes_nothing(command, motors, tmp_path):
    command("run", motors, "--out", "out")
    printed = page(tmp_path)
    (tmp_path / "out" / "index.html").unlink()
    done = command("report", "out", "--study", motors)
    assert (done.exit_code, page(tmp_path)) == (0, printed)
    for file in (tmp_path / "out" / FOLDER).glob("cases.*"):
        file.unlink()
    done = command("report", "out", "--study", motors)
    assert done.exit_code == 2
    assert "3 of 3 cases are missing in 'out': `workbench run motors.py --out out` computes them." in done.stderr


def test_the_results_have_the_cases_before_there_is_a_report(command, motors, tmp_path):
    command("run", motors, "--out", "out")
    (tmp_path / "out" / "runs" / "cases.csv").unlink()
    assert "out/runs/cases.csv: the single cases" in command("results", "out").stdout
    table = pd.read_csv(tmp_path / "out" / "runs" / "cases.csv")
    found = case_runs.run(load(tmp_path / "motors.py"))
    assert table["value"].tolist() == [row["value"] for row in found.rows]
    assert table["error"].tolist() == [row["error"] for row in found.rows]


def test_a_case_that_changes_is_computed_again_and_its_earlier_run_is_removed(command, motors, tmp_path):
    before = acknowledged(command("run", motors, "--out", "out", "--ack").stdout)
    (tmp_path / motors).write_text(CASES.replace("100.0", "101.0"), encoding="utf-8")
    changed = acknowledged(command("run", motors, "--out", "out", "--ack").stdout)
    assert len(changed) == 1
    held = json.loads(command("results", "out", "--digests").stdout)
    assert len(held) == 3
    assert len(held.keys() & before.keys()) == 2


def test_cases_that_are_one_run_by_two_names_are_computed_once(command, tmp_path):
    text = CASES.replace('case("fast", 100.0)', 'case("as slow", 50.0)')
    (tmp_path / "motors.py").write_text(text, encoding="utf-8")
    done = command("run", "motors.py", "--out", "out", "--ack")
    assert (done.exit_code, len(acknowledged(done.stdout))) == (0, 2)
    assert command("status", "out").stdout.startswith("cases: 3 of 3 runs in 3 of 3 chunks")
