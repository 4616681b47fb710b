"""The samples of a law, with the effects, indices and quantiles of its outputs, and its exact derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

import workbench as wb
from studies.a7_sensitivity.sweeps import (
    EVERY,
    METRICS,
    NARROW,
    PROPOSED_LAW,
    STEPS,
    UNTIL,
    free,
    loop,
    metrics,
    sweep_name,
)
from studies.paper.factors import GROUPS, group_of

LEVELS = (0.05, 0.5, 0.95)
FLOOR = 1e-4  # rad: what smaller errors add to an integral that holds the start is lost in its rounding
WORST = 3  # runs a joint with the largest TV, which are run again
STATE_INTERVAL = 0.01  # s between the states at which the limit of stability is looked for
Output = tuple[str, int]  # a metric and a joint


@dataclass(frozen=True, eq=False)
class LawResults:
    """The samples of a law, and their analysis by outputs such as ('RMSE', 0)."""

    law: str
    screening: wb.study.Sample
    indices: wb.study.Sample
    random: wb.study.Sample
    swings: wb.study.Sample | None = None
    equal: wb.study.Sample | None = None  # with the same range for every number

    @property
    def outputs(self) -> tuple[Output, ...]:
        return tuple((metric.name, joint) for metric in metrics(self.law) for joint in (0, 1))

    @property
    def samples(self) -> tuple[wb.study.Sample, ...]:
        every = self.screening, self.indices, self.random, self.swings, self.equal
        return tuple(sample for sample in every if sample is not None)

    @cached_property
    def effects(self) -> wb.uncertainty.MorrisEffects:
        """The effects of every factor on every output."""
        return self.effects_on(self.outputs)

    def effects_on(self, outputs: Sequence[Output]) -> wb.uncertainty.MorrisEffects:
        design = self.screening.design_of(wb.uncertainty.MorrisDesign)
        values, errors, names = _columns(self.screening, outputs)
        return wb.uncertainty.morris(design, values, names, factors=self.screening.factors, errors=errors)

    @cached_property
    def shares(self) -> wb.uncertainty.SobolIndices:
        """The indices of the free factors in the variance of every output."""
        return self.shares_of(self.outputs)

    def shares_of(self, outputs: Sequence[Output]) -> wb.uncertainty.SobolIndices:
        sample, (values, errors, names) = self.indices, _columns(self.indices, outputs)
        design = sample.design_of(wb.SobolDesign)
        return wb.sobol(
            design, values, names, factors=sample.factors, groups=self.groups, control_variate=True, errors=errors
        )

    def shares_by(self, metric: str, change: Callable[[wb.Array], wb.Array]) -> wb.uncertainty.SobolIndices:
        """The indices of a metric at both joints, whose values (N,) are changed first."""
        sample = self.indices
        values = np.stack([change(sample.score(metric, joint).value) for joint in (0, 1)], axis=1)
        names = [output_name(metric, joint) for joint in (0, 1)]
        design = sample.design_of(wb.SobolDesign)
        return wb.sobol(design, values, names, factors=sample.factors, groups=self.groups, control_variate=True)

    def shares_within(self, metric: str, begin: float, end: float) -> wb.uncertainty.SobolIndices:
        """The indices of a metric that is a mean over time, taken from `begin` to `end` s, at both joints."""
        sample = self.indices
        at = [int(np.flatnonzero(np.isclose(sample.t, time))[0]) if time else None for time in (begin, end)]

        def inside(joint: int) -> wb.Array:
            total = sample.over_time(metric, joint) * sample.t
            return (total[:, at[1]] - (0.0 if at[0] is None else total[:, at[0]])) / (end - begin)

        names = [output_name(metric, joint) for joint in (0, 1)]
        values = np.stack([inside(joint) for joint in (0, 1)], axis=1)
        design = sample.design_of(wb.SobolDesign)
        return wb.sobol(design, values, names, factors=sample.factors, groups=self.groups, control_variate=True)

    @property
    def single(self) -> wb.study.Sample:
        """The runs of the proposed law with one factor at a time."""
        if self.swings is None:
            raise ValueError(f"{self.law} has no runs with one factor at a time; {PROPOSED_LAW} alone has them.")
        return self.swings

    @cached_property
    def equal_shares(self) -> wb.uncertainty.SobolIndices:
        """The indices of the RMSE where every number has the same range."""
        assert self.equal is not None
        return replace(self, indices=self.equal).shares_of([("RMSE", joint) for joint in (0, 1)])

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """The free factors by group, and all of them."""
        names = self.indices.factors
        return {**{group: tuple(f for f in names if group_of(f) == group) for group in GROUPS}, "all": names}

    def tornado_of(self, metric: str, joint: int) -> wb.uncertainty.Tornado:
        """The swing of an output with each factor by itself."""
        sample = self.single
        design, values = sample.design_of(wb.uncertainty.OneAtATime), sample.score(metric, joint).value
        return wb.uncertainty.tornado(design, values, [output_name(metric, joint)], factors=sample.factors)

    def bands(self, joint: int) -> wb.uncertainty.Quantiles:
        """Quantiles over random runs of the decimal logarithm of the root mean square error of each window of time."""
        total = self.random.over_time("ISE", joint)
        inside = np.diff(total, axis=1, prepend=np.zeros((len(total), 1)))
        errors = np.sqrt(np.maximum(inside, 0.0) / EVERY)
        return wb.uncertainty.quantiles(
            self.random.design_of(wb.uncertainty.MonteCarlo), np.log10(np.maximum(errors, FLOOR)), levels=LEVELS
        )


def _columns(sample: wb.study.Sample, outputs: Sequence[Output]) -> tuple[wb.Array, wb.Array, list[str]]:
    """The values and the errors (N, M) of some outputs, and their names."""
    values = np.stack([sample.score(*output).value for output in outputs], axis=1)
    errors = np.stack([sample.score(*output).error for output in outputs], axis=1)
    return values, errors, [output_name(*output) for output in outputs]


def results_of(results: wb.Results, law: str) -> LawResults:
    kinds = ("screening", "indices", "bands", *(("tornado", "equal") if law == PROPOSED_LAW else ()))
    return LawResults(law, *(results.sample(sweep_name(law, kind)) for kind in kinds))


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives at the numbers of the card with respect to d factors that are shares of m numbers."""

    factors: tuple[str, ...]
    sensitivities: wb.uncertainty.LocalSensitivities
    moves: wb.Array  # (d, m): by how much a factor moves each number, where it rises by its whole value
    deviations: wb.Array  # (d,): the standard deviations of the factors

    def shares(self, metric: str, joint: int) -> wb.Array:
        """The parts of the variance (d,) if the metric were linear."""
        moved = self.deviations[:, np.newaxis] * self.moves
        return np.asarray(self.sensitivities.linear_shares(metric, moved)[joint])

    def slopes(self, metric: str) -> str:
        """The number of derivatives whose gradient is the slope of the runs, and that of all."""
        holds = self.sensitivities.holds(metric)
        return f"{holds.sum()} of {holds.size}"

    def hold(self, metric: str, joint: int) -> bool:
        """True if every derivative of the metric at a joint is the slope of the runs."""
        return bool(self.sensitivities.holds(metric)[joint].all())

    @property
    def of_runs(self) -> Derivatives:
        """The slopes of runs over 1 % of a number in place of the gradient."""
        return replace(self, sensitivities=replace(self.sensitivities, gradient=self.sensitivities.wide_slope))

    @property
    def equal(self) -> Derivatives:
        """The derivatives with the same relative range for every factor."""
        return replace(self, deviations=np.ones(len(self.factors)))


