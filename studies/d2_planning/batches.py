"""The runs on which the laws are judged: drawn plants, starts, targets and noise, at several limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import workbench as wb
from studies.d2_planning.choices import Item, items, knobs_of
from studies.d2_planning.designs import CONVERGED, Law, laws_of
from studies.d2_planning.predictive import LEVEL
from studies.d2_planning.problems import PROBLEMS, Knobs, Problem
from studies.d2_planning.runs import factors_of, loop_of, metrics_of

DRAWS, SEED = 128, 3710
AGAIN, DELAYED = "again", "late"  # tuned at the tightest limit; with a delay of a period that no law knows
MORE = "more"  # sweeps of the predictive law


def sweep_name(problem: Problem, law: Law, kind: str = "") -> str:
    """The name of a sweep."""
    return "_".join(part for part in (problem.key, law.key, kind) if part)


def level_factor(problem: Problem, loop: wb.DigitalLoop) -> wb.Factor:
    """The level of the limits as a factor, where instruments and law have them."""
    moving = ("low", "high") if min(problem.low) < 0 else ("high",)
    bounds = range(1 if len(problem.plant.inputs.names) == 1 else 2)
    paths = [f"instruments.bounds[{i}].{end}" for i in bounds for end in moving]
    if hasattr(loop.loop.controller, "target"):
        paths += [f"controller.target.{end}" for end in moving]
    return wb.Factor("level", tuple(paths), wb.Uniform(problem.levels[0], problem.levels[-1]), share=True)


def levels_of(problem: Problem, kind: str) -> tuple[float, ...]:
    """The levels of the limits in the runs of a kind, in their order."""
    tight = problem.levels[0]
    return {"": problem.levels, AGAIN: (tight,), DELAYED: (1.0,), MORE: (tight, 1.0)}[kind]


def sweep(problem: Problem, law: Law, knobs: Knobs, kind: str = "") -> wb.Sweep:
    """A law on all draws: at all levels of the limits, or at the one of its kind."""
    loop = loop_of(problem, law, knobs, late=kind == DELAYED)
    factors = (*factors_of(problem, loop), level_factor(problem, loop))
    levels = levels_of(problem, kind)
    drawn = wb.uncertainty.MonteCarlo(len(factors) - 1, DRAWS, SEED).points()
    low, high = problem.levels[0], problem.levels[-1]
    share = [np.full((DRAWS, 1), (level - low) / (high - low)) for level in levels]
    points = np.vstack([np.hstack([drawn, one]) for one in share])
    run = wb.Run(loop, metrics_of(problem), problem.horizon, h=problem.period / problem.substeps, seed=SEED)
    name = sweep_name(problem, law, kind)
    return wb.Sweep(name, run, factors, wb.uncertainty.ListedPoints(points), common=False)


def sweeps(answers: Mapping[str, Any]) -> tuple[wb.Sweep, ...]:
    """All laws on all draws, with the numbers that they chose."""
    choices = dict(zip(items(), answers["choices"], strict=True))
    made = []
    for problem in PROBLEMS.values():
        for law in laws_of(problem):
            usual = knobs_of(law, choices[Item(problem.key, law.key)])
            tightest = problem.levels[0]
            tight = knobs_of(law, choices[Item(problem.key, law.key, tightest)]) | {LEVEL: tightest}
            made += [sweep(problem, law, usual), sweep(problem, law, usual, DELAYED), sweep(problem, law, tight, AGAIN)]
        best = knobs_of(CONVERGED, choices[Item(problem.key, CONVERGED.key)])
        made.append(sweep(problem, CONVERGED, best, MORE))
    return tuple(made)
