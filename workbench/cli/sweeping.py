"""Tunings and sweeps as the command line runs them: told beforehand, kept in a ledger, shown, and gone on with."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from workbench.cli.progress import runs, shown_of
from workbench.cli.script import Record, Script, count_of, digest_of, named, resized, sweeps_of
from workbench.study import cost
from workbench.study.executors import LOCAL, on_cluster, on_threads
from workbench.study.ledger.about import About, SweepAbout
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.resume import Execute, Plan, State, complete, in_arithmetic, planned, samples
from workbench.study.ledger.store import LATER, Ledger, is_chunk, opened
from workbench.study.prepared import Prepared
from workbench.study.sample import table_of
from workbench.study.study import Results, Study
from workbench.study.tuning import Tuned, kept
from workbench.study.tuning.ready import Ready, ready
from workbench.validation.refusals import whole


class Stopped(KeyboardInterrupt):
    """Ctrl-C, with what is kept."""


@dataclass(frozen=True)
class Order:
    """What the command line asks of sweeps.

    Attributes
    ----------
    script
        The study's file, which the ledger remembers.
    samples
        In place of the numbers of the designs.
    arithmetic
        That of all sweeps; None for that of the ledger, or of this machine.
    acknowledge
        Told each chunk once it is durable.
    only_report
        Whether nothing is to be computed: what is missing is refused.
    """

    script: Path
    samples: int | None = None
    workers: int | None = None
    cluster: str | None = None
    arithmetic: str | None = None
    fresh: bool = False
    yes: bool = False
    only_report: bool = False
    acknowledge: Callable[[Chunk], None] = lambda chunk: None
    say: Callable[[str], None] = lambda said: None


@dataclass(frozen=True)
class Answered:
    """A study whose cases are known, with the results of its sweeps and tunings."""

    study: Study
    results: Results


def _say_kept(study: Study, order: Order) -> None:
    """Say of which sweeps `--samples` changes nothing."""
    kept = () if callable(study.sweeps) else tuple(one for one in study.sweeps if count_of(one) is None)
    if order.samples is not None and kept:
        order.say(f"`--samples` changes nothing of {named(kept)}: their designs have no number of samples.")


@contextmanager
def swept(study: Study, out: Path, order: Order) -> Iterator[Answered]:
    """The study with all its tunings and sweeps, computed where the ledger in `out` lacks them.

    The ledger stays locked until the report is written.
    """
    if order.workers is not None:
        whole("--workers", order.workers)
    _refuse_idle(study, order)
    if not (study.sweeps or study.tunings):
        yield Answered(study, Results())
        return
    _say_kept(study, order)
    tunings = tuple(map(ready, study.tunings))
    sweeps = sweeps_of(study)
    _afford([*_searches(tunings), *sweeps], out, order)
    with opened(out, order.fresh) as ledger:
        for remark in ledger.remarks:
            order.say(remark)
        tunings = _settled(tunings, ledger, order)
        sweeps = in_arithmetic(sweeps, ledger, order.arithmetic)
        for name, times in {one.arithmetic: cost.slower(one) for one in (*_searches(tunings), *sweeps)}.items():
            if times > 1:
                order.say(
                    f"The arithmetic '{name}' is not compiled here: the same bits take some {times:,} times longer."
                )
        ledger.drop_tables()
        script = os.path.relpath(order.script.resolve(), ledger.out.resolve())
        about = About(study.name, script, order.samples)
        plan = None
        try:
            found, searched = _tuned(study, tunings, ledger, order, about)
            if callable(study.sweeps):
                resolved = resized(study.resolved(found), order.samples)
                _say_kept(resolved, order)
                sweeps = in_arithmetic(sweeps_of(resolved), ledger, order.arithmetic)
                _afford(sweeps, out, order)
            plan = planned(sweeps)
            execute = _executor(sweeps, order, *_searched(tunings, ledger, searched) if callable(study.sweeps) else ())
            _complete(plan, ledger, execute, order, replace(about, sweeps=(*searched, *plan.about)))
            results = Results(samples=samples(plan, ledger), tunings=tuple(found.values()))
            for sample in results.all_samples:  # for those who only read the folder
                ledger.add(table_of(sample))
            yield Answered(study.resolved(found), results)
        except KeyboardInterrupt:
            raise Stopped(f"stopped; {_held(plan, ledger)} are kept in '{out}'. {LATER}") from None


def _held(plan: Plan | None, ledger: Ledger) -> str:
    if plan is None:
        return f"{sum(map(is_chunk, ledger.names))} chunks"
    return f"{sum(task.name in ledger for task in plan.tasks)} of {len(plan.tasks)} chunks"


def _settled(tunings: Sequence[Ready], ledger: Ledger, order: Order) -> tuple[Ready, ...]:
    """The tunings in the arithmetic of the ledger, or in the one that is asked for."""
    sweeps = iter(in_arithmetic(_searches(tunings), ledger, order.arithmetic))
    return tuple(
        replace(made, trials=tuple(islice(sweeps, len(made.trials))), halves=tuple(islice(sweeps, len(made.halves))))
        for made in tunings
    )


def _searches(tunings: Sequence[Ready]) -> list[Prepared]:
    """The sweeps that tunings are made of."""
    return [one for made in tunings for one in (*made.trials, *made.halves)]


def _afford(sweeps: Sequence[Prepared], out: Path, order: Order) -> None:
    if not (order.yes or order.only_report):
        cost.check(cost.cost_of(sweeps, order.workers), out)


def _refuse_idle(study: Study, order: Order) -> None:
    """Refuse options that say how sweeps are run where that cannot be, or there are none."""
    searched = bool(study.tunings)
    options = (
        ("--samples", order.samples, False),
        ("--workers", order.workers, searched),
        ("--cluster", order.cluster, searched),
    )
    for option, value, used in options:
        if value is not None and not (study.sweeps or used):
            raise ValueError(f"`{option}` is for sweeps, and the study '{study.name}' has none; leave it out.")
    if order.workers is not None and order.cluster not in (None, LOCAL) and not searched:
        raise ValueError(
            f"`--workers` is for this machine, and the cluster at '{order.cluster}' has its own workers; leave it out."
        )


def _tuned(
    study: Study, tunings: Sequence[Ready], ledger: Ledger, order: Order, about: About
) -> tuple[dict[str, Tuned], tuple[SweepAbout, ...]]:
    """What each tuning finds, by threads of this machine, and what the ledger says of them."""
    with ExitStack() as bar:

        def begin() -> Callable[[State], None]:
            if order.only_report:
                raise LookupError(
                    f"The tunings in '{ledger.out}' are not complete: `workbench run {order.script} --out "
                    f"{ledger.out}` goes on with them."
                )
            where = "" if order.cluster is None else ", on this machine"
            most = "at most " if any(made.tuning.settle is not None for made in tunings) else ""
            order.say(f"{study.name}: tuning{where}, {most}{cost.cost_of(_searches(tunings), order.workers)}.")
            told = runs(bar.enter_context(shown_of(study.name, order.say)))
            return lambda state: told(*state)

        return kept.complete(
            tunings,
            ledger,
            lambda sweeps, tasks: on_threads(sweeps, tasks, order.workers),
            begin,
            order.acknowledge,
            lambda sweeps: ledger.describe(replace(about, sweeps=sweeps)),
        )


def _complete(plan: Plan, ledger: Ledger, execute: Execute, order: Order, about: About) -> None:
    missing = [task for task in plan.tasks if task.name not in ledger]
    if order.only_report and missing:
        raise LookupError(
            f"{len(missing)} of {len(plan.tasks)} chunks are missing in '{ledger.out}': "
            f"`workbench run {order.script} --out {ledger.out}` computes them."
        )
    ledger.describe(about)
    wanted = {name for sweep in about.sweeps for name in sweep.chunks}
    if unused := sum(is_chunk(name) and name not in wanted for name in ledger.names):
        order.say(
            f"{unused} chunks in '{ledger.out}' are of other samples or equations than the study has now: they are "
            "kept, and not used; `--fresh` removes them."
        )
    if not missing:
        return
    needed, there = cost.cost_of(plan.sweeps, order.workers), len(plan.tasks) - len(missing)
    order.say(
        f"{about.study}: {needed}" + (f"; {there} of {len(plan.tasks)} chunks are there already." if there else ".")
    )
    with shown_of(about.study, order.say) as tell:
        told = runs(tell)
        complete(plan, ledger, execute, lambda state: told(*state), order.acknowledge)


def _executor(
    sweeps: Sequence[Prepared], order: Order, searches: Sequence[Prepared] = (), records: tuple[Record, ...] = ()
) -> Execute:
    """Threads of this machine, or a cluster whose workers find the same sweeps from the tunings' sweeps and chunks."""
    if order.cluster is None:
        return lambda tasks: on_threads(sweeps, tasks, order.workers)
    arithmetics = tuple((one.sweep.name, one.arithmetic) for one in (*searches, *sweeps))
    source = Script(str(order.script.resolve()), digest_of(order.script), order.samples, arithmetics, records)
    address = order.cluster
    return lambda tasks: on_cluster(address, source, tasks, order.workers)


def _searched(
    tunings: Sequence[Ready], ledger: Ledger, searched: Sequence[SweepAbout]
) -> tuple[list[Prepared], tuple[Record, ...]]:
    """The sweeps of all tunings, and their chunks."""
    chunks = (ledger.read(name) for one in searched for name in one.chunks)
    return _searches(tunings), tuple((chunk.name, chunk.head, chunk.data) for chunk in chunks)
