"""When a run diverged, as CasADi's machine finds it from the last finite kept state, whatever engine lost the run."""

from __future__ import annotations

from typing import Any

import numpy as np

from workbench.core import Step
from workbench.core.layout import Array
from workbench.simulate import virtual_machine

Places = np.ndarray[Any, np.dtype[np.intp]]


def second_opinion(step: Step, x: Array, p: Array, stride: int) -> None:
    """Let CasADi finish the runs in x (B, N, nx) that another engine lost, where it stays finite itself."""
    lost, last = _lost(x)
    stays = _steps_left(step, x[lost, last], p[lost], np.asarray(last * stride), stride) > stride
    for run, begin in zip(lost[stays], last[stays], strict=True):
        virtual_machine.march(step, x[run : run + 1, begin:], p[run : run + 1], stride, first=begin * stride)


def find_divergence(step: Step, x: Array, p: Array, stride: int) -> Array:
    """The time of the first step that is not finite in each run (B,), else NaN; its later rows in x become NaN."""
    at = np.full(len(x), np.nan)
    lost, last = _lost(x)
    steps = _steps_left(step, x[lost, last], p[lost], np.asarray(last * stride), stride)
    at[lost] = (last * stride + np.minimum(steps, stride)) * step.h
    for run, begin in zip(lost, last, strict=True):
        x[run, begin + 1 :] = np.nan
    return at


def _lost(x: Array) -> tuple[Places, Places]:
    """The runs that are not finite throughout, and for each the last kept time before that."""
    finite = np.asarray(np.isfinite(x).all(axis=2))
    lost = np.flatnonzero(~finite.all(axis=1))
    return lost, np.asarray(np.argmin(finite[lost], axis=1) - 1)


def _steps_left(step: Step, x: Array, p: Array, k: Places, stride: int) -> Array:
    """After how many steps from x (n, nx) at k (n,) each run is not finite; stride + 1 if it is, for a stride."""
    steps = np.full(len(x), stride + 1)
    done = 0
    while done < stride and (steps > stride).any():
        size = min(stride - done, max(1, virtual_machine.STEPS_PER_CALL // len(x)))
        part = np.empty((len(x), size + 1, x.shape[1]))
        part[:, 0] = x
        virtual_machine.march(step, part, p, 1, first=np.asarray(k + done, dtype=float))
        bad = np.asarray(~np.isfinite(part).all(axis=2))
        new = bad.any(axis=1) & (steps > stride)
        steps[new] = done + np.argmax(bad[new], axis=1)
        x, done = part[:, -1], done + size
    return steps
