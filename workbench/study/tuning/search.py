"""The search of a tuning: whole generations on the engine, and the best of them looked at at half the step too."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from workbench.core.equations import answer
from workbench.core.validation.refusals import Array, Integers, vector
from workbench.core.validation.signatures import answer as asked
from workbench.core.validation.signatures import check_arguments
from workbench.core.validation.type_hints import fit_of
from workbench.engine.distributions import AbstractDistribution
from workbench.proofs.differential_evolution import Flags, TrialValues, evolve
from workbench.study.compiled_sweep import CompiledSweep, compile_sweep
from workbench.study.ledger.chunk import Chunk
from workbench.study.run_and_sweep import Sweep
from workbench.study.sample import Sample
from workbench.study.tuning.convergence import SearchCourse, have_values, reasons_of
from workbench.study.tuning.tuning import Trial, Tuning
from workbench.study.tuning.tuning_result import TuningResult
from workbench.study.uncertainty.designs import ListedPoints

FINALISTS = 8  # points of a search that are looked at: one vector of the widest processors
BISECTIONS = 60  # of the unit interval, to its last bit
ROUNDING = 1e-9  # relative, of an objective that sums in another order

CHUNKS = fit_of(tuple[Chunk, ...])

# Gives the runs first to last - 1 of each sweep, one chunk a sweep.
Evaluate = Callable[[Sequence[CompiledSweep], int, int], Sequence[Chunk]]


@dataclass(frozen=True, eq=False)
class TuningSearch:
    """A tuning with the sweeps of its trials: of all points, and of the best of them, which are looked at."""

    tuning: Tuning
    trials: tuple[CompiledSweep, ...]
    finals: tuple[CompiledSweep, ...]
    noises: int  # a training noise for each seed, or one alone where no trial has any noise

    @property
    def sweeps(self) -> tuple[CompiledSweep, ...]:
        """All its sweeps."""
        return (*self.trials, *self.finals)

    @property
    def start(self) -> tuple[Array, Array]:
        """The ends of the box in the unit cube from which the first population is drawn."""
        starts, low, high = self.tuning.starts, np.zeros(len(self.tuning.factors)), np.ones(len(self.tuning.factors))
        for i, factor in enumerate(self.tuning.factors):
            if factor.name in starts:
                low[i], high[i] = (_place(factor.distribution, end) for end in starts[factor.name])
        return low, high

    def under(self, sweeps: Sequence[CompiledSweep], noise: int) -> list[CompiledSweep]:
        """Sweeps of all trials under a training noise, counted from 0."""
        trials = self.tuning.trials
        return [one.under(self.tuning.noise(t, noise)) for one, t in zip(sweeps, trials, strict=True)]


def compile_tuning(tuning: Tuning, arithmetic_of: Callable[[str], str | None] = lambda name: None) -> TuningSearch:
    """The search of a tuning, in arithmetics by the names of its sweeps."""
    trials = tuple(_compiled(tuning, trial, arithmetic_of) for trial in tuning.trials)
    noises = len(tuning.seeds) if any(one.run.step.noises for one in trials) else 1
    finalists = min(FINALISTS, tuning.evaluations) * len(tuning.seeds) * noises
    return TuningSearch(
        tuning, trials, tuple(one.looked_at(f"{one.sweep.name}_half", finalists) for one in trials), noises
    )


def _compiled(tuning: Tuning, trial: Trial, arithmetic_of: Callable[[str], str | None]) -> CompiledSweep:
    """A trial as a sweep over its pilots, of which the search asks for other points as it goes on."""
    try:
        sweep = Sweep(
            name=f"{tuning.name}_{trial.name}",
            run=trial.run,
            factors=tuning.factors,
            design=ListedPoints(_pilots(len(tuning.factors))),
            common=True,
            half_step_every=None,
            runs_of_chunk=tuning.population,
        )
        return replace(compile_sweep(sweep, arithmetic_of(sweep.name)), size=tuning.size)
    except (LookupError, ValueError) as error:
        if type(error) not in (LookupError, ValueError):
            raise
        raise type(error)(f"`Tuning({tuning.name!r})` in the trial '{trial.name}': {error}") from error


def _pilots(dimensions: int) -> Array:
    """The middle of the unit cube with one coordinate at either end, (2 d, d)."""
    ends = np.full((2 * dimensions, dimensions), 0.5)
    np.fill_diagonal(ends[0::2], 0.0)
    np.fill_diagonal(ends[1::2], 1.0)
    return ends


def _place(distribution: AbstractDistribution, value: float) -> float:
    """The place of a value of a range in the unit cube: the inverse of the quantile, by bisection."""
    low, high = 0.0, 1.0
    if value in (distribution.low, distribution.high):
        return low if value == distribution.low else high
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        below = float(distribution.quantile(np.array([middle]))[0]) < value
        low, high = (middle, high) if below else (low, middle)
    return high


@dataclass(frozen=True, eq=False)
class _Generation:
    """Points (n, d) that were evaluated together, a chunk for each trial, and their worth."""

    points: Array
    chunks: tuple[Chunk, ...]
    worth: TrialValues


def here(sweeps: Sequence[CompiledSweep], first: int, last: int) -> list[Chunk]:
    """The runs of each sweep, computed at once and kept nowhere."""
    return [one.chunk(first, last) for one in sweeps]


@check_arguments
def tune(tuning: Tuning | TuningSearch, evaluate: Evaluate = here) -> TuningResult:
    """Search the best parameters by differential evolution: one search per seed, each with the same budget.

    A point is not admissible if a run diverges in any trial, or a metric is not a number; of two such points, the one
    whose runs last longer is preferred. Each search has its own training noise. The best points of each search are run
    under the noises of all searches, at h and h / 2. The answer is the point with the least mean at h among those that
    are admissible at both. The same seeds give the same result, bit for bit. `evaluate` is the function that computes
    the runs.

    Raises
    ------
    ValueError
        If no point is admissible, none of the best points is at h / 2, or the objective gives something else than a
        number for each point.
    LookupError
        If a factor varies a number that a loop does not have, or a metric watches an output that it does not have.
    """
    search = tuning if isinstance(tuning, TuningSearch) else compile_tuning(tuning)
    past: list[_Generation] = []
    used = tuple(_run(search, k, past, evaluate) for k in range(len(search.tuning.seeds)))
    return _answer(search, past, used, evaluate)


def _run(search: TuningSearch, number: int, past: list[_Generation], evaluate: Evaluate) -> int:
    """The number of points that one search evaluates; its generations are added to those of earlier searches."""
    asked, begun = search.tuning, len(past)
    sweeps = search.under(search.trials, number % search.noises)

    def judge(u: Array) -> TrialValues:
        points = ListedPoints(np.vstack([*(one.points for one in past), u]))
        first = len(points.listed_points) - len(u)
        trials = [one.at(points) for one in sweeps]
        chunks = _evaluated(evaluate, trials, first, first + len(u))
        runs = _samples(search, trials, [[one] for one in chunks], first)
        past.append(_Generation(u, chunks, _judged(search.tuning, runs)))
        return past[-1].worth

    def should_stop() -> bool:
        best = np.minimum.accumulate([-one.worth.value.max() for one in past[begun:]])
        return SearchCourse(asked, number, best).has_ended

    rng = np.random.Generator(np.random.Philox(key=asked.seeds[number]))
    # from the best member alone: on the loops of a6 and a8 twice as near after half of the evaluations
    evolve(
        judge,
        len(asked.factors),
        asked.population,
        asked.generations - 1,
        rng,
        search.start,
        should_stop,
        mix_strategies=False,
    )
    return asked.population * (len(past) - begun)


def _evaluated(evaluate: Evaluate, sweeps: Sequence[CompiledSweep], first: int, last: int) -> tuple[Chunk, ...]:
    """A chunk of each sweep; the errors of an `evaluate` of the workbench's own pass."""
    call, must = "tune(evaluate=...)", f"give a chunk for each of {len(sweeps)} sweeps"
    if str(getattr(evaluate, "__module__", "")).startswith("workbench."):
        return tuple(evaluate(sweeps, first, last))
    chunks: tuple[Chunk, ...] = asked(call, must, lambda: evaluate(sweeps, first, last), CHUNKS, refuses=True)
    if len(chunks) != len(sweeps):
        raise ValueError(f"`{call}` must {must}; it gave {len(chunks)}.")
    return chunks


