"""The works of a study as parts of it: those that are listed, and those that follow from all other results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from workbench.engine.job import threads
from workbench.study import study_cost
from workbench.study.completion import Pieces, complete_pieces
from workbench.study.executors import on_cluster, on_threads
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Task
from workbench.study.ledger.study_record import WorkRecord
from workbench.study.run_options import StudyOptions
from workbench.study.study import Study
from workbench.study.study_part import AbstractPart, PartRecord, RunContext
from workbench.study.study_results import Results
from workbench.study.study_works import CompiledWork, compile_works


@dataclass(frozen=True, eq=False)
class WorkRuns(AbstractPart):
    """Works, each item of which is a record of the ledger."""

    works: tuple[CompiledWork, ...]

    @property
    def share(self) -> PartRecord:
        """The works with the names of their records."""
        return {"works": tuple(WorkRecord(one.work.name, one.names) for one in self.works)}

    def complete(self, site: RunContext, results: Results) -> Results:
        """The results with the answers of each work by its name."""
        order, pairs = site.order, [(i, k) for i, one in enumerate(self.works) for k in range(one.size)]
        tasks = tuple(Task(i, k, k + 1, self.works[i].names[k]) for i, k in pairs)
        if not order.only_report and any(task.name not in site.ledger for task in tasks):
            site.description.write()
        execute, needed = partial(_compute, self.works, order), str(study_cost.cost_of((), order.workers, self.works))
        pieces = Pieces("items of works", tasks, execute, needed, "items", len(tasks))
        complete_pieces(pieces, site.ledger, order, site.name)
        answers = {one.work.name: one.answers(site.ledger.read) for one in self.works}
        return replace(results, works={**results.works, **answers})


@dataclass(frozen=True, eq=False)
class LaterWorkRuns(AbstractPart):
    """The works of a study that follow from the results of all else, computed by threads of this machine."""

    study: Study

    @property
    def share(self) -> PartRecord:
        """That there are more works."""
        return {"more": callable(self.study.works)}

    def complete(self, site: RunContext, results: Results) -> Results:
        """The results with the answers of these works."""
        if not callable(self.study.works):
            return results
        here = replace(site, order=replace(site.order, cluster=None))
        later = WorkRuns(compile_works(self.study.works_from(results)))
        study_cost.afford((), later.works, site.ledger.out, site.order)
        site.description.update({**later.share, "more": False})
        site.description.write()
        found = later.complete(here, results)
        site.say_unused()
        return found


def _compute(works: Sequence[CompiledWork], order: StudyOptions, tasks: Sequence[Task]) -> Iterator[Chunk]:
    """The answers of some items, by threads here or by a cluster."""
    if order.cluster is None or order.source is None:
        return on_threads(works, tasks, order.workers, at_once=threads())
    return on_cluster(order.cluster, order.source(works=True), tasks, order.workers)
