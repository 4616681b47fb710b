"""The options with which a study is run, checked against what the study declares."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from workbench.core.validation.refusals import whole
from workbench.study.executors import LOCAL, Source
from workbench.study.ledger.chunk import Chunk
from workbench.study.ledger.store import Tell
from workbench.study.study import Study

Record = tuple[str, bytes, bytes]  # name, head and data of a chunk
Arithmetics = tuple[tuple[str, str], ...]  # that of each sweep, by their names
ArithmeticOf = Callable[[str], str | None]


def _ignore(*told: object) -> None:
    """The ear of those who need not be told."""
    del told


def _no_bar(name: str, unit: str) -> AbstractContextManager[Tell]:
    """A bar that shows nothing."""
    del name, unit
    return nullcontext(_ignore)


@dataclass(frozen=True)
class StudyOptions:
    """The options with which a study is run."""

    script: Path
    samples: int | None = None
    workers: int | None = None
    cluster: str | None = None
    arithmetic: str | None = None  # without it that of the ledger, or of this machine
    fresh: bool = False
    yes: bool = False
    only_report: bool = False  # computes nothing: what is missing is refused
    acknowledge: Callable[[Chunk], None] = _ignore  # told each chunk once it is durable
    say: Callable[[str], None] = _ignore
    # where the workers of a cluster find the same sweeps, from arithmetics and the chunks of the tunings, or works
    source: Callable[..., Source] | None = None
    # a place, by the name of the study and of its pieces, where one is told how far they are
    bar: Callable[[str, str], AbstractContextManager[Tell]] = _no_bar


def check_options(study: Study, order: StudyOptions) -> None:
    """Refuse options about sweeps and works for a study without any, and others that exclude each other."""
    for name in ("workers", "samples"):
        if (count := getattr(order, name)) is not None:
            whole(f"--{name}", count)
    if order.samples is not None and study.least_samples is not None and order.samples < study.least_samples:
        raise ValueError(
            f"`--samples` must be at least {study.least_samples:,} for the study '{study.name}', as its tables need "
            f"them; got {order.samples:,}."
        )
    searched, works = bool(study.tunings), bool(study.works)
    options = (
        ("--samples", order.samples, False),
        ("--workers", order.workers, searched or works or bool(study.cases)),
        ("--cluster", order.cluster, searched or works),
    )
    for option, value, used in options:
        if value is not None and not (study.sweeps or used):
            of = "sweeps" if option == "--samples" else "sweeps, tunings and works"
            raise ValueError(f"`{option}` is for {of}, and the study '{study.name}' has none; leave it out.")
    if order.workers is not None and order.cluster not in (None, LOCAL) and not (searched or callable(study.works)):
        raise ValueError(
            f"`--workers` is for this machine, and the cluster at '{order.cluster}' has its own workers; leave it out."
        )
