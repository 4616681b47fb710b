import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from test_page import document

from workbench.report import folder as module
from workbench.report.folder import ReportError, check_place, write

FILES = {
    "index.html",
    "report.pdf",
    "tables/rmse.csv",
    "tables/rmse.tex",
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


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("step", ["write", "first rename", "second rename"])
def test_whatever_fails_the_earlier_report_stands_and_nothing_else(tmp_path, monkeypatch, error, step):
    target = write(document("First"), tmp_path / "report")
    before = held(tmp_path)
    calls = []
    rename = Path.rename

    def failing(self, to):
        calls.append(self.name)
        if len(calls) == {"first rename": 1, "second rename": 2}.get(step, 0):
            raise error
        return rename(self, to)

    def full(handle):
        raise error

    monkeypatch.setattr(Path, "rename", failing)
    if step == "write":
        monkeypatch.setattr(module.os, "fsync", full)
    with pytest.raises(ReportError if isinstance(error, OSError) else KeyboardInterrupt):
        write(document("Second"), target)
    assert held(tmp_path) == before
    assert [path.name for path in tmp_path.iterdir()] == ["report"]


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
def test_a_full_disk_leaves_the_earlier_report_and_says_why(tmp_path):
    write(document("First"), tmp_path / "report")
    before = held(tmp_path)
    script = textwrap.dedent(
        """
        import resource
        from test_page import document
        from workbench.report.folder import ReportError, write
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        try:
            write(document("Second"), "report")
        except ReportError as error:
            raise SystemExit(str(error))
        """
    )
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    run = subprocess.run(
        [sys.executable, "-B", "-c", script], cwd=tmp_path, env=os.environ | {"PYTHONPATH": paths}, capture_output=True
    )
    assert run.returncode == 1
    assert b"File too large" in run.stderr
    assert b"Traceback" not in run.stderr
    assert held(tmp_path) == before


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


@pytest.mark.parametrize("last", [0, 1, 3, 6, 7, 8])
def test_whenever_the_writing_beside_a_ledger_ends_the_ledger_stands_and_the_next_one_is_whole(tmp_path, last):
    target = with_ledger(tmp_path / "report")
    script = textwrap.dedent(
        """
        import os, sys
        from pathlib import Path
        from test_page import document
        from workbench.report.folder import write
        left = int(sys.argv[1])

        def counted(move):
            def killed(self, to):
                global left
                left -= 1
                if left < 0:
                    os._exit(9)
                return move(self, to)
            return killed

        Path.rename, Path.replace = counted(Path.rename), counted(Path.replace)
        write(document("Second"), "report", {"runs/new.csv": b"run"})
        """
    )
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    call = [sys.executable, "-B", "-c", script, str(last)]
    done = subprocess.run(call, cwd=tmp_path, env=os.environ | {"PYTHONPATH": paths}, check=False)
    # three folders and two files are put in place, three folders are taken away before
    assert done.returncode == (9 if last < 8 else 0)
    assert (target / "ledger" / "ledger.sqlite").read_bytes() == b"chunks"
    write(document("Third"), target)
    assert set(held(target)) == FILES | {"ledger/ledger.sqlite"}
    assert b"Third" in (target / "index.html").read_bytes()


def test_a_note_laid_beside_a_ledger_keeps_the_report_from_being_written(tmp_path):
    target = with_ledger(tmp_path / "report")
    (target / "notes.txt").write_text("mine")
    with pytest.raises(ReportError, match=r"'notes\.txt'"):
        write(document("Second"), target)
