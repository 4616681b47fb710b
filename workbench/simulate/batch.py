"""B runs of a `Step`, each with its own parameters and initial state."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from workbench.core import Step
from workbench.simulate.divergence import find_divergence
from workbench.simulate.job import Job, March, Progress
from workbench.simulate.marches import arithmetic_of, march_of, march_of_pairs
from workbench.simulate.request import keys_of, plan_of, rows_of, told
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door


@door
def simulate(
    step: Step,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float | None = None,
    seed: int = 0,
    runs: Integers | None = None,
    progress: Progress | None = None,
    arithmetic: str | None = None,
    engine: str | None = None,
) -> Trajectories:
    """Run B copies of `step` from time 0 to `until`, each with its own parameters and initial state.

    What a run gives depends on its own rows of p and x0, its key in `runs`, the seed and the arithmetic alone: not on
    its neighbours, its place, the number of threads or the width of this processor's vectors.

    Parameters
    ----------
    p, x0
        (B, np) and (B, nx), as `pack` of their layouts makes them; one row serves all. An array of more than 64 MB
        is not copied: leave it as it is while the trajectories are in use.
    until, every
        The horizon and the distance of the kept times, in s: multiples of the step. With `every=until` only the end
        is kept, and memory does not grow with the horizon.
    seed, runs
        The keys of the noise: a whole number, and (B,) that name the runs, 0, 1, 2, ... if not given.
    arithmetic, engine
        "fused" and "portable" have the same bits in the engine "native", compiled for this processor, as in "numpy",
        many times slower; "casadi" is an engine with an arithmetic of its own. Without names it is what runs the step
        fastest, "native" up to 30,000 operations; `Trajectories.arithmetic` says which arithmetic that was.

    Raises
    ------
    ValueError
        If `step` is none, a number is out of its bounds, a shape is wrong, a time is no multiple of the step, the runs
        would take too much memory or time, or what is named cannot run the step. A run that diverges is only marked.

    Examples
    --------
    >>> step = wb.rk4(wb.open_loop(wb.DCMotor()), 1e-3)
    >>> p = step.parameters.pack({"v": np.array([1.0, 2.0, 3.0])})
    >>> runs = wb.simulate(step, p, until=5.0)
    >>> runs, runs["omega"].shape, runs["omega"][:, -1].round(3)
    (<3 runs of 'plant' at 5001 times to 5 s>, (3, 5001), array([0.1, 0.2, 0.3]))
    """
    tell = told("simulate", progress)
    p_rows, x_rows = rows_of("simulate", step, p, x0, least=1 if runs is None else max(1, runs.size))
    stride, kept = plan_of(step, p_rows, until, every)
    rounding = arithmetic_of(step, len(p_rows), arithmetic, engine)
    job = Job(step, p_rows, stride, *keys_of(seed, runs, len(p_rows)), arithmetic=rounding)
    march = march_of(job, engine)
    x = np.empty((len(x_rows), kept + 1, step.states.size))
    x[:, 0] = x_rows
    march(job, x, tell)
    return found(job, x, march)


@door
def simulate_both(
    whole: Step,
    half: Step,
    p: Array | None = None,
    x0: Array | None = None,
    *,
    until: float,
    every: float,
    seed: int = 0,
    progress: Progress | None = None,
    arithmetic: str | None = None,
) -> tuple[Trajectories, Trajectories]:
    """What `simulate` makes of a step and of its half; of few runs in one march, which takes as long as the half alone.

    Parameters
    ----------
    whole, half
        The same rule with lengths of h and h / 2.

    Raises
    ------
    ValueError
        If `simulate` refuses.
    """
    tell = told("simulate_both", progress)
    p_rows, x_rows = rows_of("simulate", half, p, x0)
    stride, kept = plan_of(half, p_rows, until, every)
    rounding = arithmetic_of(half, len(p_rows), arithmetic)
    job = Job(half, p_rows, stride, *keys_of(seed, None, len(p_rows)), arithmetic=rounding)
    march = march_of_pairs(job) if is_pair(whole, half, stride) else None
    if march is None:
        # the longer run first: from it the engine sees how good its code should be
        call = partial(simulate, p=p, x0=x0, until=until, every=every, seed=seed, arithmetic=rounding)
        fine = call(half, progress=lambda done: tell(2 * done / 3))
        return call(whole, progress=lambda done: tell((2 + done) / 3)), fine
    x = np.empty((2 * len(x_rows), kept + 1, half.states.size))
    x[:, 0] = np.repeat(x_rows, 2, axis=0)
    pairs = replace(job, p=np.repeat(p_rows, 2, axis=0), runs=np.repeat(job.runs, 2), paired=True)
    march(pairs, x, tell)
    return found(replace(job, step=whole, stride=stride // 2), x[1::2], march), found(job, x[::2], march)


def is_pair(whole: Step, half: Step, stride: int) -> bool:
    """Whether a kernel can go through both steps side by side, with states kept every `stride` half steps."""
    return whole.rule is half.rule and whole.h == 2 * half.h and stride % 2 == 0


def found(job: Job, x: Array, march: March) -> Trajectories:
    """The runs that a march has left in x (B, 1 + kept, nx), with those marked that diverged."""
    divergence = find_divergence(job, x, march)
    return Trajectories(job, np.asarray(np.arange(x.shape[1]) * job.stride * job.step.h), x, divergence)
