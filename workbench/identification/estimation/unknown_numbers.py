"""Unknown numbers of a fit: parameters, initial states, delays of inputs, offsets and scales of sensors.

Their names are the paths of parameters, and `omega(0)`, `delay of v`, `offset of omega` and `scale of omega`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from workbench.core import Ode
from workbench.core.validation.refusals import Array, known_name
from workbench.core.validation.signatures import check_arguments

Kind = Literal["parameter", "initial state", "delay", "offset", "scale"]


SENSOR_OR_DELAY = re.compile(r"(delay|offset|scale) of (.+)")
CLOSE = 1e-6  # relative distance to a bound that is none
INITIAL = re.compile(r"(.+)\(0\)")


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

    def is_at_bound(self, value: float) -> bool:
        """True if a value lies on a bound of the number, or nearer than rounding of a search tells."""
        size = max(abs(value), abs(self.start), 1e-300)
        return min(abs(value - self.low), abs(self.high - value)) <= CLOSE * size


@dataclass(frozen=True, eq=False)
class NumberSource:
    """A system with its values at the start, and the signals of a log, which together have all unknown numbers.

    `units` are those of the outputs by label, and `first` values of delays, offsets and scales by name, such as
    "delay of v", that differ from 0 and 1.
    """

    ode: Ode
    p: Array  # (np,)
    x0: Array  # (E, nx)
    experiments: tuple[str, ...]
    inputs: tuple[str, ...]
    units: Mapping[str, str]
    first: Mapping[str, float]
    call: str = "fit"  # in whose name a refusal speaks

    def numbers(self, names: Sequence[str]) -> tuple[UnknownNumber, ...]:
        """The numbers of some names; a name of a vector or matrix has one for each entry.

        Raises
        ------
        LookupError
            If a name is unknown.
        ValueError
            If there is none, or a number is named twice.
        """
        numbers = [number for name in names for number in self._of(name)]
        if not numbers:
            raise ValueError(f"`{self.call}(free=...)` must name at least one unknown number; got none.")
        every = [number.name for number in numbers]
        if twice := sorted({name for name in every if every.count(name) > 1}):
            raise ValueError(f"`{self.call}(free=...)` must name each number once; {twice[0]!r} came more than once.")
        return tuple(numbers)

    def _of(self, name: str) -> list[UnknownNumber]:
        if part := SENSOR_OR_DELAY.fullmatch(name):
            return [self._delay(part[2])] if part[1] == "delay" else [self._sensor(part[1], part[2])]
        if part := INITIAL.fullmatch(name):
            return self._initial(part[1])
        units = [unit for entry in self.ode.parameters.entries for unit in entry.units]
        bounds = [entry.bounds.ends for entry in self.ode.parameters.entries for _ in range(entry.size)]
        numbers = []
        for place in self.ode.parameters.indices(name):
            label = self.ode.parameters.labels[place]
            start = float(self.p[place])
            numbers.append(UnknownNumber(label, "parameter", label, "", start, *bounds[place], units[place]))
        return numbers

    def _initial(self, state: str) -> list[UnknownNumber]:
        """The initial values of a state, in each experiment by itself."""
        units = [unit for entry in self.ode.states.entries for unit in entry.units]
        numbers = []
        for place in self.ode.states.indices(state):
            label = self.ode.states.labels[place]
            for row, experiment in zip(self.x0, self.experiments, strict=True):
                name = f"{label}(0)" if len(self.experiments) == 1 else f"{label}(0) of {experiment}"
                start, inf = float(row[place]), np.inf
                numbers.append(UnknownNumber(name, "initial state", label, experiment, start, -inf, inf, units[place]))
        return numbers

    def _sensor(self, kind: str, output: str) -> UnknownNumber:
        known_name(output, self.units, f"outputs of `{self.call}(...)`")
        name = f"{kind} of {output}"
        if kind == "offset":
            start = self.first.get(name, 0.0)
            return UnknownNumber(name, "offset", output, "", start, -np.inf, np.inf, self.units[output])
        return UnknownNumber(name, "scale", output, "", self.first.get(name, 1.0), 0.0, np.inf, "")

    def _delay(self, signal: str) -> UnknownNumber:
        known_name(signal, self.inputs, f"inputs of `{self.call}(...)`")
        name = f"delay of {signal}"
        return UnknownNumber(name, "delay", signal, "", self.first.get(name, 0.0), 0.0, np.inf, "s")


def with_bounds(
    call: str, numbers: Sequence[UnknownNumber], bounds: Mapping[str, tuple[float, float]]
) -> tuple[UnknownNumber, ...]:
    """The numbers with narrower bounds of a call by name; a ValueError if a start lies beyond them."""
    names = [number.name for number in numbers]
    for name, ends in bounds.items():
        known_name(name, names, f"unknown numbers of `{call}(...)`")
        own = numbers[names.index(name)]
        if not ends[0] < ends[1] or not ends[0] <= own.start <= ends[1]:
            raise ValueError(
                f"`{call}(bounds={{{name!r}: ...}})` must be two increasing numbers with the start {own.start:g} "
                f"within them, as the search begins there; got {ends[0]:g} and {ends[1]:g}: choose another `start`."
            )
    pairs = [(one, bounds.get(one.name, (-np.inf, np.inf))) for one in numbers]
    return tuple(replace(one, low=max(one.low, ends[0]), high=min(one.high, ends[1])) for one, ends in pairs)
