"""Execution of a study: its tunings, sweeps and works, piece by piece into a ledger, and from there its results."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from workbench.simulate.arithmetic import signature
from workbench.simulate.job import threads
from workbench.study import case_runs, cost
from workbench.study.compilation import CompiledStudy, afford
from workbench.study.compiled import CompiledSweep
from workbench.study.completion import Pieces, complete_pieces, run_again
from workbench.study.executors import on_cluster, on_threads
from workbench.study.ledger import store
from workbench.study.ledger.about import UNUSED, About, SweepAbout, WorkAbout, is_chunk
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Ledger, Task, Tell
from workbench.study.order import Order, check_options
from workbench.study.run_tables import case_table_of, table_of
from workbench.study.sample import Sample
from workbench.study.study import Results, Study
from workbench.study.tuning import Tuned
from workbench.study.tuning.checkpoint import about_of_searches, tune_in_ledger
from workbench.study.tuning.search import Search
from workbench.study.work import CompiledWork, compile_works

Answers = dict[str, tuple[Any, ...]]


@dataclass(frozen=True)
class Records:
    """The sweeps of tunings, and the names of records, from which workers of a cluster make other sweeps again."""

    searched: tuple[CompiledSweep, ...] = ()
    names: tuple[str, ...] = ()


class Stopped(KeyboardInterrupt):
    """The interruption of a study by Ctrl-C, with the chunks that are kept."""


@contextmanager
def execute(study: Study, out: Path, order: Order) -> Iterator[tuple[Study, Results]]:
    """The study with its cases known, and the results of all that it declares, computed where the ledger lacks them.

    The ledger in the folder `out` stays locked until the report is written.
    """
    check_options(study, order)
    if not (study.sweeps or study.tunings or study.works or study.cases):
        _leave(study, out, order)
        yield study, Results()
        return
    plan = CompiledStudy.of(study, out, order)
    plan.afford()
    with store.opened(out, order.fresh) as ledger, _stoppable(ledger):
        for remark in (*ledger.remarks, *cost.slow([*plan.searched, *plan.sweeps])):
            order.say(remark)
        ledger.drop(store.TABLE)
        ledger.add(plan.steps.chunks.values())
        about = replace(About.of(study.name, order.script, ledger.out, order.samples), **plan.about)
        later, yet = callable(study.sweeps), replace(about, sweeps=_all_sweeps(plan.searches, plan.sweeps))
        answers = _answers(plan.works, ledger, order, yet) if plan.works else {}
        tuned, tuned_about = _tuned(plan.searches, ledger, order, about)
        plan = plan.resolved({**tuned, **answers}, ledger)
        about = replace(about, sweeps=tuned_about)
        own = (*plan.steps.chunks, *(replace(about, cases=None).chunks if later else ()))
        records = Records(plan.searched if later else (), own)
        about = replace(about, cases=case_runs.about_cases(plan.cases))
        samples, about = _samples(plan.sweeps, records, ledger, order, about)
        results = Results(samples=samples, tunings=tuple(tuned.values()), works=answers)
        for sample in results.all_samples:  # for those who only read the folder
            ledger.write_durably(table_of(sample))
        results = replace(results, outcomes=case_runs.outcomes_in(ledger, plan.cases, order, study.name))
        ledger.write_durably(case_table_of(results))
        if callable(study.works):
            results = replace(results, works=_later_answers(plan.study, results, ledger, order, about))
        yield plan.study, results


def _leave(study: Study, out: Path, order: Order) -> None:
    """Have a ledger of earlier sweeps and works say that the study no longer has any."""
    about = store.about_in(out)
    if about is None:
        return
    now = About.of(study.name, order.script, out)
    if about != now:
        with store.opened(out) as ledger:
            ledger.drop(store.TABLE)
            ledger.describe(now)
            _say_unused(now, ledger, order)


def _say_unused(about: About, ledger: Ledger, order: Order) -> None:
    if unused := about.unused(ledger.names):
        order.say(UNUSED.format(count=unused, out=ledger.out))


@contextmanager
def _stoppable(ledger: Ledger) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        kept = sum(map(is_chunk, ledger.names))
        raise Stopped(f"stopped; {kept} chunks are kept in '{ledger.out}'. {store.LATER}") from None


def _tuned(
    searches: Sequence[Search], ledger: Ledger, order: Order, about: About
) -> tuple[dict[str, Tuned], tuple[SweepAbout, ...]]:
    """The answer of each tuning, computed by threads of this machine, and its runs as the ledger describes them."""
    with ExitStack() as stack:

        def begin() -> Tell:
            if order.only_report:
                raise LookupError(f"The tunings in '{ledger.out}' are not complete: {run_again(ledger, order)}.")
            where = "" if order.cluster is None else ", on this machine"
            most = "at most " if any(search.tuning.settle is not None for search in searches) else ""
            needed = cost.cost_of([one for search in searches for one in search.sweeps], order.workers)
            order.say(f"{about.study}: tuning{where}, {most}{needed}.")
            return stack.enter_context(order.bar(about.study, "runs"))

        return tune_in_ledger(
            searches,
            ledger,
            lambda sweeps, tasks: on_threads(sweeps, tasks, order.workers),
            begin,
            order.acknowledge,
            lambda sweeps: ledger.describe(replace(about, sweeps=sweeps)),
        )


def _samples(
    sweeps: Sequence[CompiledSweep],
    records: Records,
    ledger: Ledger,
    order: Order,
    about: About,
) -> tuple[tuple[Sample, ...], About]:
    """The sample of each sweep, from chunks of which the missing are computed; and the state of the study with them."""
    tasks = tasks_of(sweeps)
    abouts = _about_sweeps(sweeps)
    now = replace(about, sweeps=(*about.sweeps, *abouts))
    missing = any(task.name not in ledger for task in tasks)
    if missing or not about.more or store.about_in(ledger.out) is None:  # else an earlier run has told more
        ledger.describe(now)
    _say_unused(now, ledger, order)
    needed, runs = cost.cost_of(sweeps, order.workers), sum(one.size for one in sweeps)
    execute = partial(_compute, sweeps, records, ledger, order)
    complete_pieces(Pieces("chunks", tasks, execute, str(needed), "runs", runs), ledger, order, about.study)
    each = zip(sweeps, abouts, strict=True)
    return tuple(one.sample(map(ledger.read, mine.chunks)) for one, mine in each), now


def _all_sweeps(searches: Sequence[Search], sweeps: Sequence[CompiledSweep]) -> tuple[SweepAbout, ...]:
    """The runs of all tunings and sweeps that are known before anything is computed."""
    nothing: dict[str, list[str]] = {one.sweep.name: [] for search in searches for one in search.sweeps}
    return (*about_of_searches(searches, nothing), *_about_sweeps(sweeps))


def _about_sweeps(sweeps: Sequence[CompiledSweep]) -> tuple[SweepAbout, ...]:
    """The sweeps with all of their chunks, as the ledger describes them."""
    names = (tuple(one.name(*ends) for ends in one.chunks) for one in sweeps)
    each = zip(sweeps, names, strict=True)
    return tuple(SweepAbout(one.sweep.name, one.size, signature(one.arithmetic), held) for one, held in each)


def _later_answers(study: Study, results: Results, ledger: Ledger, order: Order, about: About) -> Answers:
    """The answers of the works that follow from the results of all else, by threads of this machine."""
    works = compile_works(study.works_from(results))
    afford((), works, ledger.out, order)
    now = replace(about, works=tuple(WorkAbout(one.work.name, one.names) for one in works), more=False)
    ledger.describe(now)
    answers = _answers(works, ledger, replace(order, cluster=None), now)
    _say_unused(now, ledger, order)
    return answers


def _answers(works: Sequence[CompiledWork], ledger: Ledger, order: Order, about: About) -> Answers:
    """The answers of each work by its name, read from records of which the missing are computed."""
    tasks = tuple(Task(i, k, k + 1, name) for i, one in enumerate(works) for k, name in enumerate(one.names))
    execute = partial(_compute_items, works, order)
    if not order.only_report and any(task.name not in ledger for task in tasks):
        ledger.describe(about)
    needed = str(cost.cost_of((), order.workers, works))
    complete_pieces(Pieces("items of works", tasks, execute, needed, "items", len(tasks)), ledger, order, about.study)
    return {one.work.name: one.answers(ledger.read) for one in works}


def tasks_of(sweeps: Sequence[CompiledSweep]) -> tuple[Task, ...]:
    """The chunks of some sweeps, each with its name; faults in the numbers of a run are refused here."""
    return tuple(Task(i, *ends, one.name(*ends)) for i, one in enumerate(sweeps) for ends in one.chunks)


def _compute(
    sweeps: Sequence[CompiledSweep], records: Records, ledger: Ledger, order: Order, tasks: Sequence[Task]
) -> Iterator[Chunk]:
    """The chunks of tasks, by threads here or by a cluster whose workers find the same sweeps from some records."""
    if order.cluster is None or order.source is None:
        return on_threads(sweeps, tasks, order.workers)
    chunks = [ledger.read(name) for name in records.names]
    arithmetics = tuple((one.sweep.name, one.arithmetic) for one in (*records.searched, *sweeps))
    source = order.source(arithmetics, tuple((chunk.name, chunk.head, chunk.data) for chunk in chunks))
    return on_cluster(order.cluster, source, tasks, order.workers)


def _compute_items(works: Sequence[CompiledWork], order: Order, tasks: Sequence[Task]) -> Iterator[Chunk]:
    """The answers of some items, by threads here or by a cluster."""
    if order.cluster is None or order.source is None:
        return on_threads(works, tasks, order.workers, at_once=threads())
    return on_cluster(order.cluster, order.source(works=True), tasks, order.workers)
