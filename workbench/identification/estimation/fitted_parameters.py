"""Fitted parameters: estimates with their covariance, apart from their log; they go into studies, and into files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from workbench.core.validation.refusals import Array, describe, known_name, matrix, positive, vector, whole
from workbench.core.validation.refusals import seed as checked_seed
from workbench.core.validation.signatures import check_arguments
from workbench.engine.factors import Factor
from workbench.identification.estimation.fit_factors import (
    apply_values,
    direction_factors,
    refuse_no_parameter,
    refuse_numbers_of_the_log,
)
from workbench.identification.estimation.parameter_file import (
    LARGEST,
    ParameterFields,
    read_parameter_file,
    write_parameter_file,
)
from workbench.identification.estimation.unknown_numbers import UnknownNumber

T = TypeVar("T")
SYMMETRIC = 1e-12  # of the largest product of two standard errors: rounding of a covariance
MOST_PLANTS = 100_000


@dataclass(frozen=True, eq=False)
@check_arguments
class FittedParameters:
    """Parameters of a system as a log tells them: normal numbers with a mean, a covariance and bounds.

    `fit.parameters` makes them, and `from_file` reads what `save` wrote.

    Parameters
    ----------
    names, units
        The paths of the n parameters in the fitted system, and their units.
    centre
        (n,), the estimates.
    covariance
        (n, n), the covariance of the estimates, in products of the units.
    low, high
        (n,) each, the bounds of the parameters; the largest double, with its sign, where there is none.
    source
        The log from which they come, in words: the names of its experiments.
    warnings
        Sentences that speak against the fit.

    Raises
    ------
    ValueError
        If there is no parameter, a name comes twice, a size is wrong, a number is not finite, an estimate lies beyond
        its bounds, or the covariance is not symmetric and positive definite.

    Examples
    --------
    >>> names, units = ("J", "b"), ("kg m^2", "N m s/rad")
    >>> covariance = np.array([[1e-8, -5e-8], [-5e-8, 1e-6]])
    >>> numbers = wb.FittedParameters(names, units, np.array([0.01, 0.1]), covariance, np.zeros(2), np.full(2, 1e9))
    >>> numbers.save("motor.json")
    >>> wb.FittedParameters.from_file("motor.json").standard_errors
    {'J': 0.0001, 'b': 0.001}
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    centre: Array
    covariance: Array
    low: Array
    high: Array
    source: str = ""
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.names)
        if not n or len(set(self.names)) < n or not all(self.names) or len(self.units) != n:
            raise ValueError(
                "`FittedParameters(names=..., units=...)` must be the distinct paths of at least one parameter, and a "
                f"unit for each; got {describe(self.names)} with {len(self.units)} units."
            )
        centre = vector("FittedParameters(centre=...)", self.centre, n, "an estimate for each name")
        covariance = matrix("FittedParameters(covariance=...)", self.covariance, n, n)
        ends = [np.asarray(end, dtype=float) for end in (self.low, self.high)]
        if any(end.shape != (n,) for end in ends) or not ((ends[0] <= centre) & (centre <= ends[1])).all():
            raise ValueError(
                "`FittedParameters(low=..., high=...)` must be bounds (n,) around the estimates; got "
                f"{describe(self.low)} and {describe(self.high)} for {describe(centre)}."
            )
        errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        largest = np.outer(errors, errors)
        if not (errors > 0).all() or not (np.abs(covariance - covariance.T) <= SYMMETRIC * largest).all():
            raise ValueError(
                "`FittedParameters(covariance=...)` must be symmetric, with variances above 0, as a covariance of "
                f"estimates is; got {describe(covariance)}."
            )
        if np.linalg.eigvalsh(covariance / largest).min() <= 0:
            raise ValueError(
                "`FittedParameters(covariance=...)` must be positive definite; here a combination of the numbers has "
                "no variance above 0. Leave out a number that others determine."
            )

    @property
    def values(self) -> dict[str, float]:
        """The estimates by name."""
        return dict(zip(self.names, self.centre.tolist(), strict=True))

    @property
    def standard_errors(self) -> dict[str, float]:
        """The standard errors by name."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @check_arguments
    def select(self, names: Sequence[str]) -> FittedParameters:
        """Some of the parameters by name, with their covariance; a LookupError is raised for an unknown name."""
        refuse_no_parameter(names)
        at = [self.names.index(known_name(name, self.names, "parameters of this fit")) for name in names]
        some, units = tuple(self.names[i] for i in at), tuple(self.units[i] for i in at)
        square, low, high = self.covariance[np.ix_(at, at)], self.low[at], self.high[at]
        return FittedParameters(some, units, self.centre[at], square, low, high, self.source, self.warnings)

    @check_arguments
    def factors(self, names: Sequence[str] | None = None, *, path: str = "", cut: float = 4.0) -> tuple[Factor, ...]:
        """Factors of a sweep that draw the parameters together, with their covariance.

        Each is a standard normal number, cut off at `cut`, along a principal axis of the correlation: indices of a
        sweep are those of these directions. `path` is that of the fitted system in the loop, such as "plant.". A
        ValueError is raised if more than 0.1 % of the normal distribution lie beyond the bounds of a number.
        """
        some = self if names is None else self.select(names)
        positive("factors(cut=...)", cut)
        ends = some.low, some.high
        return direction_factors(some.names, some.centre, some.covariance, ends, path, cut)

    @check_arguments
    def plants(self, count: int, seed: int = 0, *, path: str = "", cut: float = 4.0) -> tuple[dict[str, float], ...]:
        """`count` draws of the parameters by name after `path`, as `wb.tune(plants=...)` takes them.

        They are draws of `factors`, with the same refusals.
        """
        count = whole("plants(count=...)", count, 1, MOST_PLANTS, " of draws")
        factors = self.factors(path=path, cut=cut)
        u = np.random.default_rng(checked_seed("plants(seed=...)", seed)).random((count, len(factors)))
        z = np.stack([factor.distribution.quantile(column) for factor, column in zip(factors, u.T, strict=True)])
        ways = [factor.direction for factor in factors if factor.direction is not None]
        draws = self.centre + z.T @ np.array([way.changes for way in ways])
        draws = np.clip(draws, self.low, self.high)  # of at most 0.1 % of the draws
        return tuple(dict(zip(factors[0].paths, row, strict=True)) for row in draws.tolist())

    @check_arguments
    def apply(self, target: T, *, values: Mapping[str, float] | None = None, path: str = "") -> T:
        """A block or an `Ode` with the estimates in place, or with other `values` by name.

        `path` is that of the block in the fitted system, such as "plant."; an unknown one raises a LookupError.
        """
        return apply_values(self.values, target, values or {}, path)

    @check_arguments
    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the parameters into a file in JSON, which `from_file` reads without any loss."""
        fields = ParameterFields(
            names=self.names,
            units=self.units,
            centre=self.centre,
            covariance=self.covariance,
            low=self.low,
            high=self.high,
            source=self.source,
            warnings=self.warnings,
        )
        write_parameter_file(path, fields)

    @staticmethod
    @check_arguments
    def from_file(path: str | os.PathLike[str]) -> FittedParameters:
        """The parameters of a file that `save` wrote.

        Raises
        ------
        LookupError
            If there is no such file.
        ValueError
            If it is no such file, or a field is missing, unknown or wrong.
        """
        return FittedParameters(**read_parameter_file(path))

    def __repr__(self) -> str:
        source = f" from {self.source}" if self.source else ""
        return f"<FittedParameters: {', '.join(self.names)}{source}>"


def fitted_parameters(
    numbers: Sequence[UnknownNumber],
    theta: Array,
    covariance: Array,
    source: str,
    warnings: tuple[str, ...],
    names: Sequence[str] | None = None,
) -> FittedParameters:
    """Numbers of the system among those of a fit, with estimates theta (nz,) and covariance (nz, nz).

    They are all parameters, or parameters and initial states by `names`; each has its path in the system.
    """
    places = {number.name: i for i, number in enumerate(numbers)}
    if names is None:
        at = [i for i, number in enumerate(numbers) if number.kind == "parameter"]
    else:
        at = [places[known_name(name, places, "numbers of this fit")] for name in names]
        refuse_numbers_of_the_log([numbers[i] for i in at])
    own = [numbers[i] for i in at]
    paths, units = tuple(number.label for number in own), tuple(number.unit for number in own)
    refuse_no_parameter(paths)
    low, high = np.clip(np.array([(number.low, number.high) for number in own]).T, -LARGEST, LARGEST)
    square = covariance[np.ix_(at, at)]
    return FittedParameters(paths, units, theta[at], (square + square.T) / 2, low, high, source, warnings)
