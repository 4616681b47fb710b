"""Who computes chunks: the threads of this machine, or a Dask cluster."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Event

from workbench.simulate.job import use_threads
from workbench.study.chunk import Chunk
from workbench.study.prepared import Prepared
from workbench.study.resume import Task

AHEAD = 2  # chunks computed or waiting while one is written


class StoppedError(RuntimeError):
    """What ends a chunk that nobody waits for any more."""


def on_threads(sweeps: Sequence[Prepared], tasks: Sequence[Task], workers: int | None = None) -> Iterator[Chunk]:
    """The chunks one behind the other, each by `workers` threads of the engine, or as many as there are processors.

    A chunk is computed while the one before it is written.
    """
    stopped = Event()

    def tell(share: float) -> None:
        del share
        if stopped.is_set():
            raise StoppedError

    def compute(task: Task) -> Chunk:
        return sweeps[task.sweep].chunk(task.first, task.last, tell)

    pool = ThreadPoolExecutor(1, initializer=use_threads, initargs=(workers,))
    waiting: deque[Future[Chunk]] = deque()
    try:
        for task in tasks:
            waiting.append(pool.submit(compute, task))
            if len(waiting) > AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)
