"""Metrics that look at the loop once a step or once in a stated number of steps: peaks, sums and step responses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from workbench.core import Ode
from workbench.core.units import per_second
from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array, finite, positive, seconds
from workbench.core.validation.signatures import check_arguments
from workbench.engine.metrics.contract import AbstractSignalMetric, Parts
from workbench.engine.metrics.signal_choice import Signal, SignalChoice, SignalColumn, column, levels

NEVER = 1e30  # in the loop's arithmetic, where 0 times infinity would be NaN
LEVELS = SignalChoice("level")  # all that is followed
ROUNDING = 1e-9  # a change by less, in units of a level of 1 at least, is rounding and no jump


def on_grid(k: ca.SX, h: ca.SX, sample: float) -> ca.SX:
    """True if t_k = k h is a multiple of a sample time that is one of h, all in s."""
    return ca.fmod(k, ca.floor(sample / h + 0.5)) == 0


@check_arguments
def _absolute(e: ca.SX) -> ca.SX:
    return ca.fabs(e)


@dataclass(frozen=True)
@check_arguments
class Peak(AbstractSignalMetric):
    """The largest absolute value of a signal over all steps, from `after` seconds on.

    Examples
    --------
    >>> wb.metrics.Peak("peak", "rad/s", "largest speed", "omega", 0.5).after
    0.5
    """

    remembers: ClassVar = ("peak",)
    signal: Signal
    after: float = 0.0
    size: Callable[[ca.SX], ca.SX] = _absolute  # of the signal's column, which counts where it is positive

    def __post_init__(self) -> None:
        finite("Peak(after=...)", self.after, " of seconds", low=0)

    def check(self, ode: Ode, horizon: float) -> None:
        """Refuse a horizon that ends before `after`."""
        if self.after > horizon * (1 + 1e-6):
            raise ValueError(
                f"The metric '{self.name}' needs a horizon beyond the {self.after:g} s after which it begins; "
                f"got {horizon:g} s."
            )

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The larger of the memory and the present value."""
        late = k * h >= self.after - h / 2
        size = ca.if_else(late, self.size(column(self.signal, y)), 0)
        return {"peak": ca.if_else(z["peak"] >= size, z["peak"], size)}  # no number is never less, and so stays

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The largest value of the run."""
        return z["peak"]


@dataclass(frozen=True)
class AbstractSampledMetric(AbstractSignalMetric):
    """A metric of a signal on a grid of `sample` seconds that begins at t = 0: it depends on the grid."""

    signal: Signal
    sample: float

    def __post_init__(self) -> None:
        seconds(f"{type(self).__name__}(sample=...)", self.sample)

    @property
    def grid(self) -> float | None:
        """The sample time of the metric."""
        return self.sample


@dataclass(frozen=True)
@check_arguments
class TotalVariation(AbstractSampledMetric):
    """The sum of |u(t_j) - u(t_(j-1))| over the grid from `after` seconds on, per second: a measure of chattering.

    Examples
    --------
    >>> wb.metrics.TotalVariation("TV", "V/s", "total variation of v", "v", 1e-3).name
    'TV'
    """

    remembers: ClassVar = ("sum", "last")
    after: float = 0.0

    def __post_init__(self) -> None:
        seconds("TotalVariation(sample=...)", self.sample)
        finite("TotalVariation(after=...)", self.after, " of seconds", low=0)

    @check_arguments
    def measured_in(self, unit: str) -> str:
        """The unit of the signal, per second."""
        return per_second(unit)

    def check(self, ode: Ode, horizon: float) -> None:
        """Refuse a horizon that ends less than one sample time of the grid after `after`."""
        if self._intervals(horizon) < 1:
            late = f" from {self.after:g} s on" if self.after else ""
            raise ValueError(
                f"The metric '{self.name}' needs a horizon of one sample time at least{late}, which is "
                f"{self.sample:g} s; got {horizon:g} s."
            )

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory with the change since the last sample added, on the grid."""
        u, sampled, first = column(self.signal, y), on_grid(k, h, self.sample), k == 0
        change = ca.if_else(first, 0, ca.fabs(u - z["last"]))
        begins = (self._skipped_samples + 1) * self.sample  # where the first change that counts ends
        counts = ca.logic_and(sampled, k * h >= begins - h / 2) if self.after else sampled
        return {
            "sum": z["sum"] + ca.if_else(counts, change, 0),
            "last": ca.if_else(sampled, u, z["last"]),
        }

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The sum per second of the time that was sampled: whole sample times only; 0 before there is one."""
        return z["sum"] / (self.sample * max(1.0, self._intervals(horizon)))

    @property
    def _skipped_samples(self) -> float:
        """The number of sample times before the first sample from `after` on."""
        return float(np.ceil(self.after / self.sample - 1e-6))

    def _intervals(self, horizon: float) -> float:
        """The number of whole sample times from `after` to the horizon."""
        return float(np.floor(horizon / self.sample + 1e-6)) - self._skipped_samples


@dataclass(frozen=True)
@check_arguments
class SampledRms(AbstractSampledMetric):
    """sqrt(1/N sum of u(t_k)^2) over the N samples t = 0, sample, 2 sample, ... up to the horizon.

    A sum over samples is not the integral: an error that starts at u(0) and falls adds about u(0)^2 / 2
    to the sum, whatever the sample time.
    """

    remembers: ClassVar = ("sum", "count")

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory with one more sample, on the grid."""
        sampled = on_grid(k, h, self.sample)
        return {
            "sum": z["sum"] + ca.if_else(sampled, column(self.signal, y) ** 2, 0),
            "count": z["count"] + ca.if_else(sampled, 1, 0),
        }

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The root of the mean."""
        return np.asarray(np.sqrt(z["sum"] / z["count"]))


class AbstractStepResponse(AbstractSignalMetric):
    """A metric of the response to jumps of a piecewise constant reference; the start counts as a jump."""

    def check(self, ode: Ode, horizon: float) -> None:
        """Refuse a reference whose derivative, as an expression, is not zero: steps and square waves pass."""
        signal = self.signal
        _, wanted = levels(signal, ode.outputs.view(ode.output))
        if ca.sparsify(ca.jacobian(wanted, ca.vertcat(ode.t, ode.x))).nnz():
            names = ", ".join(signal.references if isinstance(signal, SignalColumn) else ())
            raise ValueError(
                f"The metric '{self.name}' needs a piecewise constant reference, as it is measured from one jump to "
                f"the next; the {names} of '{ode.name}' moves. Use steps or a square wave, or `peak_error()` and "
                "`late_error(...)`."
            )


def jump(k: ca.SX, z: Parts, actual: ca.SX, reference: ca.SX) -> tuple[ca.SX, ca.SX]:
    """True if the reference has just jumped, and the level from which it did."""
    first = k == 0
    jumped = ca.logic_or(first, height(z["level"], reference) != 0)
    return jumped, ca.if_else(first, actual, ca.if_else(jumped, z["level"], z["origin"]))


def height(origin: ca.SX, level: ca.SX) -> ca.SX:
    """The way from one level to another, with a sign; zero where only rounding is between them."""
    change = level - origin
    return ca.if_else(ca.fabs(change) <= ROUNDING * ca.fmax(1, ca.fabs(level)), 0, change)


@dataclass(frozen=True)
@show
class Overshoot(AbstractStepResponse):
    """The largest excursion beyond the new level after a jump, as a share of the jump."""

    remembers: ClassVar = ("level", "origin", "excess")
    signal: Signal = LEVELS

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory with the larger of the past and the present excursion."""
        actual, level = levels(self.signal, y)
        _, origin = jump(k, z, actual, level)
        size = height(origin, level)
        beyond = ca.if_else(size == 0, 0, (actual - level) / ca.if_else(size == 0, 1, size))
        return {"level": level, "origin": origin, "excess": ca.if_else(z["excess"] >= beyond, z["excess"], beyond)}

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The overshoot in percent."""
        return 100 * z["excess"]


@dataclass(frozen=True)
@check_arguments
class SettlingTime(AbstractStepResponse):
    """The longest time after a jump until the error stays within `band` times the jump; infinite if it never does."""

    remembers: ClassVar = ("level", "origin", "since", "outside", "looked", "longest")
    band: float
    signal: Signal = LEVELS

    def __post_init__(self) -> None:
        positive("SettlingTime(band=...)", self.band)

    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory after a step; at a jump the time of the last one is closed, infinite if it did not settle."""
        actual, level = levels(self.signal, y)
        jumped, origin = jump(k, z, actual, level)
        took = z["outside"] - z["since"]
        unsettled = z["outside"] >= z["looked"]  # which was a step ago, and steps may change their length
        closed = ca.if_else(k == 0, 0, ca.if_else(unsettled, NEVER, took))
        since = ca.if_else(jumped, k * h, z["since"])
        size = ca.fabs(height(origin, level))
        out = ca.logic_and(size > 0, ca.logic_not(ca.fabs(actual - level) <= self.band * size))
        return {
            "level": level,
            "origin": origin,
            "since": since,
            "outside": ca.if_else(out, k * h, ca.fmax(z["outside"], since)),
            "looked": ca.repmat(k * h, *level.shape),
            "longest": ca.if_else(jumped, ca.fmax(z["longest"], closed), z["longest"]),
        }

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The longest over all jumps, the last one included."""
        end = horizon * (1 - 1e-12)
        # outside at the last look, which is at the horizon: the last jump was not settled
        last = np.where(z["outside"] >= end, np.inf, z["outside"] - z["since"])
        # a jump at the horizon itself has had no time at all, and does not count
        last = np.where(z["since"] >= end, 0.0, last)
        longest = np.maximum(z["longest"], last)
        return np.where(longest >= NEVER, np.inf, longest)
