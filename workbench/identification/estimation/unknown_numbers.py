"""Unknown numbers of a fit: parameters, initial states, delays of inputs, offsets and scales of sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from workbench.core import Ode
from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments
from workbench.identification.datasets import Dataset

Kind = Literal["parameter", "initial state", "delay", "offset", "scale"]


@dataclass(frozen=True)
@check_arguments
class UnknownNumber:
    """A number that a fit estimates.

    Parameters
    ----------
    name
        Its name in results: the path of a parameter, or as `omega(0)`, `delay of v` and `offset of omega`.
    kind
        The kind of number.
    label
        The parameter, state, input or output to which it belongs.
    experiment
        For an initial state, the experiment; else empty.
    start
        The value at which the search starts.
    low, high
        Its bounds.
    unit
        Its unit.
    """

    name: str
    kind: Kind
    label: str
    experiment: str
    start: float
    low: float
    high: float
    unit: str


@check_arguments
def parameter_numbers(ode: Ode, names: tuple[str, ...], start: Array) -> list[UnknownNumber]:
    """The numbers of some parameters, by path; `start` (np,) are all parameters of the equation."""
    units = [unit for entry in ode.parameters.entries for unit in entry.units]
    bounds = [entry.bounds.ends for entry in ode.parameters.entries for _ in range(entry.size)]
    numbers = []
    for name in names:
        for place in ode.parameters.indices(name):
            label = ode.parameters.labels[place]
            numbers.append(
                UnknownNumber(label, "parameter", label, "", float(start[place]), *bounds[place], units[place])
            )
    return numbers


@check_arguments
def initial_numbers(ode: Ode, names: tuple[str, ...], dataset: Dataset, start: Array) -> list[UnknownNumber]:
    """The numbers of some initial states, one for each experiment; `start` (E, nx) are all states at the begin."""
    units = [unit for entry in ode.states.entries for unit in entry.units]
    numbers = []
    for name in names:
        for place in ode.states.indices(name):
            label = ode.states.labels[place]
            for row, experiment in zip(start, dataset.names, strict=True):
                own = f"{label}(0)" if len(dataset.names) == 1 else f"{label}(0) of {experiment}"
                numbers.append(
                    UnknownNumber(
                        own, "initial state", label, experiment, float(row[place]), -np.inf, np.inf, units[place]
                    )
                )
    return numbers


@check_arguments
def sensor_numbers(
    kind: Kind, names: tuple[str, ...], outputs: tuple[str, ...], units: tuple[str, ...]
) -> list[UnknownNumber]:
    """The offsets, which start at 0, or the scales, which start at 1, of some sensors by the names of their outputs."""
    numbers = []
    for name in names:
        known_name(name, outputs, "outputs of this fit")
        unit = units[outputs.index(name)] if kind == "offset" else ""
        low = -np.inf if kind == "offset" else 0.0
        numbers.append(UnknownNumber(f"{kind} of {name}", kind, name, "", float(kind == "scale"), low, np.inf, unit))
    return numbers


@check_arguments
def delay_numbers(names: tuple[str, ...], inputs: tuple[str, ...]) -> list[UnknownNumber]:
    """The delays of some inputs in s, which start at 0 and are at least 0."""
    for name in names:
        known_name(name, inputs, "inputs of this fit")
    return [UnknownNumber(f"delay of {name}", "delay", name, "", 0.0, 0.0, np.inf, "s") for name in names]
