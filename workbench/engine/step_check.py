"""The check of a step on its own runs: its stability from their Jacobians, its accuracy from a few of them at half."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.core.validation.signatures import check_arguments
from workbench.engine.arithmetic import CASADI, march_of
from workbench.engine.divergence import Divergence, find_divergence
from workbench.engine.job import Job
from workbench.engine.pilot_selection import pilot_runs
from workbench.engine.stability import StepLimit, beyond, limit_along, span, tightest

FEW = 4  # runs of a batch at which the check is made
POINTS = 200  # states of a run at which its Jacobian is looked at
WORK = 4e9  # operations of the runs at half the step, at most: some seconds of one processor
SLOWER = 20.0  # times the compiled march: CASADI's machine
NEGLIGIBLE = 1e-9  # a state that stays below it, in its unit, is as good as zero


@dataclass(frozen=True)
@check_arguments
class StepCheck:
    """The stability limit of a step along some of its runs, and the change of their states to half of the step."""

    limit: StepLimit  # the tightest along the runs
    change: float  # the largest of a state, relative to its largest value; NaN if no run was compared
    state: str  # the one that changes so much
    run: int  # in which it does
    runs: int  # number of runs that were looked at
    until: float  # s, up to which they were compared
    tolerance: float  # of the change
    is_chosen: bool = False  # True if the step was chosen for the tolerance

    @property
    def is_passed(self) -> bool:
        """True if the step is within its limit, and the change within the tolerance."""
        return not self.warnings

    @property
    def warnings(self) -> tuple[str, ...]:
        """The sentences, without a capital or a full stop, that say how far the runs cannot be trusted."""
        return tuple(filter(None, (beyond(self.limit), self._changes)))

    @property
    def _changes(self) -> str:
        if np.isnan(self.change) or self.change <= self.tolerance:
            return ""
        where = f" of run {self.run}" if self.runs > 1 else ""
        if np.isinf(self.change):
            return f"at half the step of {span(self.limit.h)} the divergence{where} comes, goes or moves"
        return f"at half the step of {span(self.limit.h)} '{self.state}'{where} changes by {percent(self.change)}"

    def __str__(self) -> str:
        limit, how = self.limit, f" chosen for a tolerance of {self.tolerance:g}" if self.is_chosen else ""
        stable = f"{'within' if limit.holds else 'BEYOND'} its stability limit of {span(limit.limit)}"
        stable = "no mode decays" if np.isinf(limit.limit) else stable
        by = f"half of it changes '{self.state}' by {percent(self.change)} of its largest value"
        change = "it was not compared with half of it" if np.isnan(self.change) else by
        along = f"along {self.runs} run{'' if self.runs == 1 else 's'} up to {self.until:g} s"
        return f"step of {span(limit.h)}{how}: {stable}; {change}, {along}."


def check_step(job: Job, t: Array, x: Array, divergence: Divergence, tolerance: float, is_chosen: bool) -> StepCheck:
    """The check of the step of a job on its runs x (B, N, nx) at times t (N,), up to four of them."""
    few = np.sort(pilot_runs(job.p, x[:, 0], FEW))
    limit = tightest([limit_along(job.step, t, x[i], job.p[i], POINTS) for i in few])
    change, state, run, end = np.nan, "", int(few[0]), t[-1]
    again = _at_half(job, x, few)
    if again is not None:
        fine, lost = again
        rows = fine.shape[1]
        end = t[rows - 1]
        for i, own in zip(few, range(len(few)), strict=True):
            found, place = _change(x[i, :rows], fine[own], divergence.at[i], lost.at[own], end, tolerance)
            if np.isnan(change) or found > change:
                change, state, run = found, job.step.states.labels[place], int(i)
    return StepCheck(limit, float(change), state, run, len(few), float(end), tolerance, is_chosen)


def _at_half(job: Job, x: Array, few: Integers) -> tuple[Array, Divergence] | None:
    """The states of a few runs (R, rows, n) at half the step, and their divergence; None if the step has no half.

    Where that is too much work they are run over the first part of the horizon.
    """
    half = job.step.half_step
    if half is None or x.shape[1] < 2:
        return None
    n, twice = half.states.size, round(job.step.h / half.h)
    half_job = replace(job.part(few, job.stride * twice, job.begin * twice), step=half)
    if twice == 1:  # written out: a new program, which is not worth a compiler
        half_job = replace(half_job, arithmetic=CASADI)
    slower = SLOWER if half_job.arithmetic == CASADI else 1.0
    work = slower * len(few) * half_job.stride * half.operations
    rows = int(np.clip(WORK / work, 1, x.shape[1] - 1))
    fine = np.empty((len(few), rows + 1, n))
    fine[:, 0] = x[few, 0, :n]
    march = march_of(half_job)
    march(half_job, fine, lambda share: None)
    return fine, find_divergence(half_job, fine, march)


def _change(x: Array, fine: Array, at: float, fine_at: float, end: float, tolerance: float) -> tuple[float, int]:
    """The largest change of a state of one run, and its place; infinite if the divergence comes, goes or moves.

    Of a run that diverges at both steps no states are compared, as they grow beyond all bounds.
    """
    lost = [time <= end for time in (at, fine_at)]
    if any(lost):
        same = all(lost) and abs(at - fine_at) <= tolerance * end
        return (np.nan if same else np.inf), 0
    size = np.maximum(np.abs(fine).max(axis=0), NEGLIGIBLE)
    with np.errstate(all="ignore"):
        off = (np.abs(x[:, : fine.shape[1]] - fine) / size).max(axis=0, initial=0.0)
    place = int(np.argmax(off))
    return float(off[place]), place


def percent(share: float) -> str:
    """A share in per cent, or that it is beyond all comparison."""
    return f"{100 * share:.2g} %" if share < 10 else "more than 1,000 %"
