"""The ledger: what is acknowledged stays, whatever happens to the process, the file or the disk."""

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from workbench.study import store
from workbench.study.chunk import Chunk, chunk_of
from workbench.study.durable import HeldError
from workbench.study.store import DATABASE, FOLDER, LedgerError, chunks, opened

COUNT = 20
CHUNKS = [Chunk(f"s/{i}", b'{"i":%d}' % i, bytes([i]) * 8 * 500) for i in range(COUNT)]


def filled(out):
    """A closed ledger with all chunks."""
    with opened(out) as ledger:
        ledger.describe({"sweeps": []})
        for chunk in CHUNKS:
            ledger.add(chunk)
    return out / FOLDER / DATABASE


def held(out):
    return [chunk for chunk in chunks(out) if chunk.name != store.ABOUT]


def completed(out):
    """What a later run finds, and adds."""
    with opened(out) as ledger:
        for chunk in CHUNKS:
            if chunk.name not in ledger:
                ledger.add(chunk)
        return ledger.remarks


def test_what_is_added_is_read_again_bit_by_bit(tmp_path):
    filled(tmp_path)
    assert held(tmp_path) == CHUNKS
    with opened(tmp_path) as ledger:
        assert [ledger.read(chunk.name) for chunk in CHUNKS] == CHUNKS
        assert ledger.remarks == ()


def test_arrays_come_back_with_shape_and_bits_and_one_kind_of_nan():
    odd = np.frombuffer(np.array([0xFFF8000000000001, 0x7FF8000000000000], "<u8").tobytes(), "<f8")
    arrays = {"a": np.array([[1.5, -0.0], [np.inf, 5e-324]]), "none": np.empty((0, 3)), "nan": odd}
    chunk = chunk_of("s", arrays)
    back = chunk.arrays()
    assert {name: part.shape for name, part in back.items()} == {"a": (2, 2), "none": (0, 3), "nan": (2,)}
    assert back["a"].tobytes() == arrays["a"].tobytes()
    assert len(set(back["nan"].view("<u8").tolist())) == 1


def test_a_digest_is_of_name_head_and_data_and_of_where_one_ends():
    one = Chunk("ab", b"c", b"d").digest
    assert one not in {Chunk("a", b"bc", b"d").digest, Chunk("ab", b"cd", b"").digest, Chunk("ab", b"c", b"e").digest}


def test_a_transaction_is_on_the_disk_before_it_is_acknowledged(tmp_path):
    with opened(tmp_path) as ledger:
        assert ledger.connection.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        assert ledger.connection.execute("PRAGMA synchronous").fetchone() == (2,)  # FULL


def test_a_reader_sees_what_is_acknowledged_while_another_process_writes(tmp_path):
    with opened(tmp_path) as ledger:
        ledger.add(CHUNKS[0])
        assert held(tmp_path) == CHUNKS[:1]
        ledger.add(CHUNKS[1])
        assert held(tmp_path) == CHUNKS[:2]


def test_a_folder_without_a_ledger_holds_nothing(tmp_path):
    assert held(tmp_path / "none") == []
    (tmp_path / FOLDER).mkdir()
    (tmp_path / FOLDER / DATABASE).touch()
    assert held(tmp_path) == []


def test_to_begin_anew_empties_the_ledger(tmp_path):
    filled(tmp_path)
    file = tmp_path / FOLDER / DATABASE
    shutil.copy(file, file.with_name(store.RENEWED))  # as a repair leaves it that was cut off
    with opened(tmp_path, fresh=True) as ledger:
        assert ledger.places == {}
    assert held(tmp_path) == []


WRITER = """
import sys
from pathlib import Path
from workbench.study.chunk import Chunk
from workbench.study.store import opened
with opened(Path(sys.argv[1])) as ledger:
    for i in range(20):
        chunk = Chunk(f"s/{i}", b'{"i":%d}' % i, bytes([i]) * 8 * 500)
        if chunk.name not in ledger:
            ledger.add(chunk)
            print(chunk.name, flush=True)
    print("end", flush=True)
    sys.stdin.read(int(sys.argv[2]))
"""


