"""Run the cases of a study, several at once, and gather their outcomes."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from threading import Lock

from workbench.metrics import measure
from workbench.study.study import Case, Outcome, Results, Study

Progress = Callable[[float], None]


class CaseError(ValueError):
    """What went wrong in a case, with the name of the case before it; the error itself is its cause."""


def run(study: Study, progress: Progress | None = None, workers: int | None = None) -> Results:
    """Every case of the study, in its order. CasADi gives up the interpreter's lock, so threads serve.

    Sweeps and tunings are not run here; cases that follow from tunings are those of `study.resolved`.

    Parameters
    ----------
    progress
        Called from any thread with the share of all steps that is done.
    workers
        How many cases at once; as many as there are cores if not given.

    Raises
    ------
    ValueError
        If the cases are a function.
    CaseError
        As soon as a case fails, with its name; the other cases end at their next progress.
    """
    cases = study.cases
    if callable(cases):
        raise ValueError("`run(study)` needs the cases themselves, not a function: take `study.resolved(tuned)`.")
    tally = _Tally(cases, progress)
    longest_first = sorted(range(len(cases)), key=lambda i: -_work(cases[i]))
    pool = ThreadPoolExecutor(workers or os.cpu_count() or 1)
    try:
        futures = {i: pool.submit(_outcome, cases[i], tally.of(i)) for i in longest_first}
        done, _ = wait(futures.values(), return_when=FIRST_EXCEPTION)
        failed = [i for i in sorted(futures) if futures[i] in done and futures[i].exception() is not None]
        if failed:
            futures[failed[0]].result()
        return Results(tuple(futures[i].result() for i in range(len(cases))))
    finally:
        tally.stopped = True
        pool.shutdown(cancel_futures=True)


def _work(case: Case) -> float:
    # of steps that are not chosen yet, `every` is all that is known: they are no longer
    return case.until / (case.h or case.every)


def _outcome(case: Case, progress: Progress) -> Outcome:
    try:
        ode = case.loop.ode(case.name)
        measurement = measure(
            ode,
            case.metrics,
            until=case.until,
            h=case.h,
            every=case.every,
            tolerance=case.tolerance,
            progress=progress,
        )
    except Exception as error:
        kind = "" if type(error) in (ValueError, LookupError) else f"{type(error).__name__}: "
        raise CaseError(f"{case.name}: {kind}{error}") from error
    return Outcome(case, ode, measurement)


class _Tally:
    """Adds up the shares of cases that run side by side, and stops them all when one of them failed."""

    def __init__(self, cases: tuple[Case, ...], progress: Progress | None) -> None:
        total = sum(map(_work, cases)) or 1.0
        self.weights = [_work(case) / total for case in cases]
        self.shares = [0.0] * len(cases)
        self.progress = progress
        self.stopped = False
        self.lock = Lock()

    def of(self, i: int) -> Progress:
        """Where case i tells its share."""

        def tell(share: float) -> None:
            if self.stopped:
                raise RuntimeError("the study was stopped")
            with self.lock:
                self.shares[i] = share
                if self.progress is not None:
                    self.progress(sum(w * s for w, s in zip(self.weights, self.shares, strict=True)))

        return tell
