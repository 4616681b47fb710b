"""Where a run diverged: the first step whose state is not finite, found by marching again with more states kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.numbers import Array, Integers
from workbench.simulate.job import NUMBERS_OF_A_STAGE, Job, March
from workbench.simulate.kernel import virtual_machine

ROWS = 64  # of states kept in one look: ten thousand steps take three looks


@dataclass(frozen=True, eq=False)
class Divergence:
    """When each run diverged, (B,) in s, and the first state that was not finite then, (B,); NaN and -1 for none."""

    at: Array
    state: Integers


@dataclass(frozen=True, eq=False)
class Loss:
    """The step of a run that turns a finite state into one that is not."""

    run: int
    step: int
    before: Array
    after: Array


def find_divergence(job: Job, x: Array, march: March) -> Divergence:
    """The divergence of the runs in x (B, 1 + kept, nx), which `march` filled; their later rows become NaN.

    CasADi's machine judges the steps at which another march lost a run, and finishes the run if it stays
    finite itself. A state that is finite again at the next kept time counts as finite.
    """
    found = Divergence(np.full(len(x), np.nan), np.full(len(x), -1))
    losses = list(_losses(job, x, march))
    saved = set() if march is virtual_machine.march else _saved(job, losses)
    for loss in losses:
        i = slice(loss.run, loss.run + 1)
        if loss.run in saved:
            _finish(job, x[i], loss)
            later = find_divergence(job.part(np.array([loss.run]), job.stride, job.begin), x[i], virtual_machine.march)
            found.at[i], found.state[i] = later.at, later.state
        else:
            found.at[i] = (job.begin + loss.step) * job.step.h
            found.state[i] = np.argmin(np.isfinite(loss.after))
            x[i, -(-loss.step // job.stride) :] = np.nan
    return found


def _losses(job: Job, x: Array, march: March) -> Iterator[Loss]:
    """What happened to each run in x that is not finite throughout."""
    finite = np.asarray(np.isfinite(x).all(axis=2))
    lost = np.flatnonzero(~finite.all(axis=1))
    last = np.argmin(finite[lost], axis=1) - 1
    most = max(1, NUMBERS_OF_A_STAGE // (ROWS * x.shape[2]))
    for row in np.unique(last):
        runs = lost[last == row]
        for few in np.split(runs, range(most, len(runs), most)):
            begin = int(row) * job.stride
            for loss in _search(job.part(few, 1, job.begin + begin), x[few, row], job.stride, march):
                yield replace(loss, run=int(few[loss.run]), step=begin + loss.step)


def _search(job: Job, state: Array, span: int, march: March) -> Iterator[Loss]:
    """The loss of each run of a job, which is finite in `state` (B, nx) and not `span` steps later."""
    stride = -(-span // ROWS)
    rows = span // stride  # and a shorter one at the end, if need be
    x = np.empty((len(state), rows + 1, state.shape[1]))
    x[:, 0] = state
    march(replace(job, stride=stride), x, lambda share: None)
    bad = np.argmin(np.isfinite(x).all(axis=2), axis=1)
    bad[bad == 0] = rows + 1  # behind the last row
    for row in np.unique(bad):
        few, begin = np.flatnonzero(bad == row), int(row - 1) * stride
        left = min(stride, span - begin)
        if stride == 1 and row <= rows:
            yield from (Loss(int(i), int(row), x[i, row - 1].copy(), x[i, row].copy()) for i in few)
        elif left > 0:
            for loss in _search(job.part(few, 1, job.begin + begin), x[few, row - 1], left, march):
                yield replace(loss, run=int(few[loss.run]), step=begin + loss.step)


def _saved(job: Job, losses: list[Loss]) -> set[int]:
    """The runs that CasADi brings over the step at which they were lost."""
    found: set[int] = set()
    by_step: dict[int, list[Loss]] = {}
    for loss in losses:
        by_step.setdefault(loss.step, []).append(loss)
    for step, same in by_step.items():
        runs = np.array([loss.run for loss in same])
        x = np.stack([np.stack([loss.before, loss.before]) for loss in same])
        virtual_machine.march(job.part(runs, 1, job.begin + step - 1), x, lambda share: None)
        found.update(int(run) for run in runs[np.isfinite(x[:, 1]).all(axis=1)])
    return found


def _finish(job: Job, x: Array, loss: Loss) -> None:
    """Let CasADi fill the rows of a run in x (1, 1 + kept, nx) from the state before its loss on."""
    begin, run = loss.step - 1, np.array([loss.run])
    row = begin // job.stride + 1
    two = np.stack([loss.before, loss.before])[np.newaxis]
    virtual_machine.march(job.part(run, row * job.stride - begin, job.begin + begin), two, lambda share: None)
    x[0, row] = two[0, 1]
    if row + 1 < x.shape[1]:
        rest = job.part(run, job.stride, job.begin + row * job.stride)
        virtual_machine.march(rest, x[:, row:], lambda share: None)
