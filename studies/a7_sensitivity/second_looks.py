"""Runs of a7 again: those that stray, up to a later horizon, and the heaviest one with other gains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import workbench as wb
from studies.a7_sensitivity.results import LawResults
from studies.a7_sensitivity.sweeps import LATE, STEPS, UNTIL, factors, loop
from studies.paper.factors import SEED
from studies.paper.fitted_arm import unless_fitted

ASTRAY = 1.0  # rad, of a late error: as large as the reference itself
BOUNDS = (ASTRAY / 2, 2 * ASTRAY)  # rad, beside it
FROM, TO = 18.0, 20.0  # s: the later look at runs that are astray from `LATE` to `UNTIL`
REDRAW_COUNT = 400  # sets of gains


def rows_of_fit(runs: Numbers, ode: wb.Ode) -> tuple[wb.Array, wb.Array]:
    """The parameters (N, np) and the initial states (N, nx) of runs whose factors are shares or directions of a fit."""
    moved = tuple(factor for factor in factors(runs.law) if factor.name in runs.factors)
    assert tuple(factor.name for factor in moved) == runs.factors
    return wb.uncertainty.Space(moved, ode.parameters, ode.states).rows_at(runs.values)


@dataclass(frozen=True, eq=False)
class Numbers:
    """Runs of a law by the values (N, d) of some factors, which are shares of the loop's numbers."""

    law: str
    factors: tuple[str, ...]
    values: wb.Array

    @unless_fitted(rows_of_fit)
    def rows(self, ode: wb.Ode) -> tuple[wb.Array, wb.Array]:
        """The parameters (N, np) and the initial states (N, nx) of these runs."""
        moved = tuple(factor for factor in factors(self.law) if factor.name in self.factors)
        assert tuple(factor.name for factor in moved) == self.factors
        rows = np.tile(np.concatenate([ode.parameters.default, ode.states.default]), (len(self.values), 1))
        for places, values in zip(
            wb.uncertainty.Space(moved, ode.parameters, ode.states).places, self.values.T, strict=True
        ):
            rows[:, places] *= values[:, np.newaxis]
        return rows[:, : ode.parameters.size], rows[:, ode.parameters.size :]


def late_errors(of: Numbers, begin: float, end: float) -> wb.Array:
    """The largest |e| (N, 2) of each joint from `begin` to `end` s; NaN where a run diverges."""
    ode, metrics = loop(of.law).ode(), (wb.metrics.late_error(begin),)
    step = wb.metrics.step_with_metrics(ode, metrics, STEPS[of.law])
    p, x0 = of.rows(ode)
    more = np.tile(step.states.default[x0.shape[1] :], (len(x0), 1))
    runs = wb.simulate(step, p=p, x0=np.hstack([x0, more]), until=end, every=end)
    return wb.metrics.final_values(runs, metrics)["late error"]


@dataclass(frozen=True)
class Later:
    """The largest |e| of each joint (N, 2) in a later look at some runs, in rad; NaN where one has diverged."""

    errors: wb.Array


def late_errors_of(sample: wb.study.Sample) -> wb.Array:
    """The late error (N, 2) of each joint."""
    return np.stack([sample.score("late error", joint).value for joint in (0, 1)], axis=1)


def beyond(errors: wb.Array, bound: float = ASTRAY) -> wb.uncertainty.Flags:
    """True for the runs (N,) in which an error (N, 2) reaches the bound, or that diverged."""
    return np.asarray(~(errors < bound).all(axis=1))


def suspects(one: LawResults) -> tuple[Numbers, ...]:
    """The runs of each sample of a law that could stray by any of the bounds; none where a sample has none."""
    flagged = [(sample, beyond(late_errors_of(sample), min(BOUNDS))) for sample in one.samples]
    return tuple(
        Numbers(one.law, sample.factors, sample.factor_values[flags]) for sample, flags in flagged if flags.any()
    )


def look_later(runs: Numbers) -> Later:
    """Some runs again, up to a later horizon."""
    return Later(late_errors(runs, FROM, TO))


def redrawn_gains(ours: LawResults) -> Numbers:
    """The run that has most of the variance of the late error, with random gains in place of its own."""
    sample = ours.indices
    run, _ = heaviest_run(sample)
    values = np.tile(sample.factor_values[run], (REDRAW_COUNT, 1))
    gains = [factor for factor in factors(ours.law) if factor.name in ours.groups["gains"]]
    for factor, u in zip(gains, wb.uncertainty.MonteCarlo(len(gains), REDRAW_COUNT, SEED).points().T, strict=True):
        values[:, sample.factors.index(factor.name)] = factor.distribution.quantile(u)
    return Numbers(ours.law, sample.factors, values)


def redraw(runs: Numbers) -> Later:
    """The late errors of the run with redrawn gains."""
    return Later(late_errors(runs, LATE, UNTIL))


def redrawn_words(ours: LawResults, redraws: Later) -> str:
    """The share of the redrawn runs that stray."""
    run, _ = heaviest_run(ours.indices)
    stray, runs = int(beyond(redraws.errors).sum()), len(redraws.errors)
    helps = ": the gains contribute to whether a run strays" if 0 < stray < runs else ""
    return (
        f"With the arm and the model of run {run + 1:,}, and {runs} random draws of the gains "
        f"({', '.join(ours.groups['gains'])}), {stray} runs exceed {ASTRAY:g} rad{helps}."
    )


def heaviest_run(sample: wb.study.Sample) -> tuple[int, int]:
    """The number from 0 of the run with the largest part in the variance of the late error, and the joint."""
    values = late_errors_of(sample)
    squares = (values - values.mean(axis=0)) ** 2
    run, joint = np.unravel_index((squares / squares.sum(axis=0)).argmax(), squares.shape)
    return int(run), int(joint)
