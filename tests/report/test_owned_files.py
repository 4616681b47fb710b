"""Files of others: no run removes or overwrites what it did not write, nor reports what is no longer asked."""

import json
import os
import re

import pytest

from tests.support.documents import document
from tests.support.swept_studies import SWEPT
from workbench.report.folder import ReportError, write
from workbench.study.ledger.chunk import chunk_of, parse_chunk
from workbench.study.ledger.store import FOLDER, LedgerError, open_ledger

posix = pytest.mark.skipif(os.name != "posix", reason="links need no rights on POSIX alone")
WITHOUT = re.sub(r"    sweeps=\(Sweep\(.*?\n    \),\),\n", "", SWEPT, flags=re.DOTALL)
WITHOUT = re.sub(r"lambda results: \[.*\],\n    sections", "sections", WITHOUT)
WITHOUT = re.sub(r"(sections|headlines)=lambda results: \[.*\],", r"\1=lambda results: [],", WITHOUT)


@pytest.fixture
def study(tmp_path):
    def put(text=SWEPT):
        (tmp_path / "swept.py").write_text(text, encoding="utf-8")
        return "swept.py"

    put()
    return put


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.is_symlink()
    }


def test_a_sweep_that_a_study_no_longer_has_is_neither_reported_nor_delivered(command, study, tmp_path):
    assert command("run", study(), "--out", "out").exit_code == 0
    said = command("run", study(WITHOUT), "--out", "out")
    assert said.exit_code == 0, said.output
    assert "5 chunks in 'out' are of other samples or equations than the study has now" in said.stderr
    status, results = command("status", "out").stdout, command("results", "out").stdout
    assert "decay" not in status + results
    assert "Nothing is missing" not in status
    assert status.endswith("It has no sweeps and no works.\n")
    assert "5 chunks in 'out' are of other samples or equations than the study has now" in status
    assert "The study 'swept' has no sweeps and no works." in results
    assert not (tmp_path / "out" / "runs").exists()
    again = command("run", study(SWEPT), "--out", "out", "--ack")  # they were kept
    assert "ACK" not in again.stdout
    assert "decay" in command("results", "out").stdout


def test_a_script_that_was_edited_since_its_run_is_said(command, study):
    command("run", study(), "--out", "out")
    assert "Nothing is missing." in command("status", "out").stdout
    study(SWEPT.replace("seed=3", "seed=4"))
    assert "Nothing is missing" not in command("status", "out").stdout
    assert "It has changed since it was run" in command("status", "out").stdout
    assert "'swept.py' has changed since it was run: these are earlier runs" in command("results", "out").stdout


@pytest.mark.parametrize("fresh", [(), ("--fresh",)])
@pytest.mark.parametrize("name", ["song.part", "moon.record", "x.record.12.part.mine", "old.damaged", "ledger.xlsx"])
def test_a_folder_named_ledger_of_somebody_else_is_refused_and_stays_as_it_is(command, study, tmp_path, name, fresh):
    mine = tmp_path / "out" / FOLDER
    mine.mkdir(parents=True)
    (mine / name).write_text("mine")
    (mine / "account.txt").write_text("mine too")
    before = contents(tmp_path / "out")
    said = command("run", study(), "--out", "out", *fresh)
    assert said.exit_code == 2
    assert "is no ledger of the workbench: it holds 'account.txt'" in said.stderr
    assert contents(tmp_path / "out") == before


def test_what_lies_beside_the_records_of_a_ledger_is_not_touched(tmp_path):
    with open_ledger(tmp_path):
        pass
    for name in ("song.part", "moon.record", "letter.txt"):
        (tmp_path / FOLDER / name).write_text("mine")
    with open_ledger(tmp_path, fresh=True) as ledger:
        assert ledger.remarks == ()
    assert {"song.part", "moon.record", "letter.txt"} < {file.name for file in (tmp_path / FOLDER).iterdir()}


def test_a_page_of_somebody_else_beside_a_folder_named_ledger_is_not_overwritten(tmp_path):
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / "account.txt").write_text("mine")
    (tmp_path / "index.html").write_text("mine")
    with pytest.raises(ReportError, match=r"holds 'index.html' from elsewhere"):
        write(document(), tmp_path)
    (tmp_path / "index.html").unlink()
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "mine.csv").write_text("mine")
    with pytest.raises(ReportError, match=r"holds 'runs(/mine.csv)?' from elsewhere"):
        write(document(), tmp_path)


@posix
@pytest.mark.parametrize("link", ["ledger", "ledger/lock", "runs", "tables", "figures", "index.html"])
def test_nothing_is_written_or_removed_through_a_link_in_a_folder(command, study, tmp_path, link):
    command("run", study(), "--out", "out")
    place, away = tmp_path / "out" / link, tmp_path / "away"
    place.exists() or place.mkdir()
    place.rename(away)
    if away.is_dir():
        (away / "about.record.1f.part").write_text("mine")
    place.symlink_to(away)
    before = contents(tmp_path)
    for words in (("run", study()), ("run", study(), "--fresh"), ("run", study(WITHOUT)), ("run", study(SWEPT))):
        said = command(*words, "--out", "out")
        assert said.exit_code == 2, said.output
        assert "link" in said.stderr or f"'{link}' from elsewhere" in said.stderr
    assert contents(tmp_path) == before


@posix
def test_the_table_of_a_sweep_is_written_through_no_link(command, study, tmp_path):
    command("run", study(), "--out", "out")
    (tmp_path / "out" / "runs").rename(tmp_path / "away")
    (tmp_path / "out" / "runs").symlink_to(tmp_path / "away")
    before = contents(tmp_path)
    for form in ("csv", "mat"):
        said = command("results", "out", "--format", form)
        assert said.exit_code == 2
        assert "'out/runs' is a link to another place" in said.stderr
    assert contents(tmp_path) == before


@posix
def test_a_lock_that_is_a_link_leaves_the_file_to_which_it_leads(tmp_path):
    (tmp_path / "diary").write_text("mine")
    (tmp_path / "out" / FOLDER).mkdir(parents=True)
    (tmp_path / "out" / FOLDER / "lock").symlink_to(tmp_path / "diary")
    with pytest.raises(LedgerError, match="lock' is a link to another place"), open_ledger(tmp_path / "out"):
        pass
    assert (tmp_path / "diary").read_text() == "mine"


def test_a_record_of_other_shapes_is_named_and_costs_its_own_runs_alone(command, study, tmp_path):
    command("run", study(), "--out", "out")
    file = next((tmp_path / "out" / FOLDER).glob("decay.8-16.*"))
    chunk = parse_chunk(file.read_bytes())
    arrays = chunk.arrays()
    file.write_bytes(bytes(chunk_of(chunk.name, arrays | {"states": arrays["states"][..., :0]})))
    said = command("run", study(), "--out", "out")
    assert said.exit_code == 2
    assert f"does not hold the runs of its name: remove its file 'ledger/{file.name}'" in said.stderr
    assert "--fresh" not in said.stderr
    file.unlink()
    again = command("run", study(), "--out", "out", "--ack")
    assert re.findall(r"ACK (\S+)/", again.stdout) == ["decay/8-16"]
    assert json.loads(command("results", "out", "--digests").stdout)