def derivatives(law: str) -> Derivatives:
    """The derivatives of a law with respect to the factors of its Sobol indices."""
    ode, moved = loop(law).ode(), free(law)
    labels = [numbers_of(ode, factor) for factor in moved]
    names = [name for some in labels for name in some]
    found = wb.uncertainty.local_sensitivities(ode, METRICS, names, until=UNTIL, h=STEPS[law])
    moves = np.array([np.where(np.isin(found.labels, some), found.at, 0.0) for some in labels])
    u = (np.arange(4000) + 0.5) / 4000
    deviations = np.array([factor.distribution.quantile(u).std() for factor in moved])
    return Derivatives(tuple(factor.name for factor in moved), found, moves, deviations)


@dataclass(frozen=True)
class WorstRuns:
    """The runs of a law with the largest TV, by their points (B, d), and the deviation of TV over all runs, by joint.

    There gains have grown most, and the limit of stability is nearest.
    """

    law: str
    points: tuple[tuple[float, ...], ...]
    deviation: tuple[float, ...]


@dataclass(frozen=True)
class Stress:
    """The longest stable step along some runs in s, and the largest error of their TV over its deviation."""

    limit: float
    error: float


def worst_runs(one: LawResults) -> WorstRuns:
    """The runs of the indices with the largest TV, some of each joint."""
    sample = one.indices
    values = np.stack([sample.score("TV", joint).value for joint in (0, 1)], axis=1)
    runs = np.unique(np.argsort(-values, axis=0)[:WORST])
    design = sample.design_of(wb.SobolDesign)
    points = np.concatenate([design.points(run, run + 1) for run in runs.tolist()])
    return WorstRuns(one.law, tuple(map(tuple, points.tolist())), tuple(values.std(axis=0).tolist()))


