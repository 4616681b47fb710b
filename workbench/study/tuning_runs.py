"""The tunings of a study as a part of it: generations in a ledger, and from there the answer of each tuning."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace

from workbench.study import study_cost
from workbench.study.compiled_sweep import CompiledSweep
from workbench.study.completion import run_again
from workbench.study.executors import on_threads
from workbench.study.ledger.store import Tell
from workbench.study.ledger.study_record import SweepRecord
from workbench.study.study_part import AbstractPart, PartRecord, RunContext
from workbench.study.study_results import Results
from workbench.study.tuning.checkpoint import about_of_searches, tune_in_ledger
from workbench.study.tuning.search import TuningSearch


@dataclass(frozen=True, eq=False)
class TuningRuns(AbstractPart):
    """Tunings, each generation of which is a record of the ledger, computed by threads of this machine."""

    searches: tuple[TuningSearch, ...]

    @property
    def sweeps(self) -> tuple[CompiledSweep, ...]:
        """The sweeps of all searches."""
        return tuple(one for search in self.searches for one in search.sweeps)

    @property
    def share(self) -> PartRecord:
        """The runs that are known before anything is computed."""
        return {"tunings": about_of_searches(self.searches, {one.sweep.name: [] for one in self.sweeps})}

    def complete(self, site: RunContext, results: Results) -> Results:
        """The results with the answer of each tuning."""

        def describe(tunings: tuple[SweepRecord, ...]) -> None:
            site.description.update({"tunings": tunings})
            site.description.write()

        with ExitStack() as stack:
            tuned, tunings = tune_in_ledger(
                self.searches,
                site.ledger,
                lambda sweeps, tasks: on_threads(sweeps, tasks, site.order.workers),
                lambda: stack.enter_context(self._begin(site)),
                site.order.acknowledge,
                describe,
            )
        site.description.update({"tunings": tunings})
        return replace(results, tunings=tuple(tuned.values()))

    def _begin(self, site: RunContext) -> AbstractContextManager[Tell]:
        """The place where one is told how far the tunings are, after their cost was said."""
        order = site.order
        if order.only_report:
            ledger = site.ledger
            raise LookupError(f"The tunings in '{ledger.out}' are not complete: {run_again(ledger, order)}.")
        where = "" if order.cluster is None else ", on this machine"
        most = "at most " if any(search.tuning.settle is not None for search in self.searches) else ""
        order.say(f"{site.name}: tuning{where}, {most}{study_cost.cost_of(self.sweeps, order.workers)}.")
        return order.bar(site.name, "runs")
