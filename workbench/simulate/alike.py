"""Steps that are much alike, as those of one law in two scenarios, or less a part of it: one run of each, in one march.

What a run gives is what it gives alone, to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from workbench.core import Step
from workbench.simulate.batch import found, is_pair, simulate_both
from workbench.simulate.job import Alike, Job, March, Progress, differing
from workbench.simulate.kernel.merging import merged, widened
from workbench.simulate.kernel.plan import pass_of
from workbench.simulate.kernel.stages import stepped
from workbench.simulate.marches import arithmetic_of, march_of_pairs
from workbench.simulate.request import keys_of, plan_of, rows_of, told
from workbench.simulate.trajectories import Trajectories
from workbench.validation.refusals import Array
from workbench.validation.signatures import door

LARGEST = 2**28  # bytes of the states of all; what is larger runs one after the other

Pair = tuple[Step, Step]  # a step and its half
Both = tuple[Trajectories, Trajectories]


@dataclass(frozen=True)
class _Asked:
    """A pair, the job of its half, and how many times of it are kept."""

    pair: Pair
    job: Job
    kept: int
    until: float


@door
def simulate_alike(
    pairs: Sequence[Pair],
    *,
    until: Sequence[float],
    every: float,
    seed: int = 0,
    progress: Progress | None = None,
    arithmetic: str | None = None,
) -> list[Both]:
    """What `simulate_both` makes of each of several pairs, at default parameters and from default states.

    Pairs that are much alike march together; others do so one after the other.

    Parameters
    ----------
    until
        The horizon of each, in s.

    Raises
    ------
    ValueError
        If `simulate` refuses.
    """
    tell = told("simulate_alike", progress)
    if len(until) != len(pairs):
        raise ValueError(
            f"`simulate_alike(until=...)` needs a horizon for each of the {len(pairs)} pairs; got {len(until)}."
        )
    asked = []
    for pair, end in zip(pairs, until, strict=True):
        p, _ = rows_of("simulate", pair[1], None, None)
        stride, kept = plan_of(pair[1], p, end, every)
        rounding = arithmetic_of(pair[1], 1, arithmetic)
        asked.append(_Asked(pair, Job(pair[1], p, stride, *keys_of(seed, None, 1), arithmetic=rounding), kept, end))
    march = _march(asked)
    shared = _shared([one.job for one in asked]) if march else None
    if march is None or shared is None:
        return _one_by_one(asked, every, seed, tell)
    members, joint = shared
    x = _together(joint, asked, members, march, tell)
    both = []
    for i, (one, job) in enumerate(zip(asked, members, strict=True)):
        fine, coarse = x[2 * i : 2 * i + 2, np.newaxis, : one.kept + 1, job.places]
        whole = replace(job, step=one.pair[0], stride=job.stride // 2)
        both.append((found(whole, coarse, march), found(job, fine, march)))
    return both


def _one_by_one(asked: Sequence[_Asked], every: float, seed: int, tell: Progress) -> list[Both]:
    both = []
    for i, one in enumerate(asked):
        told = partial(_told, tell, i, 1, len(asked))
        rounding = one.job.arithmetic
        both.append(
            simulate_both(*one.pair, until=one.until, every=every, seed=seed, progress=told, arithmetic=rounding)
        )
    return both


def _together(joint: Job, asked: Sequence[_Asked], members: Sequence[Job], march: March, tell: Progress) -> Array:
    """The states of all pairs side by side, each until its own horizon: (2 pairs, 1 + kept, nx)."""
    kept = np.repeat([one.kept for one in asked], 2)
    x = np.zeros((len(kept), kept.max() + 1, joint.size))
    for i, (one, job) in enumerate(zip(asked, members, strict=True)):
        x[2 * i : 2 * i + 2, 0, job.places] = one.pair[1].states.default
    begin, last = 0, int(kept.max())
    for end in np.unique(kept).tolist():
        some = np.flatnonzero(kept >= end)
        job = replace(joint.part(some, joint.stride, begin * joint.stride), ahead=(last - end) * joint.stride)
        part = x[some, begin : end + 1]
        march(job, part, partial(_told, tell, begin, end - begin, last))
        x[some, begin : end + 1] = part
        begin = end
    return x


def _told(tell: Progress, done: int, part: int, whole: int, share: float) -> None:
    """The share of the whole that is done with a share of a part."""
    tell((done + part * share) / whole)


def _march(asked: Sequence[_Asked]) -> March | None:
    """What marches all of them, if they are several that can be paired and compiled."""
    steps = [one.job.step for one in asked]
    same = {
        (step.h, step.noises, step.rule.rate.numel() > 0, one.job.stride, one.job.arithmetic)
        for step, one in zip(steps, asked, strict=True)
    }
    if len(asked) < 2 or len(same) > 1:
        return None
    size = 16 * len(asked) * (1 + max(one.kept for one in asked)) * max(step.states.size for step in steps)
    if size > LARGEST or not all(is_pair(*one.pair, one.job.stride) for one in asked):
        return None
    marches = [march_of_pairs(one.job) for one in asked]
    return None if None in marches else marches[0]


def _shared(jobs: Sequence[Job]) -> tuple[list[Job], Job] | None:
    """The jobs with the graph that they share, and the job of all of them in pairs; None if they are not alike."""
    rates = [int(job.step.rule.rate.numel()) for job in jobs]
    sizes = [job.step.states.size for job in jobs]
    most, others = max(rates), max(size - n for size, n in zip(sizes, rates, strict=True))
    graphs = [widened(pass_of(job.step), n, most, others) for job, n in zip(jobs, rates, strict=True)]
    one = merged(graphs, max(job.p.shape[1] for job in jobs))
    if one is None:
        return None
    one = replace(one, graph=stepped(one.graph, most))
    places = tuple(np.r_[:n, most : most + size - n] for size, n in zip(sizes, rates, strict=True))
    p = np.stack([np.pad(job.p[0], (0, one.parameters - job.p.shape[1])) for job in jobs])
    which = np.arange(len(jobs))
    alike = Alike(one, differing(one.rows(p, which)), places, which)
    twice = np.repeat(which, 2)
    joint = replace(jobs[0], p=p, runs=np.zeros_like(which), alike=alike).part(twice, jobs[0].stride, 0)
    members = [replace(job, alike=alike._replace(which=which[i : i + 1])) for i, job in enumerate(jobs)]
    return members, replace(joint, paired=True)
