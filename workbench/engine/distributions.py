"""Distributions of uncertain numbers, by their quantiles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import MISSING, dataclass, fields, is_dataclass
from math import inf, log
from typing import ClassVar

import numpy as np

from workbench.core.validation.refusals import Array, finite, numbers, positive
from workbench.core.validation.signatures import check_arguments

# No random point comes nearer to a face of the cube, where a normal number would be infinite: the middle of the outer
# one of 2^30 cells, which is all that a Sobol sequence of 30 bits can tell apart.
MARGIN = 2.0**-31
LEAST_SHARE = 1e-9  # of a bell between its cuts


class AbstractDistribution(ABC):
    """A distribution of a number between `low` and `high`, by its quantiles; `WORDS` is the template of `words`.

    Examples
    --------
    >>> isinstance(wb.Uniform(0.0, 1.0), wb.uncertainty.AbstractDistribution)
    True
    """

    WORDS: ClassVar[str]
    low: float
    high: float

    @abstractmethod
    def _formula(self, u: Array) -> Array:
        """The quantiles u, of the same shape, but for rounding at the ends."""

    def quantile(self, u: Array) -> Array:
        """The values that are not exceeded with the probabilities u from 0 to 1; 0 and 1 give the very ends.

        Raises
        ------
        ValueError
            If `u` holds a number that is not a probability.
        """
        u = numbers(f"{type(self).__name__}.quantile(u)", u)
        if not ((u >= 0) & (u <= 1)).all():
            raise ValueError(f"`{type(self).__name__}.quantile(u)` takes probabilities from 0 to 1; got others.")
        values = np.clip(self._formula(u), self.low, self.high)
        values = np.where((u == 0) & (self.low > -inf), self.low, values)
        return np.where((u == 1) & (self.high < inf), self.high, values)

    def words(self) -> str:
        """The distribution as a table prints it."""
        low = f", from {self.low:g} on" if self.low > -inf else ""
        cuts = f"{low}, up to {self.high:g}" if self.high < inf else low
        return self.WORDS.format(**vars(self), cuts=cuts)

    def reach(self) -> tuple[float, float]:
        """The least and the largest value that a design samples: the ends, or its outermost points if infinite."""
        least, largest = self.quantile(np.array([MARGIN, 1 - MARGIN]))
        return (
            self.low if self.low > -inf else float(least),
            self.high if self.high < inf else float(largest),
        )


@dataclass(frozen=True)
@check_arguments
class Uniform(AbstractDistribution):
    """A uniform distribution: all numbers from `low` to `high` are equally likely.

    Raises
    ------
    ValueError
        If the range is reversed, empty or not finite.

    Examples
    --------
    >>> wb.Uniform(1.0, 1.5).quantile(np.array([0.0, 0.5, 1.0]))
    array([1.  , 1.25, 1.5 ])
    """

    WORDS = "uniform, {low:g} to {high:g}"
    low: float
    high: float

    def __post_init__(self) -> None:
        _check(self)

    def _formula(self, u: Array) -> Array:
        return np.asarray(self.low * (1 - u) + self.high * u)


@dataclass(frozen=True)
@check_arguments
class LogUniform(AbstractDistribution):
    """A number whose logarithm is uniform, from `low` > 0 to `high`, for numbers known by their order of magnitude.

    Raises
    ------
    ValueError
        If the range is reversed, empty, not finite or not positive.

    Examples
    --------
    >>> wb.LogUniform(0.01, 1.0).quantile(np.array([0.0, 0.5, 1.0])).round(2)
    array([0.01, 0.1 , 1.  ])
    """

    WORDS = "log-uniform, {low:g} to {high:g}"
    low: float
    high: float

    def __post_init__(self) -> None:
        _check(self, above_zero=("low",))

    def _formula(self, u: Array) -> Array:
        """low^(1 - u) high^u."""
        return np.asarray(np.exp(log(self.low) * (1 - u) + log(self.high) * u))


@dataclass(frozen=True)
@check_arguments
class Triangular(AbstractDistribution):
    """A number from `low` to `high` whose density rises to `mode` and falls from there, by straight lines.

    Raises
    ------
    ValueError
        If the range is reversed, empty or not finite, or if the mode is not within it.

    Examples
    --------
    >>> wb.uncertainty.Triangular(0.0, 1.0, 2.0).quantile(0.5).round(6)
    np.float64(1.0)
    """

    WORDS = "triangular, {low:g} to {high:g}, mode {mode:g}"
    low: float
    mode: float
    high: float

    def __post_init__(self) -> None:
        _check(self)
        finite("Triangular(mode=...)", self.mode, low=self.low, high=self.high)

    def _formula(self, u: Array) -> Array:
        """On the rising line below the probability of the mode, on the falling line above it."""
        width, left, right = self.high - self.low, self.mode - self.low, self.high - self.mode
        rising = self.low + np.sqrt(u * width) * left**0.5
        falling = self.high - np.sqrt((1 - u) * width) * right**0.5
        return np.asarray(np.where(u * width < left, rising, falling))


@dataclass(frozen=True)
@check_arguments
class Normal(AbstractDistribution):
    """A normal number, cut off at `low` and `high` if given; `mean` and `deviation` are those before the cut.

    Raises
    ------
    ValueError
        If a number is not finite, the deviation is not positive, the range is reversed or empty, or lies so far out
        in a tail that less than 1e-9 of the numbers are within it.

    Examples
    --------
    >>> wb.uncertainty.Normal(2.0, 0.1).quantile(0.5).round(6)
    np.float64(2.0)
    """

    WORDS = "normal, mean {mean:g}, deviation {deviation:g}{cuts}"
    mean: float
    deviation: float
    low: float = -inf
    high: float = inf

    def __post_init__(self) -> None:
        _check(self, above_zero=("deviation",))
        _check_cut(self, *self._z())

    def _formula(self, u: Array) -> Array:
        return np.asarray(self.mean + self.deviation * _bell(u, *self._z()))

    def _z(self) -> tuple[float, float]:
        return (self.low - self.mean) / self.deviation, (self.high - self.mean) / self.deviation


@dataclass(frozen=True)
@check_arguments
class LogNormal(AbstractDistribution):
    """A positive number whose logarithm is normal with deviation `sigma`, cut off at `low` and `high` if given.

    Without a cut half of the numbers are below `median`.

    Raises
    ------
    ValueError
        If median, sigma or a cut is not positive, a number is not finite, the range is reversed or empty, or lies so
        far out in a tail that less than 1e-9 of the numbers are within it.

    Examples
    --------
    >>> wb.uncertainty.LogNormal(2.0, 0.1).quantile(0.5).round(6)
    np.float64(2.0)
    """

    WORDS = "lognormal, median {median:g}, sigma {sigma:g}{cuts}"
    median: float
    sigma: float
    low: float = -inf
    high: float = inf

    def __post_init__(self) -> None:
        _check(self, above_zero=("median", "sigma", "low", "high"))
        _check_cut(self, *self._z())

    def _formula(self, u: Array) -> Array:
        with np.errstate(over="ignore"):  # the quantile 1 of a bell without a cut is infinite
            return np.asarray(self.median * np.exp(self.sigma * _bell(u, *self._z())))

    def _z(self) -> tuple[float, float]:
        low = log(self.low / self.median) / self.sigma if self.low > -inf else -inf
        return low, log(self.high / self.median) / self.sigma if self.high < inf else inf


def _bell(u: Array, low: float, high: float) -> Array:
    """Quantiles of the standard normal distribution between two cuts, to full accuracy in both tails."""
    from scipy.special import ndtr, ndtri  # costs a fifth of a second, and only those who cut or draw a bell

    if low > 0:  # the upper tail is the lower one mirrored, where a probability keeps its digits
        return -_bell(1 - u, -high, -low)
    return np.asarray(ndtri(ndtr(low) * (1 - u) + ndtr(high) * u))


def _check(distribution: AbstractDistribution, above_zero: tuple[str, ...] = ()) -> None:
    """Refuse numbers that are not finite, but for open ends, or not positive where they must be, and an empty range."""
    kind = type(distribution).__name__
    given: object = distribution
    for field in fields(given) if is_dataclass(given) else ():
        value = getattr(distribution, field.name)
        if field.default is MISSING or value != field.default:
            (positive if field.name in above_zero else finite)(f"{kind}({field.name}=...)", value)
    low, high = distribution.low, distribution.high
    if not low < high or (high < inf and low > -inf and high - low == inf):
        why = (
            "an empty range, which varies nothing" if low == high else "a reversed range" if low > high else "too wide"
        )
        raise ValueError(
            f"`{kind}(low=..., high=...)` must be a range with low < high; got {low:.17g} and {high:.17g}: {why}."
        )


def _check_cut(distribution: AbstractDistribution, low: float, high: float) -> None:
    """Refuse cuts of a bell between which hardly anything is left, given in deviations from its middle."""
    from scipy.special import ndtr

    left = float(ndtr(-low) - ndtr(-high) if low + high > 0 else ndtr(high) - ndtr(low))
    if not left >= LEAST_SHARE:
        raise ValueError(
            f"`{type(distribution).__name__}(low=..., high=...)` must keep at least {LEAST_SHARE:g} of the bell, which "
            f"is computed to that accuracy; between {distribution.low:g} and {distribution.high:g} lies {left:.1e}."
        )
