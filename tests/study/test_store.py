"""The ledger: what is acknowledged stays, whatever happens to the process, the file or the disk."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.stores import completed, filled, held
from workbench.study.ledger import store
from workbench.study.ledger.chunk import FORMAT, Chunk, chunk_of, parse_chunk
from workbench.study.ledger.durability import LockedFolderError
from workbench.study.ledger.store import FOLDER, StudyRecord, SweepRecord, about_of, file_of, open_ledger

COUNT = 20
CHUNKS = [chunk_of(f"s/{i:02d}-{i}/f", {"a": np.full(500, float(i))}) for i in range(COUNT)]


def test_what_is_added_is_read_again_bit_by_bit(tmp_path):
    filled(tmp_path)
    assert held(tmp_path) == CHUNKS
    with open_ledger(tmp_path) as ledger:
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


def test_a_record_is_four_lines_and_its_numbers():
    chunk = chunk_of("s/0-2/f", {"a": np.array([[1.0], [2.0]])})
    form, digest, name, head, data = bytes(chunk).split(b"\n", 4)
    assert (form, digest.decode(), name, head) == (FORMAT, chunk.digest.hex(), b"s/0-2/f", b'{"arrays":[["a",[2,1]]]}')
    assert np.frombuffer(data, "<f8").tolist() == [1.0, 2.0]
    assert parse_chunk(bytes(chunk)) == chunk


@pytest.mark.parametrize(
    "head",
    [
        b"",
        b"null",
        b"[]",
        b"{",
        b'{"arrays":3}',
        b'{"arrays":[["a"]]}',
        b'{"arrays":[["a",[2]]]}',
        b'{"arrays":[["a",[-1,-1]]]}',
        b'{"arrays":[["a",[1.0]]]}',
        b'{"arrays":[["a",[true]]]}',
        b'{"arrays":[["a",["x"]]]}',
        b'{"arrays":[[7,[1]]]}',
        b"[" * 100_000,
    ],
)
def test_a_record_that_was_never_written_so_is_none(head):
    assert parse_chunk(bytes(Chunk("s", head, bytes(8)))) is None


def test_a_chunk_is_on_the_disk_before_it_is_acknowledged(tmp_path, monkeypatch):
    calls = []
    for name in ("fsync", "replace"):
        call = getattr(os, name)
        monkeypatch.setattr(os, name, lambda *given, name=name, call=call: (calls.append(name), call(*given)))
    with open_ledger(tmp_path) as ledger:
        calls.clear()
        ledger.write_durably(CHUNKS[0])
        # the file, then its name
        assert calls == ["fsync", "replace", "fsync"] if os.name == "posix" else ["fsync", "replace"]


def test_a_reader_sees_what_is_acknowledged_while_another_process_writes(tmp_path):
    with open_ledger(tmp_path) as ledger:
        ledger.write_durably(CHUNKS[0])
        assert held(tmp_path) == CHUNKS[:1]
        ledger.write_durably(CHUNKS[1])
        assert held(tmp_path) == CHUNKS[:2]


def test_a_folder_without_a_ledger_holds_nothing(tmp_path):
    assert held(tmp_path / "none") == []
    (tmp_path / FOLDER).mkdir()
    assert held(tmp_path) == []


def test_to_begin_anew_empties_the_ledger(tmp_path):
    folder = filled(tmp_path)
    (folder / "x.record.1234.part").touch()  # as a writer leaves it that was killed
    (folder / "x.damaged").touch()
    with open_ledger(tmp_path, fresh=True) as ledger:
        assert ledger.names == set()
    assert [file.name for file in folder.iterdir()] == ["lock"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with a name")
def test_no_pipe_is_waited_for(tmp_path):
    folder = filled(tmp_path)
    (folder / file_of(CHUNKS[0].name)).unlink()
    os.mkfifo(folder / file_of(CHUNKS[0].name))
    assert held(tmp_path) == CHUNKS[1:]
    completed(tmp_path)
    assert held(tmp_path) == CHUNKS


def test_a_record_counts_under_its_own_name_alone(tmp_path):
    folder = filled(tmp_path)
    (folder / file_of(CHUNKS[0].name)).replace(folder / file_of(CHUNKS[1].name))
    assert held(tmp_path) == CHUNKS[2:]


WRITER = """
import sys
from pathlib import Path
import numpy as np
from workbench.study.ledger.chunk import chunk_of
from workbench.study.ledger.store import open_ledger
with open_ledger(Path(sys.argv[1])) as ledger:
    for i in range(20):
        chunk = chunk_of(f"s/{i:02d}-{i}/f", {"a": np.full(500, float(i))})
        if chunk.name not in ledger:
            ledger.write_durably(chunk)
            print(chunk.name, flush=True)
    print("end", flush=True)
    sys.stdin.read(int(sys.argv[2]))
