"""What all tests share: repeatable random examples, and the command line as a user meets it."""

import gc
import os
import shutil
import subprocess
import sys
import tempfile
import zlib
from collections import Counter, defaultdict
from pathlib import Path

import hypothesis
import pytest
from click.testing import CliRunner

# Compiled kernels stay in the project's folder, never in the user's own cache; what runs below inherits it.
os.environ.setdefault("WORKBENCH_CACHE", str(Path(__file__).parent.parent / ".pytest_cache" / "kernels"))

# One thread of linear algebra for each worker and what it starts: threads that wait for each other spin, and take the
# time of the other worker. NumPy asks once, when it is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What tests write goes to memory where there is room and programs may run: a disk takes its time over each file.
MEMORY, ROOM = Path("/dev/shm"), 4 * 2**30  # bytes; a run of all tests leaves less than one
if MEMORY.is_dir() and os.access(MEMORY, os.W_OK | os.X_OK) and shutil.disk_usage(MEMORY).free > ROOM:
    runs_programs = not os.statvfs(MEMORY).f_flag & os.ST_NOEXEC
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY if runs_programs else Path(tempfile.gettempdir())))

# The same examples in every run: a test that fails fails again. No deadline: machines differ.
hypothesis.settings.register_profile("house", derandomize=True, deadline=None, max_examples=50)
hypothesis.settings.load_profile("house")

# Of the cases of a heavy test `make test-all` runs every fourth, as it must end within a quarter of an hour.
EVERY = 4

STUDY = """
from workbench.study.document.document import Paragraph, Section
from workbench.study.study import Study

def sections(results):
    return [Section("An answer", (Paragraph("Yes."),))]

study = Study(
    name="small", title={title!r}, question="Does it run?", method="By running it.",
    sections=sections, headlines=lambda results: ["It runs."],
)
"""


def pytest_xdist_auto_num_workers():
    """One worker more than processors: some tests wait, for a browser, a signal or a cluster."""
    return (os.cpu_count() or 1) + 1


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Search for garbage only when all modules are loaded: what they make stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_finish():
    """Leave ten thousand tests and their modules out of every later search for garbage, and search seldom."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.hookimpl(tryfirst=True)  # before the marks choose what is run
def pytest_collection_modifyitems(items):
    """Mark three of four cases of each heavy test for a release, and begin with the files that have most of the rest.

    A worker that got a heavy file last would work on when the others are done.
    """
    heavy = [item for item in items if item.get_closest_marker("heavy")]
    for item in cases_of_a_release(heavy):
        item.add_marker("release")
    heavy_tests = Counter(item.path for item in heavy if not item.get_closest_marker("release"))
    items.sort(key=lambda item: -heavy_tests[item.path])


def cases_of_a_release(heavy):
    """The cases that `make test-all` leaves out: it runs every fourth case of a test from one of the first four on."""
    cases = defaultdict(list)
    for item in heavy:
        cases[item.nodeid.partition("[")[0]].append(item)
    return [
        item
        for test, found in cases.items()
        for number, item in enumerate(found)
        if (number - zlib.crc32(test.encode()) % min(EVERY, len(found))) % EVERY
    ]


@pytest.fixture(autouse=True)
def usual_precision():
    """Give Arb its usual 53 bits again after a test that has raised them for its whole process."""
    yield
    if flint := sys.modules.get("flint"):
        flint.ctx.prec = 53


@pytest.fixture(scope="session")
def browser():
    """One Chromium for the pages of all tests of a process."""
    from studies.performance.chromium import open_browser

    with open_browser() as found:
        yield found


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Call the command line within this process, in an empty folder."""
    from workbench.cli.command import cli

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "__study__", raising=False)
    return lambda *words: CliRunner().invoke(cli, [str(word) for word in words])


@pytest.fixture
def shell(tmp_path):
    """Call the command line as a process of its own, in an empty folder."""

    def call(*words, **options):
        line = [sys.executable, "-m", "workbench", *map(str, words)]
        environment = {**os.environ, "PYTHONWARNINGS": "error"}
        settings = {"cwd": tmp_path, "env": environment, "capture_output": True, "text": True, "timeout": 120}
        return subprocess.run(line, check=False, **(settings | options))

    return call


@pytest.fixture
def script(tmp_path):
    """Write a study script and hand back its path, relative to the folder of `command` and `shell`."""

    def write(text="", name="study.py", title="A small study"):
        (tmp_path / name).write_text(text + STUDY.replace("{title!r}", repr(title)), encoding="utf-8")
        return Path(name)

    return write
