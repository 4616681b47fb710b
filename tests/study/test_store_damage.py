"""What a ledger says of damaged records, of a full disk, and of a folder that cannot be written."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.stores import completed, filled, held
from workbench.study.ledger import store
from workbench.study.ledger.chunk import chunk_of
from workbench.study.ledger.store import FOLDER, LedgerError, file_of, open_ledger

COUNT = 20
CHUNKS = [chunk_of(f"s/{i:02d}-{i}/f", {"a": np.full(500, float(i))}) for i in range(COUNT)]


def test_no_bit_flipped_anywhere_delivers_a_wrong_chunk_and_a_later_run_mends_it(tmp_path):
    folder = filled(tmp_path)
    file, good = folder / file_of(CHUNKS[3].name), bytes(CHUNKS[3])
    rng = np.random.default_rng(7)
    for place in map(int, [*range(150), *rng.integers(150, len(good), 50)]):
        bad = bytearray(good)
        bad[place] ^= 1 << int(rng.integers(8))
        file.write_bytes(bad)
        assert held(tmp_path) == [*CHUNKS[:3], *CHUNKS[4:]]
        (remark,) = completed(tmp_path)
        assert remark.startswith("1 damaged records in the ledger of")
        assert held(tmp_path) == CHUNKS


@pytest.mark.parametrize("keep", [0, 1, 50, 1000, -1])
def test_a_record_that_was_cut_off_is_put_aside_said_and_done_again(tmp_path, keep):
    file = filled(tmp_path) / file_of(CHUNKS[3].name)
    file.write_bytes(file.read_bytes()[:keep])
    assert CHUNKS[3] not in held(tmp_path)
    assert len(completed(tmp_path)) == 1
    assert [path.name for path in file.parent.glob("*.damaged")] == ["s.03-3.f.damaged"]
    assert completed(tmp_path) == ()
    assert held(tmp_path) == CHUNKS


def test_damage_costs_the_records_that_it_hit_and_no_other(tmp_path):
    folder = filled(tmp_path)
    for i in range(0, COUNT, 2):
        with (folder / file_of(CHUNKS[i].name)).open("r+b") as stream:
            stream.seek(100)
            stream.write(bytes(16))
    assert held(tmp_path) == CHUNKS[1::2]


def test_what_is_damaged_while_it_is_open_is_refused_when_it_is_read(tmp_path):
    folder = filled(tmp_path)
    with open_ledger(tmp_path) as ledger:
        (folder / file_of(CHUNKS[3].name)).write_bytes(bytes(4000))
        with pytest.raises(LedgerError, match=r"'s/03-3/f' .* has been damaged"):
            ledger.read("s/03-3/f")


@pytest.mark.skipif(os.name != "posix", reason="elsewhere no file is removed that is open")
@pytest.mark.parametrize("replaced", [False, True])
def test_nothing_is_acknowledged_into_a_ledger_that_was_removed(tmp_path, replaced):
    out = tmp_path / "out"
    with open_ledger(out) as ledger:
        ledger.write_durably(CHUNKS[0])
        out.rename(tmp_path / "elsewhere")
        if replaced:
            filled(out)
        with pytest.raises(LedgerError, match="was removed, moved or replaced while it was being written"):
            ledger.write_durably(CHUNKS[1])
        assert CHUNKS[1].name not in ledger
    assert completed(out) == ()
    assert held(out) == CHUNKS


FULL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (9_000, 9_000))
from pathlib import Path
import numpy as np
from workbench.study.ledger.chunk import chunk_of
from workbench.study.ledger.store import LedgerError, open_ledger
try:
    with open_ledger(Path(sys.argv[1])) as ledger:
        for i in range(20):
            ledger.write_durably(chunk_of(f"s/{i:02d}-{i}/f", {"a": np.full(500 if i < 5 else 5000, float(i))}))
            print(f"s/{i:02d}-{i}/f", flush=True)
except LedgerError as error:
    raise SystemExit(str(error))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs resource limits")
def test_a_full_disk_is_one_sentence_and_what_was_acknowledged_stays(tmp_path):
    environment = os.environ | {"PYTHONPATH": str(Path(store.__file__).parents[3])}
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
        with pytest.raises(LedgerError, match="cannot be written"), open_ledger(tmp_path):
            pass
    finally:
        (tmp_path / FOLDER).chmod(0o700)


def test_a_place_below_a_file_is_refused_in_a_sentence(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(LedgerError, match="cannot be written"), open_ledger(tmp_path / "file"):
        pass
