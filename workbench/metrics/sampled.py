"""Metrics that look at the loop once a step, or once in a stated number of steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.metrics.contract import AbstractSignalMetric, Parts
from workbench.metrics.signals import Signal, column, product
from workbench.validation.doors import door
from workbench.validation.words import Array, finite, seconds


def on_grid(k: ca.SX, h: ca.SX, sample: float) -> ca.SX:
    """True if t_k = k h is a multiple of a sample time that is one of h, all in s."""
    return ca.fmod(k, ca.floor(sample / h + 0.5)) == 0


@door
def _absolute(e: ca.SX) -> ca.SX:
    """|e|."""
    return ca.fabs(e)


@dataclass(frozen=True)
@door
class Peak(AbstractSignalMetric):
    """The largest absolute value of a signal over all steps, from `after` seconds on.

    Attributes
    ----------
    size
        What is to be largest in place of the absolute value, of the column of the signal; it counts where positive.
    """

    signal: Signal
    after: float = 0.0
    size: Callable[[ca.SX], ca.SX] = _absolute

    def __post_init__(self) -> None:
        finite("Peak(after=...)", self.after, " of seconds", low=0)

    def check(self, ode: Ode, horizon: float) -> None:
        """Some time must be left for it."""
        if self.after > horizon * (1 + 1e-6):
            raise ValueError(
                f"The metric '{self.name}' needs a horizon beyond the {self.after:g} s after which it begins; "
                f"got {horizon:g} s."
            )

    def memory(self, size: int) -> Layout:
        """The largest so far."""
        return Layout((Entry("peak", np.zeros(size)),))

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The larger of what was and what is."""
        late = k * h >= self.after - h / 2
        size = ca.if_else(late, self.size(column(self.signal, y)), 0)
        return {"peak": ca.if_else(z["peak"] >= size, z["peak"], size)}  # no number is never less, and so stays

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The largest."""
        return z["peak"]


@dataclass(frozen=True)
@door
class TotalVariation(AbstractSignalMetric):
    """The sum of |u(t_j) - u(t_(j-1))| over a grid of `sample` seconds, per second: a measure of chattering.

    It depends on the grid, which is why the grid is part of the metric and not of the step.
    """

    signal: Signal
    sample: float

    def __post_init__(self) -> None:
        seconds("TotalVariation(sample=...)", self.sample)

    def measured_in(self, unit: str) -> str:
        """That of the signal, per second."""
        return product((unit, 1), ("s", -1))

    @property
    def grid(self) -> float | None:
        """Its sample time."""
        return self.sample

    def check(self, ode: Ode, horizon: float) -> None:
        """At least one sample time must pass."""
        if self.sample > horizon * (1 + 1e-6):
            raise ValueError(
                f"The metric '{self.name}' needs a horizon of one sample time at least, which is {self.sample:g} s; "
                f"got {horizon:g} s."
            )

    def memory(self, size: int) -> Layout:
        """The sum so far and the last sample."""
        return Layout((Entry("sum", np.zeros(size)), Entry("last", np.zeros(size))))

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """On the grid the change since the last sample is added."""
        u, sampled, first = column(self.signal, y), on_grid(k, h, self.sample), k == 0
        change = ca.if_else(first, 0, ca.fabs(u - z["last"]))
        return {
            "sum": z["sum"] + ca.if_else(sampled, change, 0),
            "last": ca.if_else(sampled, u, z["last"]),
        }

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The sum per second of the time that was sampled: whole sample times only."""
        return z["sum"] / (self.sample * int(horizon / self.sample + 1e-6))


@dataclass(frozen=True)
@door
class SampledRms(AbstractSignalMetric):
    """sqrt(1/N sum of u(t_k)^2) over the N samples t = 0, sample, 2 sample, ... up to the horizon.

    A sum over samples is not the integral: an error that starts at u(0) and falls adds about u(0)^2 / 2
    to the sum, whatever the sample time. The grid is therefore part of the metric.
    """

    signal: Signal
    sample: float

    def __post_init__(self) -> None:
        seconds("SampledRms(sample=...)", self.sample)

    @property
    def grid(self) -> float | None:
        """Its sample time."""
        return self.sample

    def memory(self, size: int) -> Layout:
        """The sum of squares and the number of samples so far."""
        return Layout((Entry("sum", np.zeros(size)), Entry("count", np.zeros(size))))

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """On the grid one sample more."""
        sampled = on_grid(k, h, self.sample)
        return {
            "sum": z["sum"] + ca.if_else(sampled, column(self.signal, y) ** 2, 0),
            "count": z["count"] + ca.if_else(sampled, 1, 0),
        }

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The root of the mean."""
        return np.asarray(np.sqrt(z["sum"] / z["count"]))
