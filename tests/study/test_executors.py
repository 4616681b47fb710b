"""Who computes chunks: threads that stop when they are told, and a cluster that may lose a worker."""

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from tests.support import warm_runs
from tests.support.compilers import SLOW
from tests.support.sweeps import sweep
from tests.support.swept_studies import SWEPT
from workbench.cli.script import Script
from workbench.study import executors
from workbench.study.compiled_sweep import compile_sweep
from workbench.study.executors import ClusterError, on_cluster, on_threads
from workbench.study.sweep_runs import tasks_of
from workbench.study.uncertainty import MonteCarlo

STUDY = Path(__file__).parents[1] / "exams" / "small_study.py"


def test_chunks_come_in_the_order_of_their_tasks():
    sweeps = [compile_sweep(sweep())]
    tasks = tasks_of(sweeps)
    assert [chunk.name for chunk in on_threads(sweeps, tasks, 2)] == [task.name for task in tasks]
    assert list(on_threads(sweeps, [])) == []


def test_threads_stop_within_a_chunk_when_nobody_waits_for_it():
    # some minutes of work in a single chunk behind a short one
    short = compile_sweep(sweep(design=MonteCarlo(2, 8)))
    long = compile_sweep(sweep(design=MonteCarlo(2, 4096), h=1e-5, until=100.0, runs_of_chunk=4096))
    first, second = tasks_of([short, long])
    chunks = on_threads([short, long], [first, first, first, second])
    next(chunks)
    began = time.monotonic()
    chunks.close()
    assert time.monotonic() - began < 30  # a look at progress comes every half second of a processor


def test_what_a_chunk_raises_is_raised_where_it_is_waited_for():
    sweeps = [compile_sweep(sweep())]
    with pytest.raises(ValueError, match="must be a whole number from 0 to 50; got 1000"):
        list(on_threads(sweeps, [tasks_of(sweeps)[0]._replace(last=1000)]))


def test_a_cluster_without_its_library_is_refused_in_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"install `control-workbench\[cluster\]`"):
        next(on_cluster("local", lambda: (), ()))


# What follows starts a scheduler and workers as processes of their own.


def command(out, *words, study=STUDY):
    words = ["run", study, "--out", out, "--ack", *words]
    return warm_runs.start(
        words, out.parent, warm_runs.ENVIRONMENT, modules=warm_runs.CLUSTER if "--cluster" in words else ()
    )


def acknowledged(stdout):
    return {line.split()[1]: line.split()[2] for line in stdout.splitlines() if line.startswith("ACK ")}


@pytest.mark.heavy
@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_a_cluster_that_loses_a_worker_gives_every_chunk_with_the_bits_of_one_machine(cluster, tmp_path):
    address, worker, _ = cluster
    first, _ = worker(), worker()
    with command(tmp_path / "there", "--cluster", address) as process:
        lines = []
        while len(lines) < 4:
            lines.append(process.stdout.readline())
            assert lines[-1]
        first.send_signal(signal.SIGKILL)
        rest, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    with command(tmp_path / "here") as process:
        stdout, _ = process.communicate(timeout=300)
    there = acknowledged("".join(lines) + rest)
    assert there == acknowledged(stdout)
    assert len(there) == 20


@pytest.mark.heavy
def test_workers_with_and_without_a_compiler_give_the_same_bits(cluster, tmp_path):
    address, worker, _ = cluster
    worker(first="sys.modules['llvmlite'] = None")
    study = tmp_path / "swept.py"
    study.write_text(SWEPT.replace("until=2.0", "until=0.2"), encoding="utf-8")
    done = []
    for out, words in (("plain", ["--cluster", address]), ("both", ["--cluster", address]), ("here", [])):
        if out == "both":
            worker()
        with command(tmp_path / out, *words, study=study) as process:
            stdout, said = process.communicate(timeout=300)
        assert process.returncode == 0, said
        done.append(acknowledged(stdout))
    assert done[0] == done[1] == done[2]
    assert len(done[0]) == 5


@pytest.mark.heavy
def test_a_worker_with_another_version_is_refused_with_both(cluster, tmp_path):
    address, worker, _ = cluster
    worker(first='from workbench.study import executors; executors.__version__ = "0.0.1"')
    with command(tmp_path / "out", "--cluster", address) as process:
        stdout, said = process.communicate(timeout=300)
    assert (process.returncode, acknowledged(stdout)) == (2, {})
    assert "has workbench 0.0.1, CasADi" in said.splitlines()[-1]


def test_a_worker_that_comes_later_with_another_version_is_told_both(monkeypatch):
    ours = executors.version()
    monkeypatch.setattr(executors, "__version__", "9.9")
    with pytest.raises(ClusterError, match=f"later has workbench 9.9, .*, and this is {ours}: chunks of two versions"):
        executors.compute(lambda: (), (0, 0, 8, "x"), ours)


@pytest.mark.heavy
@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_the_death_of_a_scheduler_is_said_in_one_sentence(cluster, tmp_path):
    address, worker, scheduler = cluster
    worker()
    with command(tmp_path / "out", "--cluster", address) as process:
        assert process.stdout.readline().startswith("ACK ")
        scheduler.kill()
        _, said = process.communicate(timeout=300)
    cost, *progress, sentence = said.removeprefix("".join(SLOW)).splitlines()
    # a worker that has still to start, or a chunk that is not compiled, lasts until progress is told
    assert all(line.startswith("small_study: 5% done") for line in progress)
    assert cost.startswith("small_study: 5,120 runs")
    assert sentence.startswith(f"workbench: The scheduler at '{address}' has gone. What was done is kept.")


@pytest.mark.heavy
@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_a_cluster_that_loses_all_workers_or_its_scheduler_is_refused_in_a_sentence(cluster, monkeypatch):
    address, worker, scheduler = cluster
    patient = executors.PATIENCE
    source = Script.of(STUDY)
    tasks = tasks_of(source())

    def lose(process, patience):
        monkeypatch.setattr(executors, "PATIENCE", patient)
        chunks = on_cluster(address, source, tasks)
        assert next(chunks).name in {task.name for task in tasks}
        monkeypatch.setattr(executors, "PATIENCE", patience)
        process.kill()
        process.communicate(timeout=30)
        list(chunks)

    first = worker()
    with pytest.raises(ClusterError, match=r"has no workers, and none came in .* What was done is kept"):
        lose(first, 1.0)
    worker()
    with pytest.raises(ClusterError, match=f"The scheduler at '{address}' has gone"):
        lose(scheduler, patient)


@pytest.mark.parametrize("address", ["", "host:port", "http://127.0.0.1:9"])
def test_an_address_that_is_none_is_refused_with_what_one_is(address):
    pytest.importorskip("distributed", exc_type=ImportError)
    with pytest.raises(ClusterError, match="An address is HOST:PORT, as `dask scheduler` prints it, or `local`"):
        next(on_cluster(address, lambda: (), ()))


def test_a_cluster_that_does_not_answer_is_refused_in_a_sentence(monkeypatch):
    pytest.importorskip("distributed", exc_type=ImportError)
    monkeypatch.setattr(executors, "PATIENCE", 0.5)
    with pytest.raises(ClusterError, match=r"'tcp://127\.0\.0\.1:9' does not answer: Timed out .* after 0\.5 s"):
        next(on_cluster("tcp://127.0.0.1:9", lambda: (), ()))
