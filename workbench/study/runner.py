"""Run the cases of a study, several at once, and gather their outcomes."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_EXCEPTION, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import partial
from threading import Lock
from typing import Any, TypeVar, cast

from workbench.core import Ode, Sampled
from workbench.metrics import Measurement, measure, measure_alike
from workbench.study.contract import Run, equations_of
from workbench.study.study import Case, Outcome, Results, Study
from workbench.validation.doors import door
from workbench.validation.words import whole

FULL = 4  # cases and their half steps fill one of the widest vectors
FEW_WORKERS = 4  # up to so many gain more by two vectors of one kernel than by another kernel beside it

Progress = Callable[[float], None]
T = TypeVar("T")


class CaseError(ValueError):
    """What went wrong in a case, with the name of the case before it; the error itself is its cause."""


@door
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
    workers = (os.cpu_count() or 1) if workers is None else whole("run(workers=...)", workers)
    groups = _in_turns(cases, _groups(cases, 2 * FULL if workers <= FEW_WORKERS else FULL))
    pool = ThreadPoolExecutor(workers)
    try:
        futures = {g: pool.submit(_outcomes, [cases[i] for i in g], [tally.of(i) for i in g]) for g in groups}
        done, _ = wait(futures.values(), return_when=FIRST_EXCEPTION)
        failed = [g for g in sorted(futures) if futures[g] in done and futures[g].exception() is not None]
        if failed:
            futures[failed[0]].result()
        outcomes = {i: outcome for g in groups for i, outcome in zip(g, futures[g].result(), strict=True)}
        return Results(tuple(outcomes[i] for i in range(len(cases))))
    finally:
        tally.stopped = True
        pool.shutdown(cancel_futures=True)


def _work(case: Case) -> float:
    # of steps that are not chosen yet, `every` is all that is known: they are no longer
    return case.run.until / (2 * case.run.h if case.run.h else case.run.kept)


def _groups(cases: Sequence[Case], most: int) -> list[tuple[int, ...]]:
    """The numbers of the cases, at most so many together that may be alike: loops of the same blocks, at one step.

    What a loop follows may differ, and so may metrics and horizon.
    """
    groups: dict[object, list[int]] = {}
    for i, case in enumerate(cases):
        run, loop = case.run, cast(Any, case.run.loop)
        named = is_dataclass(loop) and not isinstance(loop, Ode | Sampled) and run.h is not None
        names = [f.name for f in fields(loop)] if named else []
        blocks: list[object] = [type(getattr(loop, name)) for name in names if name != "reference"] or [i]
        groups.setdefault((run.h, run.every, run.tolerance, run.seed, *blocks), []).append(i)
    return [tuple(g[k : k + most]) for g in groups.values() for k in range(0, len(g), most)]


def _in_turns(cases: Sequence[Case], groups: Sequence[tuple[int, ...]]) -> list[tuple[int, ...]]:
    """Longest first, but groups of many spread among those of a few: the former keep the interpreter busy."""
    shares: list[tuple[float, tuple[int, ...]]] = []
    for few in (True, False):
        kind = [group for group in groups if (len(group) <= 2) is few]
        work = {group: sum(_work(cases[i]) for i in group) for group in kind}
        done, total = 0.0, sum(work.values()) or 1.0
        for group in sorted(kind, key=lambda group: -work[group]):
            shares.append((done / total, group))
            done += work[group]
    return [group for _, group in sorted(shares)]


def _outcomes(cases: Sequence[Case], tells: Sequence[Progress]) -> list[Outcome]:
    """The outcomes of cases that may be alike."""
    odes = [_named(case, partial(_ode, case)) for case in cases]
    first, found = cases[0].run, None
    if first.h is not None and len(cases) > 1:
        with suppress(ValueError, LookupError):  # what is wrong with which of them is told below
            found = measure_alike(
                odes,
                [case.run.metrics for case in cases],
                until=[case.run.until for case in cases],
                h=2 * first.h,
                every=first.every,
                tolerance=first.tolerance,
                seed=first.seed,
                progress=partial(_tell_all, tells),
            )
    if found is None:
        runs = zip(cases, odes, tells, strict=True)
        found = [_named(case, partial(_measured, case, ode, tell)) for case, ode, tell in runs]
    return [Outcome(*of) for of in zip(cases, odes, found, strict=True)]


def _tell_all(tells: Sequence[Progress], share: float) -> None:
    for tell in tells:
        tell(share)


def _named(case: Case, call: Callable[[], T]) -> T:
    """What a call gives, or its error with the name of the case."""
    try:
        return call()
    except Exception as error:
        kind = "" if type(error) in (ValueError, LookupError) else f"{type(error).__name__}: "
        raise CaseError(f"{case.name}: {kind}{error}") from error


def _ode(case: Case) -> Ode | Sampled:
    ode: Ode | Sampled = equations_of(case.run.loop, case.name)
    _ = ode.fingerprint  # the report needs it, and here the cases make theirs side by side
    return ode


def _measured(case: Case, ode: Ode | Sampled, tell: Progress) -> Measurement:
    return measurement(case.run, ode, f"Case({case.scenario!r}, {case.law!r}, run=...)", tell)


def measurement(
    run: Run, equation: Ode | Sampled, call: str = "Run(...)", progress: Progress | None = None
) -> Measurement:
    """What a run gives: its values at the step, and their change from twice the step.

    Raises
    ------
    ValueError, LookupError
        If `measure` refuses, or twice the step does not divide the period of a sampled loop, in the name of a call.
    """
    h = None if run.h is None else run.doubled(equation, call)
    asked: dict[str, Any] = {"until": run.until, "h": h, "every": run.every, "tolerance": run.tolerance}
    return measure(equation, run.metrics, **asked, seed=run.seed, progress=progress)


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
