"""One step for all runs and the whole horizon: halved until that changes no state by more than a tolerance."""

from __future__ import annotations

from functools import partial

import numpy as np

from workbench.simulate.batch import simulate
from workbench.simulate.stepping.cells import lost
from workbench.simulate.stepping.pilot import NOTHING
from workbench.simulate.stepping.schedule import Make
from workbench.simulate.stepping.stability import longest_steps, modes_at
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array

HALVINGS = 12
STATES = 4  # of a run at which its modes are looked at


def single_step(
    make: Make,
    p: Array,
    x0: Array,
    until: float,
    tolerance: float,
    longest: float,
    *,
    halvings: int = HALVINGS,
    seed: int = 0,
    arithmetic: str | None = None,
) -> float:
    """The first of `longest`, its half, its quarter and so on in s, at which RK4 keeps a tolerance.

    The change of a state to half the step is taken at the multiples of `longest`, relative to the largest value that
    the state has in the run; then the largest of all states, and the mean over the runs. Integrals of metrics are
    states; the memory of sampled metrics is not asked. A run that diverges tells but the limit of stability, which no
    step exceeds: a step beyond it may lose a run as its half does.

    Parameters
    ----------
    make
        (method, h) -> the step of length h, or that of a sampling period with substeps of length h.
    p, x0
        (R, np) and (R, nx), the pilot runs.
    seed
        Of the noise, which is the same at all steps.

    Raises
    ------
    ValueError
        If no pilot run stays finite, or none of the steps keeps the tolerance.
    """
    march = partial(simulate, p=p, x0=x0, until=until, every=longest, seed=seed, arithmetic=arithmetic)
    rough, found = march(make("rk4", longest)), np.nan
    for halving in range(halvings):
        fine, h = march(make("rk4", longest / 2 ** (halving + 1))), longest / 2**halving
        if not fine.diverged.all():
            found = _change(fine, rough)
            if found <= tolerance and h <= _limit(fine):
                return float(h)
        rough = fine
    if np.isnan(found):
        raise lost(len(p), until, longest / 2**halvings)
    raise ValueError(
        f"`choose(tolerance={tolerance:g})` is not reached: the step {longest / 2 ** (halvings - 1):g} s still changes "
        f"a state by {found:.1e}. Where a law switches, smaller steps help little: ask for less, or name a step `h`."
    )


def _change(fine: Trajectories, rough: Trajectories) -> float:
    """The mean over the runs that last of the largest change of a state, relative to its largest value."""
    lasts, flow = ~fine.diverged, fine.step.flow.states.size
    x, other = (runs.x[lasts, :, :flow] for runs in (fine, rough))
    size = np.maximum(np.abs(x).max(axis=1, keepdims=True), NOTHING)
    with np.errstate(all="ignore"):
        off = np.abs(x - other) / size
    return float(np.nan_to_num(off, nan=np.inf).max(axis=(1, 2), initial=0.0).mean())


def _limit(runs: Trajectories) -> float:
    """The longest stable step at the start of every run, and at some states of those that last, in s."""
    step, some = runs.step, np.unique(np.linspace(0, len(runs.t) - 1, STATES).round().astype(int))
    lasts = np.flatnonzero(~runs.diverged)
    run = np.concatenate([np.arange(len(runs.p)), np.repeat(lasts, len(some))])
    at = np.concatenate([np.zeros(len(runs.p), dtype=int), np.tile(some, len(lasts))])
    modes = modes_at(step.flow, runs.t[at], runs.x[run, at, : step.flow.states.size], runs.p[run])
    return float(np.nanmin(longest_steps(modes[np.isfinite(modes).all(axis=1)], step.amplification), initial=np.inf))
