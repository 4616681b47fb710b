"""Where the knobs of a tuning act: the parameters of a linear loop, and the fields of the loop itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from workbench.core import Ode, SampledSystem
from workbench.core.equations import Loop, equations_of
from workbench.core.validation.refusals import Array, nearest
from workbench.design.linear_loop import LinearLoop
from workbench.study.knob import Knob


@dataclass(frozen=True, eq=False)
class KnobPlaces:
    """The places (np,) of each knob among the parameters of a loop, and the range and scale of its number."""

    knobs: tuple[Knob, ...]
    places: tuple[tuple[int, ...], ...]
    base: Array  # the parameters of the loop as it came

    @staticmethod
    def of(call: str, linear: LinearLoop, knobs: Sequence[Knob]) -> KnobPlaces:
        """The places of knobs; one that moves no parameter of the loop is refused."""
        layout, found = linear.parameters, []
        names = [knob.name for knob in knobs]
        if len(set(names)) < len(names):
            raise ValueError(f"`{call}(knobs=...)` needs knobs of distinct names; got {names}.")
        for knob in knobs:
            own = [path for path in knob.paths if path in layout or path in layout.labels]
            if not own:
                raise LookupError(
                    f"`{call}(knobs=...)`: this loop has no parameter '{knob.paths[0]}', which the knob '{knob.name}' "
                    f"turns.{nearest(knob.paths[0], [*layout.names, *layout.labels])}"
                )
            found.append(tuple(dict.fromkeys(i for path in own for i in layout.indices(path))))
        return KnobPlaces(tuple(knobs), tuple(found), linear.p0.copy())

    def factors(self, linear: LinearLoop) -> tuple[tuple[float, ...], ...]:
        """By what the number of each knob is multiplied at its places, for the parameters of a linear loop."""
        return tuple(
            tuple(float(linear.p0[i]) for i in places) if knob.share else tuple(1.0 for _ in places)
            for knob, places in zip(self.knobs, self.places, strict=True)
        )

    @property
    def first(self) -> Array:
        """The numbers (d,) of the knobs as the loop came, within their ranges."""
        own = [
            1.0 if knob.share else float(self.base[places[0]])
            for knob, places in zip(self.knobs, self.places, strict=True)
        ]
        return np.clip(own, self.low, self.high)

    @property
    def low(self) -> Array:
        """The low ends of the ranges."""
        return np.array([knob.low for knob in self.knobs])

    @property
    def high(self) -> Array:
        """The high ends of the ranges."""
        return np.array([knob.high for knob in self.knobs])

    def numbers(self, shares: Array) -> Array:
        """The numbers of the knobs at shares (d,) of their ranges, of the range of logarithms if that is the scale."""
        return np.array([_number(knob, share) for knob, share in zip(self.knobs, shares, strict=True)])

    def shares(self, numbers: Array) -> Array:
        """The shares (d,) of their ranges at which the numbers lie."""
        return np.array([_share(knob, number) for knob, number in zip(self.knobs, numbers, strict=True)])

    def slopes(self, numbers: Array) -> Array:
        """The derivatives (d,) of the numbers by the shares."""
        spans = [np.log(knob.high / knob.low) if knob.log else knob.high - knob.low for knob in self.knobs]
        steps = [number if knob.log else 1.0 for knob, number in zip(self.knobs, numbers, strict=True)]
        return np.asarray(np.array(spans) * np.array(steps))

    def values(self, numbers: Array) -> dict[str, float]:
        """The number of each knob, by its name."""
        return {knob.name: float(number) for knob, number in zip(self.knobs, numbers, strict=True)}

    def parameters(self, numbers: Array) -> Array:
        """The parameters (np,) of the loop with the numbers."""
        p = self.base.copy()
        for knob, places, number in zip(self.knobs, self.places, numbers, strict=True):
            p[list(places)] = number * self.base[list(places)] if knob.share else number
        return p


def _number(knob: Knob, share: float) -> float:
    if knob.log:
        return float(knob.low * (knob.high / knob.low) ** share)
    return float(knob.low + share * (knob.high - knob.low))


def _share(knob: Knob, number: float) -> float:
    if knob.log:
        return float(np.log(number / knob.low) / np.log(knob.high / knob.low))
    return float((number - knob.low) / (knob.high - knob.low))


def turned_loop(loop: Loop | Ode | SampledSystem, values: Mapping[str, Array]) -> Loop | Ode | SampledSystem | None:
    """The loop itself with new arrays in the fields that its paths name; None where a path is no field of a block."""
    made: object = loop
    for path, value in values.items():
        owner = getattr(made, "loop", made)
        changed = _with_field(owner, path.split("."), value)
        if changed is None:
            return None
        made = changed if owner is made else dataclasses.replace(made, loop=changed)  # type: ignore[type-var]
    new = cast(Loop | Ode | SampledSystem, made)
    layout = _flow(equations_of(new, "loop")).parameters
    kept = all(np.allclose(layout[path].default, value, rtol=1e-12, atol=0) for path, value in values.items())
    return new if kept else None


def _with_field(owner: object, path: Sequence[str], value: Array) -> object | None:
    name, _, index = path[0].partition("[")
    if not dataclasses.is_dataclass(owner) or isinstance(owner, type) or not hasattr(owner, name):
        return None
    part, new = getattr(owner, name), object()
    if index:
        place = int(index.rstrip("]"))
        if not isinstance(part, tuple) or len(path) < 2:
            return None
        inner = _with_field(part[place], path[1:], value)
        new = (*part[:place], inner, *part[place + 1 :])
    else:
        inner = (
            _with_field(part, path[1:], value) if len(path) > 1 else (value if np.ndim(part) else float(value.flat[0]))
        )
        new = inner
    if inner is None:
        return None
    try:
        return dataclasses.replace(owner, **{name: new})
    except (TypeError, ValueError):
        return None


def _flow(equations: Ode | SampledSystem) -> Ode:
    return equations.flow if isinstance(equations, SampledSystem) else equations
