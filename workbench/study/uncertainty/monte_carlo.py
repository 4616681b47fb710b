"""Monte Carlo and Latin hypercubes: points for distributions of the outputs, all factors at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.study.uncertainty.design import AbstractDesign, span, uniforms
from workbench.validation.refusals import Array, Integers, seed, whole
from workbench.validation.signatures import door


@dataclass(frozen=True)
@door
class MonteCarlo(AbstractDesign):
    """Independent uniform points: the ones to which confidence intervals of quantiles and of shares belong.

    A longer design of the same seed begins with the same points.

    Raises
    ------
    ValueError
        If there is no factor or no run, or if the seed is none.
    """

    dimensions: int
    runs: int
    seed: int = 0

    def __post_init__(self) -> None:
        _check(self)

    @property
    def size(self) -> int:
        """How many runs."""
        return self.runs

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1."""
        return uniforms(self.seed, *span(self, first, last), self.dimensions)


@dataclass(frozen=True)
@door
class LatinHypercube(AbstractDesign):
    """Random points with exactly one in each of `runs` equal slices of every axis.

    The variance of a mean over them is at most runs / (runs - 1) times that over independent points, for any
    function, and less the more the function is a sum of functions of one factor each.

    Raises
    ------
    ValueError
        If there is no factor or no run, or if the seed is none.

    References
    ----------
    McKay, Beckman and Conover (1979), Technometrics 21; Owen (1997), Monte Carlo variance of scrambled net
    quadrature, SIAM Journal on Numerical Analysis 34.
    """

    dimensions: int
    runs: int
    seed: int = 0

    def __post_init__(self) -> None:
        _check(self)

    @property
    def size(self) -> int:
        """How many runs."""
        return self.runs

    def points(self, first: int = 0, last: int | None = None) -> Array:
        """The points with the numbers first to last - 1."""
        first, last = span(self, first, last)
        within = uniforms(self.seed, first, last, self.dimensions)
        return np.asarray((self._slices[first:last] + within) / self.runs)

    @cached_property
    def _slices(self) -> Integers:
        """The slice of each point on each axis, (runs, dimensions): a random order an axis."""
        orders = np.tile(np.arange(self.runs), (self.dimensions, 1))
        return np.random.default_rng(self.seed).permuted(orders, axis=1).T


def _check(design: MonteCarlo | LatinHypercube) -> None:
    name = type(design).__name__
    whole(f"{name}(dimensions=...)", design.dimensions, of=" of factors")
    whole(f"{name}(runs=...)", design.runs, of=" of runs")
    seed(f"{name}(seed=...)", design.seed)