def writer(out, waits=0, **options):
    root = str(Path(store.__file__).parents[2])
    settings = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    environment = os.environ | {"PYTHONPATH": root}
    call = [sys.executable, "-c", WRITER, str(out), str(waits)]
    return subprocess.Popen(call, env=environment, **(settings | options))


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_no_kill_loses_or_repeats_what_was_acknowledged(tmp_path):
    kills = 0
    for trial in range(25):
        out = tmp_path / str(trial)
        got = []
        for wanted in (1 + trial % 9, 3):  # two kills of one folder, each after so many acknowledgements
            with writer(out) as process:
                lines = [process.stdout.readline() for _ in range(wanted)]
                process.send_signal(signal.SIGKILL)
                rest = process.communicate(timeout=30)[0]
            kills += 1
            new = [line.strip() for line in (*lines, *rest.splitlines()) if line.startswith("s/")]
            assert not set(new) & set(got)
            got += new
            there = held(out)
            assert set(got) <= {chunk.name for chunk in there}
            assert all(chunk in CHUNKS for chunk in there)
        assert completed(out) == ()
        assert held(out) == CHUNKS
    assert kills == 50


def test_a_second_writer_is_refused_with_the_process_of_the_first(tmp_path):
    with writer(tmp_path, waits=1) as process:
        while process.stdout.readline() != "end\n":
            pass
        with pytest.raises(HeldError, match=rf"written by process {process.pid}, which began at \d{{4}}-"):
            completed(tmp_path)
        process.communicate("x", timeout=30)
    assert completed(tmp_path) == ()


@pytest.mark.parametrize("said", ["", "{", '{"process": 1}', '{"process": "x", "began": 1}', "[]"])
def test_the_lock_holds_whatever_stands_in_its_file(tmp_path, said):
    with opened(tmp_path):
        (tmp_path / FOLDER / "lock").write_text(said)
        with pytest.raises(HeldError, match="another process, which has just begun"), opened(tmp_path):
            pass


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_the_lock_of_a_process_that_was_killed_is_free(tmp_path):
    with writer(tmp_path, waits=1) as process:
        while process.stdout.readline() != "end\n":
            pass
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=30)
    assert completed(tmp_path) == ()


def test_no_bit_flipped_anywhere_delivers_a_wrong_chunk_and_a_later_run_mends_it(tmp_path):
    good = filled(tmp_path / "good").read_bytes()
    file = tmp_path / "bad" / FOLDER / DATABASE
    rng = np.random.default_rng(7)
    places = [*range(0, 100, 7), *rng.integers(100, len(good), 60)]  # the header is small and matters most
    for place in map(int, places):
        file.parent.mkdir(parents=True)
        bad = bytearray(good)
        bad[place] ^= 1 << int(rng.integers(8))
        file.write_bytes(bad)
        assert all(chunk in CHUNKS for chunk in held(tmp_path / "bad"))
        completed(tmp_path / "bad")
        assert sorted(held(tmp_path / "bad"), key=lambda c: int(c.name[2:])) == CHUNKS
        shutil.rmtree(tmp_path / "bad")


@pytest.mark.parametrize("keep", [1, 50, 4096, 20_000, -4096])
def test_a_database_that_was_cut_off_is_put_aside_and_said(tmp_path, keep):
    file = filled(tmp_path)
    file.write_bytes(file.read_bytes()[:keep])
    (remark,) = completed(tmp_path)
    assert "damaged-1.sqlite" in remark
    assert (tmp_path / FOLDER / "damaged-1.sqlite").is_file()
    assert {chunk.name for chunk in held(tmp_path)} == {chunk.name for chunk in CHUNKS}


def test_a_damaged_record_is_taken_out_said_and_done_again(tmp_path):
    file = filled(tmp_path)
    with sqlite3.connect(file) as connection:
        connection.execute("UPDATE record SET data = zeroblob(4000) WHERE name = ?", (b"s/3",))
    connection.close()
    assert CHUNKS[3].name not in {chunk.name for chunk in held(tmp_path)}
    (remark,) = completed(tmp_path)
    assert remark.startswith("Damaged records were found")
    assert remark.endswith("1 of them; they are computed again.")
    assert len(held(tmp_path)) == COUNT


