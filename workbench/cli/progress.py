"""Progress on stderr: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Protocol

SECONDS_BETWEEN_LINES = 10.0


class ProgressReporter(Protocol):
    """A function that takes the share of the work that is done, and a remark."""

    def __call__(self, share: float, remark: str = "", /) -> None:
        """Take the share and the remark."""


@contextmanager
def progress_bar(name: str, say: Callable[[str], None]) -> Iterator[ProgressReporter]:
    """A bar on a terminal, and elsewhere a line now and then, by the share that is done."""
    if not sys.stderr.isatty():
        yield _lines(name, say)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    told = (TaskProgressColumn(), TextColumn("{task.fields[remark]}"), TimeRemainingColumn())
    columns = (TextColumn("{task.description}"), BarColumn(), *told)
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=1.0, remark="")

        def tell(share: float, remark: str = "", /) -> None:
            bar.update(task, completed=share, remark=remark)

        yield tell


@contextmanager
def runs_shown(name: str, unit: str, say: Callable[[str], None]) -> Iterator[Callable[[int, int, int], None]]:
    """The progress as `progress_bar` prints it, from the counts of runs or items that are done, failed and in all."""
    with progress_bar(name, say) as tell:
        yield runs(tell, unit)


def runs(tell: ProgressReporter, unit: str = "runs") -> Callable[[int, int, int], None]:
    """A function of the runs, or items, done, failed and in all, that tells the share and rate since its first call."""
    start, before = monotonic(), -1

    def report_progress(done_count: int, failed_count: int, total: int) -> None:
        nonlocal before
        before = done_count if before < 0 else before
        rate = (done_count - before) / max(monotonic() - start, 1e-9)
        lost = f", {failed_count:,} failed" if failed_count else ""
        share = (done_count - before) / (total - before) if total > before else 1.0
        tell(share, f"{done_count:,} of {total:,} {unit}, {rate:,.{0 if rate >= 10 else 2}f} a second{lost}")

    return report_progress


def _lines(name: str, say: Callable[[str], None]) -> ProgressReporter:
    start = last = monotonic()

    def tell(share: float, remark: str = "", /) -> None:
        nonlocal last
        now = monotonic()
        if 0 < share < 0.995 and now - last >= SECONDS_BETWEEN_LINES:
            last = now
            left = (now - start) * (1 - share) / share
            say(f"{name}: {share:.0%} done, {f'{remark}, ' if remark else ''}about {left:.0f} s left")

    return tell
