"""How far a run is, on stderr: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

SECONDS_BETWEEN_LINES = 10.0


@contextmanager
def shown(name: str, say: Callable[[str], None]) -> Iterator[Callable[[float], None]]:
    """What is told the share that is done: it draws a bar on a terminal, and elsewhere says a line now and then."""
    if not sys.stderr.isatty():
        yield _lines(name, say)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=1.0)
        yield lambda share: bar.update(task, completed=share)


def _lines(name: str, say: Callable[[str], None]) -> Callable[[float], None]:
    start = last = monotonic()

    def tell(share: float) -> None:
        nonlocal last
        now = monotonic()
        if 0 < share < 0.995 and now - last >= SECONDS_BETWEEN_LINES:
            last = now
            left = (now - start) * (1 - share) / share
            say(f"{name}: {share:.0%} done, about {left:.0f} s left")

    return tell
