"""Tunings and sweeps as the command line runs them: told beforehand, kept in a ledger, shown, and gone on with."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from workbench.progress import runs, shown_of
from workbench.script import load
from workbench.study import cost
from workbench.study.chunk import Chunk
from workbench.study.executors import LOCAL, ClusterError, on_cluster, on_threads
from workbench.study.prepared import Prepared, prepared
from workbench.study.resume import Execute, Plan, State, complete, planned, samples
from workbench.study.sample import Sample
from workbench.study.store import ABOUT, LATER, Ledger, opened
from workbench.study.study import Study
from workbench.study.sweep import Sweep, whole
from workbench.study.tuning import Tuned, kept
from workbench.study.tuning.ready import Ready, ready

Record = tuple[str, bytes, bytes]  # name, head and data of a chunk
COUNTS = ("runs", "base", "trajectories")  # how designs call the number that `--samples` sets


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
    acknowledge
        Told each chunk once it is durable.
    only_report
        Whether nothing is to be computed: what is missing is refused.
    """

    script: Path
    samples: int | None = None
    workers: int | None = None
    cluster: str | None = None
    fresh: bool = False
    yes: bool = False
    only_report: bool = False
    acknowledge: Callable[[Chunk], None] = lambda chunk: None
    say: Callable[[str], None] = lambda said: None


@dataclass(frozen=True)
class Answered:
    """A study whose cases are known, the samples of its sweeps, and what its tunings found."""

    study: Study
    samples: tuple[Sample, ...] = ()
    tunings: tuple[Tuned, ...] = ()


def resized(study: Study, count: int | None) -> Study:
    """The study with so many samples in the design of each sweep that has a number of them, as far as these are known.

    A design without one, one factor at a time say, keeps its points.

    Raises
    ------
    ValueError
        If the count is no positive whole number, or no design has such a number.
    """
    if count is None:
        return study
    whole("--samples", count)
    if callable(study.sweeps):
        return study
    if study.sweeps and not any(map(_count_of, study.sweeps)):
        raise ValueError(
            f"`--samples` cannot change the study '{study.name}': the designs of its sweeps, {_named(study.sweeps)}, "
            "have no number of samples; leave it out."
        )
    return replace(study, sweeps=tuple(_resized(one, count) for one in study.sweeps))


def _resized(sweep: Sweep, count: int) -> Sweep:
    name = _count_of(sweep)
    return sweep if name is None else replace(sweep, design=replace(sweep.design, **{name: count}))  # type: ignore[type-var]


def _count_of(sweep: Sweep) -> str | None:
    """How the design of a sweep calls its number of samples; None where it has none."""
    held: Any = fields(sweep.design) if is_dataclass(sweep.design) else ()
    whole_ones = {field.name for field in held if isinstance(getattr(sweep.design, field.name), int)}
    return next((name for name in COUNTS if name in whole_ones), None)  # the `base` of `OneAtATime` is a quantile


def _say_kept(study: Study, order: Order) -> None:
    """Say of which sweeps `--samples` changes nothing."""
    kept = () if callable(study.sweeps) else tuple(one for one in study.sweeps if _count_of(one) is None)
    if order.samples is not None and kept:
        order.say(f"`--samples` changes nothing of {_named(kept)}: their designs have no number of samples.")


def _named(sweeps: Sequence[Sweep]) -> str:
    return ", ".join(f"'{one.name}'" for one in sweeps)


@contextmanager
def swept(study: Study, out: Path, order: Order) -> Iterator[Answered]:
    """The study with all its tunings and sweeps, computed where the ledger in `out` lacks them.

    The ledger stays locked until the report is written.
    """
    whole("--workers", order.workers, optional=True)
    _refuse_idle(study, order)
    if not (study.sweeps or study.tunings):
        yield Answered(study)
        return
    _say_kept(study, order)
    tunings = tuple(map(ready, study.tunings))
    sweeps = _prepared(study)
    _afford([*_searches(tunings), *sweeps], out, order)
    with opened(out, order.fresh) as ledger:
        for remark in ledger.remarks:
            order.say(remark)
        about: dict[str, Any] = {
            "study": study.name,
            "script": os.path.relpath(order.script.resolve(), ledger.out.resolve()),
            "samples": order.samples,
        }
        plan = None
        try:
            found, said = _tuned(study, tunings, ledger, order, about)
            if callable(study.sweeps):
                resolved = resized(study.resolved(found), order.samples)
                _say_kept(resolved, order)
                sweeps = _prepared(resolved)
                _afford(sweeps, out, order)
            plan = planned(sweeps)
            execute = _executor(sweeps, order, _records(ledger, said) if callable(study.sweeps) else ())
            _complete(plan, ledger, execute, order, about | {"sweeps": [*said, *plan.said]})
            yield Answered(study.resolved(found), samples(plan, ledger), tuple(found.values()))
        except KeyboardInterrupt:
            raise Stopped(f"stopped; {_held(plan, ledger)} are kept in '{out}'. {LATER}") from None


