"""Designs: the points of the unit cube that the runs of a sample belong to."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from workbench.core.validation.refusals import Array, Integers, finite, refusal, seed, whole
from workbench.core.validation.signatures import check_arguments
from workbench.engine.distributions import MARGIN

WORDS = 4  # that one counter of Philox gives


class AbstractDesign(ABC):
    """A design: `size` points in the unit cube of `dimensions` factors, one per run."""

    dimensions: int

    @property
    @abstractmethod
    def size(self) -> int:
        """The number of runs."""

    @abstractmethod
    def _rows(self, first: int, last: int) -> Array:
        """The points with the numbers first to last - 1, (last - first, dimensions)."""

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1, (last - first, dimensions); by default all.

        Raises
        ------
        ValueError
            If 0 <= first <= last <= size does not hold.
        """
        begin = whole("points(first=...)", first, 0, self.size)
        return self._rows(begin, self.size if last is None else whole("points(last=...)", last, begin, self.size))


def uniforms(seed: int, first: int, last: int, width: int) -> Array:
    """Rows first to last - 1 of uniform numbers within the cube, (last - first, width), from seed and row number."""
    counters = -(-width // WORDS)
    bits = np.random.Philox(key=seed)
    bits.advance(first * counters)
    rows = np.random.Generator(bits).random((last - first, WORDS * counters))
    return np.clip(rows[:, :width], MARGIN, 1 - MARGIN)


@dataclass(frozen=True, eq=False)
@check_arguments
class NominalPoint(AbstractDesign):
    """The one point of the unit cube of no factor: a run with the numbers of its loop."""

    dimensions: int = field(default=0, init=False)

    @property
    def size(self) -> int:
        """The number of runs."""
        return 1

    def _rows(self, first: int, last: int) -> Array:
        return np.empty((last - first, 0))


@dataclass(frozen=True, eq=False)
@check_arguments
class ListedPoints(AbstractDesign):
    """The points (N, d) of the unit cube as they are given.

    Raises
    ------
    ValueError
        If there are no points, or they are not in the unit cube.

    Examples
    --------
    >>> from workbench.study.uncertainty import ListedPoints
    >>> ListedPoints([[0.5, 0.25], [0.0, 1.0]]).points()
    array([[0.5 , 0.25],
           [0.  , 1.  ]])
    """

    listed_points: Array
    dimensions: int = field(init=False)

    def __post_init__(self) -> None:
        points = self.listed_points
        if points.ndim != 2 or not points.size or not ((points >= 0) & (points <= 1)).all():
            raise refusal("ListedPoints(listed_points)", "at least one point (N, d) of the unit cube", points)
        object.__setattr__(self, "listed_points", points.copy())
        object.__setattr__(self, "dimensions", points.shape[1])

    @property
    def size(self) -> int:
        """The number of runs."""
        return len(self.listed_points)

    def _rows(self, first: int, last: int) -> Array:
        return self.listed_points[first:last]


@dataclass(frozen=True)
@check_arguments
class OneAtATime(AbstractDesign):
    """The point where all factors have the quantile `base`, then each factor by itself at each of `levels`.

    Point 0 is the base, and point 1 + i k + j has factor i at level j of k. The design says nothing about interactions.

    Raises
    ------
    ValueError
        If there is no factor or no level, or if a level or the base is not a quantile from 0 to 1, or levels repeat.

    Examples
    --------
    >>> from workbench.study.uncertainty import OneAtATime
    >>> OneAtATime(2, (0.05, 0.95), 0.5).points()
    array([[0.5 , 0.5 ],
           [0.05, 0.5 ],
           [0.95, 0.5 ],
           [0.5 , 0.05],
           [0.5 , 0.95]])
    """

    dimensions: int
    levels: tuple[float, ...] = (0.05, 0.95)
    base: float = 0.5

    def __post_init__(self) -> None:
        whole("OneAtATime(dimensions=...)", self.dimensions, of=" of factors")
        for quantile in (*self.levels, self.base):
            finite("OneAtATime(levels=..., base=...)", quantile, ", a quantile", low=0, high=1)
        if not self.levels or len(set(self.levels)) < len(self.levels):
            raise refusal("OneAtATime(levels=...)", "different quantiles, at least one", self.levels)

    @property
    def size(self) -> int:
        """The number of runs: the base, and each level of each factor."""
        return 1 + self.dimensions * len(self.levels)

    def _rows(self, first: int, last: int) -> Array:
        rows = np.full((last - first, self.dimensions), self.base)
        moved = np.arange(max(first, 1), last)
        factor, level = np.divmod(moved - 1, len(self.levels))
        rows[moved - first, factor] = np.array(self.levels)[level]
        return rows


@dataclass(frozen=True)
@check_arguments
class MonteCarlo(AbstractDesign):
    """Independent uniform points: the ones to which confidence intervals of quantiles and of shares belong.

    A longer design of the same seed begins with the same points.

    Raises
    ------
    ValueError
        If there is no factor or no run, or if the seed is not a seed.

    Examples
    --------
    >>> from workbench.study.uncertainty import MonteCarlo
    >>> MonteCarlo(2, 24, 3).points().shape
    (24, 2)
    """

    dimensions: int
    runs: int
    seed: int = 0

    def __post_init__(self) -> None:
        _check_random(self, "runs", self.runs, 1)

    @property
    def size(self) -> int:
        """The number of runs."""
        return self.runs

    def _rows(self, first: int, last: int) -> Array:
        return uniforms(self.seed, first, last, self.dimensions)


@dataclass(frozen=True)
@check_arguments
class LatinHypercube(AbstractDesign):
    """Random points with exactly one in each of `runs` equal slices of every axis.

    The variance of a mean over them is at most runs / (runs - 1) times the variance over independent points (Owen). It
    is less, the more the function is a sum of functions of one factor each (McKay, Beckman and Conover).

    Raises
    ------
    ValueError
        If there is no factor or no run, or if the seed is not a seed.

    References
    ----------
    Owen (1997), SIAM Journal on Numerical Analysis 34.
    McKay, Beckman and Conover (1979), Technometrics 21.

    Examples
    --------
    >>> wb.study.LatinHypercube(2, 24, 3).points().shape
    (24, 2)
    """

    dimensions: int
    runs: int
    seed: int = 0

    def __post_init__(self) -> None:
        _check_random(self, "runs", self.runs, 1)

    @property
    def size(self) -> int:
        """The number of runs."""
        return self.runs

    def _rows(self, first: int, last: int) -> Array:
        within = uniforms(self.seed, first, last, self.dimensions)
        return np.asarray((self._slices[first:last] + within) / self.runs)

    @cached_property
    def _slices(self) -> Integers:
        """The slice of each point on each axis, (runs, dimensions): a random order an axis."""
        orders = np.tile(np.arange(self.runs), (self.dimensions, 1))
        return np.random.default_rng(self.seed).permuted(orders, axis=1).T


@dataclass(frozen=True)
@check_arguments
class MorrisDesign(AbstractDesign):
    """A design of `trajectories` random paths over a grid of p = `levels` levels per axis.

    From one of the dimensions + 1 points of a path to the next a single factor moves, up or down, by
    delta = p / (2 (p - 1)). Run k (dimensions + 1) + j is point j of path k. The levels include 0 and 1, so a factor
    must be bounded.

    Raises
    ------
    ValueError
        If there is no factor, less than two trajectories or an odd number of levels, or if the seed is not a seed.

    References
    ----------
    Morris (1991), Technometrics 33.

    Examples
    --------
    >>> from workbench.study.uncertainty import MorrisDesign
    >>> MorrisDesign(2, 8, 4, 3).points().shape
    (24, 2)
    """

    dimensions: int
    trajectories: int
    levels: int = 4
    seed: int = 0

    def __post_init__(self) -> None:
        _check_random(self, "trajectories", self.trajectories, 2)
        if whole("MorrisDesign(levels=...)", self.levels, 2) % 2:
            raise refusal("MorrisDesign(levels=...)", "even, so that half of them can step up", self.levels)

    @property
    def size(self) -> int:
        """The number of runs."""
        return self.trajectories * (self.dimensions + 1)

    @property
    def delta(self) -> float:
        """The distance by which a factor moves, in the unit cube."""
        return self.levels / (2 * (self.levels - 1))

    def _rows(self, first: int, last: int) -> Array:
        d, length = self.dimensions, self.dimensions + 1
        begin, end = first // length, -(-last // length)
        drawn = uniforms(self.seed, begin, end, 3 * d).reshape(end - begin, 3, 1, d)
        lower = np.floor(drawn[:, 0] * (self.levels // 2)) / (self.levels - 1)
        rises = drawn[:, 1] < 0.5
        turn = np.argsort(np.argsort(drawn[:, 2], axis=-1), axis=-1)  # when each factor moves
        moved = turn < np.arange(length)[:, np.newaxis]
        rows = lower + self.delta * (moved == rises)
        # delta and the levels are rounded by themselves: the upmost level may end beyond 1
        rows = np.minimum(rows.reshape(-1, d), 1.0)
        return np.asarray(rows[first - begin * length : last - begin * length])


def _check_random(design: MonteCarlo | LatinHypercube | MorrisDesign, name: str, count: int, least: int) -> None:
    kind = type(design).__name__
    whole(f"{kind}(dimensions=...)", design.dimensions, of=" of factors")
    whole(f"{kind}({name}=...)", count, least)
    seed(f"{kind}(seed=...)", design.seed)
