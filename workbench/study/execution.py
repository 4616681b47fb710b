"""Execution of a study: all of its parts, piece by piece into a ledger, and from there its results."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from workbench.study.compiled_study import CompiledStudy
from workbench.study.ledger import store
from workbench.study.ledger.store import Ledger
from workbench.study.ledger.study_record import StudyRecord, is_chunk
from workbench.study.run_options import StudyOptions, check_options
from workbench.study.study import Study
from workbench.study.study_part import Description, RunContext
from workbench.study.study_results import Results


class StudyInterrupt(KeyboardInterrupt):
    """The interruption of a study by Ctrl-C, with the chunks that are kept."""


@contextmanager
def execute(study: Study, out: Path, order: StudyOptions) -> Iterator[tuple[Study, Results]]:
    """The study with its cases known, and the results of all that it declares, computed where the ledger lacks them.

    The ledger in the folder `out` stays locked until the report is written.
    """
    check_options(study, order)
    if not (study.sweeps or study.tunings or study.works or study.cases):
        _leave(StudyRecord.of(study.name, order.script, out), out, order)
        yield study, Results()
        return
    plan = CompiledStudy.of(study, out, order)
    plan.afford()
    with store.open_ledger(out, order.fresh) as ledger, _stoppable(ledger):
        for remark in (*ledger.remarks, *plan.remarks):
            order.say(remark)
        ledger.drop(store.TABLE)
        ledger.add(plan.steps.chunks.values())
        yield plan.complete(ledger)


def _leave(now: StudyRecord, out: Path, order: StudyOptions) -> None:
    """Have a ledger of an earlier version of a study say that the study no longer declares anything."""
    if store.about_in(out) in (None, now):
        return
    with store.open_ledger(out) as ledger:
        ledger.drop(store.TABLE)
        description = Description(ledger, now)
        description.write()
        RunContext(ledger, order, description).say_unused()


@contextmanager
def _stoppable(ledger: Ledger) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        kept = sum(map(is_chunk, ledger.names))
        raise StudyInterrupt(f"stopped; {kept} chunks are kept in '{ledger.out}'. {store.LATER}") from None