def _answer(
    search: TuningSearch, past: Sequence[_Generation], used: tuple[int, ...], evaluate: Evaluate
) -> TuningResult:
    """The answer of a tuning: all generations, and the best points at half the step under all training noises."""
    objective = np.concatenate([-one.worth.value for one in past])
    points = ListedPoints(np.vstack([one.points for one in past]))
    trials = [one.at(points) for one in search.trials]
    samples = _samples(search, trials, [[one.chunks[i] for one in past] for i in range(len(trials))])
    found = np.isfinite(objective)
    _refuse_nothing(search, found, objective, samples, f"at the step of {_steps(search.trials)}")
    _refuse_dependent(search, samples, objective)
    best = _best(objective, used)
    again = ListedPoints(np.tile(points.listed_points[best], (search.noises, 1)))
    looked_at = [one.at(again) for one in search.finals]
    ends = [(k * len(best), (k + 1) * len(best)) for k in range(search.noises)]
    chunks = [_evaluated(evaluate, search.under(looked_at, k), *ends[k]) for k in range(search.noises)]
    by_trial = list(zip(*chunks, strict=True))
    runs, halves = (_samples(search, looked_at, by_trial, at_half=at_half) for at_half in (False, True))
    finals, halved = (-_judged(search.tuning, held).value.reshape(search.noises, -1).T for held in (runs, halves))
    found = np.isfinite(halved.mean(axis=1) + finals.mean(axis=1))
    where = f"at half the step, {_steps(looked_at, 2)}, though their runs are finite at the step"
    _refuse_nothing(search, found, halved.T.ravel(), halves, where)
    values = search.trials[0].space.values(points.listed_points)
    return TuningResult(
        search.tuning, used, points.listed_points, values, objective, samples, best, finals, halved, runs
    )