def measure_stress(worst: WorstRuns) -> Stress:
    """These runs again, with their states kept."""
    ode = loop(worst.law).ode()
    p, x0 = wb.uncertainty.Space(free(worst.law), ode.parameters, ode.states).rows(np.array(worst.points))
    again = wb.measure(ode, metrics(worst.law), p, x0, until=UNTIL, h=STEPS[worst.law], every=STATE_INTERVAL)
    errors = np.stack([again.score("TV", joint).error for joint in (0, 1)], axis=1)
    return Stress(again.limit.limit, float((errors / worst.deviation).max()))


def numbers_of(ode: wb.Ode, factor: wb.Factor) -> Sequence[str]:
    """The numbers of a loop that a share of them moves: not the zeros of a matrix."""
    layouts = [(path, ode.parameters if path in ode.parameters else ode.states) for path in factor.paths]
    return [of.labels[i] for path, of in layouts for i in of.indices(path) if of.default[i] != 0]


def output_name(metric: str, joint: int) -> str:
    """An output as tables call it."""
    return f"{metric} of joint {joint + 1}"


def leaders(factors: Sequence[str], total: wb.uncertainty.Estimate) -> tuple[str, ...]:
    """The factors whose total index the runs do not tell from the largest, that one first."""
    order = np.argsort(-total.value, kind="stable")
    least = total.low[order[0]]
    return tuple(factors[i] for i in order if total.high[i] >= least or i == order[0])


def narrow(*estimates: wb.uncertainty.Estimate) -> bool:
    """True if every interval is narrow enough for a sentence to rest on it."""
    return all(bool((2 * one.half < NARROW).all()) for one in estimates)


def interval(one: wb.uncertainty.Estimate, digits: int = 2) -> str:
    """A number with its interval, rounded up."""
    half = np.ceil(10**digits * float(one.half)) / 10**digits
    return f"{float(one.value):.{digits}f} \N{PLUS-MINUS SIGN} {half:.{digits}f}"


percent = partial(wb.document.percent, decimals=0)


def winsorize_largest(values: wb.Array) -> wb.Array:
    """The values with the largest one lowered to the next."""
    return np.asarray(np.minimum(values, np.sort(values)[-2]))


def winsorize_tail(values: wb.Array) -> wb.Array:
    """The values with the largest 1 % lowered to the largest of the others."""
    return np.minimum(values, np.quantile(values, 0.99))


# By words: what may be taken in place of a metric whose variance a few runs could carry.
ROBUST: dict[str, Callable[[wb.Array], wb.Array]] = {
    "the largest run lowered to the next": winsorize_largest,
    "the largest 1 % of the runs lowered to the rest": winsorize_tail,
    "the decimal logarithm in place of the error": np.log10,
}
