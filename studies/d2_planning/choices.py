"""The choice of the numbers of each law: as many candidates for each law, judged on the same training runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import workbench as wb
from studies.d2_planning.designs import BY_KEY, LOAD, MOST_KNOBS, TUNED, Law, laws_of
from studies.d2_planning.machine import Cost, cost_on_machine
from studies.d2_planning.predictive import LEVEL, DesignRecord, design_record
from studies.d2_planning.problems import PROBLEMS, Knobs, Problem, observer_of
from studies.d2_planning.runs import cost_of, factors_of, is_lost, loop_of, metrics_of, terms_of

CANDIDATES = 40
TRAINING, SEED = 32, 3700  # runs for each candidate, with noise of their own


@dataclass(frozen=True)
class Item:
    """A law of a problem, and the level of the limits at which it is tuned."""

    problem: str
    law: str
    level: float = 1.0


@dataclass(frozen=True)
class Choice:
    """The candidates of a law, the number of training runs that each loses, and the mean cost of the others.

    `cost` is that of the best on a microcontroller, of a law that is tuned at the usual limits. `design` has
    the numbers that the design of a predictive law derives for the best.
    """

    shares: wb.Array  # (N, 5), of the ranges of the knobs
    losses: wb.Array  # (N,)
    costs: wb.Array  # (N,), NaN where each run is lost
    cost: Cost | None = None
    design: DesignRecord | None = None

    @property
    def best(self) -> int:
        """The candidate that loses the fewest runs, and among these the one of least mean cost."""
        costs = np.where(np.isnan(self.costs), np.inf, self.costs)
        return int(np.lexsort((costs, self.losses))[0])


def items() -> tuple[Item, ...]:
    """All laws, tuned at the usual limits, and at the tightest."""
    return tuple(
        Item(problem.key, law.key, level)
        for problem in PROBLEMS.values()
        for level in (1.0, problem.levels[0])
        for law in laws_of(problem)
    )


def candidates() -> wb.Array:
    """The candidates as shares of the ranges of knobs, the same for all laws."""
    return wb.uncertainty.LatinHypercube(MOST_KNOBS, CANDIDATES, SEED).points()


def choose(item: Item) -> Choice:
    """The candidates of a law on the training runs, and what follows for the best."""
    problem = PROBLEMS[item.problem].with_limits(item.level)
    shares, law = candidates(), TUNED[item.law]
    choice = Choice(shares, *judge_candidates(problem, training_terms(problem, law, [law.choice(s) for s in shares])))
    best, judged = knobs_of(law, choice), BY_KEY[item.law]
    own = None
    if judged is not law:
        best |= {LEVEL: item.level}
        means = [alone(problem, one, best) for one in (judged, law)]
        own = design_record(problem, best, *means)
    cost = cost_on_machine(loop_of(problem, judged, best), problem.substeps) if item.level == 1.0 else None
    return replace(choice, cost=cost, design=own)


def alone(problem: Problem, law: Law, knobs: Knobs) -> float:
    """The mean cost of a law in the training runs, each law with the same noise; NaN if it loses one."""
    lost, (mean,) = judge_candidates(problem, training_terms(problem, law, [knobs]))
    return float("nan") if lost.any() else float(mean)


def training_terms(problem: Problem, law: Law, knobs: Sequence[Knobs]) -> wb.Array:
    """The terms of the cost in the training runs of each of some knobs, (N, runs, 3)."""
    blocks = [law.block(problem, one) for one in knobs]
    observers = [observer_of(problem, one[LOAD.name]) for one in knobs]
    ode = loop_of(problem, law, knobs[0]).ode()
    factors = factors_of(problem, loop_of(problem, law, knobs[0]))
    space = wb.uncertainty.Space(factors, ode.parameters, ode.states)
    p, x0 = space.rows(wb.uncertainty.MonteCarlo(len(factors), TRAINING, SEED + 1).points())
    every, starts = [], []
    for block, observer in zip(blocks, observers, strict=True):
        own, start = p.copy(), x0.copy()
        own[:, ode.parameters.indices("observer.L")] = np.asarray(observer.L).ravel(order="F")
        for field in law.fields:
            put(ode, own, start, field, block)
        every.append(own)
        starts.append(start)
    measurement = wb.measure(
        ode,
        metrics_of(problem),
        np.vstack(every),
        np.vstack(starts),
        until=problem.horizon,
        h=problem.period / problem.substeps,
        every=problem.horizon,
        seed=SEED,
    )
    return terms_of(problem, measurement).reshape(len(knobs), TRAINING, 3)


def judge_candidates(problem: Problem, terms: wb.Array) -> tuple[wb.Array, wb.Array]:
    """The number of lost runs of each candidate, and the mean cost of the others."""
    lost = np.array([is_lost(problem, one).sum() for one in terms], dtype=float)
    kept = [cost_of(problem, one) for one in terms]
    costs = [float(np.nanmean(one)) if np.isfinite(one).any() else np.nan for one in kept]
    return lost, np.array(costs)


def put(ode: wb.core.SampledSystem, p: wb.Array, x0: wb.Array, field: str, block: wb.Controller) -> None:
    """Put a number of a law into rows of parameters, or of first states."""
    value: object = block
    for part in field.split("."):
        value = getattr(value, part)
    path = f"controller.{field}"
    flat = np.asarray(value, dtype=float).ravel(order="F")
    if path in ode.parameters.names:
        p[:, ode.parameters.indices(path)] = flat
    else:
        x0[:, ode.states.indices(path)] = flat


def knobs_of(law: Law, choice: Choice, place: int | None = None) -> Knobs:
    """The knobs of the best candidate, or of another one."""
    return law.choice(choice.shares[choice.best if place is None else place])
