"""A loop with other numbers: the same equations, with other defaults of parameters and initial states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.core import Layout, Ode, Sampled
from workbench.study.contract import Loop, check_loop, equations_of
from workbench.validation.refusals import Array, nearest
from workbench.validation.signatures import door
from workbench.validation.views import show


@dataclass(frozen=True, eq=False)
@show
class Adjusted:
    """A loop whose numbers at some paths are those given; see `adjusted`."""

    loop: Loop
    numbers: Mapping[str, Any]

    @door
    def ode(self, name: str = "loop") -> Any:
        """The equations of the loop, with these numbers as defaults."""
        equation: Ode | Sampled = equations_of(self.loop, name)
        p = {path: value for path, value in self.numbers.items() if _knows(equation.parameters, path)}
        x0 = {path: value for path, value in self.numbers.items() if path not in p}
        for path in x0:
            if not _knows(equation.states, path):
                known = (*equation.parameters.names, *equation.states.names)
                raise LookupError(
                    f"`adjusted(loop, numbers)`: there is no '{path}' among the {len(equation.parameters.names)} "
                    f"parameters and {len(equation.states.names)} states of '{name}'.{nearest(path, known)}"
                )
        return with_defaults(equation, _row(equation.parameters, p), _row(equation.states, x0))


@door
def adjusted(loop: Loop, numbers: Mapping[str, Any]) -> Adjusted:
    """The loop with other numbers: {path: number or array}, of parameters or initial states, or single ones of them.

    Raises
    ------
    ValueError
        If the loop has no equations or the numbers are no mapping; where the loop says its equations, if a value has
        a wrong shape, is out of its bounds, or is given for several runs.
    LookupError
        There, if a path is neither a parameter's nor a state's; the message names the nearest.
    """
    check_loop("adjusted(loop=...)", loop)
    return Adjusted(loop, dict(numbers))


def with_defaults(equation: Ode | Sampled, p: Array, x0: Array) -> Ode | Sampled:
    """The same equations with the parameters (np,) and initial states (nx,) as defaults."""
    if isinstance(equation, Sampled):
        flow = with_defaults(equation.flow, p, x0)
        assert isinstance(flow, Ode)
        return replace(equation, flow=flow)
    return replace(equation, parameters=_refilled(equation.parameters, p), states=_refilled(equation.states, x0))


def _refilled(layout: Layout, row: Array) -> Layout:
    values = layout.unpack(row)
    return Layout(tuple(replace(entry, default=values[entry.name]) for entry in layout.entries))


def _row(layout: Layout, values: Mapping[str, Any]) -> Array:
    rows = layout.pack(values)
    if len(rows) != 1:
        raise ValueError(f"`adjusted(loop, numbers)` takes one value a path, not those of {len(rows)} runs.")
    return np.asarray(rows[0])


def _knows(layout: Layout, path: str) -> bool:
    return path in layout or path in layout.labels
