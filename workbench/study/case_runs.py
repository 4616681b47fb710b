"""The cases of a study, each a sweep of one run that keeps its states, and their outcomes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from contextvars import copy_context
from dataclasses import dataclass, replace
from functools import partial

from workbench.core import Ode, SampledSystem
from workbench.core.equations import equations_of
from workbench.core.validation.permission import refuse_in_pages
from workbench.core.validation.refusals import whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.arithmetic import signature
from workbench.engine.job import Progress, threads
from workbench.study import study_cost
from workbench.study.compiled_sweep import CASES, CompiledSweep, compile_case
from workbench.study.completion import Pieces, complete_pieces
from workbench.study.executors import on_threads
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Task
from workbench.study.ledger.study_record import SweepRecord
from workbench.study.run_tables import case_table_of
from workbench.study.study import Study
from workbench.study.study_part import AbstractPart, PartRecord, RunContext
from workbench.study.study_results import Case, Outcome, Results

LONG_RUN = 10.0  # s: what takes longer is said before it begins


class CaseError(ValueError):
    """An error in a case: its message begins with the name of the case, and its cause is the error itself."""


@dataclass(frozen=True, eq=False)
class CompiledCase:
    """A case with its sweep of one run."""

    case: Case
    sweep: CompiledSweep

    def name(self, first: int = 0, last: int = 1) -> str:
        """The name of its chunk, which follows from all on which its numbers depend."""
        return self.sweep.name(first, last)

    def chunk(self, first: int = 0, last: int = 1, progress: Progress | None = None) -> Chunk:
        """Its run, with the states."""
        with _named(self.case):
            return self.sweep.chunk(first, last, progress)

    def outcome(self, chunk: Chunk) -> Outcome:
        """Its outcome, from the chunk of its run."""
        return Outcome(self.case, self.sweep.equation, self.sweep.sample([chunk]).measurement)


@check_arguments
def run(study: Study, progress: Progress | None = None, workers: int | None = None) -> Results:
    """Run every case of the study, in order; `Study.resolve` makes the cases that follow from tunings.

    Parameters
    ----------
    progress
        Called with the share of all steps that is done, from 0 to 1, as each case ends.
    workers
        The number of cases that run at once; as many as there are cores if not given.

    Raises
    ------
    ValueError
        If the cases are a function.
    CaseError
        As soon as a case fails; the other cases end at their next progress.
    """
    refuse_in_pages("run(study)")
    if callable(study.cases):
        raise ValueError("`run(study)` needs the cases themselves, not a function: take `study.resolve(tuned)`.")
    workers = None if workers is None else whole("run(workers=...)", workers)
    cases = compile_cases(study.cases)
    work = {i: one.sweep.cost.seconds for i, one in enumerate(cases)}
    found: dict[str, Chunk] = {}
    for chunk in _computed(cases, tasks_of(cases), workers):
        found[chunk.name] = chunk
        if progress is not None:
            done = sum(work[i] for i, one in enumerate(cases) if one.name() in found)
            progress(done / sum(work.values()))
    return Results(tuple(one.outcome(found[one.name()]) for one in cases))


def compile_cases(cases: Sequence[Case], arithmetic: str | None = None) -> tuple[CompiledCase, ...]:
    """The cases with their sweeps of one run, in an arithmetic by its name or each in the one that serves it best."""
    contexts = [copy_context() for _ in cases]  # that of a thread is its own, and knows of no chosen steps
    with ThreadPoolExecutor(threads()) as pool:  # CasADi gives up the interpreter's lock
        return tuple(pool.map(lambda case, here: here.run(_compiled, case, arithmetic), cases, contexts))


def _compiled(case: Case, arithmetic: str | None) -> CompiledCase:
    with _named(case):
        equation: Ode | SampledSystem = equations_of(case.run.loop, case.name)
        _ = equation.fingerprint  # the report needs it, and here the cases make theirs side by side
        made = CompiledCase(case, compile_case(case.run, equation, arithmetic))
        _ = made.sweep.format.fingerprint
        return made


def tasks_of(cases: Sequence[CompiledCase]) -> tuple[Task, ...]:
    """The run of each case, the longest first; one that several cases share comes once."""
    order = sorted(range(len(cases)), key=lambda i: -cases[i].sweep.cost.seconds)
    tasks = {name: Task(i, 0, 1, name) for i in order if (name := cases[i].name())}
    return tuple(tasks.values())


@dataclass(frozen=True, eq=False)
class CaseRuns(AbstractPart):
    """The cases of a study, the run of each of which is a record of the ledger."""

    cases: tuple[CompiledCase, ...]

    @property
    def share(self) -> PartRecord:
        """The cases as one sweep; None if there are none."""
        arithmetics = "; ".join(sorted({signature(one.sweep.arithmetic) for one in self.cases}))
        names = tuple(one.name() for one in self.cases)
        return {"cases": SweepRecord(CASES, len(names), arithmetics, names) if names else None}

    def complete(self, site: RunContext, results: Results) -> Results:
        """The results with the outcome of each case, and a table of them; runs of earlier cases are removed."""
        ledger, order, tasks = site.ledger, site.order, tasks_of(self.cases)
        missing = [one.sweep for one in self.cases if one.name() not in ledger]
        needed = study_cost.cost_of(missing, order.workers)
        said = f"cases, {needed}" if needed.seconds > LONG_RUN else ""
        pieces = Pieces(
            "cases", tasks, partial(_computed, self.cases, workers=order.workers), said, "cases", len(tasks)
        )
        complete_pieces(pieces, ledger, order, site.name)
        ledger.drop(CASES, {one.name() for one in self.cases})
        found = replace(results, outcomes=tuple(one.outcome(ledger.read(one.name())) for one in self.cases))
        ledger.write_durably(case_table_of(found))
        return found


def _computed(cases: Sequence[CompiledCase], tasks: Sequence[Task], workers: int | None) -> Iterator[Chunk]:
    return on_threads(cases, tasks, workers, at_once=threads())


@contextmanager
def _named(case: Case) -> Iterator[None]:
    """An error is raised with the name of the case."""
    try:
        yield
    except Exception as error:
        kind = "" if type(error) in (ValueError, LookupError) else f"{type(error).__name__}: "
        raise CaseError(f"{case.name}: {kind}{error}") from error