"""


def writer(out, waits=0, **options):
    root = str(Path(store.__file__).parents[3])
    settings = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    environment = os.environ | {"PYTHONPATH": root}
    call = [sys.executable, "-c", WRITER, str(out), str(waits)]
    return subprocess.Popen(call, env=environment, **(settings | options))


@pytest.mark.heavy
@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_no_kill_loses_or_repeats_what_was_acknowledged(tmp_path):
    kills = 0
    for trial in range(0, 9, 4):
        out = tmp_path / str(trial)
        got = []
        for wanted in (1 + trial, 3):  # two kills of one folder, each after so many acknowledgements
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
        assert {file.suffix for file in (out / FOLDER).iterdir()} == {"", ".record"}
    assert kills == 6


def test_a_second_writer_is_refused_with_the_process_of_the_first(tmp_path):
    with writer(tmp_path, waits=1) as process:
        while process.stdout.readline() != "end\n":
            pass
        with pytest.raises(LockedFolderError, match=rf"written by process {process.pid}, which began at \d{{4}}-"):
            completed(tmp_path)
        process.communicate("x", timeout=30)
    assert completed(tmp_path) == ()


@pytest.mark.parametrize("said", ["", "{", '{"process": 1}', '{"process": "x", "began": 1}', "[]"])
def test_the_lock_holds_whatever_stands_in_its_file(tmp_path, said):
    with open_ledger(tmp_path):
        (tmp_path / FOLDER / "lock").write_text(said)
        with pytest.raises(LockedFolderError, match="another process, which has just begun"), open_ledger(tmp_path):
            pass


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_the_lock_of_a_process_that_was_killed_is_free(tmp_path):
    with writer(tmp_path, waits=1) as process:
        while process.stdout.readline() != "end\n":
            pass
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=30)
    assert completed(tmp_path) == ()


ABOUT = StudyRecord(
    "s", "../s.py", 16, (SweepRecord("a", 40, "fused 1", ("a/0-40/f",)), SweepRecord("b", 0, "casadi", ()))
)


def test_what_a_ledger_says_of_its_study_is_read_again(tmp_path):
    with open_ledger(tmp_path) as ledger:
        assert store.about_in(tmp_path) is None
        ledger.describe(ABOUT)
        assert store.about_in(tmp_path) == ABOUT


@pytest.mark.parametrize(
    "change",
    [
        {"study": 3},
        {"script": None},
        {"samples": -1},
        {"samples": True},
        {"sweeps": 3},
        {"sweeps": [3]},
        {"sweeps": [{"name": "a"}]},
        {"sweeps": [{"name": "a", "runs": "4", "arithmetic": "", "chunks": []}]},
        {"sweeps": [{"name": "a", "runs": 4, "arithmetic": "", "chunks": [4]}]},
    ],
)
def test_a_description_that_says_something_else_is_none(change):
    assert about_of(chunk_of("about", {}, ABOUT.chunk.content)) == ABOUT
    assert about_of(chunk_of("about", {}, ABOUT.chunk.content | change)) is None
