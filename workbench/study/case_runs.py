"""Run the cases of a study, several at once, and gather their outcomes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from threading import Event, Lock

from workbench.core import Ode, Sampled
from workbench.core.equations import equations_of
from workbench.simulate.job import Progress, ended
from workbench.study.compiled import CompiledSweep, compile_case
from workbench.study.ledger.chunk import Chunk
from workbench.study.study import Case, Outcome, Results, Study
from workbench.validation.refusals import whole
from workbench.validation.signatures import door


class CaseError(ValueError):
    """An error in a case: its message begins with the name of the case, and its cause is the error itself."""


@door
def run(study: Study, progress: Progress | None = None, workers: int | None = None) -> Results:
    """Every case of the study, in its order; those that follow from tunings are in `study.resolved`.

    Parameters
    ----------
    progress
        Called from any thread with the share of all steps that is done.
    workers
        The number of cases that run at once; as many as there are cores if not given.

    Raises
    ------
    ValueError
        If the cases are a function.
    CaseError
        As soon as a case fails; the other cases end at their next progress.
    """
    cases = study.cases
    if callable(cases):
        raise ValueError("`run(study)` needs the cases themselves, not a function: take `study.resolved(tuned)`.")
    total = sum(map(_work, cases)) or 1.0
    weights = [_work(case) / total for case in cases]
    shares, lock, stopped = [0.0] * len(cases), Lock(), Event()

    def tell(i: int, share: float) -> None:
        if stopped.is_set():
            raise RuntimeError("the study was stopped")
        with lock:
            shares[i] = share
            if progress is not None:
                progress(sum(w * s for w, s in zip(weights, shares, strict=True)))

    workers = (os.cpu_count() or 1) if workers is None else whole("run(workers=...)", workers)
    order = sorted(range(len(cases)), key=lambda i: -_work(cases[i]))  # the longest first
    pool = ThreadPoolExecutor(workers)  # CasADi gives up the interpreter's lock
    try:
        futures = {i: pool.submit(_outcome, cases[i], partial(tell, i)) for i in order}
        done = ended(futures.values())
        failed = [i for i in sorted(futures) if futures[i] in done and futures[i].exception() is not None]
        if failed:
            futures[failed[0]].result()
        return Results(tuple(futures[i].result() for i in range(len(cases))))
    finally:
        stopped.set()
        pool.shutdown(cancel_futures=True)


def _work(case: Case) -> float:
    # of steps that are not chosen yet, `every` is all that is known: they are no longer
    return case.run.until / (case.run.h or case.run.kept)


def _outcome(case: Case, tell: Progress) -> Outcome:
    with named(case):
        one = compiled(case)
        return outcome(case, one, one.chunk(0, 1, tell))


@contextmanager
def named(case: Case) -> Iterator[None]:
    """An error is raised with the name of the case."""
    try:
        yield
    except Exception as error:
        kind = "" if type(error) in (ValueError, LookupError) else f"{type(error).__name__}: "
        raise CaseError(f"{case.name}: {kind}{error}") from error


def compiled(case: Case, arithmetic: str | None = None) -> CompiledSweep:
    """The case as a sweep of one row."""
    equation: Ode | Sampled = equations_of(case.run.loop, case.name)
    _ = equation.fingerprint  # the report needs it, and here the cases make theirs side by side
    return compile_case(case.run, equation, arithmetic)


def outcome(case: Case, one: CompiledSweep, chunk: Chunk) -> Outcome:
    """The outcome of a case from the chunk of its run."""
    return Outcome(case, one.equation, one.sample([chunk]).measurement)
