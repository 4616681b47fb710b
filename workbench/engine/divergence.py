"""Divergence of a run: the first step whose state is not finite, found by marching again with more states kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.validation.refusals import Array, Integers
from workbench.engine.job import NUMBERS_OF_A_STAGE, Job, March

ROWS = 64  # of states kept in one look: ten thousand steps take three looks


@dataclass(frozen=True, eq=False)
class Divergence:
    """The time in s at which each run diverged, (B,), and the first state not finite then; NaN and -1 for none."""

    at: Array
    state: Integers


@dataclass(frozen=True, eq=False)
class Loss:
    """The step of a run that turns a finite state into one that is not: the state after it."""

    run: int
    step: int
    after: Array


def find_divergence(job: Job, x: Array, march: March) -> Divergence:
    """The divergence of the runs in x (B, 1 + kept, nx), which `march` filled; their later rows become NaN.

    A state that is finite again at the next kept time counts as finite.
    """
    found = Divergence(np.full(len(x), np.nan), np.full(len(x), -1))
    for loss in _losses(job, x, march):
        found.at[loss.run] = (job.begin + loss.step) * job.step.h
        found.state[loss.run] = np.argmin(np.isfinite(loss.after))
        x[loss.run, -(-loss.step // job.stride) :] = np.nan
    return found


def _losses(job: Job, x: Array, march: March) -> Iterator[Loss]:
    if np.isfinite(x).all():
        return
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
            yield from (Loss(int(i), int(row), x[i, row].copy()) for i in few)
        elif left > 0:
            for loss in _search(job.part(few, 1, job.begin + begin), x[few, row - 1], left, march):
                yield replace(loss, run=int(few[loss.run]), step=begin + loss.step)
