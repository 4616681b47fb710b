"""The estimates of a fit in studies: factors that keep their correlations, and blocks with the estimates in place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np
from scipy import stats

from workbench.core.number_replacement import replace_initial_states, replace_numbers
from workbench.core.validation.refusals import Array, finite, known_name
from workbench.engine.distributions import Normal
from workbench.engine.factors import Factor, FactorDirection
from workbench.identification.estimation.unknown_numbers import UnknownNumber

T = TypeVar("T")
UNMOVED = 1e-12  # standard errors: rounding of an axis in which a number has no part
BEYOND = 1e-3  # share of a normal distribution beyond the bounds of a number, from which it is no model of its doubt


def direction_factors(
    names: Sequence[str], theta: Array, covariance: Array, bounds: tuple[Array, Array], path: str, cut: float
) -> tuple[Factor, ...]:
    """Independent factors along the principal axes of the correlation of estimates theta (n,), the longest first.

    theta = estimate + D U sqrt(Lambda) z, with D the standard errors, U Lambda U' the correlation, and z standard
    normal numbers up to `cut`. `bounds` are (n,) each. A `path` is put before each name.
    """
    errors = np.sqrt(np.diag(covariance))
    sizes, axes = np.linalg.eigh(covariance / np.outer(errors, errors))
    axes = axes[:, ::-1] * np.sqrt(np.maximum(sizes[::-1], 0.0))
    axes = axes * np.sign(axes[np.argmax(np.abs(axes), axis=0), np.arange(len(errors))])
    changes = errors[:, np.newaxis] * np.where(np.abs(axes) < UNMOVED, 0.0, axes)
    _refuse_beyond(names, bounds, theta, errors, cut * np.abs(changes).sum(axis=1))
    paths = tuple(f"{path}{name}" for name in names)
    spread, centres = Normal(0.0, 1.0, -cut, cut), tuple(theta.tolist())
    ways = [FactorDirection(centres, tuple(column.tolist())) for column in changes.T]
    return tuple(
        Factor(f"direction {k}", paths, spread, "derived", direction=way) for k, way in enumerate(ways, start=1)
    )


def _refuse_beyond(
    names: Sequence[str], bounds: tuple[Array, Array], theta: Array, errors: Array, reach: Array
) -> None:
    """Refuse a normal distribution of which a share that matters lies beyond the bounds of a number."""
    for name, low, high, value, error, far in zip(names, *bounds, theta, errors, reach, strict=True):
        if low <= value - far and value + far <= high:
            continue
        with np.errstate(over="ignore"):
            share = float(stats.norm.cdf((low - value) / error) + stats.norm.sf((high - value) / error))
        if share > BEYOND:
            raise ValueError(
                f"`factors(...)` draws from a normal distribution, of which {100 * share:.3g} % lie beyond the "
                f"bounds of '{name}' ({value:.4g} +- {error:.2g}, from {low:g} to {high:g}): "
                "record more, take a smaller `cut`, or use the draws of `bootstrap`, which keep to the bounds."
            )


def refuse_no_parameter(names: Sequence[str]) -> None:
    """Refuse a fit that estimated no parameter of the system, or a choice that is empty or names one twice."""
    if not names or len(set(names)) < len(names):
        raise ValueError(
            "`factors(names=...)` needs at least one parameter that was estimated, each once; got "
            f"{len(names)} names for {len(set(names))}."
        )


NOT_OF_THE_SYSTEM = {
    "delay": "a delay of the log's input; give the loop `delay=...` in whole periods, or the plant a `PadeDelay`",
    "offset": "an error of the log's sensor, which no instrument of a loop has; a sweep measures true outputs",
    "scale": "an error of the log's sensor, which no instrument of a loop has; a sweep measures true outputs",
}


def refuse_numbers_of_the_log(numbers: Sequence[UnknownNumber]) -> None:
    """Refuse what is no number of the system: delays, offsets and scales, and a state of two experiments."""
    for number in numbers:
        if number.kind in NOT_OF_THE_SYSTEM:
            raise ValueError(
                f"`Fit.factors(names=...)` must name parameters and initial states, which a run of a loop has; "
                f"'{number.name}' is {NOT_OF_THE_SYSTEM[number.kind]}."
            )
        if several := [one.name for one in numbers if one.kind == "initial state" and one.label == number.label][1:]:
            raise ValueError(
                f"`Fit.factors(names=...)` must name the initial state '{number.label}' of one experiment, as a run "
                f"begins once; got '{several[0]}', too."
            )


def estimates_of(
    numbers: Sequence[UnknownNumber], theta: Array, values: Mapping[str, float], experiment: str | None
) -> tuple[dict[str, float], dict[str, float]]:
    """By path, parameters and the initial states of an experiment at the estimates theta (nz,), or at other `values`.

    Initial states are left out without an experiment.
    """
    for name, value in values.items():
        known_name(name, [number.name for number in numbers], "numbers of this fit")
        finite(f"apply(values={{{name!r}: ...}})", value)
    now = [(one, float(values.get(one.name, value))) for one, value in zip(numbers, theta, strict=True)]
    if experiment is not None:
        begun = dict.fromkeys(one.experiment for one in numbers if one.kind == "initial state")
        known_name(experiment, begun, "experiments with estimated initial states")
    return (
        {one.label: value for one, value in now if one.kind == "parameter"},
        {one.label: value for one, value in now if one.kind == "initial state" and one.experiment == experiment},
    )


def apply_initial_states(states: Mapping[str, float], target: T, path: str) -> T:
    """A block or an `Ode` with other initial states, whose names begin with `path`."""
    inside = {name.removeprefix(path): value for name, value in states.items() if name.startswith(path)}
    return replace_initial_states(target, inside) if inside else target


def apply_values(estimates: Mapping[str, float], target: T, values: Mapping[str, float], path: str) -> T:
    """A block or an `Ode` with the parameters of a fit whose names begin with `path`, or with other `values`."""
    own = dict(estimates)
    for name, value in values.items():
        known_name(name, own, "parameters of this fit")
        own[name] = finite(f"apply(values={{{name!r}: ...}})", value)
    inside = {name.removeprefix(path): value for name, value in own.items() if name.startswith(path)}
    if not inside:
        raise LookupError(
            f"`apply(path={path!r})` must be the path of a block with estimated parameters; those of this fit are "
            f"{', '.join(own) or 'none'}."
        )
    return replace_numbers(target, inside)
