"""The search of a tuning: whole generations on the engine, and the best of them again at half the step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.study.chunk import Chunk
from workbench.study.contract import answer
from workbench.study.prepared import Prepared
from workbench.study.sample import Sample
from workbench.study.sampling import Listed
from workbench.study.tuning.contract import Tuning
from workbench.study.tuning.ready import Ready, ready
from workbench.study.tuning.tuned import Tuned, have_values, reasons_of
from workbench.validation.doors import door
from workbench.validation.words import Array, several, vector
from workbench.verify.evolution import Judged, evolve

ROUNDING = 1e-9  # relative, of an objective that sums in another order

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


@door
def tune(tuning: Tuning | Ready, evaluate: Evaluate = here) -> Tuned:
    """What the searches of a tuning find: by differential evolution, a search a seed, each with the same budget.

    A point is not admissible if a run diverges in any trial, or a metric is no number; of two such the one whose runs
    last longer is nearer to it. The best points of all searches are run again at h / 2, and the best there is the
    answer: so no winner is made by the step alone. The same seeds give the same bits, whatever the threads.

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
        trials = [one.at(points) for one in made.trials]
        chunks = _evaluated(evaluate, trials, first, first + len(u))
        runs = _samples(made, trials, [[one] for one in chunks], first)
        past.append(_Generation(u, chunks, _judged(made.tuning, runs)))
        return past[-1].worth

    for seed in asked.seeds:
        rng = np.random.Generator(np.random.Philox(key=seed))
        evolve(judge, len(asked.factors), asked.population, asked.generations - 1, rng)
    return _answer(made, past, evaluate)


def _evaluated(evaluate: Evaluate, sweeps: Sequence[Prepared], first: int, last: int) -> tuple[Chunk, ...]:
    """One chunk of each sweep."""
    call = "tune(evaluate=...)(sweeps, first, last)"
    chunks = several(call, answer(call, evaluate, sweeps, first, last), Chunk)
    if len(chunks) != len(sweeps):
        raise ValueError(f"`{call}` must give a chunk of each of the {len(sweeps)} sweeps; got {len(chunks)}.")
    return chunks


def _answer(made: Ready, past: Sequence[_Generation], evaluate: Evaluate) -> Tuned:
    """All generations put together, and the best points of them at half the step."""
    objective = np.concatenate([-one.worth.value for one in past])
    points = Listed(np.vstack([one.points for one in past]))
    trials = [one.at(points) for one in made.trials]
    samples = _samples(made, trials, [[one.chunks[i] for one in past] for i in range(len(trials))])
    _refuse_nothing(made, objective, samples, f"at the step of {_steps(made.trials)}")
    _refuse_dependent(made, samples, objective)
    best = np.argsort(objective, kind="stable")[: min(made.finalists, int(np.isfinite(objective).sum()))]
    halves = [one.at(Listed(points.given[best])) for one in made.halves]
    chunks = _evaluated(evaluate, halves, 0, len(best))
    finer = _samples(made, halves, [[one] for one in chunks])
    worth = -_judged(made.tuning, finer).value
    _refuse_nothing(made, worth, finer, f"at half the step, {_steps(halves)}, though their runs are finite at the step")
    values = made.trials[0].space.values(points.given)
    watched = zip(made.names, halves, chunks, strict=True)
    limits = {name: half.watched_limits(chunk) for name, half, chunk in watched}
    return Tuned(made.tuning, points.given, values, objective, samples, best, worth, finer, limits)


def _steps(sweeps: Sequence[Prepared]) -> str:
    return ", ".join(f"{h:g} s" for h in dict.fromkeys(one.sweep.h for one in sweeps))


def _refuse_dependent(made: Ready, samples: Mapping[str, Sample], objective: Array) -> None:
    """Refuse an objective whose value for one point depends on the others, which no search could make least."""
    together = -_judged(made.tuning, samples).value
    apart = together != objective
    apart[apart] = ~np.isclose(together[apart], objective[apart], rtol=ROUNDING, atol=0.0)
    if apart.any():
        place = int(np.argmax(apart))
        raise ValueError(
            f"`Tuning({made.tuning.name!r}, objective=...)` must judge each point by its own runs; among all "
            f"{len(objective):,} points it gives one {together[place]:.6g}, and {objective[place]:.6g} in its "
            "generation: compare it with nothing that depends on the others, such as their mean."
        )


def _refuse_nothing(made: Ready, objective: Array, samples: Mapping[str, Sample], where: str) -> None:
    """Refuse where no point is admissible, with the reasons."""
    if np.isfinite(objective).any():
        return
    reasons = ", ".join(f"{reason} in {count:,}" for reason, count in reasons_of(objective, samples).items() if count)
    raise ValueError(
        f"`Tuning({made.tuning.name!r})` has no admissible point among {len(objective):,} {where} ({reasons}): move "
        "the ranges of its factors, or take a shorter step."
    )


def _samples(
    made: Ready, sweeps: Sequence[Prepared], chunks: Sequence[Sequence[Chunk]], first: int = 0
) -> dict[str, Sample]:
    """The chunks of each trial, from a first run on, as one sample by its name."""
    found = (one.sample(held, first) for one, held in zip(sweeps, chunks, strict=True))
    return dict(zip(made.names, found, strict=True))


def _judged(tuning: Tuning, samples: Mapping[str, Sample]) -> Judged:
    """What points are worth, larger being better, from their runs by trial."""
    ends = np.stack([one.diverged_at / one.t[-1] for one in samples.values()])
    missed = np.where(np.isnan(ends), 0.0, 1 - ends).sum(axis=0)
    good = np.flatnonzero(np.all([have_values(one) for one in samples.values()], axis=0))
    objective = np.full(len(missed), np.inf)
    if len(good):
        objective[good] = _worth(tuning, {name: one.only(good) for name, one in samples.items()})
    tiny = np.finfo(float).tiny  # of a point whose runs last to the end, and that is not admissible all the same
    return Judged(-objective, np.where(np.isfinite(objective), 0.0, np.maximum(missed, tiny)))


def _worth(tuning: Tuning, samples: Mapping[str, Sample]) -> Array:
    """The objective of points with values in all trials, (n,); infinity for one that is not admissible.

    Raises
    ------
    ValueError
        If the objective gives something else than that.
    """
    call = f"Tuning({tuning.name!r}, objective=...)"
    drawn = next(iter(samples.values())).drawn
    found = vector(call, answer(call, tuning.objective, samples), len(drawn), "points")
    odd = np.flatnonzero(np.isnan(found) | (found == -np.inf))
    if len(odd):
        row = zip(tuning.factors, drawn[odd[0]], strict=True)
        at = ", ".join(f"{factor.name} = {value:.6g}" for factor, value in row)
        raise ValueError(
            f"`{call}` must give a number for every point, or infinity for one that is not "
            f"admissible; got {found[odd[0]]:g} at {at}."
        )
    return found
