"""A study with a sweep, as a file in the folder of a test, and a Dask cluster on this machine."""

import json
import time
from functools import partial

import pytest

from tests.support import warm_runs
from tests.support.swept_studies import SWEPT

PROGRAM = """
import os, sys
for number in (1, 2):
    os.dup2(os.open(os.devnull, os.O_WRONLY), number)
{first}
from distributed.cli.{module} import main
main()
"""


@pytest.fixture
def swept(tmp_path):
    """A study with one sweep of five chunks."""
    (tmp_path / "swept.py").write_text(SWEPT, encoding="utf-8")
    return "swept.py"


@pytest.fixture
def cluster(tmp_path):
    """A scheduler: its address, what starts a worker after some line of code, and its process; all are forks."""
    pytest.importorskip("distributed", exc_type=ImportError)
    started = []

    def start(module, *words, first="pass"):
        code, words = PROGRAM.format(module=module, first=first), [*words, "--no-dashboard"]
        started.append(warm_runs.start(words, tmp_path, warm_runs.ENVIRONMENT, code, warm_runs.CLUSTER))
        return started[-1]

    file = tmp_path / "scheduler.json"
    began = time.monotonic()
    start("dask_scheduler", "--host", "127.0.0.1", "--port", 0, "--scheduler-file", file)
    while not file.exists() or not file.stat().st_size:
        assert time.monotonic() - began < 60
        time.sleep(0.05)
    address = json.loads(file.read_text())["address"]
    worker = partial(start, "dask_worker", address, "--no-nanny", "--nthreads", 1)
    yield address, worker, started[0]
    for process in started:
        process.kill()
        process.communicate(timeout=30)