def test_a_repair_that_was_cut_off_between_its_renames_goes_on(tmp_path):
    file = filled(tmp_path)
    file.rename(file.with_name(store.RENEWED))
    file.with_name(f"{DATABASE}-wal").write_bytes(b"of the damaged one")
    assert completed(tmp_path) == ()
    assert held(tmp_path) == CHUNKS


def test_what_is_damaged_while_it_is_open_is_refused_when_it_is_read(tmp_path):
    filled(tmp_path)
    with opened(tmp_path) as ledger:
        with ledger.connection:
            ledger.connection.execute("UPDATE record SET head = ? WHERE name = ?", (b"{}", b"s/3"))
        with pytest.raises(LedgerError, match=r"'s/3' .* has been damaged"):
            ledger.read("s/3")


@pytest.mark.skipif(os.name != "posix", reason="elsewhere no file is removed that is open")
@pytest.mark.parametrize("replaced", [False, True])
def test_nothing_is_acknowledged_into_a_ledger_that_was_removed(tmp_path, replaced):
    out = tmp_path / "out"
    with opened(out) as ledger:
        ledger.add(CHUNKS[0])
        out.rename(tmp_path / "elsewhere")
        if replaced:
            filled(out)
        with pytest.raises(LedgerError, match="was removed, moved or replaced while it was being written"):
            ledger.add(CHUNKS[1])
        assert CHUNKS[1].name not in ledger
    assert completed(out) == ()
    assert held(out) == CHUNKS


def test_a_ledger_of_another_version_is_refused_and_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(store, "__version__", "0.0.1")
    before = filled(tmp_path).read_bytes()
    monkeypatch.undo()
    with pytest.raises(LedgerError, match=r"written by workbench 0\.0\.1.*begin anew with `--fresh`"):
        completed(tmp_path)
    assert (tmp_path / FOLDER / DATABASE).read_bytes() == before


FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
from pathlib import Path
from workbench.study.chunk import Chunk
from workbench.study.store import LedgerError, opened
try:
    with opened(Path(sys.argv[1])) as ledger:
        for i in range(20):
            ledger.add(Chunk(f"s/{i}", b'{"i":%d}' % i, bytes([i]) * 8 * 500))
            print(f"s/{i}", flush=True)
except LedgerError as error:
    raise SystemExit(str(error))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
def test_a_full_disk_is_one_sentence_and_what_was_acknowledged_stays(tmp_path):
    environment = os.environ | {"PYTHONPATH": str(Path(store.__file__).parents[2])}
    call = [sys.executable, "-c", FULL, str(tmp_path)]
    done = subprocess.run(call, env=environment, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1
    assert done.stderr.startswith("The ledger in '")
    assert done.stderr.count("\n") == 1
    got = set(done.stdout.split())
    assert 0 < len(got) < COUNT
    assert got <= {chunk.name for chunk in held(tmp_path)}
    completed(tmp_path)
    assert held(tmp_path) == CHUNKS


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="needs a user whom permissions bind")
def test_a_folder_that_may_not_be_written_is_refused_and_can_be_read(tmp_path):
    filled(tmp_path)
    (tmp_path / FOLDER).chmod(0o500)
    try:
        assert held(tmp_path) == CHUNKS
        with pytest.raises(LedgerError, match="cannot be written"), opened(tmp_path):
            pass
    finally:
        (tmp_path / FOLDER).chmod(0o700)


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_what_only_the_log_holds_is_read_where_nothing_may_be_written(tmp_path, monkeypatch):
    with writer(tmp_path, waits=1) as process:
        while process.stdout.readline() != "end\n":
            pass
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=30)
    monkeypatch.setattr(os, "access", lambda place, mode: False)  # no permission binds root
    assert {chunk.name for chunk in held(tmp_path)} == {chunk.name for chunk in CHUNKS}


def test_a_place_below_a_file_is_refused_in_a_sentence(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(LedgerError, match="cannot be written"), opened(tmp_path / "file"):
        pass
