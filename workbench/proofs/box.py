"""A box of parameters and initial states, by name: where a search may look."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.core import Ode
from workbench.validation.refusals import Array, as_array, described, matrix, nearest, vector
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Box:
    """low <= theta <= high for d numbers of an equation, each a parameter or an initial state.

    Attributes
    ----------
    ode
        Whose numbers they are; all others stay at their defaults.
    labels
        One name a number: `plant.q[0]`.
    low, high
        (d,).
    """

    ode: Ode
    labels: tuple[str, ...]
    low: Array
    high: Array

    def __post_init__(self) -> None:
        for side in ("low", "high"):
            vector(f"Box({side}=...)", getattr(self, side), len(self.labels), "labels")

    @staticmethod
    @door
    def of(ode: Ode, ranges: Mapping[str, tuple[Any, Any]]) -> Box:
        """A box from (low, high) per name: of a number (`plant.q[0]`), or of all numbers of a quantity (`plant.q`).

        Raises
        ------
        LookupError
            If a name is neither a parameter's nor a state's; the message names the nearest.
        ValueError
            If there is no range, a number has two, or an end is not finite, out of bounds or above the other.
        """
        labels: list[str] = []
        ends: list[Array] = []
        for name, pair in ranges.items():
            mine = _labels(ode, name)
            labels += mine
            sides = [as_array(end) for end in pair]
            if any(side is None or side.size not in (1, len(mine)) for side in sides):
                raise ValueError(
                    f"`Box.of(ranges=...)` must give (low, high) for '{name}', each a number or {len(mine)} of them; "
                    f"got {described(pair)}."
                )
            ends.append(np.stack([np.broadcast_to(side.ravel(), len(mine)) for side in sides if side is not None]))
        if not labels or len(set(labels)) < len(labels):
            raise ValueError(f"`Box.of(ranges=...)` must give each sought number one range; got {list(ranges)}.")
        low, high = np.concatenate(ends, axis=1)
        if not (np.isfinite([low, high]).all() and (low <= high).all()):
            raise ValueError(f"`Box.of(ranges=...)` must have finite ends, low <= high; got {low} and {high}.")
        box = Box(ode, tuple(labels), low, high)
        for end in (low, high):
            box.rows(end[np.newaxis])  # refuses what is out of the bounds of its quantity
        return box

    @door
    def at(self, u: Array) -> Array:
        """theta (B, d) of points u (B, d) of the unit cube."""
        u = matrix("Box.at(u=...)", u, columns=len(self.labels))
        return np.asarray(self.low + u * (self.high - self.low))

    @door
    def rows(self, theta: Array) -> tuple[Array, Array]:
        """Parameters (B, np) and initial states (B, nx) of theta (B, d)."""
        theta = matrix("Box.rows(theta=...)", theta, columns=len(self.labels))
        columns = dict(zip(self.labels, theta.T, strict=True))
        parameters = {name: value for name, value in columns.items() if name in self.ode.parameters.labels}
        states = {name: value for name, value in columns.items() if name not in parameters}
        rows = self.ode.parameters.pack(parameters), self.ode.states.pack(states)
        p, x0 = (np.tile(part, (len(theta) // len(part), 1)) for part in rows)
        return p, x0


def _labels(ode: Ode, name: str) -> list[str]:
    """The labels of a quantity or of one of its numbers; a parameter is looked for first."""
    for layout in (ode.parameters, ode.states):
        if name in layout:
            return layout[name].labels()
        if name in layout.labels:
            return [name]
    names = (*ode.parameters.names, *ode.states.names)
    raise LookupError(f"There is no parameter and no state {described(name)} in '{ode.name}'.{nearest(name, names)}")
