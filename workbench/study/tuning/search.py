"""The search of a tuning: whole generations on the engine, and the best of them again at half the step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from workbench.claims.evolution import Flags, Judged, evolve
from workbench.study.contract import answer
from workbench.study.ledger.chunk import Chunk
from workbench.study.prepared import Prepared
from workbench.study.sample import Sample
from workbench.study.tuning.contract import Tuning
from workbench.study.tuning.course import Course, have_values, reasons_of
from workbench.study.tuning.ready import FINALISTS, Ready, ready
from workbench.study.tuning.tuned import Tuned
from workbench.study.uncertainty.designs import Listed
from workbench.validation.doors import door
from workbench.validation.words import Array, Integers, several, vector

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
    last longer is nearer to it. Each search has its own training noise. The best points of each are run again at h / 2
    under the noises of all searches, and the answer is that of the least mean: so no winner is made by the step or by
    one noise alone. The same seeds give the same bits, whatever the threads.

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
    past: list[_Generation] = []
    used = tuple(_searched(made, k, past, evaluate) for k in range(len(made.tuning.seeds)))
    return _answer(made, past, used, evaluate)


def _searched(made: Ready, search: int, past: list[_Generation], evaluate: Evaluate) -> int:
    """How many points a search looks at, whose generations are added to those of the searches before it."""
    asked, begun = made.tuning, len(past)
    sweeps = made.under(made.trials, search % made.noises)

    def judge(u: Array) -> Judged:
        points = Listed(np.vstack([*(one.points for one in past), u]))
        first = len(points.given) - len(u)
        trials = [one.at(points) for one in sweeps]
        chunks = _evaluated(evaluate, trials, first, first + len(u))
        runs = _samples(made, trials, [[one] for one in chunks], first)
        past.append(_Generation(u, chunks, _judged(made.tuning, runs)))
        return past[-1].worth

    def ended() -> bool:
        best = np.minimum.accumulate([-one.worth.value.max() for one in past[begun:]])
        return Course(asked, search, best).ended

    rng = np.random.Generator(np.random.Philox(key=asked.seeds[search]))
    # from the best member alone: on the loops of a6 and a8 twice as near after half of the evaluations
    evolve(judge, len(asked.factors), asked.population, asked.generations - 1, rng, made.start, ended, mixed=False)
    return asked.population * (len(past) - begun)


def _evaluated(evaluate: Evaluate, sweeps: Sequence[Prepared], first: int, last: int) -> tuple[Chunk, ...]:
    """One chunk of each sweep."""
    call = "tune(evaluate=...)(sweeps, first, last)"
    chunks = several(call, answer(call, evaluate, sweeps, first, last), Chunk)
    if len(chunks) != len(sweeps):
        raise ValueError(f"`{call}` must give a chunk of each of the {len(sweeps)} sweeps; got {len(chunks)}.")
    return chunks


def _answer(made: Ready, past: Sequence[_Generation], used: tuple[int, ...], evaluate: Evaluate) -> Tuned:
    """All generations put together, and the best points of each search at half the step, under all training noises."""
    objective = np.concatenate([-one.worth.value for one in past])
    points = Listed(np.vstack([one.points for one in past]))
    trials = [one.at(points) for one in made.trials]
    samples = _samples(made, trials, [[one.chunks[i] for one in past] for i in range(len(trials))])
    found = np.isfinite(objective)
    _refuse_nothing(made, found, objective, samples, f"at the step of {_steps(made.trials)}")
    _refuse_dependent(made, samples, objective)
    best = _best(objective, used)
    again = Listed(np.tile(points.given[best], (made.noises, 1)))
    halves = [one.at(again) for one in made.halves]
    ends = [(k * len(best), (k + 1) * len(best)) for k in range(made.noises)]
    chunks = [_evaluated(evaluate, made.under(halves, k), *ends[k]) for k in range(made.noises)]
    by_trial = list(zip(*chunks, strict=True))
    finer = _samples(made, halves, by_trial)
    worth = -_judged(made.tuning, finer).value.reshape(made.noises, -1).T
    found = np.isfinite(worth.mean(axis=1))
    where = f"at half the step, {_steps(halves)}, though their runs are finite at the step"
    _refuse_nothing(made, found, worth.T.ravel(), finer, where)
    values = made.trials[0].space.values(points.given)
    watched = zip(made.names, halves, by_trial, strict=True)
    limits = {name: np.min([half.watched_limits(chunk) for chunk in held], axis=0) for name, half, held in watched}
    return Tuned(made.tuning, used, points.given, values, objective, samples, best, worth, finer, limits)


def _best(objective: Array, used: Sequence[int]) -> Integers:
    """The places of the best admissible points of each search, the best of each first."""
    ends = np.cumsum(used)
    each = [first + np.argsort(objective[first:last], kind="stable") for first, last in pairwise([0, *ends])]
    return np.concatenate([places[np.isfinite(objective[places])][:FINALISTS] for places in each])


def _steps(sweeps: Sequence[Prepared]) -> str:
    return ", ".join(f"{h:g} s" for h in dict.fromkeys(one.h for one in sweeps))


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


def _refuse_nothing(made: Ready, found: Flags, objective: Array, samples: Mapping[str, Sample], where: str) -> None:
    """Refuse where no point is admissible, with the reasons by which runs are not."""
    if found.any():
        return
    reasons = ", ".join(f"{reason} in {count:,}" for reason, count in reasons_of(objective, samples).items() if count)
    raise ValueError(
        f"`Tuning({made.tuning.name!r})` has no admissible point among {len(found):,} {where} ({reasons}): move "
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
