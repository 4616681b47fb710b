"""The search, within stated bounds, for the run with the worst metric, or for one that breaks a claim."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from workbench.core import Ode
from workbench.core.claim import Declared
from workbench.core.validation.refusals import Array, known, multiple, seconds, whole
from workbench.core.validation.refusals import seed as key
from workbench.core.validation.signatures import door
from workbench.engine import simulate
from workbench.engine.metrics import AbstractMetric, measured
from workbench.engine.metrics.accumulators import final_values
from workbench.proofs.claim_margins import UNDEFINED, Box, Largest, slope_of, violation, watching
from workbench.proofs.counterexample import CounterExample, Pair, Replay, run
from workbench.proofs.differential_evolution import Judged, evolve

Kind = Literal["refuted", "not refuted", "not checkable"]
ROWS = 20  # of states kept, so that of a run that diverges little is lost
ENOUGH, DECIMALS = 0.95, 16  # of the worst value that shorter numbers keep; decimals that a double has
HALVINGS = 16  # of the step along a gradient, all tried at once


@dataclass(frozen=True)
@door
class Budget:
    """The members of a generation, the generations that follow the first, and the gradients that follow the best."""

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
class Found:
    """The outcome of a search: a verdict, and the worst run, None where it is not checkable for the reason `why`.

    So many `runs` were tried, so many of them `kept` the hypotheses, and so many `diverged`.
    """

    kind: Kind
    worst: CounterExample | None
    runs: int
    kept: int
    diverged: int
    why: str = ""


def verdict_of(worst: Pair, target: AbstractMetric | Declared) -> tuple[Kind, str]:
    """The verdict from the worst run of a search, and the reason if the step is too long for it to be checkable.

    A claim is `refuted` by a run that breaks it by more than its error of the step, and keeps the hypotheses by more
    than theirs. All else, and any metric, is `not refuted`.
    """
    is_claim = isinstance(target, Declared)
    if np.isnan(worst.value) or (is_claim and worst.value > 0 and worst.doubt):
        return "not checkable", worst.doubt or "the worst run is no number"
    return ("refuted" if is_claim and worst.refutes else "not refuted"), ""


@dataclass(frozen=True, eq=False)
@door
class Hunt:
    """A search of the runs of `ode` within `ranges` for the worst of a metric, or of the violation of a claim.

    The ranges are (low, high) per name of a parameter or of an initial state; horizon and step of each run are in s.
    A run must keep the hypotheses at every step to count; those of the target with a margin join them.
    """

    ode: Ode
    target: AbstractMetric | Declared
    ranges: Mapping[str, tuple[object, object]]
    until: float
    h: float
    hypotheses: tuple[Declared, ...] = ()

    def __post_init__(self) -> None:
        multiple(
            "Hunt(until=...)", seconds("Hunt(until=...)", self.until), seconds("Hunt(h=...)", self.h), "the step h"
        )

    @cached_property
    def box(self) -> Box:
        """The box of the numbers that the search may choose."""
        return Box.of(self.ode, self.ranges)

    @cached_property
    def kept(self) -> tuple[Declared, ...]:
        """The hypotheses that a run can break."""
        target = self.target
        own = target.claim.hypotheses if isinstance(target, Declared) else ()
        path = target.path if isinstance(target, Declared) else ""
        return (*self.hypotheses, *(Declared(claim, path) for claim in own if claim.margin is not None))

    @cached_property
    def watched(self) -> Ode:
        """The equation with a violation for each claim in question."""
        own = (self.target,) if isinstance(self.target, Declared) else ()
        return watching(self.ode, (*own, *self.kept))

    @property
    def metric(self) -> AbstractMetric:
        """The metric that is maximised."""
        return violation(self.target.claim) if isinstance(self.target, Declared) else self.target

    @door
    def search(self, seed: int, budget: Budget | None = None) -> Found:
        """A population search, and gradients from its best run where there are any; the same seed, the same run.

        A claim in question without a margin, or a target whose margin is no number somewhere, is a ValueError.
        """
        seed, budget = key("Hunt.search(seed=...)", seed), budget or Budget()
        seen: list[Judged] = []

        def judge(u: Array) -> Judged:
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

    def _judge(self, u: Array) -> Judged:
        p, x0 = self.box.rows(self.box.at(u))
        step = measured(self.watched, (self.metric, *self._violations), self.h)
        every = self.h * max(1, round(self.until / self.h) // ROWS)
        every = every if abs(self.until / every - round(self.until / every)) < 1e-9 else self.until
        start = np.hstack([x0, np.tile(step.states.default[x0.shape[1] :], (len(x0), 1))])
        runs = simulate(step, p, start, until=self.until, every=every)
        value = final_values(runs, (self.metric,))[self.metric.name].max(axis=1)
        value = np.where(runs.diverged, np.inf, np.where(np.isnan(value), -np.inf, value))
        finite = np.isfinite(runs.x).all(axis=2).sum(axis=1) - 1  # the last row before a run is lost
        last = step.states.unpack(runs.x[np.arange(len(p)), finite])
        excess = [last[f"{kept.name}.largest"].max(axis=1) for kept in self._violations]
        if isinstance(self.target, Declared) and (value[np.isfinite(value)] >= UNDEFINED).any():
            name = self.target.claim.name
            raise ValueError(
                f"`Hunt(target=...)` must have a margin; that of '{name}' is none at some instant of a run."
            )
        return Judged(value, np.max(excess, axis=0) if excess else np.zeros(len(p)))

    @door
    def at(self, numbers: Mapping[str, object]) -> Pair:
        """The run with these parameters and initial states by name, all others at their defaults, and half its step."""
        at = Box.of(self.ode, {name: (value, value) for name, value in numbers.items()})
        return self._run(*at.rows(at.low[np.newaxis]))

    @door
    def shortened(self, found: Found) -> Found:
        """The same outcome with as few decimals in the worst run's numbers as keep the verdict and most of it."""
        if found.worst is None:
            return found
        sought = found.worst.sought
        theta = np.array([sought[known(label, sought, "numbers of the worst run")] for label in self.box.labels])
        for decimals in range(1, DECIMALS):
            cut = np.clip(np.trunc(theta * 10**decimals) / 10**decimals + 0.0, self.box.low, self.box.high)
            pair = self.at(dict(zip(self.box.labels, cut.tolist(), strict=True)))
            holds = pair.refutes if found.kind == "refuted" else pair.excess <= 0
            if holds and pair.value >= found.worst.value - (1 - ENOUGH) * abs(found.worst.value):
                return replace(found, worst=self._example(cut, pair, found.worst.seed))
        return found

    @door
    def replay(self, example: CounterExample) -> Replay:
        """Run a counter-example of this hunt again."""
        rows = example.rows(self.ode)
        return example.compared(run(self.watched, self.metric, self._violations, *rows, example.until, example.h))

    @property
    def _violations(self) -> tuple[Largest, ...]:
        return tuple(violation(kept.claim) for kept in self.kept)

    def _climbed(self, judge: Callable[[Array], Judged], u: Array, value: float) -> tuple[Array, float]:
        slope = slope_of(self.watched, self.metric, self.box, u, self.until, self.h)
        if slope is None or not np.isfinite(slope).all() or not slope.any():
            return u, value
        lengths = 0.5 ** np.arange(HALVINGS)
        trials = np.clip(u + lengths[:, np.newaxis] * slope / np.abs(slope).max(), 0, 1)
        worth = judge(trials)
        place = worth.best()
        return (trials[place], float(worth.value[place])) if worth.excess[place] <= 0 else (u, value)

    def _run(self, p: Array, x0: Array) -> Pair:
        return run(self.watched, self.metric, self._violations, p, x0, self.until, self.h)

    def _example(self, theta: Array, pair: Pair, seed: int) -> CounterExample:
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


def _found(kind: Kind, worst: CounterExample | None, seen: list[Judged], why: str = "") -> Found:
    runs = sum(len(judged.value) for judged in seen)
    kept = sum(int((judged.excess <= 0).sum()) for judged in seen)
    return Found(kind, worst, runs, kept, sum(int((judged.value == np.inf).sum()) for judged in seen), why)
