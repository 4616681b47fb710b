"""Executors: the threads of this machine, or the workers of a Dask cluster, which compute chunks and items of works."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from itertools import islice
from queue import Empty, Queue, SimpleQueue
from threading import Event, Lock, Thread
from threading import enumerate as enumerate_threads
from time import monotonic
from types import ModuleType
from typing import Any, Protocol

import casadi as ca

from workbench import __version__
from workbench.core.validation.permission import refuse_in_pages
from workbench.engine.arithmetic import VERSION
from workbench.engine.job import LOOK, set_stop_check, threads, use_threads
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import LATER, Task

AHEAD = 2  # chunks computed or waiting while one is written
PATIENCE = 15.0  # s for a cluster to answer
GRACE_PERIOD = 0.3  # s in which pieces under way may end by themselves when they are no longer wanted
CREW = "crew"  # the name of the threads that compute them
LOCAL = "local"  # the address of a cluster that is started here
RESUME_ADVICE = f"What was done is kept. {LATER}"


class CancelledError(RuntimeError):
    """The error that ends a march whose result is no longer wanted."""


class ClusterError(ValueError):
    """The error of a cluster that cannot do what it is asked for; its finished chunks are kept."""


class ChunkMaker(Protocol):
    """A sweep, a case or a work, compiled: it names and computes its chunks."""

    def name(self, first: int, last: int) -> str:
        """The name of a chunk."""

    def chunk(self, first: int, last: int) -> Chunk:
        """A chunk."""


Pieces = Sequence[ChunkMaker]
# The source of a study's sweeps or works for another process, as plain data that is sent there and can be hashed.
Source = Callable[[], Pieces]


def on_threads(pieces: Pieces, tasks: Sequence[Task], workers: int | None = None, at_once: int = 1) -> Iterator[Chunk]:
    """The chunks as they are done, `at_once` of them side by side, which share `workers` threads or one a processor.

    One at a time, a few are computed while one is written. When no more are wanted, marches under way end at their
    next look at progress. What cannot be ended stays with a thread that holds up nothing: the process still ends.
    """
    refuse_in_pages("on_threads(...)")  # the context of a thread is its own
    side = workers or threads()
    at_once = max(1, min(at_once, side, len(tasks)))
    stopped, rest = Event(), iter(tasks)
    waiting, done = SimpleQueue[Task | None](), SimpleQueue[Chunk | BaseException]()

    def look() -> None:
        if stopped.is_set():
            raise CancelledError

    def serve() -> None:
        use_threads(side // at_once)
        set_stop_check(look)
        while (task := waiting.get()) is not None and not stopped.is_set():
            try:
                done.put(pieces[task.sweep].chunk(task.first, task.last))
            except BaseException as error:
                done.put(error)

    crew = [Thread(target=serve, name=CREW, daemon=True) for _ in range(at_once)]
    try:
        for one in crew:
            one.start()
        for task in islice(rest, at_once if at_once > 1 else 1 + AHEAD):
            waiting.put(task)
        for _ in tasks:
            yield _next(done)
            waiting.put(next(rest, None))
    finally:
        stopped.set()
        for _ in crew:
            waiting.put(None)
        parting = monotonic() + GRACE_PERIOD
        for one in crew:
            one.join(max(0.0, parting - monotonic()))


def is_busy() -> bool:
    """True if a thread still computes what is no longer wanted."""
    return any(one.name == CREW for one in enumerate_threads())


def _next(done: SimpleQueue[Chunk | BaseException]) -> Chunk:
    """The next chunk, or the error that came instead; Windows tells of Ctrl-C only between two waits."""
    while True:
        try:
            found = done.get(timeout=LOOK)
        except Empty:
            continue
        if isinstance(found, BaseException):
            raise found
        return found


def on_cluster(address: str, source: Source, tasks: Sequence[Task], workers: int | None = None) -> Iterator[Chunk]:
    """The chunks as the workers of a Dask cluster finish them; those of a lost worker are computed by another one.

    Each worker makes the sweeps or works itself, and its samples from their seeds: only names travel there, and
    numbers back. With the address "local", a scheduler and `workers` of one thread are started, which listen on this
    machine alone.
    """
    try:
        import distributed
        from distributed.comm.core import CommClosedError
    except ImportError as error:
        raise ClusterError("`--cluster` needs the extra `cluster`: install `control-workbench[cluster]`.") from error
    with _client(distributed, address, workers) as client:
        try:
            _check_versions(client, address)
            yield from _gathered(client, address, source, tasks)
        except CommClosedError as error:
            raise ClusterError(f"The scheduler at '{address}' has gone. {RESUME_ADVICE}") from error
        except distributed.KilledWorker as error:
            raise ClusterError(
                f"A chunk was lost with several workers of the cluster at '{address}', one after the other: {error} "
                "Look at their logs: perhaps they lack memory."
            ) from error


def _gathered(client: Any, address: str, source: Source, tasks: Sequence[Task]) -> Iterator[Chunk]:
    """The chunks in the order in which they are done; as many wait at the workers as keep them busy."""
    rest, waiting, done = iter(tasks), {}, Queue[Any]()

    def submit(count: int) -> None:
        for _, task in zip(range(count), rest, strict=False):
            future = client.submit(compute, source, tuple(task), version(), key=task.name)
            waiting[future.key] = future
            future.add_done_callback(done.put)

    submit(AHEAD * max(1, sum(client.nthreads().values())))
    while waiting:
        try:
            future = done.get(timeout=PATIENCE)
        except Empty:  # chunks may be long, but not without workers
            _wait_for_workers(client, address)
            continue
        if future.key not in waiting:  # one that was asked for twice
            continue
        if future.cancelled():
            raise ClusterError(f"The scheduler at '{address}' has gone. {RESUME_ADVICE}")
        try:
            chunk = Chunk(*future.result(timeout=PATIENCE))
        except TimeoutError:
            if future.status == "error":  # the study's own
                raise
            _wait_for_workers(client, address)  # its worker was lost with it, and another one computes it again
            done.put(future)
            continue
        yield chunk
        del waiting[future.key]
        submit(1)


@contextmanager
def _client(distributed: ModuleType, address: str, workers: int | None) -> Iterator[Any]:
    """A client of the cluster, which has at least one worker."""
    from distributed.comm.addressing import resolve_address

    page = {"dashboard": False, "dashboard_address": "127.0.0.1:0"}  # any free port: two clusters may run at once
    local: dict[str, object] = {"host": "127.0.0.1", "scheduler_kwargs": page, "silence_logs": 50}
    for name in ("distributed", "asyncio", *logging.root.manager.loggerDict):
        if name.partition(".")[0] in ("distributed", "asyncio"):  # each has a level of its own
            logging.getLogger(name).setLevel(logging.CRITICAL)  # a connection that ends is said in one sentence
    with ExitStack() as stack:
        try:
            cluster = address
            if address == LOCAL:
                made = distributed.LocalCluster(n_workers=workers or threads(), threads_per_worker=1, **local)
                cluster = stack.enter_context(made)
            else:
                resolve_address(address)  # a name that is none is refused before a thread is started for it
            client = stack.enter_context(distributed.Client(cluster, timeout=PATIENCE))
        except (OSError, ValueError, TypeError, ImportError) as error:  # the last three: what it makes of odd addresses
            raise ClusterError(
                f"The cluster at '{address}' does not answer: {error}. An address is HOST:PORT, as `dask scheduler` "
                "prints it, or `local`."
            ) from error
        _wait_for_workers(client, address)
        yield client


def _wait_for_workers(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except OSError as error:
        raise ClusterError(
            f"The cluster at '{address}' has no workers, and none came in {PATIENCE:g} s: start `dask worker`. "
            f"{RESUME_ADVICE}"
        ) from error


def _check_versions(client: Any, address: str) -> None:
    """Refuse workers with another version of the workbench, whose bits could differ."""
    try:
        found: dict[str, str] = client.run(version)
    except OSError:  # the scheduler has gone
        raise
    except Exception as error:  # a worker that cannot import the workbench raises whatever its import raises
        raise ClusterError(f"A worker of the cluster at '{address}' cannot load the workbench: {error}.") from error
    for worker, theirs in found.items():
        if theirs != version():
            raise ClusterError(_another(f"The worker {worker}", theirs, version()))


def version() -> str:
    """The versions on which a bit can depend, asked of a worker."""
    return f"workbench {__version__}, CasADi {ca.CasadiMeta.version()}, arithmetic {VERSION}"


def compute(source: Source, task: tuple[int, int, int, str], version_of_caller: str) -> tuple[str, bytes, bytes]:
    """Name, head and data of a chunk, in the process of a worker: one at a time, with the worker's threads."""
    import distributed

    if version_of_caller != version():
        raise ClusterError(_another("A worker that has come later", version(), version_of_caller))
    sweep, first, last, name = task
    with _ALONE:
        use_threads(int(distributed.get_worker().state.nthreads))
        one = _pieces(source)[sweep]
        found = one.name(first, last)
        if found != name:
            raise ClusterError(
                f"A worker finds '{found}' where '{name}' was asked for: it has another study or machine."
            )
        chunk = one.chunk(first, last)
    return chunk.name, chunk.head, chunk.data


_ALONE = Lock()  # CasADi's expressions are not for several threads


@lru_cache(maxsize=1)
def _pieces(source: Source) -> Pieces:
    """The sweeps or works in the process of a worker, or the refusal of a study that cannot be imported there."""
    try:
        return source()
    except ImportError as error:
        raise ClusterError(f"A worker cannot load the study: {error}. What it imports must be there too.") from error


def _another(worker: str, theirs: str, ours: str) -> str:
    return f"{worker} has {theirs}, and this is {ours}: chunks of two versions do not mix. Install the same there."
