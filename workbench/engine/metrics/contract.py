"""The contract of a metric, and the checks that its methods obey it."""

from __future__ import annotations

import functools
import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, TypeVar

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.units import checked_unit, join_units, unit_of_each
from workbench.core.validation.refusals import Array, describe, several
from workbench.core.validation.signatures import answer, check_arguments
from workbench.core.validation.type_hints import KindError, fit_of
from workbench.engine.metrics.signal_choice import Signal, choose, column, names_of

Parts = Mapping[str, ca.SX]  # outputs of a loop, or the memory of a metric, by name


@dataclass(frozen=True)
@check_arguments
class AbstractMetric(ABC):
    """A metric: one number per run and component of a signal, with its name, unit and meaning (`about`).

    The arguments and answers of its methods are checked against the types and shapes stated here. A metric must define
    `value` and `watches`; by default it accumulates nothing.

    Attributes
    ----------
    unit
        If empty, the unit is that of the first output in `watches`. Several units are listed one by one, as in "m,
        rad".
    labels
        The names of the components that its numbers belong to, from the equation that it measures.
    """

    name: str
    unit: str
    about: str
    labels: tuple[str, ...] = field(default=(), kw_only=True)

    def __init_subclass__(cls) -> None:
        for name in ANSWERS.keys() & vars(cls).keys():
            own = vars(cls)[name]
            if not getattr(own, "__isabstractmethod__", False):
                setattr(cls, name, _faithful(name, own))
        cls.of = check_arguments(vars(cls).get("of", cls.of))  # type: ignore[method-assign]

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each of its numbers."""
        return unit_of_each(self.unit, len(self.labels))

    @property
    def is_time(self) -> bool:
        """True if the metric is a time, which is known to one step at best."""
        return self.unit == "s"

    @check_arguments
    def of(self, ode: Ode) -> AbstractMetric:
        """The metric for this equation: with the signals, the unit and the labels that it has there."""
        return bind_metric(self, watches(self)[0], ode)

    @property
    @abstractmethod
    def watches(self) -> tuple[str, ...]:
        """The names of the outputs that the metric uses; the first one has the size of the metric."""

    @property
    def grid(self) -> float | None:
        """The sample time of the metric in s, which every step must divide; None if it has none."""
        return None

    @check_arguments
    def check(self, ode: Ode, horizon: float) -> None:
        """Refuse an equation or a horizon [s] for which the metric is not defined."""
        del ode, horizon

    @check_arguments
    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """The integrand over time, (k, 1), or None."""
        return None

    @check_arguments
    def memory(self, size: int) -> Layout:
        """The states that the metric updates at each step, for a signal of `size` numbers."""
        return Layout()

    @check_arguments
    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory after the outputs y at time k h; the grid of the metric, if it has one, is a multiple of h."""
        return {}

    @abstractmethod
    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The metric (B, k) from the integral (B, k) and the memory at the horizon."""


NAMES = fit_of(tuple[str, ...])
A_COLUMN, A_LAYOUT, A_NONE = fit_of(ca.SX), fit_of(Layout), fit_of(type(None))
PARTS, ROWS = fit_of(Parts), fit_of(Array)


def watches(metric: AbstractMetric) -> tuple[str, ...]:
    """The outputs that a metric watches."""
    call, must = f"{type(metric).__name__}.watches", f"be a tuple of outputs, for the metric '{metric.name}'"
    return several(call, answer(call, must, lambda: metric.watches, NAMES), str, 1)


Own = TypeVar("Own", bound=AbstractMetric)


def bind_metric(metric: Own, signal: Signal, ode: Ode, measure: Callable[[str], str] = str, /, **parts: Signal) -> Own:
    """A metric of a signal of this equation, whose units are measured from those of the signal where it has none."""
    seen = choose(metric.name, signal, ode)
    units = [measure(unit) for unit in seen.units]
    unit = checked_unit(f"{type(metric).__name__}({metric.name}, unit=...)", metric.unit) or join_units(units)
    about = metric.about if metric.labels else metric.about.replace("{}", seen.words) + seen.remark  # said once
    changed: Callable[..., Own] = replace  # of fields that only the metric's own class has
    return changed(metric, unit=unit, about=about, labels=seen.labels, **parts)


def expression(value: object) -> ca.SX:
    """An expression (k, 1), for an answer that must be one."""
    column: ca.SX = A_COLUMN(value)
    if column.shape[1] != 1 or column.numel() == 0:
        raise KindError("", f"one of shape {column.shape}")
    return column


def _updates(result: object, k: object, h: object, z: Parts, y: object) -> Parts:
    updates: Parts = PARTS(result)
    came, wanted = ({name: part.shape for name, part in sorted(parts.items())} for parts in (updates, z))
    if came != wanted:
        raise KindError("", f"{describe(came)} where z has {describe(wanted)}")
    return updates


def _rows(result: object, integral: Array, *_: object) -> Array:
    rows: Array = ROWS(result)
    if rows.ndim != 2 or rows.shape[:1] != integral.shape[:1] or rows.size == 0:
        raise KindError("", f"an array of shape {rows.shape} where the integral has {integral.shape}")
    return rows


# What each method must give, in words, and what makes it fit, which sees the arguments too.
ANSWERS: dict[str, tuple[str, Callable[..., object]]] = {
    "check": ("raise a `ValueError` or give None", lambda given, *_: A_NONE(given)),
    "integrand": ("give an expression (k, 1) or None", lambda given, *_: None if given is None else expression(given)),
    "memory": ("give a `Layout`", lambda given, *_: A_LAYOUT(given)),
    "update": ("give an expression of the same shape for each name in z", _updates),
    "value": ("give numbers (B, k), a row for each run", _rows),
}
REFUSES = ("check", "integrand")  # may do so in their own words
OWN = "as_its_author_wrote_it"  # an attribute of a method with a door


def _faithful(name: str, own: Callable[..., object]) -> Callable[..., object]:
    """A method of a metric, wrapped so that answers and errors outside of the contract are refused."""
    must, fit = ANSWERS[name]
    contract = getattr(AbstractMetric, name)
    signature = inspect.signature(contract)

    @functools.wraps(contract, updated=())  # without the mark of an abstract method
    def method(*args: object, **kwargs: object) -> object:
        metric, *arguments = signature.bind(*args, **kwargs).args if kwargs else args
        assert isinstance(metric, AbstractMetric)
        call = f"{type(metric).__name__}.{name}"
        ask, fits = functools.partial(own, metric, *arguments), lambda given: fit(given, *arguments)
        return answer(call, f"{must}, for the metric '{metric.name}'", ask, fits, refuses=name in REFUSES)

    method.__qualname__, method.__doc__ = own.__qualname__, own.__doc__
    opened = check_arguments(method)
    setattr(opened, OWN, own)
    return opened


def value_as_written(metric: AbstractMetric) -> Callable[..., Array]:
    """The `value` of a metric as its author wrote it, whose arguments may be other things than arrays of doubles."""
    return functools.partial(getattr(metric.value, OWN), metric)


class AbstractSignalMetric(AbstractMetric):
    """A metric of one signal, in the unit of the signal or a derived one, with names for its memory.

    Examples
    --------
    >>> isinstance(wb.peak_error(), wb.metrics.AbstractSignalMetric), wb.peak_error().watches
    (True, ())
    """

    signal: Signal
    remembers: ClassVar[tuple[str, ...]] = ()

    @property
    def watches(self) -> tuple[str, ...]:
        """The signal and, if it is an error, its reference."""
        return names_of(self.signal)

    @check_arguments
    def of(self, ode: Ode) -> AbstractMetric:
        """The metric with its signal looked up in this equation."""
        seen = choose(self.name, self.signal, ode)
        return bind_metric(self, seen, ode, self.measured_in, signal=seen)

    @check_arguments
    def column_of(self, y: Mapping[str, ca.SX]) -> ca.SX:
        """The column of the signal, (k, 1), from the outputs y by name; an error is the output minus its reference."""
        return column(self.signal, y)

    @check_arguments
    def measured_in(self, unit: str) -> str:
        """The unit of the metric for a signal with this unit."""
        return unit

    def memory(self, size: int) -> Layout:
        """A zero for each number, under each name."""
        return Layout(tuple(Entry(name, np.zeros(size)) for name in self.remembers))


@dataclass(frozen=True)
@check_arguments
class Integral(AbstractMetric):
    """The metric finish(integral of g(t, y) dt, horizon), with the horizon in s.

    Attributes
    ----------
    g
        A function of the time and the outputs by name; if `signal` is given, of the time and its column e.
    signals
        The outputs that g uses, if no `signal` is given.
    measure
        A function from the units of the signals to the unit of the metric; without it, `unit` is taken.

    Examples
    --------
    >>> area = wb.metrics.Integral(
    ...     "area", "rad", "integral of omega", lambda t, y: y["omega"], lambda sum, until: sum, signals=("omega",)
    ... )
    >>> round(wb.measure(wb.open_loop(wb.DCMotor()), [area], until=1.0, h=1e-2).scores[0].pair[0], 3)
    0.0
    """

    g: Callable[..., ca.SX]
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

    @check_arguments
    def of(self, ode: Ode) -> AbstractMetric:
        """The metric with its signal looked up in this equation."""
        if self.signal is not None:
            seen = choose(self.name, self.signal, ode)
            return bind_metric(self, seen, ode, self.measure or str, signal=seen)
        if not self.signals:
            raise ValueError(f"The metric '{self.name}' has no signal: name at least one, `Integral(signals=('e',))`.")
        missing = [name for name in self.signals if name not in ode.outputs]
        if missing and self.measure is not None:
            raise LookupError(
                f"The metric '{self.name}' is of {' times '.join(map(repr, self.signals))}, and '{ode.name}' has no "
                f"'{missing[0]}': name a pair whose product is a power, as in `energy(power=('v', 'i'))`. It has: "
                f"{', '.join(ode.outputs.names) or 'none'}."
            )
        first, *others = [choose(self.name, name, ode) for name in self.signals]
        for other in others:
            if self.measure is not None and len(other.units) != len(first.units):
                raise ValueError(
                    f"The metric '{self.name}' takes its signals number by number; '{first.words}' has "
                    f"{len(first.units)} and '{other.words}' has {len(other.units)}: name two of one size."
                )
        if self.measure is None or self.unit:
            return bind_metric(self, first, ode)
        units = dict.fromkeys(map(self.measure, *(seen.units for seen in (first, *others))))
        return replace(bind_metric(self, first, ode), unit=", ".join(units))

    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """The integrand g."""
        e = y if self.signal is None else column(self.signal, y)
        must = f"be a function of (t, y) that gives an expression (k, 1), for the metric '{self.name}'"
        return answer("Integral(g=...)", must, lambda: self.g(t, e), expression)

    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The integral as `finish` turns it."""
        return self.finish(integral, horizon)
