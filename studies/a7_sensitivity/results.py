"""What the runs of a law say: effects, indices, swings, bands over time; or why they do not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from studies.a7_sensitivity.sweeps import EVERY, called, kinds, metrics
from studies.a7_sensitivity.words import GROUPS, group_of, percent
from workbench.study.sample import Sample
from workbench.study.study import Results
from workbench.study.uncertainty import (
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


@dataclass(frozen=True, eq=False)
class Found:
    """The samples of a law, and what they say of outputs such as ('RMSE', 0): a metric and a joint."""

    law: str
    screening: Sample
    indices: Sample
    random: Sample
    swings: Sample | None = None

    @property
    def outputs(self) -> tuple[tuple[str, int], ...]:
        """The metrics at the horizon, joint by joint."""
        return tuple((metric.name, joint) for metric in metrics(self.law) for joint in (0, 1))

    @property
    def samples(self) -> tuple[Sample, ...]:
        """All that there are."""
        return self.screening, self.indices, self.random, *(() if self.swings is None else (self.swings,))

    @cached_property
    def effects(self) -> MorrisEffects:
        """Of every factor on every output."""
        return self._judged(morris, self.screening, self.outputs)

    @cached_property
    def shares(self) -> SobolIndices:
        """Of the free factors in the variance of every output."""
        return self.shares_of(self.outputs)

    def shares_of(self, outputs: Sequence[tuple[str, int]]) -> SobolIndices:
        """The same of some outputs."""
        return self._judged(partial(sobol, groups=self.groups, control=True), self.indices, outputs)

    @property
    def groups(self) -> dict[str, tuple[str, ...]]:
        """The free factors by group, and all of them."""
        free = self.indices.factors
        return {**{group: tuple(f for f in free if group_of(f) == group) for group in GROUPS}, "all": free}

    def effects_on(self, metric: str) -> MorrisEffects:
        """Of every factor on both joints of one metric."""
        return self._judged(morris, self.screening, ((metric, 0), (metric, 1)))

    def tornado_of(self, metric: str, joint: int) -> Tornado:
        """What each factor does by itself."""
        sample = self.swings
        return tornado(sample.design, sample.outputs(metric, joint), [named(metric, joint)], factors=sample.factors)

    def shares_over_time(self, joint: int) -> SobolIndices:
        """Of the free factors in the variance of the error of each window of time."""
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

    @staticmethod
    def _judged(call: Callable[..., Any], sample: Sample, outputs: Sequence[tuple[str, int]]) -> Any:
        values = np.stack([sample.outputs(*output) for output in outputs], axis=1)
        errors = np.stack([sample.errors_of(*output) for output in outputs], axis=1)
        names = [named(*output) for output in outputs]
        return call(sample.design, values, names, factors=sample.factors, errors=errors)


def found(results: Results, law: str) -> Found:
    """What a study found of a law."""
    return Found(law, *(results.sample(called(law, kind)) for kind in kinds(law)))


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


def unit_of(metric: str) -> str:
    """The unit of a metric, as axes print it."""
    return {"TV": "N m/s", "effort": "N m"}.get(metric, "rad")


def heaviest(sample: Sample, metric: str = "late error") -> str:
    """How much of the variance of a metric a single run has, at the joint where it has most."""
    values = np.stack([sample.outputs(metric, joint) for joint in (0, 1)])
    squares = (values - values.mean(axis=1, keepdims=True)) ** 2
    part = squares.max(axis=1) / squares.sum(axis=1)
    joint = int(part.argmax())
    second, first = np.sort(values[joint])[-2:]
    return (
        f"One of {len(sample):,} runs has {percent(part[joint])} of the variance at joint {joint + 1} "
        f"({first:.2f} rad; the next is {second:.2f})."
    )
