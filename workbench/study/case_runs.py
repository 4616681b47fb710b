"""Run the cases of a study, several at once, and gather their outcomes."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import Event, Lock
from typing import Any

from workbench.core import Ode, Sampled
from workbench.core.equations import equations_of
from workbench.metrics import Measurement, measure
from workbench.simulate.job import Progress, ended
from workbench.study.contract import Run
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
    return case.run.until / (2 * case.run.h if case.run.h else case.run.kept)


def _outcome(case: Case, tell: Progress) -> Outcome:
    """The equations and the measurement of a case; an error is raised with its name."""
    try:
        ode: Ode | Sampled = equations_of(case.run.loop, case.name)
        _ = ode.fingerprint  # the report needs it, and here the cases make theirs side by side
        return Outcome(case, ode, measurement(case.run, ode, f"Case({case.scenario!r}, {case.law!r}, run=...)", tell))
    except Exception as error:
        kind = "" if type(error) in (ValueError, LookupError) else f"{type(error).__name__}: "
        raise CaseError(f"{case.name}: {kind}{error}") from error


def measurement(
    run: Run, equation: Ode | Sampled, call: str = "Run(...)", progress: Progress | None = None
) -> Measurement:
    """The measurement of a run, its values at the step and their change from twice the step, in the name of a call."""
    h = None if run.h is None else run.doubled(equation, call)
    asked: dict[str, Any] = {"until": run.until, "h": h, "every": run.every, "tolerance": run.tolerance}
    return measure(equation, run.metrics, **asked, seed=run.seed, progress=progress)
