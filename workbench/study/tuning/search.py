"""The search of a tuning: whole generations on the engine, and the best of them again at half the step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.core.layout import Array
from workbench.core.numbers import Integers, numbers
from workbench.study.chunk import Chunk
from workbench.study.prepared import Prepared
from workbench.study.resume import said_of
from workbench.study.sample import Sample, sample_of
from workbench.study.sampling import Listed
from workbench.study.tuning.contract import Ready, Tuning, ready
from workbench.study.tuning.tuned import Tuned, reasons_of
from workbench.verify.evolution import Judged, evolve

# Gives the runs first to last - 1 of each sweep, one chunk a sweep.
Evaluate = Callable[[Sequence[Prepared], int, int], Sequence[Chunk]]


@dataclass(frozen=True, eq=False)
class _Generation:
    """Points (n, d) that were asked for at once, a chunk for each trial, and what they are worth."""

    points: Array
    chunks: tuple[Chunk, ...]
    worth: Judged


def here(sweeps: Sequence[Prepared], first: int, last: int) -> list[Chunk]:
    """The runs of each sweep, computed at once and kept nowhere."""
    return [one.chunk(first, last) for one in sweeps]


def tune(tuning: Tuning | Ready, evaluate: Evaluate = here) -> Tuned:
    """What the searches of a tuning find: by differential evolution, a search a seed, each with the same budget.

    A point at which a run diverges in any trial is not admissible; of two such the one whose runs last longer is
    nearer to being so. The best points of all searches are run again at h / 2, and the best there is the answer: so
    no winner is made by the step alone. The same seeds give the same bits, however many threads there are.

    Parameters
    ----------
    evaluate
        Who computes the runs; this process if not given.

    Raises
    ------
    ValueError
        If no point is admissible, none of the best is at h / 2, or the objective gives something else than a number
        for each point.
    LookupError
        If a factor varies what a loop does not have, or a metric watches what it does not put out.
    """
    made = tuning if isinstance(tuning, Ready) else ready(tuning)
    asked, past = made.tuning, list[_Generation]()

    def judge(u: Array) -> Judged:
        points = Listed(np.vstack([*(one.points for one in past), u]))
        first = len(points.given) - len(u)
        chunks = tuple(evaluate([one.at(points) for one in made.trials], first, first + len(u)))
        past.append(_Generation(u, chunks, _judged(made, made.trials, chunks)))
        return past[-1].worth

    for seed in asked.seeds:
        rng = np.random.Generator(np.random.Philox(key=seed))
        evolve(judge, len(asked.factors), asked.population, asked.generations - 1, rng)
    return _answer(made, past, evaluate)


def _answer(made: Ready, past: Sequence[_Generation], evaluate: Evaluate) -> Tuned:
    """All generations put together, and the best points of them at half the step."""
    objective = np.concatenate([-one.worth.value for one in past])
    points = Listed(np.vstack([one.points for one in past]))
    found = _samples(made, made.trials, [[one.chunks[i] for one in past] for i in range(len(made.trials))])
    samples = {name: replace(one, design=points) for name, one in found.items()}
    tuned = Tuned(made.tuning, points.given, made.trials[0].space.values(points.given), objective, samples)
    _refuse_nothing(tuned, objective, samples, f"at the step of {_steps(made.trials)}")
    best = _best(objective, made.finalists)
    halves = [one.at(Listed(points.given[best])) for one in made.halves]
    chunks = evaluate(halves, 0, len(best))
    worth = -_judged(made, halves, chunks).value
    finer = _samples(made, halves, [[one] for one in chunks])
    _refuse_nothing(
        tuned, worth, finer, f"at half the step, {_steps(halves)}, though their runs are finite at the step"
    )
    return replace(tuned, finalists=best, halved=worth, halves=finer)


def _best(objective: Array, most: int) -> Integers:
    """The places of the best points, the best first: as many as there are, and at most so many."""
    return np.argsort(objective, kind="stable")[: min(most, int(np.isfinite(objective).sum()))]


def _steps(sweeps: Sequence[Prepared]) -> str:
    return ", ".join(f"{h:g} s" for h in dict.fromkeys(one.sweep.h for one in sweeps))


def _refuse_nothing(tuned: Tuned, objective: Array, samples: Mapping[str, Sample], where: str) -> None:
    """Refuse where no point is admissible, with the reasons."""
    if np.isfinite(objective).any():
        return
    reasons = ", ".join(f"{reason} in {count:,}" for reason, count in reasons_of(objective, samples).items() if count)
    raise ValueError(
        f"`Tuning({tuned.name!r})` has no admissible point among {len(objective):,} {where} ({reasons}): move the "
        "ranges of its factors, or take a shorter step."
    )


def _samples(made: Ready, sweeps: Sequence[Prepared], chunks: Sequence[Sequence[Chunk]]) -> dict[str, Sample]:
    """The chunks of each trial as one sample, by its name."""
    found = (sample_of(said_of(one, ()), held) for one, held in zip(sweeps, chunks, strict=True))
    return dict(zip(made.names, found, strict=True))


def _judged(made: Ready, sweeps: Sequence[Prepared], chunks: Sequence[Chunk]) -> Judged:
    """What points are worth, larger being better, from their runs in each trial."""
    samples = _samples(made, sweeps, [[one] for one in chunks])
    ends = np.stack([one.diverged_at / one.t[-1] for one in samples.values()])
    missed = np.where(np.isnan(ends), 0.0, 1 - ends).sum(axis=0)
    stayed = np.flatnonzero(np.isnan(ends).all(axis=0))
    objective = np.full(len(missed), np.inf)
    if len(stayed):
        objective[stayed] = worth(made.tuning, {name: one.only(stayed) for name, one in samples.items()})
    tiny = np.finfo(float).tiny  # of a run that lasts to the end, and is not admissible all the same
    return Judged(-objective, np.where(np.isfinite(objective), 0.0, np.maximum(missed, tiny)))


def worth(tuning: Tuning, samples: Mapping[str, Sample]) -> Array:
    """The objective of points whose runs are finite in all trials, (n,); infinity for one that is not admissible.

    Raises
    ------
    ValueError
        If the objective gives something else than that.
    """
    call = f"Tuning({tuning.name!r}, objective=...)"
    drawn = next(iter(samples.values())).drawn
    given = tuning.objective(samples)
    try:
        found = numbers(given)
    except (TypeError, ValueError):
        raise ValueError(f"`{call}` must give numbers, one a point; got {given!r}.") from None
    if found.shape != (len(drawn),):
        raise ValueError(f"`{call}` must give one number a point, ({len(drawn)},); got shape {found.shape}.")
    odd = np.flatnonzero(np.isnan(found) | (found == -np.inf))
    if len(odd):
        row = zip(tuning.factors, drawn[odd[0]], strict=True)
        at = ", ".join(f"{factor.name} = {value:.6g}" for factor, value in row)
        raise ValueError(
            f"`{call}` must give a number for every point whose runs are finite, or infinity for one that is not "
            f"admissible; got {found[odd[0]]:g} at {at}."
        )
    return found
