"""The disk cache keeps what it was given, or nothing; whatever happens to its folder."""

import errno
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

from workbench.engine.kernel import cache

CODE = bytes(range(32))
KEY, OTHER = cache.key("this kernel"), cache.key("another kernel")
posix = pytest.mark.skipif(os.name != "posix", reason="owners and modes of POSIX")


@pytest.fixture
def kernels(tmp_path, monkeypatch):
    """The folder of the cache, which does not exist yet."""
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "kernels"))
    return tmp_path / "kernels"


def files(folder):
    return sorted(file.name for file in folder.iterdir())


def test_what_is_stored_is_found_again_under_its_key_only(kernels):
    assert cache.load(KEY) is None
    cache.store(KEY, CODE)
    assert cache.load(KEY) == CODE
    assert cache.load(OTHER) is None
    assert files(kernels) == [f"{KEY}.kernel"]


def test_a_key_tells_texts_apart_and_where_one_ends():
    keys = {cache.key(*texts) for texts in (("ab", "c"), ("a", "bc"), ("abc",), ("c", "ab"), ("ab", "c", ""))}
    assert len(keys) == 5


@posix
def test_the_folder_and_its_files_are_for_their_owner_only(kernels):
    mask = os.umask(0)
    try:
        cache.store(KEY, CODE)
    finally:
        os.umask(mask)
    assert kernels.stat().st_mode & 0o777 == 0o700
    assert (kernels / f"{KEY}.kernel").stat().st_mode & 0o777 == 0o600


# a file that is not as it was written


def test_a_file_with_a_bit_of_any_byte_flipped_counts_as_absent_and_is_replaced(kernels):
    cache.store(KEY, CODE)
    file = kernels / f"{KEY}.kernel"
    good = file.read_bytes()
    for place in range(len(good)):
        bad = bytearray(good)
        bad[place] ^= 1 << place % 8
        file.write_bytes(bad)
        assert cache.load(KEY) is None, f"byte {place}"
    cache.store(KEY, CODE)
    assert cache.load(KEY) == CODE


def test_a_file_cut_off_anywhere_or_with_more_behind_counts_as_absent(kernels):
    cache.store(KEY, CODE)
    file = kernels / f"{KEY}.kernel"
    good = file.read_bytes()
    for bad in (*(good[:end] for end in range(len(good))), good + b"\0", good + good):
        file.write_bytes(bad)
        assert cache.load(KEY) is None, f"{len(bad)} bytes"


def test_the_file_of_another_key_under_this_name_counts_as_absent(kernels):
    cache.store(KEY, CODE)
    (kernels / f"{KEY}.kernel").rename(kernels / f"{OTHER}.kernel")
    assert cache.load(OTHER) is None


def test_a_file_larger_than_all_of_the_cache_is_not_even_read(kernels, monkeypatch):
    cache.store(KEY, CODE)
    monkeypatch.setattr(cache, "LARGEST", len(CODE))
    assert cache.load(KEY) is None


@posix
@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir], ids=["a pipe", "a folder"])
def test_what_is_no_file_counts_as_absent_and_is_not_waited_for(kernels, make):
    cache.store(KEY, CODE)
    (kernels / f"{KEY}.kernel").unlink()
    make(kernels / f"{KEY}.kernel", 0o600)
    text = f"from workbench.engine.kernel import cache; assert cache.load({KEY!r}) is None"
    # a pipe that nobody writes to would keep its reader for ever
    subprocess.run([sys.executable, "-c", text], check=True, timeout=60)


# a folder that cannot or must not be used


def test_a_folder_that_cannot_be_made_keeps_nothing_and_does_not_fail(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("WORKBENCH_CACHE", str(tmp_path / "file" / "kernels"))
    cache.store(KEY, CODE)
    assert cache.load(KEY) is None


@posix
@pytest.mark.skipif(os.name == "posix" and os.geteuid() == 0, reason="root may write into any folder")
def test_a_read_only_folder_is_read_and_keeps_nothing_new(kernels):
    cache.store(KEY, CODE)
    kernels.chmod(0o500)
    cache.store(OTHER, CODE)
    assert cache.load(KEY) == CODE
    assert cache.load(OTHER) is None
    kernels.chmod(0o700)


@posix
@pytest.mark.parametrize("mode", [0o770, 0o720, 0o702, 0o777])
def test_a_folder_that_others_may_write_is_neither_read_nor_written(kernels, mode):
    cache.store(KEY, CODE)
    kernels.chmod(mode)
    cache.store(OTHER, CODE)
    assert cache.load(KEY) is None
    assert files(kernels) == [f"{KEY}.kernel"]


@posix
def test_a_folder_of_somebody_else_is_neither_read_nor_written(kernels, monkeypatch):
    cache.store(KEY, CODE)
    somebody = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: somebody)
    cache.store(OTHER, CODE)
    assert cache.load(KEY) is None
    assert files(kernels) == [f"{KEY}.kernel"]


