"""The search, within stated bounds, for the run with the worst metric, or for one that breaks a claim."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from workbench.core import Ode
from workbench.core.claim import BlockClaim
from workbench.core.validation.refusals import Array, known_name, multiple, seconds, whole
from workbench.core.validation.refusals import seed as key
from workbench.core.validation.signatures import check_arguments
from workbench.engine import simulate
from workbench.engine.metrics import AbstractMetric, step_with_metrics
from workbench.engine.metrics.accumulators import final_values
from workbench.proofs.claim_margins import UNDEFINED_MARGIN, Box, Largest, slope_of, violation, with_violations
from workbench.proofs.counterexample import CounterExample, CounterExampleReplay, StepPair, run
from workbench.proofs.differential_evolution import TrialValues, evolve

Kind = Literal["refuted", "not refuted", "not checkable"]
ROWS = 20  # of states kept, so that of a run that diverges little is lost
ENOUGH, DECIMALS = 0.95, 16  # of the worst value that shorter numbers keep; decimals that a double has
HALVINGS = 16  # of the step along a gradient, all tried at once


@dataclass(frozen=True)
@check_arguments
class Budget:
    """The effort of a search: runs per generation, generations after the first, and gradient climbs at the end."""

    population: int = 64
    generations: int = 20
    climbs: int = 4

    def __post_init__(self) -> None:
        whole(
            "Budget(population=...)", self.population, 4, of=" of members, three of which make a trial for another one"
        )
        whole("Budget(generations=...)", self.generations, 0)
        whole("Budget(climbs=...)", self.climbs, 0)


@dataclass(frozen=True, eq=False)
class SearchResult:
    """The outcome of a search: its verdict `kind`, and the `worst` run, or None with the reason `why`.

    `runs` is the number of runs that were tried; `admissible_runs` of them keep the hypotheses, and `diverged_runs`
    diverge.
    """

    kind: Kind
    worst: CounterExample | None
    runs: int
    admissible_runs: int
    diverged_runs: int
    why: str = ""


def verdict_of(worst: StepPair, target: AbstractMetric | BlockClaim) -> tuple[Kind, str]:
    """The verdict from the worst run of a search, and the reason if the step is too long for it to be checkable.

    A claim is `refuted` by a run that breaks it by more than its error of the step, and keeps the hypotheses by more
    than theirs. All else, and any metric, is `not refuted`.
    """
    is_claim = isinstance(target, BlockClaim)
    if np.isnan(worst.value) or (is_claim and worst.value > 0 and worst.doubt):
        return "not checkable", worst.doubt or "the worst run is no number"
    return ("refuted" if is_claim and worst.refutes else "not refuted"), ""


@dataclass(frozen=True, eq=False)
@check_arguments
class RunSearch:
    """A search of the runs of `ode` within `ranges` for the worst of a metric, or of the violation of a claim.

    `ranges` are (low, high) by the name of a parameter or an initial state; horizon and step of each run are in s. A
    run counts only if it keeps the `hypotheses` at every step. The hypotheses of the target that have a margin are
    added.
    """

    ode: Ode
    target: AbstractMetric | BlockClaim
    ranges: Mapping[str, tuple[object, object]]
    until: float
    h: float
    hypotheses: tuple[BlockClaim, ...] = ()

    def __post_init__(self) -> None:
        multiple(
            "RunSearch(until=...)",
            seconds("RunSearch(until=...)", self.until),
            seconds("RunSearch(h=...)", self.h),
            "the step h",
        )

    @cached_property
    def box(self) -> Box:
        """The box of the numbers that the search may choose."""
        return Box.of(self.ode, self.ranges)

    @cached_property
    def all_hypotheses(self) -> tuple[BlockClaim, ...]:
        """The hypotheses that a run can break."""
        target = self.target
        own = target.claim.hypotheses if isinstance(target, BlockClaim) else ()
        path = target.path if isinstance(target, BlockClaim) else ""
        return (*self.hypotheses, *(BlockClaim(claim, path) for claim in own if claim.margin is not None))

    @cached_property
    def violation_equation(self) -> Ode:
        """The equation with a violation for each claim in question."""
        own = (self.target,) if isinstance(self.target, BlockClaim) else ()
        return with_violations(self.ode, (*own, *self.all_hypotheses))

    @property
    def metric(self) -> AbstractMetric:
        """The metric that is maximised."""
        return violation(self.target.claim) if isinstance(self.target, BlockClaim) else self.target

    @check_arguments
    def search(self, seed: int, budget: Budget | None = None) -> SearchResult:
        """Searches by a population, then by gradients from the best run where they exist; reproducible by `seed`.

        It raises a ValueError if the claim has no margin, or if the margin is not a number at some run.
        """
        seed, budget = key("RunSearch.search(seed=...)", seed), budget or Budget()
        seen: list[TrialValues] = []

        def judge(u: Array) -> TrialValues:
            seen.append(self._judge(u))
            return seen[-1]

        rng = np.random.default_rng(seed)
        u, worth = evolve(judge, len(self.box.labels), budget.population, budget.generations, rng)
        place = worth.best()
        best, value = u[place], worth.value[place]
        if worth.excess[place] > 0 or value == -np.inf:
            return _found("not checkable", None, seen, "no run kept the hypotheses")
        for _ in range(budget.climbs if np.isfinite(value) else 0):
            better, higher = self._climbed(judge, best, value)
            if higher <= value:
                break
            best, value = better, higher
        theta = self.box.at(best[np.newaxis])
        pair = self._run(*self.box.rows(theta))
        kind, why = verdict_of(pair, self.target)
        return _found(kind, None if why else self._example(theta[0], pair, seed), seen, why)

    def _judge(self, u: Array) -> TrialValues:
        p, x0 = self.box.rows(self.box.at(u))
        step = step_with_metrics(self.violation_equation, (self.metric, *self._violations), self.h)
        every = self.h * max(1, round(self.until / self.h) // ROWS)
        every = every if abs(self.until / every - round(self.until / every)) < 1e-9 else self.until
        start = np.hstack([x0, np.tile(step.states.default[x0.shape[1] :], (len(x0), 1))])
        runs = simulate(step, p, start, until=self.until, every=every)
        value = final_values(runs, (self.metric,))[self.metric.name].max(axis=1)
        value = np.where(runs.has_diverged, np.inf, np.where(np.isnan(value), -np.inf, value))
        finite = np.isfinite(runs.x).all(axis=2).sum(axis=1) - 1  # the last row before a run is lost
        last = step.states.unpack(runs.x[np.arange(len(p)), finite])
        excess = [last[f"{kept.name}.largest"].max(axis=1) for kept in self._violations]
        if isinstance(self.target, BlockClaim) and (value[np.isfinite(value)] >= UNDEFINED_MARGIN).any():
            name = self.target.claim.name
            raise ValueError(
                f"`RunSearch(target=...)` must have a margin; that of '{name}' is none at some instant of a run."
            )
        return TrialValues(value, np.max(excess, axis=0) if excess else np.zeros(len(p)))

    @check_arguments
    def at(self, numbers: Mapping[str, object]) -> StepPair:
        """The run with these parameters and initial states by name, others at their defaults, at h and at h / 2."""
        at = Box.of(self.ode, {name: (value, value) for name, value in numbers.items()})
        return self._run(*at.rows(at.low[np.newaxis]))

    @check_arguments
    def shorten(self, result: SearchResult) -> SearchResult:
        """The result with as few decimals in the worst run's numbers as keep the verdict and most of the value."""
        if result.worst is None:
            return result
        sought = result.worst.sought
        theta = np.array([sought[known_name(label, sought, "numbers of the worst run")] for label in self.box.labels])
        for decimals in range(1, DECIMALS):
            cut = np.clip(np.trunc(theta * 10**decimals) / 10**decimals + 0.0, self.box.low, self.box.high)
            pair = self.at(dict(zip(self.box.labels, cut.tolist(), strict=True)))
            holds = pair.refutes if result.kind == "refuted" else pair.excess <= 0
            if holds and pair.value >= result.worst.value - (1 - ENOUGH) * abs(result.worst.value):
                return replace(result, worst=self._example(cut, pair, result.worst.seed))
        return result

    @check_arguments
    def replay(self, example: CounterExample) -> CounterExampleReplay:
        """Run a counter-example of this search again."""
        rows = example.rows(self.ode)
        return example.compare(
            run(self.violation_equation, self.metric, self._violations, *rows, example.until, example.h)
        )

    @property
    def _violations(self) -> tuple[Largest, ...]:
        return tuple(violation(kept.claim) for kept in self.all_hypotheses)

    def _climbed(self, judge: Callable[[Array], TrialValues], u: Array, value: float) -> tuple[Array, float]:
        slope = slope_of(self.violation_equation, self.metric, self.box, u, self.until, self.h)
        if slope is None or not np.isfinite(slope).all() or not slope.any():
            return u, value
        lengths = 0.5 ** np.arange(HALVINGS)
        trials = np.clip(u + lengths[:, np.newaxis] * slope / np.abs(slope).max(), 0, 1)
        worth = judge(trials)
        place = worth.best()
        return (trials[place], float(worth.value[place])) if worth.excess[place] <= 0 else (u, value)

    def _run(self, p: Array, x0: Array) -> StepPair:
        return run(self.violation_equation, self.metric, self._violations, p, x0, self.until, self.h)

    def _example(self, theta: Array, pair: StepPair, seed: int) -> CounterExample:
        p, x0 = self.box.rows(theta[np.newaxis])
        return CounterExample(
            self.metric.name,
            self.ode.fingerprint,
            dict(zip(self.box.labels, theta.tolist(), strict=True)),
            dict(zip(self.ode.parameters.labels, p[0].tolist(), strict=True)),
            dict(zip(self.ode.states.labels, x0[0].tolist(), strict=True)),
            self.until,
            self.h,
            seed,
            pair.value,
            pair.error,
        )


def _found(kind: Kind, worst: CounterExample | None, seen: list[TrialValues], why: str = "") -> SearchResult:
    runs = sum(len(judged.value) for judged in seen)
    kept = sum(int((judged.excess <= 0).sum()) for judged in seen)
    return SearchResult(kind, worst, runs, kept, sum(int((judged.value == np.inf).sum()) for judged in seen), why)
