"""Steps that are much alike, as those of one law less a part of it at a time: one run of each, in one march.

What a run gives is what it gives alone, to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from workbench.core import Step
from workbench.simulate.batch import found, is_pair, simulate_both
from workbench.simulate.job import Alike, Job, March, Progress, differing
from workbench.simulate.kernel.merging import merged
from workbench.simulate.kernel.plan import pass_of
from workbench.simulate.kernel.stages import stepped
from workbench.simulate.marches import march_of_pairs
from workbench.simulate.request import keys_of, plan_of, rows_of
from workbench.simulate.trajectories import Trajectories

Pair = tuple[Step, Step]  # a step and its half
Both = tuple[Trajectories, Trajectories]


def simulate_alike(
    pairs: Sequence[Pair], *, until: float, every: float, progress: Progress | None = None
) -> list[Both]:
    """What `simulate_both` makes of each of several pairs, at default parameters and from default states.

    Pairs that are much alike march together; others do so one after the other.

    Raises
    ------
    ValueError
        If `simulate` refuses.
    """
    tell = progress or (lambda share: None)
    sizes = [(half.h, half.states.size, half.rule.rate.numel(), half.noises) for _, half in pairs]
    runs: dict[int, Both] = {}
    for size in dict.fromkeys(sizes):
        group = [i for i, other in enumerate(sizes) if other == size]
        told = partial(_told, tell, len(runs), len(group), len(pairs))
        runs |= zip(group, _of_one_size([pairs[i] for i in group], until, every, told), strict=True)
    return [runs[i] for i in range(len(pairs))]


def _told(tell: Progress, done: int, part: int, whole: int, share: float) -> None:
    """The share of the whole that is done with a share of a part."""
    tell((done + part * share) / whole)


def _of_one_size(pairs: Sequence[Pair], until: float, every: float, tell: Progress) -> list[Both]:
    """The runs of pairs of one length and with equally many states."""
    jobs, kept = [], 0
    for _, half in pairs:
        p, _ = rows_of("simulate", half, None, None)
        stride, kept = plan_of(half, p, until, every)
        jobs.append(Job(half, p, stride, *keys_of(0, None, 1)))
    march = _march(pairs, jobs)
    shared = _shared(jobs) if march else None
    if march is None or shared is None:
        tells = [partial(_told, tell, i, 1, len(pairs)) for i in range(len(pairs))]
        return [
            simulate_both(*pair, until=until, every=every, progress=told)
            for pair, told in zip(pairs, tells, strict=True)
        ]
    members, joint = shared
    x = np.empty((2 * len(jobs), kept + 1, joint.step.states.size))
    x[:, 0] = np.repeat([half.states.default for _, half in pairs], 2, axis=0)
    march(joint, x, tell)
    return [
        (found(replace(job, step=whole, stride=job.stride // 2), coarse, march), found(job, fine, march))
        for (whole, _), job, fine, coarse in zip(pairs, members, x[::2, np.newaxis], x[1::2, np.newaxis], strict=True)
    ]


def _march(pairs: Sequence[Pair], jobs: Sequence[Job]) -> March | None:
    """What marches all of them, if they are several that can be paired and compiled."""
    if len(pairs) < 2 or not all(is_pair(*pair, job.stride) for pair, job in zip(pairs, jobs, strict=True)):
        return None
    marches = [march_of_pairs(job) for job in jobs]
    return None if None in marches else marches[0]


def _shared(jobs: Sequence[Job]) -> tuple[list[Job], Job] | None:
    """The jobs with the graph that they share, and the job of all of them in pairs; None if they are not alike."""
    most = max(job.p.shape[1] for job in jobs)
    one = merged([pass_of(job.step) for job in jobs], most)
    if one is None:
        return None
    one = replace(one, graph=stepped(one.graph, int(jobs[0].step.rule.rate.numel())))
    p = np.stack([np.pad(job.p[0], (0, most - job.p.shape[1])) for job in jobs])
    which = np.arange(len(jobs))
    alike = Alike(one, differing(one.rows(p, which)), which)
    twice = np.repeat(which, 2)
    joint = replace(jobs[0], p=p, runs=np.zeros_like(which), alike=alike).part(twice, jobs[0].stride, 0)
    members = [replace(job, alike=alike._replace(which=which[i : i + 1])) for i, job in enumerate(jobs)]
    return members, replace(joint, paired=True)
