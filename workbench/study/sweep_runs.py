"""The sweeps of a study as a part of it: chunks in a ledger, and from there a sample of each sweep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from workbench.engine.arithmetic import signature
from workbench.study import study_cost
from workbench.study.chosen_steps import ChosenSteps
from workbench.study.compiled_sweep import CompiledSweep
from workbench.study.completion import Pieces, complete_pieces
from workbench.study.executors import on_cluster, on_threads
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Task
from workbench.study.ledger.study_record import SweepRecord
from workbench.study.run_tables import table_of
from workbench.study.study_part import AbstractPart, PartRecord, RunContext
from workbench.study.study_results import Results


@dataclass(frozen=True, eq=False)
class SweepRuns(AbstractPart):
    """Sweeps, each chunk of which is a record of the ledger.

    Attributes
    ----------
    tuning_sweeps, steps, made_later
        The sweeps of tunings, and the chosen steps, from which workers of a cluster make these sweeps again if these
        were made from results.
    """

    sweeps: tuple[CompiledSweep, ...]
    tuning_sweeps: tuple[CompiledSweep, ...]
    steps: ChosenSteps
    made_later: bool

    @property
    def share(self) -> PartRecord:
        """The sweeps with all of their chunks."""
        names = (tuple(one.name(*ends) for ends in one.chunks) for one in self.sweeps)
        each = zip(self.sweeps, names, strict=True)
        return {"sweeps": tuple(SweepRecord(s.sweep.name, s.size, signature(s.arithmetic), held) for s, held in each)}

    def complete(self, site: RunContext, results: Results) -> Results:
        """The results with the sample of each sweep; tables of all runs are written for who only reads the folder."""
        tasks, ledger, order = tasks_of(self.sweeps), site.ledger, site.order
        if site.description.is_newest or any(task.name not in ledger for task in tasks):
            site.description.write()
        site.say_unused()
        needed, runs = study_cost.cost_of(self.sweeps, order.workers), sum(one.size for one in self.sweeps)
        pieces = Pieces("chunks", tasks, partial(self._compute, site), str(needed), "runs", runs)
        complete_pieces(pieces, ledger, order, site.name)
        names = ([task.name for task in tasks if task.sweep == i] for i in range(len(self.sweeps)))
        samples = tuple(one.sample(map(ledger.read, own)) for one, own in zip(self.sweeps, names, strict=True))
        found = replace(results, samples=samples)
        for sample in found.all_samples:
            ledger.write_durably(table_of(sample))
        return found

    def _compute(self, site: RunContext, tasks: Sequence[Task]) -> Iterator[Chunk]:
        """The chunks of tasks, by threads here or by a cluster whose workers find the same sweeps from records."""
        order = site.order
        if order.cluster is None or order.source is None:
            return on_threads(self.sweeps, tasks, order.workers)
        later = self.made_later
        names = (*self.steps.chunks, *(site.description.chunks if later else ()))
        chunks = [site.ledger.read(name) for name in names]
        known = (*(self.tuning_sweeps if later else ()), *self.sweeps)
        arithmetics = tuple((one.sweep.name, one.arithmetic) for one in known)
        source = order.source(arithmetics, tuple((chunk.name, chunk.head, chunk.data) for chunk in chunks))
        return on_cluster(order.cluster, source, tasks, order.workers)


def tasks_of(sweeps: Sequence[CompiledSweep]) -> tuple[Task, ...]:
    """The chunks of some sweeps, each with its name; faults in the numbers of a run are refused here."""
    return tuple(Task(i, *ends, one.name(*ends)) for i, one in enumerate(sweeps) for ends in one.chunks)
