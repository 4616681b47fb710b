"""Parameters that a filter estimates with the state, as random walks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from workbench.core import Entry, Layout, Ode
from workbench.core.validation.refusals import Array, finite
from workbench.core.validation.signatures import check_arguments


@dataclass(frozen=True)
@check_arguments
class ParameterWalk:
    """A parameter that is estimated with the state, p' = w: unknown at first, and constant or slowly changing.

    Parameters
    ----------
    variance
        The variance of the parameter before the first sample, in its unit squared.
    intensity
        The intensity of w, in its unit squared per second; 0 for a constant.
    start
        The mean before the first sample; by default the value in the parameters of the model.

    Raises
    ------
    ValueError
        If the variance is not positive, or the intensity is negative.
    """

    variance: float
    intensity: float = 0.0
    start: float | None = None

    def __post_init__(self) -> None:
        if not finite("ParameterWalk(variance=...)", self.variance) > 0:
            raise ValueError(
                f"`ParameterWalk(variance=...)` must be positive, or nothing is estimated; got {self.variance:g}."
            )
        finite("ParameterWalk(intensity=...)", self.intensity, low=0.0)
        if self.start is not None:
            finite("ParameterWalk(start=...)", self.start)


@check_arguments
def with_walks(ode: Ode, names: Iterable[str]) -> Ode:
    """The same equations with some parameters as states behind the others, p' = 0.

    Raises
    ------
    LookupError
        If there is no such parameter.
    ValueError
        If a parameter is an input, or is named twice.
    """
    names = list(names)
    if not names:
        return ode
    labels = [ode.parameters.labels[place] for name in names for place in ode.parameters.indices(name)]
    inputs = {ode.parameters.labels[place] for name in ode.inputs for place in ode.parameters.indices(name)}
    for label in labels:
        if label in inputs or labels.count(label) > 1:
            why = "is an input, which the log gives" if label in inputs else "came twice"
            raise ValueError(f"`walks` must name different parameters that are no inputs; '{label}' {why}.")
    numbers, places = [], [ode.parameters.labels.index(label) for label in labels]
    for entry in ode.parameters.entries:
        divided = entry.shape and set(entry.labels()) & set(labels)
        numbers += _divided(entry) if divided else [entry]
    by_name = {entry.name: entry for entry in numbers}
    rest = [place for place in range(ode.parameters.size) if place not in places]
    return replace(
        ode,
        states=ode.states + Layout(tuple(by_name[label] for label in labels)),
        parameters=Layout(tuple(entry for entry in numbers if entry.name not in labels)),
        x=ca.vertcat(ode.x, ode.p[places]),
        p=ode.p[rest] if rest else ca.SX(0, 1),
        rate=ca.vertcat(ode.rate, ca.SX.zeros(len(places))),
    )


def _divided(entry: Entry) -> list[Entry]:
    """A vector or matrix as its numbers."""
    values = entry.default.ravel(order="F")
    return [
        replace(entry, name=label, default=np.array(value), unit=unit)
        for label, value, unit in zip(entry.labels(), values, entry.units, strict=True)
    ]


def starts_of(ode: Ode, walks: Mapping[str, ParameterWalk], p: Array) -> tuple[list[float], list[float], list[float]]:
    """Mean, variance and intensity of each number of the parameters."""
    means, variances, intensities = [], [], []
    for name, walk in walks.items():
        for place in ode.parameters.indices(name):
            means.append(float(p[place]) if walk.start is None else walk.start)
            variances.append(walk.variance)
            intensities.append(walk.intensity)
    return means, variances, intensities