def _best(objective: Array, used: Sequence[int]) -> Integers:
    """The places of the best admissible points of each search, the best of each first."""
    ends = np.cumsum(used)
    each = [first + np.argsort(objective[first:last], kind="stable") for first, last in pairwise([0, *ends])]
    return np.concatenate([places[np.isfinite(objective[places])][:FINALISTS] for places in each])


def _steps(sweeps: Sequence[CompiledSweep], parts: int = 1) -> str:
    return ", ".join(f"{h / parts:g} s" for h in dict.fromkeys(one.h for one in sweeps))


def _refuse_dependent(search: TuningSearch, samples: Mapping[str, Sample], objective: Array) -> None:
    """Refuse an objective whose value for one point depends on the other points."""
    together = -_judged(search.tuning, samples).value
    apart = together != objective
    apart[apart] = ~np.isclose(together[apart], objective[apart], rtol=ROUNDING, atol=0.0)
    if apart.any():
        place = int(np.argmax(apart))
        raise ValueError(
            f"`Tuning({search.tuning.name!r}, objective=...)` must judge each point by its own runs; among all "
            f"{len(objective):,} points it gives one {together[place]:.6g}, and {objective[place]:.6g} in its "
            "generation: compare it with nothing that depends on the others, such as their mean."
        )


def _refuse_nothing(
    search: TuningSearch, found: Flags, objective: Array, samples: Mapping[str, Sample], where: str
) -> None:
    if found.any():
        return
    reasons = ", ".join(f"{reason} in {count:,}" for reason, count in reasons_of(objective, samples).items() if count)
    raise ValueError(
        f"`Tuning({search.tuning.name!r})` has no admissible point among {len(found):,} {where} ({reasons}): move "
        "the ranges of its factors, or take a shorter step."
    )


def _samples(
    search: TuningSearch,
    sweeps: Sequence[CompiledSweep],
    chunks: Sequence[Sequence[Chunk]],
    first: int = 0,
    at_half: bool = False,
) -> dict[str, Sample]:
    """The chunks of each trial, from a first run on, as one sample by its name."""
    found = (one.sample(held, first, at_half) for one, held in zip(sweeps, chunks, strict=True))
    return dict(zip((trial.name for trial in search.tuning.trials), found, strict=True))


def _judged(tuning: Tuning, samples: Mapping[str, Sample]) -> TrialValues:
    """The worth of points, larger being better, from their runs by trial."""
    ends = np.stack([one.diverged_at / one.t[-1] for one in samples.values()])
    missed = np.where(np.isnan(ends), 0.0, 1 - ends).sum(axis=0)
    good = np.flatnonzero(np.all([have_values(one) for one in samples.values()], axis=0))
    objective = np.full(len(missed), np.inf)
    if len(good):
        objective[good] = _worth(tuning, {name: one.only(good) for name, one in samples.items()})
    tiny = np.finfo(float).tiny  # of a point whose runs last to the end, and that is not admissible all the same
    return TrialValues(-objective, np.where(np.isfinite(objective), 0.0, np.maximum(missed, tiny)))


def _worth(tuning: Tuning, samples: Mapping[str, Sample]) -> Array:
    """The objective of points with values in all trials, (n,); infinity for one that is not admissible."""
    call = f"Tuning({tuning.name!r}, objective=...)"
    drawn = next(iter(samples.values())).factor_values
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
