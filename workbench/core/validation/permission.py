"""Permission to simulate: everywhere but where a page is made of results that are there already."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar


@contextmanager
def no_runs(where: str) -> Iterator[None]:
    """Have all that simulates refused in this context, in which `where` is called."""
    mark = _where.set(where)
    try:
        yield
    finally:
        _where.reset(mark)


def refuse_in_pages(call: str) -> None:
    """Refuse a call that simulates while a page is made.

    Raises
    ------
    ValueError
        Within `no_runs`.
    """
    if where := _where.get():
        raise ValueError(
            f"`{call}` must not be called by `{where}`: what is simulated there is in no ledger, no estimate and no "
            "progress, and is lost with the page. Declare a `Case`, a `Sweep` or a `Work` and take its numbers from "
            "the results; a study that measures times says `measures_time=True`."
        )


_where: ContextVar[str] = ContextVar("where no run is begun", default="")
