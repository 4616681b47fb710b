"""The samples of a law, with the effects, indices and quantiles of its outputs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from studies.a7_sensitivity.factors import GROUPS, group_of
from studies.a7_sensitivity.sweeps import EVERY, NARROW, PROPOSED, called, metrics
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.uncertainty import (
    Estimate,
    MorrisEffects,
    Quantiles,
    SobolIndices,
    Tornado,
    morris,
    quantiles,
    sobol,
    tornado,
)
from workbench.validation.refusals import Array

LEVELS = (0.05, 0.5, 0.95)
FLOOR = 1e-4  # rad: what smaller errors add to an integral that holds the start is lost in its rounding
Output = tuple[str, int]  # a metric and a joint


@dataclass(frozen=True, eq=False)
class LawResults:
    """The samples of a law, and their analysis by outputs such as ('RMSE', 0)."""

    law: str
    screening: Sample
    indices: Sample
    random: Sample
    swings: Sample | None = None

    @property
    def outputs(self) -> tuple[Output, ...]:
        """The metrics at the horizon, joint by joint."""
        return tuple((metric.name, joint) for metric in metrics(self.law) for joint in (0, 1))

    @property
    def samples(self) -> tuple[Sample, ...]:
        """All samples of the law."""
        return self.screening, self.indices, self.random, *(() if self.swings is None else (self.swings,))

    @cached_property
    def effects(self) -> MorrisEffects:
        """The effects of every factor on every output."""
        return self.effects_on(self.outputs)

    def effects_on(self, outputs: Sequence[Output]) -> MorrisEffects:
        """The effects of every factor on some outputs."""
        return _judged(morris, self.screening, outputs)

    @cached_property
    def shares(self) -> SobolIndices:
        """The indices of the free factors in the variance of every output."""
        return self.shares_of(self.outputs)

    def shares_of(self, outputs: Sequence[Output]) -> SobolIndices:
        """The indices of the free factors in the variance of some outputs."""
        return _judged(partial(sobol, groups=self.groups, control=True), self.indices, outputs)

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """The free factors by group, and all of them."""
        free = self.indices.factors
        return {**{group: tuple(f for f in free if group_of(f) == group) for group in GROUPS}, "all": free}

    def tornado_of(self, metric: str, joint: int) -> Tornado:
        """The swing of an output with each factor by itself."""
        sample = self.swings
        return tornado(sample.design, sample.outputs(metric, joint), [named(metric, joint)], factors=sample.factors)

    def shares_over_time(self, joint: int) -> SobolIndices:
        """The indices of the free factors in the variance of the error of each window of time."""
        names = [f"{t:g} s" for t in middles(self.indices)]
        design, factors = self.indices.design, self.indices.factors
        return sobol(design, windows(self.indices, joint), names, factors=factors, groups=self.groups, control=True)

    def bands(self, joint: int) -> Quantiles:
        """Quantiles of the decimal logarithm of the error of each window, at least `FLOOR`, over random runs."""
        errors = np.log10(np.maximum(windows(self.random, joint), FLOOR))
        return quantiles(self.random.design, errors, levels=LEVELS)

    def spread(self, metric: str, joint: int) -> Quantiles:
        """Quantiles of an output over random runs."""
        return quantiles(self.random.design, self.random.outputs(metric, joint), levels=LEVELS)


def _judged(call: Callable[..., Any], sample: Sample, outputs: Sequence[Output]) -> Any:
    values = np.stack([sample.outputs(*output) for output in outputs], axis=1)
    errors = np.stack([sample.errors_of(*output) for output in outputs], axis=1)
    names = [named(*output) for output in outputs]
    return call(sample.design, values, names, factors=sample.factors, errors=errors)


def results_of(results: Results, law: str) -> LawResults:
    """The results of a study for a law."""
    kinds = ("screening", "indices", "bands", *(("tornado",) if law == PROPOSED else ()))
    return LawResults(law, *(results.sample(called(law, kind)) for kind in kinds))


def named(metric: str, joint: int) -> str:
    """An output as tables call it."""
    return f"{metric} of joint {joint + 1}"


def windows(sample: Sample, joint: int) -> Array:
    """The root mean square error of each window of time, (N, T), in rad, from the integrals up to each time."""
    total = sample.over_time("ISE", joint)
    inside = np.diff(total, axis=1, prepend=np.zeros((len(total), 1)))
    return np.asarray(np.sqrt(np.maximum(inside, 0.0) / EVERY))


def middles(sample: Sample) -> Array:
    """The middles of the windows, (T,), in s."""
    return np.asarray(sample.t - EVERY / 2)


def leaders(factors: Sequence[str], total: Estimate) -> tuple[str, ...]:
    """The factors whose total index the runs do not tell from the largest, that one first."""
    order = np.argsort(-total.value, kind="stable")
    least = total.low[order[0]]
    return tuple(factors[i] for i in order if total.high[i] >= least or i == order[0])


def narrow(*estimates: Estimate) -> bool:
    """True if every interval is narrow enough for a sentence to rest on it."""
    return all(bool((2 * one.half < NARROW).all()) for one in estimates)


def interval(one: Estimate, digits: int = 2) -> str:
    """A number with its interval, rounded up."""
    half = np.ceil(10**digits * float(one.half)) / 10**digits
    return f"{float(one.value):.{digits}f} \N{PLUS-MINUS SIGN} {half:.{digits}f}"


def percent(share: float) -> str:
    """A share in whole percents."""
    return f"{100 * share:.0f} %"
