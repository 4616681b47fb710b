"""The estimates of a fit in studies: factors that keep their correlations, and blocks with the estimates in place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np
from scipy import stats

from workbench.core.number_replacement import replace_numbers
from workbench.core.validation.refusals import Array, finite, known_name, positive
from workbench.engine.distributions import Normal
from workbench.engine.factors import Factor, FactorDirection
from workbench.identification.estimation.unknown_numbers import UnknownNumber

T = TypeVar("T")
BEYOND = 1e-3  # share of a normal distribution beyond the bounds of a number, from which it is no model of its doubt


def direction_factors(
    numbers: Sequence[UnknownNumber], theta: Array, covariance: Array, path: str, cut: float
) -> tuple[Factor, ...]:
    """Independent factors along the principal axes of the correlation of estimates theta (n,), the longest first.

    theta = estimate + D U sqrt(Lambda) z, with D the standard errors, U Lambda U' the correlation, and z standard
    normal numbers up to `cut`. A `path` is put before each name.
    """
    errors = np.sqrt(np.diag(covariance))
    sizes, axes = np.linalg.eigh(covariance / np.outer(errors, errors))
    axes = axes[:, ::-1] * np.sqrt(np.maximum(sizes[::-1], 0.0))
    axes = axes * np.sign(axes[np.argmax(np.abs(axes), axis=0), np.arange(len(errors))])
    changes = errors[:, np.newaxis] * axes
    _refuse_beyond(numbers, theta, errors, cut * np.abs(changes).sum(axis=1))
    paths = tuple(f"{path}{number.name}" for number in numbers)
    spread, centres = Normal(0.0, 1.0, -cut, cut), tuple(theta.tolist())
    ways = [FactorDirection(centres, tuple(column.tolist())) for column in changes.T]
    return tuple(
        Factor(f"direction {k}", paths, spread, "derived", direction=way) for k, way in enumerate(ways, start=1)
    )


def _refuse_beyond(numbers: Sequence[UnknownNumber], theta: Array, errors: Array, reach: Array) -> None:
    """Refuse a normal distribution of which a share that matters lies beyond the bounds of a number."""
    for number, value, error, far in zip(numbers, theta, errors, reach, strict=True):
        if number.low <= value - far and value + far <= number.high:
            continue
        with np.errstate(over="ignore"):
            share = float(stats.norm.cdf((number.low - value) / error) + stats.norm.sf((number.high - value) / error))
        if share > BEYOND:
            raise ValueError(
                f"`Fit.factors(...)` draws from a normal distribution, of which {100 * share:.3g} % lie beyond the "
                f"bounds of '{number.name}' ({value:.4g} +- {error:.2g}, from {number.low:g} to {number.high:g}): "
                "record more, take a smaller `cut`, or use the draws of `bootstrap`, which keep to the bounds."
            )


def chosen_parameters(numbers: Sequence[UnknownNumber], names: Sequence[str] | None, cut: float) -> list[int]:
    """The places of the parameters of a system among the numbers of a fit, by default of all."""
    positive("Fit.factors(cut=...)", cut)
    known = {number.name: i for i, number in enumerate(numbers) if number.kind == "parameter"}
    places = [known[known_name(name, known, "parameters of this fit")] for name in (known if names is None else names)]
    if not places or len(set(places)) < len(places):
        raise ValueError(
            f"`Fit.factors(names=...)` needs at least one parameter that was estimated, each once; got {len(places)} "
            f"names for {len(set(places))} of {len(known)}."
        )
    return places


def apply_values(
    numbers: Sequence[UnknownNumber], theta: Array, target: T, values: Mapping[str, float], path: str
) -> T:
    """A block or an `Ode` with the parameters of a fit whose names begin with `path`, at theta or the `values`."""
    own = {n.name: float(v) for n, v in zip(numbers, theta, strict=True) if n.kind == "parameter"}
    for name, value in values.items():
        known_name(name, [number.name for number in numbers], "numbers of this fit")
        if name in own:
            own[name] = finite(f"Fit.apply(values={{{name!r}: ...}})", value)
    inside = {name.removeprefix(path): value for name, value in own.items() if name.startswith(path)}
    if not inside:
        raise LookupError(
            f"`Fit.apply(path={path!r})` must be the path of a block with estimated parameters; those of this fit are "
            f"{', '.join(own) or 'none'}."
        )
    return replace_numbers(target, inside)
