import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.documents import document
from workbench.report import folder as module
from workbench.report.folder import ReportError, check_place, write

FILES = {
    "index.html",
    "report.pdf",
    "tables/rmse.csv",
    "tables/rmse.tex",
    "figures/errors.csv",
    "figures/errors.svg",
}


def held(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_report_is_a_page_a_pdf_tables_and_figures(tmp_path):
    target = write(document(), tmp_path / "new" / "report")
    assert set(held(target)) == FILES
    assert [path.name for path in target.parent.iterdir()] == ["report"]


def test_the_same_document_gives_the_same_files(tmp_path):
    assert held(write(document(), tmp_path / "a")) == held(write(document(), tmp_path / "b"))


def test_an_earlier_report_is_replaced_whole(tmp_path):
    target = write(document("First"), tmp_path / "report")
    write(document("Second"), target)
    assert b"Second" in (target / "index.html").read_bytes()
    assert set(held(tmp_path)) == {f"report/{name}" for name in FILES}


def test_an_empty_folder_is_filled(tmp_path):
    (tmp_path / "report").mkdir()
    write(document(), tmp_path / "report")
    assert set(held(tmp_path)) == {f"report/{name}" for name in FILES}


@pytest.mark.parametrize("name", ["notes.txt", "index.html", "tables/mine.xlsx", ".hidden"])
def test_a_folder_with_files_of_someone_else_is_refused_and_left_alone(tmp_path, name):
    (tmp_path / "report" / "tables").mkdir(parents=True)
    (tmp_path / "report" / name).write_text("mine")
    with pytest.raises(ReportError, match="from elsewhere"):
        write(document(), tmp_path / "report")
    assert held(tmp_path) == {f"report/{name}": b"mine"}


def test_a_note_laid_into_a_report_keeps_it_from_being_replaced(tmp_path):
    target = write(document(), tmp_path / "report")
    (target / "notes.txt").write_text("mine")
    with pytest.raises(ReportError, match=r"'notes\.txt'"):
        write(document("Second"), target)
    assert (target / "notes.txt").read_text() == "mine"


def test_a_place_below_a_file_is_refused_in_one_sentence(tmp_path):
    (tmp_path / "file").write_text("mine")
    for place in (tmp_path / "file", tmp_path / "file" / "report"):
        with pytest.raises(ReportError, match="`write"):
            write(document(), place)
    assert held(tmp_path) == {"file": b"mine"}


def broken_writes(attempt, folder):
    """How many steps each way of writing has, at each of which it was stopped."""
    paths = os.pathsep.join(sys.path)
    script = Path(__file__).parents[1] / "support" / "broken_writes.py"
    done = subprocess.run(
        [sys.executable, "-B", script, attempt, folder / "place"],
        env=os.environ | {"PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [int(line) for line in done.stdout.split()]


@pytest.mark.heavy
@pytest.mark.skipif(sys.platform == "win32", reason="needs fork")
def test_a_kill_at_any_step_leaves_the_earlier_page_or_the_new_one_and_the_next_report_clears_up(tmp_path):
    steps = broken_writes("kill", tmp_path)
    assert len(steps) == 4
    assert min(steps) > 50  # a file each is opened, synced, put in place and, as the earlier one, spared and removed


@pytest.mark.heavy
def test_an_error_at_any_step_leaves_the_earlier_report_and_nothing_else(tmp_path):
    steps = broken_writes("fail", tmp_path)
    assert len(steps) == 8
    assert min(steps) > 50


def test_files_are_spared_as_copies_where_the_disk_has_no_second_names(tmp_path, monkeypatch):
    target = write(document("First"), tmp_path / "report")
    before, replace = held(tmp_path), os.replace

    def unlinked(*_):
        raise OSError(1, "Operation not permitted")

    def locked(source, place):
        if Path(place).name == "report.pdf" and "new" in Path(source).parts:
            raise OSError(13, "Permission denied")
        replace(source, place)

    monkeypatch.setattr(module.os, "link", unlinked)
    monkeypatch.setattr(module.os, "replace", locked)
    with pytest.raises(ReportError, match="Permission denied.*Nothing was changed"):
        write(document("Second"), target)
    assert held(tmp_path) == before


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
def test_a_full_disk_leaves_the_earlier_report_and_says_why(tmp_path):
    import resource

    write(document("First"), tmp_path / "report")
    before, usual = held(tmp_path), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, usual[1]))
    try:
        with pytest.raises(ReportError, match="File too large"):
            write(document("Second"), tmp_path / "report")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert held(tmp_path) == before


def test_what_lies_below_folders_from_elsewhere_is_not_read(tmp_path, monkeypatch):
    (tmp_path / "usr" / "lib").mkdir(parents=True)
    (tmp_path / "tables").symlink_to(tmp_path / "usr", target_is_directory=True)
    read = []
    monkeypatch.setattr(Path, "iterdir", lambda self: read.append(self) or map(self.joinpath, os.listdir(self)))
    monkeypatch.setattr(Path, "rglob", None)
    with pytest.raises(ReportError, match="from elsewhere"):
        check_place(tmp_path)
    (tmp_path / "usr").rename(tmp_path / "runs")
    with pytest.raises(ReportError, match="'(tables|runs/lib)' from elsewhere"):
        check_place(tmp_path)
    assert {*read} <= {tmp_path, tmp_path / "runs"}


def test_a_place_is_tried_before_the_run_and_nothing_stays_there(tmp_path):
    check_place(tmp_path / "a" / "b" / "report")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ReportError, match="cannot go to"):
        check_place(tmp_path / "file" / "report")


def with_ledger(folder):
    """A folder with a ledger, an earlier report, and what a run that was killed has left hidden."""
    (folder / "ledger").mkdir(parents=True)
    (folder / "ledger" / "ledger.sqlite").write_bytes(b"chunks")
    write(document("First"), folder, {"runs/old.csv": b"run\n"})
    (folder / ".partial-0123abcd").mkdir()
    (folder / ".partial-0123abcd" / "page").write_text("half")
    return folder


def test_a_report_beside_a_ledger_replaces_the_earlier_one_and_does_not_move_the_ledger(tmp_path):
    target = with_ledger(tmp_path / "report")
    ledger = (target / "ledger" / "ledger.sqlite").stat().st_ino
    write(document("Second"), target, {"runs/new.csv": b"run\n"})
    assert set(held(target)) == FILES | {"ledger/ledger.sqlite", "runs/new.csv"}
    assert (target / "ledger" / "ledger.sqlite").stat().st_ino == ledger
    assert b"Second" in (target / "index.html").read_bytes()
    assert [path.name for path in tmp_path.iterdir()] == ["report"]


def test_a_note_laid_beside_a_ledger_keeps_the_report_from_being_written(tmp_path):
    target = with_ledger(tmp_path / "report")
    (target / "notes.txt").write_text("mine")
    with pytest.raises(ReportError, match=r"'notes\.txt'"):
        write(document("Second"), target)


def test_a_damaged_page_beside_a_ledger_is_written_again(tmp_path):
    write(document(), tmp_path / "out")
    (tmp_path / "out" / "index.html").write_bytes(b"")
    with pytest.raises(ReportError, match="that folder holds 'index.html' from elsewhere"):
        check_place(tmp_path / "out")
    (tmp_path / "out" / "ledger").mkdir()
    write(document(), tmp_path / "out")
    assert (tmp_path / "out" / "index.html").stat().st_size > 1000