def _held(plan: Plan | None, ledger: Ledger) -> str:
    if plan is None:
        return f"{len(ledger.places) - (ABOUT in ledger)} chunks"
    return f"{sum(task.name in ledger for task in plan.tasks)} of {len(plan.tasks)} chunks"


def _prepared(study: Study) -> tuple[Prepared, ...]:
    """The sweeps that are known."""
    return () if callable(study.sweeps) else tuple(map(prepared, study.sweeps))


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
    study: Study, tunings: Sequence[Ready], ledger: Ledger, order: Order, about: dict[str, Any]
) -> tuple[dict[str, Tuned], list[dict[str, Any]]]:
    """What each tuning finds, by threads of this machine, and what the ledger says of them."""
    with ExitStack() as bar:

        def begin() -> Callable[[State], None]:
            if order.only_report:
                raise LookupError(
                    f"The tunings in '{ledger.out}' are not complete: `workbench run {order.script} --out "
                    f"{ledger.out}` goes on with them."
                )
            where = "" if order.cluster is None else ", on this machine"
            order.say(f"{study.name}: tuning{where}, {cost.cost_of(_searches(tunings), order.workers)}.")
            told = runs(bar.enter_context(shown_of(study.name, order.say)))
            return lambda state: told(*state)

        return kept.complete(
            tunings,
            ledger,
            lambda sweeps, tasks: on_threads(sweeps, tasks, order.workers),
            begin,
            order.acknowledge,
            lambda said: ledger.describe(about | {"sweeps": said}),
        )


def _complete(plan: Plan, ledger: Ledger, execute: Execute, order: Order, about: dict[str, Any]) -> None:
    missing = [task for task in plan.tasks if task.name not in ledger]
    if order.only_report and missing:
        raise LookupError(
            f"{len(missing)} of {len(plan.tasks)} chunks are missing in '{ledger.out}': "
            f"`workbench run {order.script} --out {ledger.out}` computes them."
        )
    ledger.describe(about)
    wanted = {ABOUT, *(name for said in about["sweeps"] for name in said["chunks"])}
    if unused := len(ledger.places.keys() - wanted):
        order.say(
            f"{unused} chunks in '{ledger.out}' are of other samples, numbers or code than the study has now: they are "
            "kept, and not used; `--fresh` removes them."
        )
    if not missing:
        return
    needed, there = cost.cost_of(plan.sweeps, order.workers), len(plan.tasks) - len(missing)
    order.say(
        f"{about['study']}: {needed}" + (f"; {there} of {len(plan.tasks)} chunks are there already." if there else ".")
    )
    with shown_of(about["study"], order.say) as tell:
        told = runs(tell)
        complete(plan, ledger, execute, lambda state: told(*state), order.acknowledge)


def _records(ledger: Ledger, said: Sequence[dict[str, Any]]) -> tuple[Record, ...]:
    """The chunks of all tunings, from which a worker finds the same sweeps."""
    chunks = (ledger.read(name) for one in said for name in one["chunks"])
    return tuple((chunk.name, chunk.head, chunk.data) for chunk in chunks)


def _executor(sweeps: Sequence[Prepared], order: Order, records: tuple[Record, ...]) -> Execute:
    if order.cluster is None:
        return lambda tasks: on_threads(sweeps, tasks, order.workers)
    source = Script(str(order.script.resolve()), digest_of(order.script), order.samples, records)
    address = order.cluster
    return lambda tasks: on_cluster(address, source, tasks, order.workers)


@dataclass(frozen=True)
class Script:
    """A study's file, at the same place on every worker, with its digest; called, it is loaded and its sweeps prepared.

    Attributes
    ----------
    records
        The chunks of the tunings, from which sweeps follow: name, head and data of each.

    Raises
    ------
    ClusterError
        If there is no such file, or another one, or its tunings ask there for other points than here.
    """

    file: str
    digest: str
    samples: int | None
    records: tuple[Record, ...] = ()

    def __call__(self) -> tuple[Prepared, ...]:
        """The sweeps, in the process of a worker."""
        file = Path(self.file)
        if not file.is_file() or digest_of(file) != self.digest:
            raise ClusterError(f"A worker finds no '{self.file}', or another one: the study must be where it is here.")
        study = load(file)
        if callable(study.sweeps):
            chunks = {name: Chunk(name, head, data) for name, head, data in self.records}
            try:
                found = {one.name: kept.replayed(ready(one), chunks) for one in study.tunings}
            except KeyError as error:
                raise ClusterError(f"A worker asks in a tuning for {error}, which is not here: it differs.") from None
            study = replace(study, sweeps=study.sweeps(found))
        return _prepared(resized(study, self.samples))


def digest_of(file: Path) -> str:
    """The SHA-256 of a file."""
    return hashlib.sha256(file.read_bytes()).hexdigest()
