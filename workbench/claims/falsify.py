"""Search, within stated bounds, for the worst run of an equation: the worst metric, or the one that breaks a claim."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from workbench.claims.ascent import slope_of
from workbench.claims.counterexample import CounterExample, Pair, Replay, run
from workbench.claims.evolution import Judged, evolve
from workbench.claims.margins import UNDEFINED, Largest, violation, watching
from workbench.core import Ode, Step
from workbench.core.claim import Declared
from workbench.metrics import AbstractMetric, measured
from workbench.metrics.accumulators import final_values
from workbench.proofs.box import Box
from workbench.simulate import simulate
from workbench.validation.refusals import Array, known, multiple, seconds, whole
from workbench.validation.refusals import seed as key
from workbench.validation.signatures import door

Kind = Literal["refuted", "not refuted", "not checkable"]
ROWS = 20  # of states kept, so that of a run that diverges little is lost
ENOUGH, DECIMALS = 0.95, 16  # of the worst value that shorter numbers keep; decimals that a double has
HALVINGS = 16  # of the step along a gradient, all tried at once


@dataclass(frozen=True)
@door
class Budget:
    """How many members a generation has, how many generations follow the first, and how many gradients the best."""

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
    """What a search came to.

    Attributes
    ----------
    kind
        Of the claim: `refuted` if the worst run breaks it by more than its error of the step and keeps the hypotheses
        at half the step too; `not checkable` if no run kept them, or the step is too long for the worst one: its
        divergence is not confirmed, or its error is a large share of the violation. Of a metric, which cannot be
        refuted: `not refuted`.
    worst
        The worst run; None where it is not checkable.
    runs, kept, diverged
        How many were tried, how many of them kept the hypotheses, and how many diverged.
    why
        What makes it not checkable; empty elsewhere.
    """

    kind: Kind
    worst: CounterExample | None
    runs: int
    kept: int
    diverged: int
    why: str = ""


@dataclass(frozen=True, eq=False)
@door
class Hunt:
    """The worst of a metric, or of the violation of a claim, is sought over the runs of `ode` within `ranges`.

    Attributes
    ----------
    target
        A metric, whose largest component counts, or a claim with a margin.
    ranges
        (low, high) per name of a parameter or of an initial state.
    until, h
        Horizon and step of each run, in s.
    hypotheses
        Claims with margins that a run must keep at every step to count; those of the target join them.
    """

    ode: Ode
    target: AbstractMetric | Declared
    ranges: Mapping[str, tuple[Any, Any]]
    until: float
    h: float
    hypotheses: tuple[Declared, ...] = ()

    def __post_init__(self) -> None:
        multiple(
            "Hunt(until=...)", seconds("Hunt(until=...)", self.until), seconds("Hunt(h=...)", self.h), "the step h"
        )

    @cached_property
    def box(self) -> Box:
        """Where it looks."""
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
        """What is to be as large as possible."""
        return violation(self.target.claim) if isinstance(self.target, Declared) else self.target

    @door
    def search(self, seed: int, budget: Budget | None = None) -> Found:
        """A population search, and gradients from its best run where there are any; the same seed, the same run.

        Raises
        ------
        ValueError
            If the box, the horizon or the step is none, a claim in question has no margin, or that of the target is
            not a number somewhere.
        LookupError
            If a name is not one of the equation's.
        """
        seed, budget = key("Hunt.search(seed=...)", seed), budget or Budget()
        seen: list[Judged] = []

        def judge(u: Array) -> Judged:
            seen.append(self.judge(u))
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
        pair = self._run(best)
        broken = isinstance(self.target, Declared) and pair.value - pair.error > 0 and pair.excess <= 0
        if np.isnan(pair.value) or (isinstance(self.target, Declared) and pair.value > 0 and pair.doubt):
            return _found("not checkable", None, seen, pair.doubt or "the worst run is no number")
        theta = self.box.at(best[np.newaxis])[0]
        return _found("refuted" if broken else "not refuted", self._example(theta, pair, seed), seen)

    @door
    def judge(self, u: Array) -> Judged:
        """What the runs at points u (B, d) of the unit cube are worth."""
        p, x0 = self.box.rows(self.box.at(u))
        step = self._step
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
            raise ValueError(
                f"`Hunt(target=...)` needs a margin that is a number wherever a run may be; that of "
                f"'{self.target.claim.name}' is none at some instant of some run."
            )
        return Judged(value, np.max(excess, axis=0) if excess else np.zeros(len(p)))

    @door
    def at(self, numbers: Mapping[str, Any]) -> Pair:
        """The run with these parameters and initial states by name, all others at their defaults, and half its step.

        Raises
        ------
        LookupError
            If a name is neither a parameter's nor a state's.
        ValueError
            If a number is out of bounds, or is one of several runs.
        """
        at = Box.of(self.ode, {name: (value, value) for name, value in numbers.items()})
        return run(self.watched, self.metric, self._violations, *at.rows(at.low[np.newaxis]), self.until, self.h)

    @door
    def shortened(self, found: Found) -> Found:
        """The same outcome with the fewest decimals in the worst run's numbers that keep verdict and `ENOUGH` of it.

        Raises
        ------
        LookupError
            If the worst run is one of another search.
        """
        if found.worst is None:
            return found
        sought = found.worst.sought
        theta = np.array([sought[known(label, sought, "numbers of the worst run")] for label in self.box.labels])
        for decimals in range(1, DECIMALS):
            cut = np.clip(np.trunc(theta * 10**decimals) / 10**decimals + 0.0, self.box.low, self.box.high)
            pair = self.at(dict(zip(self.box.labels, cut.tolist(), strict=True)))
            holds = pair.excess <= 0 and not (found.kind == "refuted" and (pair.doubt or pair.value <= pair.error))
            if holds and pair.value >= found.worst.value - (1 - ENOUGH) * abs(found.worst.value):
                return replace(found, worst=self._example(cut, pair, found.worst.seed))
        return found

    @door
    def replay(self, example: CounterExample) -> Replay:
        """Run a counter-example of this hunt again."""
        return example.replay(self.ode, self.metric, self._violations, self.watched)

    @cached_property
    def _step(self) -> Step:
        """The step with the metric and all hypotheses accumulated."""
        return measured(self.watched, (self.metric, *self._violations), self.h)

    @property
    def _violations(self) -> tuple[Largest, ...]:
        """The metrics of the hypotheses."""
        return tuple(violation(kept.claim) for kept in self.kept)

    def _climbed(self, judge: Callable[[Array], Judged], u: Array, value: float) -> tuple[Array, float]:
        """The best of some points along the gradient from u (d,), or u itself; each is judged as any other."""
        slope = slope_of(self.watched, self.metric, self.box, u, self.until, self.h)
        if slope is None or not np.isfinite(slope).all() or not slope.any():
            return u, value
        lengths = 0.5 ** np.arange(HALVINGS)
        trials = np.clip(u + lengths[:, np.newaxis] * slope / np.abs(slope).max(), 0, 1)
        worth = judge(trials)
        place = worth.best()
        return (trials[place], float(worth.value[place])) if worth.excess[place] <= 0 else (u, value)

    def _run(self, u: Array) -> Pair:
        """The run at a point u (d,) of the unit cube, at its step and at half of it."""
        rows = self.box.rows(self.box.at(u[np.newaxis]))
        return run(self.watched, self.metric, self._violations, *rows, self.until, self.h)

    def _example(self, theta: Array, pair: Pair, seed: int) -> CounterExample:
        """The run with the sought numbers theta (d,), as plain numbers."""
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
