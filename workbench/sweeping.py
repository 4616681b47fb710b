"""The sweeps of a study as the command line runs them: told beforehand, kept in a ledger, shown, and gone on with."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any

from workbench.progress import runs, shown_of
from workbench.script import load
from workbench.study import cost
from workbench.study.chunk import Chunk
from workbench.study.executors import ClusterError, on_cluster, on_threads
from workbench.study.prepared import Prepared, prepared
from workbench.study.resume import Execute, Plan, complete, planned, samples
from workbench.study.sample import Sample
from workbench.study.store import LATER, Ledger, opened
from workbench.study.study import Study
from workbench.study.sweep import whole

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


def resized(study: Study, count: int | None) -> Study:
    """The study with so many samples in the design of each sweep.

    Raises
    ------
    ValueError
        If the count is no positive whole number, or a design has no such number.
    """
    if count is None:
        return study
    whole("--samples", count)
    return replace(
        study, sweeps=tuple(replace(one, design=_resized(one.design, count, one.name)) for one in study.sweeps)
    )


def _resized(design: Any, count: int, sweep: str) -> Any:
    names = [field.name for field in fields(design)] if is_dataclass(design) else []
    for name in COUNTS:
        if name in names and not isinstance(design, type):
            return replace(design, **{name: count})
    raise ValueError(
        f"`--samples` cannot change the sweep '{sweep}', whose design has no number of samples of its own."
    )


@contextmanager
def swept(study: Study, out: Path, order: Order) -> Iterator[tuple[Sample, ...]]:
    """The samples of all sweeps of a study, computed where the ledger in `out` lacks them; none without sweeps.

    The ledger stays locked until the report is written.
    """
    whole("--workers", order.workers, optional=True)
    if not study.sweeps:
        _refuse_idle(study, order)
        yield ()
        return
    sweeps = tuple(map(prepared, study.sweeps))
    needed = cost.cost_of(sweeps, order.workers)
    if not (order.yes or order.only_report):
        cost.check(needed, out)
    with opened(out, order.fresh) as ledger:
        for remark in ledger.remarks:
            order.say(remark)
        plan = planned(sweeps)
        try:
            _complete(study, plan, ledger, order, needed)
            yield samples(plan, ledger)
        except KeyboardInterrupt:
            held = sum(task.name in ledger for task in plan.tasks)
            raise Stopped(f"stopped; {held} of {len(plan.tasks)} chunks are kept in '{out}'. {LATER}") from None


def _refuse_idle(study: Study, order: Order) -> None:
    """Refuse options that say how sweeps are run where there are none."""
    for option, value in (("--samples", order.samples), ("--workers", order.workers), ("--cluster", order.cluster)):
        if value is not None:
            raise ValueError(f"`{option}` is for sweeps, and the study '{study.name}' has none; leave it out.")


def _complete(study: Study, plan: Plan, ledger: Ledger, order: Order, needed: cost.Cost) -> None:
    missing = [task for task in plan.tasks if task.name not in ledger]
    if order.only_report and missing:
        raise LookupError(
            f"{len(missing)} of {len(plan.tasks)} chunks are missing in '{ledger.out}': "
            f"`workbench run {order.script} --out {ledger.out}` computes them."
        )
    script = os.path.relpath(order.script.resolve(), ledger.out.resolve())
    ledger.describe({"study": study.name, "script": script, "samples": order.samples, "sweeps": plan.said})
    if not missing:
        return
    kept = len(plan.tasks) - len(missing)
    order.say(f"{study.name}: {needed}" + (f"; {kept} of {len(plan.tasks)} chunks are there already." if kept else "."))
    with shown_of(study.name, order.say) as tell:
        told = runs(tell)
        complete(plan, ledger, _executor(plan.sweeps, order), lambda state: told(*state), order.acknowledge)


def _executor(sweeps: Sequence[Prepared], order: Order) -> Execute:
    if order.cluster is None:
        return lambda tasks: on_threads(sweeps, tasks, order.workers)
    source = Script(str(order.script.resolve()), digest_of(order.script), order.samples)
    address = order.cluster
    return lambda tasks: on_cluster(address, source, tasks, order.workers)


@dataclass(frozen=True)
class Script:
    """A study's file, at the same place on every worker, with its digest; called, it is loaded and its sweeps prepared.

    Raises
    ------
    ClusterError
        If there is no such file, or another one.
    """

    file: str
    digest: str
    samples: int | None

    def __call__(self) -> tuple[Prepared, ...]:
        """The sweeps, in the process of a worker."""
        file = Path(self.file)
        if not file.is_file() or digest_of(file) != self.digest:
            raise ClusterError(f"A worker finds no '{self.file}', or another one: the study must be where it is here.")
        return tuple(map(prepared, resized(load(file), self.samples).sweeps))


def digest_of(file: Path) -> str:
    """The SHA-256 of a file."""
    return hashlib.sha256(file.read_bytes()).hexdigest()
