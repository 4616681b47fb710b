"""Knob: a number of the loops of a study that a reader of its page can turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from workbench.core import Layout, StepMap
from workbench.core.validation.refusals import Array, nearest, vector
from workbench.core.validation.signatures import check_arguments
from workbench.engine.distributions import LogUniform, Uniform
from workbench.engine.factors import Factor, Mark, Space
from workbench.study.design_knob import DesignKnob

TAILS = 0.005, 0.995  # quantiles where a distribution without ends is cut off


@dataclass(frozen=True)
@check_arguments
class Knob:
    """A number that a reader of the page can turn, from `low` to `high`, in all loops that have its path.

    Attributes
    ----------
    path
        A parameter or an initial state, as `controller.phi`, or a single number of one, as `controller.K[0]`; several
        as a tuple, of which each loop moves those that it has. A vector takes the same value at each of its places.
    log
        True for a scale of equal ratios.
    origin
        Where the number of the loop comes from; '' if this is not stated.
    share
        True if the knob is a factor of the loop's numbers, which keep their proportions; it starts at 1.

    Raises
    ------
    ValueError
        If there is no name or no path, or low is not below high, or a scale of ratios begins at zero or below.

    Examples
    --------
    >>> wb.Knob("friction", "plant.b", 0.01, 1.0, log=True).paths
    ('plant.b',)
    """

    name: str
    path: str | tuple[str, ...]
    low: float
    high: float
    log: bool = False
    origin: Mark | Literal[""] = "assumed"
    share: bool = False

    WAYS: ClassVar[Mapping[str, str]] = {"str": 'write `Knob("phi", "controller.phi", low, high)`'}

    def __post_init__(self) -> None:
        if not -np.inf < self.low < self.high < np.inf or (self.log and self.low <= 0):
            least = "0 < " if self.log else ""
            raise ValueError(
                f"`Knob({self.name!r}, low=..., high=...)` must be a range, {least}low < high; got {self.low:g} and "
                f"{self.high:g}."
            )
        _ = self.factor

    @staticmethod
    @check_arguments
    def of(factor: Factor) -> Knob:
        """The knob of a factor of a sweep, over the range of its distribution.

        Raises
        ------
        ValueError
            If the factor moves numbers along a direction, which a knob cannot.
        """
        if factor.direction is not None:
            raise ValueError(
                f"`Knob.of(factor)` must be a factor whose numbers are equal or keep their proportions; "
                f"'{factor.name}' moves {', '.join(factor.paths)} along a direction: make a knob for each of them."
            )
        low, high = factor.distribution.reach()
        ends = factor.distribution.quantile(np.array(TAILS))
        low, high = (float(end if np.isfinite(end) else tail) for end, tail in zip((low, high), ends, strict=True))
        log = isinstance(factor.distribution, LogUniform)
        return Knob(factor.name, factor.paths, low, high, log, factor.origin, factor.share)

    @check_arguments
    def together(self, other: Knob) -> Knob:
        """One knob with the paths and ranges of two knobs of the same name."""
        paths = tuple(dict.fromkeys((*other.paths, *self.paths)))
        return replace(self, path=paths, low=min(self.low, other.low), high=max(self.high, other.high))

    @property
    def paths(self) -> tuple[str, ...]:
        """The paths of the knob, as a tuple."""
        return (self.path,) if isinstance(self.path, str) else self.path

    @cached_property
    def factor(self) -> Factor:
        """The knob as a factor, spread over its range."""
        spread = LogUniform(self.low, self.high) if self.log else Uniform(self.low, self.high)
        return Factor(self.name, self.paths, spread, self.origin or "assumed", self.share)

    @check_arguments
    def places(self, step: StepMap) -> tuple[int, ...]:
        """The places that the knob moves in a row of parameters followed by states, for the paths that the loop has.

        Raises
        ------
        ValueError
            If the range of the knob leads beyond the bounds of a number.
        """
        if not (there := tuple(path for path in self.paths if has(step, path))):
            return ()
        space = Space((replace(self.factor, paths=there),), step.parameters, step.states)
        return tuple(int(place) for place in space.places[0])

    @check_arguments
    def value(self, step: StepMap, p: Array, x0: Array) -> float:
        """The value of the knob before it is turned, for parameters p and initial states x0; 1 for a share."""
        p = vector("Knob.value(p=...)", p, step.parameters.size, "parameters")
        x0 = vector("Knob.value(x0=...)", x0, step.states.size, "states")
        return 1.0 if self.share else float(np.concatenate([p, x0])[self.places(step)[0]])

    @check_arguments
    def numbers_at(self, value: float, own: Array) -> Array:
        """The numbers at the places of the knob for a value, where the loop's own are `own`."""
        own = np.asarray(own, dtype=float)
        return value * own if self.share else np.full(own.shape, float(value))

    @check_arguments
    def unit(self, step: StepMap) -> str:
        """The unit of the numbers that the knob moves; "1" for a share."""
        entries = (*step.parameters.entries, *step.states.entries)
        units = [unit for entry in entries for unit in entry.units]
        return "1" if self.share else ", ".join(dict.fromkeys(units[place] for place in self.places(step)))


def check(knobs: tuple[Knob | DesignKnob, ...], steps: Mapping[str, StepMap]) -> None:
    """Refuse two knobs of one name, and a path that no loop has.

    Raises
    ------
    ValueError
        If two knobs have one name.
    LookupError
        If no loop has any path of a knob; the message names the nearest.
    """
    names = [knob.name for knob in knobs]
    if len(set(names)) < len(names):
        raise ValueError(f"`Study(live=...)` needs knobs of distinct names; got {names}.")
    known = {name for step in steps.values() for name in _names(step)}
    for knob in knobs:
        if not known & {*knob.paths}:
            raise LookupError(
                f"`Study(live=...)`: there is no '{knob.paths[0]}', which the knob '{knob.name}' turns, in any of the "
                f"{len(steps)} live loops.{nearest(knob.paths[0], sorted(known))}"
            )


def has(step: StepMap, path: str) -> bool:
    """True if a loop has a parameter or a state of this path."""
    return path in _names(step)


def _names(step: StepMap) -> set[str]:
    layouts: tuple[Layout, ...] = (step.parameters, step.states)
    return {name for layout in layouts for name in (*layout.names, *layout.labels)}