@posix
def test_a_file_that_others_may_write_counts_as_absent_in_a_good_folder(kernels):
    cache.store(KEY, CODE)
    (kernels / f"{KEY}.kernel").chmod(0o660)
    assert cache.load(KEY) is None


def test_a_full_disk_keeps_nothing_leaves_nothing_and_does_not_fail(kernels, monkeypatch):
    @contextmanager
    def on_a_full_disk(*words, **options):
        with open(*words, **options) as stream:

            def write(data):
                stream.write(data[: len(data) // 2])
                raise OSError(errno.ENOSPC, "No space left on device")

            yield SimpleNamespace(write=write)

    monkeypatch.setattr(cache, "open", on_a_full_disk, raising=False)
    cache.store(KEY, CODE)
    assert cache.load(KEY) is None
    assert files(kernels) == []


def test_off_is_no_folder_and_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv("WORKBENCH_CACHE", "off")
    cache.store(KEY, CODE)
    assert cache.load(KEY) is None
    assert files(tmp_path) == []


# where the folder is


@pytest.mark.parametrize(
    ("system", "variable", "value", "place"),
    [
        ("linux", "XDG_CACHE_HOME", "{home}/elsewhere", "elsewhere"),
        ("linux", "XDG_CACHE_HOME", "relative", ".cache"),  # the XDG specification: not absolute is not set
        ("linux", "XDG_CACHE_HOME", "", ".cache"),
        ("darwin", "XDG_CACHE_HOME", "", "Library/Caches"),
        ("win32", "LOCALAPPDATA", "{home}/Local", "Local"),
        ("win32", "LOCALAPPDATA", "", "AppData/Local"),
    ],
)
def test_the_folder_is_where_the_system_keeps_a_users_caches(tmp_path, monkeypatch, system, variable, value, place):
    monkeypatch.delenv("WORKBENCH_CACHE", raising=False)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setenv(variable, value.format(home=tmp_path))
    assert cache.folder() == tmp_path / place / "control-workbench" / "kernels"


@posix
def test_a_user_without_a_home_has_no_cache(monkeypatch):
    def unknown(number):
        raise KeyError(number)

    for name in ("WORKBENCH_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", unknown)
    monkeypatch.setattr(sys, "platform", "linux")
    cache.store(KEY, CODE)
    assert cache.load(KEY) is None


# what is removed


def test_beyond_its_size_the_cache_loses_the_kernels_longest_out_of_use(kernels, monkeypatch):
    # one store in sixteen looks after the size: that of a key that begins with a zero
    old, used, new = (letter + KEY[1:] for letter in "120")
    for age, name in ((200, used), (100, old)):
        cache.store(name, CODE)
        file = kernels / f"{name}.kernel"
        os.utime(file, (file.stat().st_atime - age, file.stat().st_mtime - age))
    assert cache.load(used) == CODE
    monkeypatch.setattr(cache, "LARGEST", 2 * file.stat().st_size)
    cache.store(new, CODE)
    assert files(kernels) == sorted([f"{used}.kernel", f"{new}.kernel"])


def test_what_a_crash_left_is_removed_some_day_and_what_is_not_of_the_cache_never(kernels, monkeypatch):
    kernels.mkdir(mode=0o700)
    abandoned, at_work = (kernels / f"{OTHER}.{digit * 16}.part" for digit in "ab")
    for file in (abandoned, at_work, kernels / "notes.part", kernels / "my.kernel"):
        file.write_bytes(CODE)
        os.utime(file, (0, 0))
    os.utime(at_work)
    monkeypatch.setattr(cache, "LARGEST", 0)
    cache.store("0" + KEY[1:], CODE)
    assert files(kernels) == sorted([at_work.name, "notes.part", "my.kernel"])


# several at once


def test_a_reader_finds_a_whole_kernel_while_another_process_writes(kernels):
    codes = [bytes([i]) * 2_000_000 for i in range(2)]
    cache.store(KEY, codes[0])
    text = f"""
import sys
from workbench.engine.kernel import cache
print("ready", flush=True)
for i in range(40):
    cache.store({KEY!r}, bytes([i % 2]) * 2_000_000)
"""
    with subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE) as writer:
        writer.stdout.readline()
        found = []
        while writer.poll() is None:
            found.append(cache.load(KEY))
            cache.store(KEY, codes[0])
    assert writer.returncode == 0
    assert found
    assert all(code in codes for code in found)
    assert files(kernels) == [f"{KEY}.kernel"]
