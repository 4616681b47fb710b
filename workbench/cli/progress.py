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
    with shown_of(name, say) as tell:
        yield lambda share: tell(share, "")


@contextmanager
def shown_of(name: str, say: Callable[[str], None]) -> Iterator[Callable[[float, str], None]]:
    """The same, told a remark beside the share."""
    if not sys.stderr.isatty():
        yield _lines(name, say)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    told = (TaskProgressColumn(), TextColumn("{task.fields[remark]}"), TimeRemainingColumn())
    columns = (TextColumn("{task.description}"), BarColumn(), *told)
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=1.0, remark="")
        yield lambda share, remark: bar.update(task, completed=share, remark=remark)


def runs(tell: Callable[[float, str], None]) -> Callable[[int, int, int], None]:
    """What is told the runs done, those that failed, and all of them; it tells on the share of those that were missing.

    What was done before says nothing of the rate.
    """
    start, before = monotonic(), -1

    def told(done: int, failed: int, total: int) -> None:
        nonlocal before
        before = done if before < 0 else before
        rate = (done - before) / max(monotonic() - start, 1e-9)
        lost = f", {failed:,} failed" if failed else ""
        share = (done - before) / (total - before) if total > before else 1.0
        tell(share, f"{done:,} of {total:,} runs, {rate:,.0f} a second{lost}")

    return told


def _lines(name: str, say: Callable[[str], None]) -> Callable[[float, str], None]:
    start = last = monotonic()

    def tell(share: float, remark: str) -> None:
        nonlocal last
        now = monotonic()
        if 0 < share < 0.995 and now - last >= SECONDS_BETWEEN_LINES:
            last = now
            left = (now - start) * (1 - share) / share
            say(f"{name}: {share:.0%} done, {f'{remark}, ' if remark else ''}about {left:.0f} s left")

    return tell
