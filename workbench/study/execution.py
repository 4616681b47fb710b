"""Execution of a study: all of its parts, piece by piece into a ledger, and from there its results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from workbench.study.compilation import CompiledStudy
from workbench.study.ledger import store
from workbench.study.ledger.about import About, is_chunk
from workbench.study.ledger.store import Ledger
from workbench.study.outcome import Results
from workbench.study.part_contract import Description, Site
from workbench.study.run_options import Order, check_options
from workbench.study.study import Study


class Stopped(KeyboardInterrupt):
    """The interruption of a study by Ctrl-C, with the chunks that are kept."""


@contextmanager
def execute(study: Study, out: Path, order: Order) -> Iterator[tuple[Study, Results]]:
    """The study with its cases known, and the results of all that it declares, computed where the ledger lacks them.

    The ledger in the folder `out` stays locked until the report is written.
    """
    check_options(study, order)
    if not (study.sweeps or study.tunings or study.works or study.cases):
        _leave(About.of(study.name, order.script, out), out, order)
        yield study, Results()
        return
    plan = CompiledStudy.of(study, out, order)
    plan.afford()
    with store.opened(out, order.fresh) as ledger, _stoppable(ledger):
        for remark in (*ledger.remarks, *plan.remarks):
            order.say(remark)
        ledger.drop(store.TABLE)
        ledger.add(plan.steps.chunks.values())
        yield plan.complete(ledger)


def _leave(now: About, out: Path, order: Order) -> None:
    """Have a ledger of an earlier version of a study say that the study no longer declares anything."""
    if store.about_in(out) in (None, now):
        return
    with store.opened(out) as ledger:
        ledger.drop(store.TABLE)
        description = Description(ledger, now)
        description.write()
        Site(ledger, order, description).say_unused()


@contextmanager
def _stoppable(ledger: Ledger) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        kept = sum(map(is_chunk, ledger.names))
        raise Stopped(f"stopped; {kept} chunks are kept in '{ledger.out}'. {store.LATER}") from None
