"""Exports beside what is there: an edited file stays, a pipe is not waited for, and a replay is within bounds."""

import os
import socket
import sys
import time
import zipfile
from functools import partial

import pytest

import workbench as wb
from tests.support.cases import heavy_but
from tests.support.digital_laws import motor_law
from tests.support.law_files import FILE
from workbench.handover.export_folder import write_files
from workbench.handover.export_seal import is_unchanged, sealed_text
from workbench.handover.law_export import FORMS

COMPILED = ("fmi2", "fmi3", "simulink", "ros2", "cortex-m4")  # forms that take a second or two to be made so often
NO_LIMITS = ("control",)  # forms of linear laws alone


def law_for(form):
    return motor_law(**({"low": None, "high": None} if form in NO_LIMITS else {})).law()


def edited(path):
    """A change of one letter, as by hand."""
    content = path.read_bytes()
    at = len(content) // 2
    path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
    return path.read_bytes()


@pytest.mark.parametrize("form", heavy_but(FORMS, *(form for form in FORMS if form not in COMPILED)))
def test_an_edited_file_is_left_and_an_untouched_one_is_replaced(form, tmp_path):
    law = law_for(form)
    paths = wb.export(law, form, tmp_path / "a", name="law")
    assert all(is_unchanged(path.read_bytes()) for path in paths)
    wb.export(law, form, tmp_path / "a", name="law")  # over its own
    for path in paths:
        before = path.read_bytes()
        after = edited(path)
        with pytest.raises(ValueError, match=rf"'.*{path.name}' was (changed since|not written by) an export"):
            wb.export(law, form, tmp_path / "a", name="law")
        assert path.read_bytes() == after
        path.write_bytes(before)
    assert {path.read_bytes() for path in wb.export(law, form, tmp_path / "b", name="law")} == {
        path.read_bytes() for path in paths
    } or form == "mat"  # which holds the time at which it was made


def test_a_line_added_at_the_end_or_the_mark_in_an_own_file_is_an_edit(tmp_path):
    law = motor_law().law()
    _, source = wb.export(law, "c", tmp_path, name="law")
    source.write_text(source.read_text() + "/* tuned on the bench: Kp = 80 */\n")
    with pytest.raises(ValueError, match=r"law\.c' was changed since an export wrote it.*overwrite=True"):
        wb.export(law, "c", tmp_path, name="law")
    source.write_text("/* my own notes on control-workbench */\n")
    with pytest.raises(ValueError, match="was changed"):
        wb.export(law, "c", tmp_path, name="law")
    wb.export(law, "c", tmp_path, name="law", overwrite=True)
    assert is_unchanged(source.read_bytes())


def test_the_verb_leaves_an_edited_file_unless_it_is_told(command, tmp_path):
    (tmp_path / "motor.py").write_text(FILE)
    run = partial(command, "export", "motor.py", "--loop", "computer", "--name", "law")
    assert run().exit_code == 0
    source = tmp_path / "law" / "law.c"
    source.write_text(source.read_text().replace("= 100.0;", "= 80.0;"))
    mine, done = source.read_text(), run()
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "'law/law.c' was changed since an export wrote it" in done.stderr
    assert source.read_text() == mine
    assert run("--overwrite").exit_code == 0
    assert source.read_text() != mine


def named_pipe(path):
    os.mkfifo(path)


def bound_socket(path):
    with socket.socket(socket.AF_UNIX) as own:
        own.bind(str(path))


OTHERS = {
    "a named pipe": named_pipe,
    "a socket": bound_socket,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.mkdir(),
}


@pytest.mark.skipif(sys.platform == "win32", reason="no named pipes in a folder")
@pytest.mark.parametrize("kind", heavy_but(OTHERS, "a named pipe", "a device"))
@pytest.mark.parametrize("overwrite", [False, True])
def test_what_is_no_file_is_neither_waited_for_nor_replaced(kind, overwrite, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # a socket has a short name
    os.mkdir("code")
    OTHERS[kind](tmp_path.joinpath("code", "law.c") if kind == "a device" else type(tmp_path)("code/law.c"))
    found = "a symbolic link" if kind == "a device" else kind
    with pytest.raises(ValueError, match=f"law.c', which is {found}"):
        wb.export(motor_law().law(), "c", "code", name="law", overwrite=overwrite)
    assert os.listdir("code") == ["law.c"]
    before = os.lstat("code/law.c").st_mode
    for folder in ("code/law.c", "/dev/null") if kind != "a folder" else ():
        with pytest.raises(ValueError, match=r"export\(folder=\.\.\.\)"):
            wb.export(motor_law().law(), "c", folder, name="law", overwrite=overwrite)
    assert os.lstat("code/law.c").st_mode == before


@pytest.mark.skipif(sys.platform == "win32", reason="no named pipes in a folder")
def test_no_other_writer_waits_for_a_pipe_or_puts_a_file_in_its_place(tmp_path):
    from tests.support.counterexamples import worst_run

    os.mkfifo(pipe := tmp_path / "a.fmu")
    unit = wb.fmu(wb.open_loop(wb.DCMotor()), name="motor", h=1e-3, compiler="")
    writers = (unit.write, worst_run().write, wb.live(wb.open_loop(wb.DCMotor()), until=0.1).write)
    for write in writers:
        with pytest.raises((ValueError, LookupError)):
            write(pipe)
    assert pipe.is_fifo()


def test_an_archive_and_a_table_keep_their_form(tmp_path):
    (path,) = wb.export(motor_law().law(), "fmi2", tmp_path, name="law")
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
    from scipy.io import loadmat

    (path,) = wb.export(motor_law().law(), "mat", tmp_path, name="law")
    assert loadmat(path)["Ts"] == 0.01
    table = sealed_text("a.csv", "# a law\nk,y\n0,1.5\n")
    assert is_unchanged(table)
    assert table.decode().splitlines()[1:] == ["k,y", "0,1.5"]
    write_files(tmp_path, {"a.csv": "# a law\nk,y\n0,1.5\n"})
    write_files(tmp_path, {"a.csv": "# a law\nk,y\n0,2.5\n"})


@pytest.mark.parametrize("periods", [10**9, 10**12, 10**15])
def test_more_periods_than_memory_holds_are_refused_at_once(periods):
    from workbench.handover.recording import record

    sampled = motor_law()
    began = time.perf_counter()
    with pytest.raises(ValueError, match=r"`replay\(periods=\.\.\.\)` must be at most .* GB"):
        wb.replay(sampled, periods=periods)
    with pytest.raises(ValueError, match=r"`record\(periods=\.\.\.\)` must be at most .* GB"):
        record(sampled, sampled.law(), periods)
    assert time.perf_counter() - began < 5.0  # s: nothing was run
