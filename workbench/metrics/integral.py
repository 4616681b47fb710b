"""Metrics that are integrals over time, carried along by the integrator of the loop itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import casadi as ca

from workbench.core import Ode
from workbench.metrics.contract import AbstractMetric, Parts, bound, expression
from workbench.metrics.signal_choice import Signal, column, names_of, watched
from workbench.validation.refusals import Array
from workbench.validation.signatures import answer, door
from workbench.validation.views import show


@dataclass(frozen=True)
@show
class Integral(AbstractMetric):
    """finish(integral of g(t, y) dt, horizon).

    Attributes
    ----------
    g
        Of the time and the outputs by name; where a `signal` is told, of the time and its column e.
    signals
        The outputs that g looks at, where no `signal` is told.
    measure
        The unit of the metric from those of its signals; without it, `unit` says it.
    """

    g: Callable[[ca.SX, Any], ca.SX]
    finish: Callable[[Array, float], Array]
    signals: tuple[str, ...] = ("e",)
    signal: Signal | None = None
    measure: Callable[..., str] | None = None

    @property
    def watches(self) -> tuple[str, ...]:
        """The outputs of g."""
        return self.signals if self.signal is None else names_of(self.signal)

    @property
    def is_time(self) -> bool:
        """True if its unit is declared as s, and not made from the unit of the signal."""
        return self.unit == "s" and self.measure is None

    @door
    def of(self, ode: Ode) -> AbstractMetric:
        """The metric with its signal as this equation has it."""
        if self.signal is not None:
            seen = watched(self.name, self.signal, ode)
            return bound(self, seen, ode, self.measure or str, signal=seen)
        missing = [name for name in self.signals if name not in ode.outputs]
        if missing and self.measure is not None:
            raise LookupError(
                f"The metric '{self.name}' is of {' times '.join(map(repr, self.signals))}, and '{ode.name}' has no "
                f"'{missing[0]}': name a pair whose product is a power, as in `energy(power=('v', 'i'))`. It has: "
                f"{', '.join(ode.outputs.names) or 'none'}."
            )
        first, *others = [watched(self.name, name, ode) for name in self.signals]
        for other in others:
            if self.measure is not None and len(other.units) != len(first.units):
                raise ValueError(
                    f"The metric '{self.name}' takes its signals number by number; '{first.words}' has "
                    f"{len(first.units)} and '{other.words}' has {len(other.units)}: name two of one size."
                )
        if self.measure is None or self.unit:
            return bound(self, first, ode)
        units = dict.fromkeys(map(self.measure, *(seen.units for seen in (first, *others))))
        return replace(bound(self, first, ode), unit=", ".join(units))

    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """The integrand g."""
        e = y if self.signal is None else column(self.signal, y)
        must = f"be a function of (t, y) that gives an expression (k, 1), for the metric '{self.name}'"
        return cast(ca.SX, answer("Integral(g=...)", must, lambda: self.g(t, e), expression))

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The integral as `finish` turns it."""
        return self.finish(integral, horizon)
