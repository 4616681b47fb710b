"""What a metric must say of itself."""

from __future__ import annotations

import functools
import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from workbench.core import Layout, Ode
from workbench.validation.doors import answer, door
from workbench.validation.kinds import KindError, fit_of
from workbench.validation.words import Array, described

# Outputs of a loop, or the memory of a metric, by name.
Parts = Mapping[str, ca.SX]


@dataclass(frozen=True)
@door
class AbstractMetric(ABC):
    """A number per run and joint with its name and unit; without a unit it has that of the first output it watches.

    What its methods are given, and what they give, is held to the types and shapes stated here.
    """

    name: str
    unit: str
    about: str

    def __init_subclass__(cls) -> None:
        for name in ANSWERS.keys() & vars(cls).keys():
            own = vars(cls)[name]
            if not getattr(own, "__isabstractmethod__", False):
                setattr(cls, name, _faithful(name, own))

    @property
    @abstractmethod
    def watches(self) -> tuple[str, ...]:
        """The outputs that the metric looks at; the size of the first is that of the metric."""

    @property
    @abstractmethod
    def grid(self) -> float | None:
        """The sample time [s] of a grid of its own, which every step must divide; None without one."""

    @abstractmethod
    def check(self, ode: Ode, horizon: float) -> None:
        """Refuse an equation or a horizon [s] for which the metric means nothing."""

    @abstractmethod
    def integrand(self, t: ca.SX, y: Parts) -> ca.SX | None:
        """What is integrated over time, (k, 1), or None."""

    @abstractmethod
    def memory(self, joints: int) -> Layout:
        """What is updated at each step."""

    @abstractmethod
    def update(self, k: ca.SX, h: ca.SX, z: Parts, y: Parts) -> Parts:
        """The memory after looking at the outputs y at time k h; with a grid of its own, h divides it."""

    @abstractmethod
    def value(self, integral: Array, z: Mapping[str, Array], horizon: float) -> Array:
        """The metric (B, k) from the integral (B, k) and the memory at the horizon."""


A_COLUMN, PARTS, A_LAYOUT, ROWS, NOTHING = map(fit_of, (ca.SX, Parts, Layout, Array, type(None)))


def column(given: Any) -> ca.SX:
    """An expression (k, 1), for an answer that must be one."""
    expression: ca.SX = A_COLUMN(given)
    if expression.shape[1] != 1 or expression.numel() == 0:
        raise KindError("", f"one of shape {expression.shape}")
    return expression


def _updates(given: Any, k: Any, h: Any, z: Parts, y: Any) -> Parts:
    updates: Parts = PARTS(given)
    came, wanted = ({name: part.shape for name, part in sorted(parts.items())} for parts in (updates, z))
    if came != wanted:
        raise KindError("", f"{described(came)} where z has {described(wanted)}")
    return updates


def _rows(given: Any, integral: Array, *_: Any) -> Array:
    rows: Array = ROWS(given)
    if rows.ndim != 2 or rows.shape[:1] != integral.shape[:1] or rows.size == 0:
        raise KindError("", f"an array of shape {rows.shape} where the integral has {integral.shape}")
    return rows


# What each method must give, in words, and what makes it fit, which sees the arguments too.
ANSWERS: dict[str, tuple[str, Callable[..., Any]]] = {
    "check": ("raise a `ValueError` or give None", lambda given, *_: NOTHING(given)),
    "integrand": ("give an expression (k, 1) or None", lambda given, *_: None if given is None else column(given)),
    "memory": ("give a `Layout`", lambda given, *_: A_LAYOUT(given)),
    "update": ("give an expression of the same shape for each name in z", _updates),
    "value": ("give numbers (B, k), a row for each run", _rows),
}
REFUSES = ("check", "integrand")  # may do so in their own words


def _faithful(name: str, own: Callable[..., Any]) -> Callable[..., Any]:
    """A method of a metric that takes what the contract says, and refuses what it gives or raises beside that."""
    must, fit = ANSWERS[name]
    contract = getattr(AbstractMetric, name)
    signature = inspect.signature(contract)

    @functools.wraps(contract, updated=())  # without the mark of an abstract method
    def method(*args: Any, **kwargs: Any) -> Any:
        metric, *arguments = signature.bind(*args, **kwargs).args if kwargs else args
        call = f"{type(metric).__name__}.{name}"
        ask, fits = functools.partial(own, metric, *arguments), lambda given: fit(given, *arguments)
        return answer(call, f"{must}, for the metric '{metric.name}'", ask, fits, refuses=name in REFUSES)

    method.__qualname__, method.__doc__ = own.__qualname__, own.__doc__
    return door(method)
