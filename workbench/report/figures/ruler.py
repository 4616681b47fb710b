"""The ruler at one side of a panel: what it spans, where its marks are, and the numbers at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from matplotlib.ticker import Locator, LogFormatterSciNotation, LogLocator, MaxNLocator, ScalarFormatter

from workbench.report.figures.labels import NUMBER, block_of, unmarked
from workbench.report.figures.looks import SMALL_LETTERS
from workbench.study.document.curves import Array

PLAIN = (1e-3, 1e4)  # between these a short logarithmic ruler needs no powers of ten


@dataclass(frozen=True)
class Ticks:
    """Marks at their places with their numbers, and the power of ten that all numbers share.

    Names take the place of numbers where things are counted: they have no marks, and stand `upright` where they are
    too wide to stand side by side.
    """

    places: tuple[float, ...]
    numbers: tuple[str, ...]
    minor: tuple[float, ...] = ()
    power: str = ""
    named: bool = False
    upright: bool = False

    @property
    def width(self) -> float:
        """The width of the widest number, in points."""
        return max((block_of(number, SMALL_LETTERS).width for number in self.numbers), default=0.0)

    @property
    def depth(self) -> float:
        """The room that the numbers take below an abscissa, in points."""
        if not self.named:
            return NUMBER.height
        if not any(self.numbers):  # as the names stand below another panel
            return 0.0
        return self.width if self.upright else max(block_of(name, SMALL_LETTERS).height for name in self.numbers)


@dataclass(frozen=True)
class Ruler:
    """From low to high, on a linear or a logarithmic scale; with marks at `whole` numbers alone where it counts.

    With `names` it has a place for each of them, 0, 1, ..., and no numbers.
    """

    scale: Literal["linear", "log"]
    low: float
    high: float
    whole: bool = False
    names: tuple[str, ...] = ()

    @staticmethod
    def of_names(names: Sequence[str], downwards: bool = False, least: int = 0) -> Ruler:
        """A ruler with a place for each name, from the left, or from the top down, with room for so many at least."""
        first, last = -0.5, max(len(names), least) - 0.5
        low, high = (last, first) if downwards else (first, last)
        return Ruler("linear", low, high, names=tuple(names))

    @staticmethod
    def around(
        scale: Literal["linear", "log"],
        limits: tuple[float, float] | None,
        held: Sequence[npt.ArrayLike],
        margin: float,
    ) -> Ruler:
        """A ruler within its limits, or else around all finite numbers that it holds, with a margin at both ends."""
        if limits is not None:
            return Ruler(scale, *limits)
        numbers = np.concatenate([np.ravel(np.asarray(part, dtype=float)) for part in held])
        numbers = numbers[np.isfinite(numbers)]
        low, high = (float(numbers.min()), float(numbers.max())) if numbers.size else (1.0, 10.0)
        if high - low <= 1e-15 * max(abs(low), abs(high)):  # nothing to measure: some room around the only number
            reach = 0.05 * abs(high) or 0.05
            low, high = (low / 10, 10 * high) if scale == "log" else (low - reach, high + reach)
        bare, whole = Ruler(scale, low, high), bool(numbers.size and (numbers == np.round(numbers)).all())
        return Ruler(scale, bare._inverse(-margin), bare._inverse(1 + margin), whole)

    def share(self, numbers: npt.ArrayLike) -> Array:
        """Where numbers lie between low (0) and high (1)."""
        low, high, at = map(self._straight, (self.low, self.high, numbers))
        return np.asarray((at - low) / (high - low))

    def ticks(self, most: int, length: float = np.inf) -> Ticks:
        """Marks for as many numbers as there is room, at most 9; all names, on a ruler of a length in points."""
        if self.names:
            each = tuple(float(place) for place in range(len(self.names)))
            room = length / abs(self.high - self.low)
            wide = Ticks(each, self.names, named=True).width + 0.5 * SMALL_LETTERS > room
            return Ticks(each, self.names, named=True, upright=wide)
        formatter: Any = LogFormatterSciNotation() if self.scale == "log" else ScalarFormatter(useMathText=True)
        formatter.create_dummy_axis(minpos=self.low)
        formatter.axis.set_view_interval(self.low, self.high)
        places = self._within(_locator(self.scale, most, whole=self.whole))
        numbers = {
            place: unmarked(number) for place, number in zip(places, formatter.format_ticks(places), strict=True)
        }
        power = formatter.get_offset()
        fine = self._within(_locator("log", most, subs=range(2, 10))) if self.scale == "log" else []
        for place, number in zip(fine, formatter.format_ticks(fine), strict=True):
            if number:  # where a logarithmic ruler is short
                numbers[place] = number
        rest = tuple(place for place in fine if place not in numbers)
        if len(numbers) > len(places) and PLAIN[0] <= self.low < self.high <= PLAIN[1]:
            numbers = {place: f"{place:g}" for place in numbers}
        return Ticks(tuple(numbers), tuple(numbers.values()), rest, power)

    def _within(self, locator: Locator) -> list[float]:
        found = np.asarray(locator.tick_values(self.low, self.high))
        share = self.share(found)
        return [float(place) for place in found[(share > -1e-9) & (share < 1 + 1e-9)]]

    def _straight(self, numbers: npt.ArrayLike) -> Array:
        return np.log10(numbers) if self.scale == "log" else np.asarray(numbers, dtype=float)

    def _inverse(self, share: float) -> float:
        low, high = self._straight(self.low), self._straight(self.high)
        at = float(low + share * (high - low))
        return 10.0**at if self.scale == "log" else at


def _locator(scale: str, most: int, subs: Sequence[float] = (1.0,), whole: bool = False) -> Locator:
    most = max(1, min(most, 9))
    if scale == "log":
        return LogLocator(subs=subs, numticks=max(2, most))
    return MaxNLocator(nbins=most, steps=[1, 2, 2.5, 5, 10], integer=whole)
