"""One core for what is measured: two threads of one core share it, and their processor time says little."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def one_core() -> Iterator[None]:
    """Restrict this process to its first processor within a `with` block, if the system can do that.

    A time that is measured within the block is of one core, whatever the number of threads.

    Examples
    --------
    >>> from time import process_time
    >>> with wb.study.one_core():
    ...     start = process_time()
    ...     _ = sum(range(1000))
    ...     used = process_time() - start
    >>> used >= 0
    True
    """
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
