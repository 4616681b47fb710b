"""A box of parameters of a linear loop, by their names, within their bounds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.core import Layout
from workbench.core.validation.refusals import Array, as_array, describe, known_name, refusal


@dataclass(frozen=True, eq=False)
class ParameterBox:
    """The box low <= theta <= high, (d,) each, of d numbers of a loop by their labels, as `plant.m` or `law.K[0]`."""

    labels: tuple[str, ...]
    low: Array
    high: Array

    @staticmethod
    def of(call: str, parameters: Layout, ranges: Mapping[str, object]) -> ParameterBox:
        """A box from (low, high) per name: of one number, or of each number of a vector or matrix.

        Raises
        ------
        LookupError
            If a name is none of a parameter.
        ValueError
            If there is no range, or one is no pair of finite numbers with low < high within the bounds.
        """
        labels, lows, highs = list[str](), list[Array](), list[Array]()
        for name, pair in ranges.items():
            own, low, high = _range(call, parameters, name, pair)
            labels += own
            lows.append(low)
            highs.append(high)
        if not labels or len(set(labels)) < len(labels):
            must = "must give at least one parameter a range (low, high), and each of them once"
            raise ValueError(f"`{call}` {must}; got {describe(list(ranges))}.")
        return ParameterBox(tuple(labels), np.concatenate(lows), np.concatenate(highs))

    def at(self, u: Array) -> Array:
        """theta (N, d) at points u (N, d) of the unit cube."""
        theta = self.low + u * (self.high - self.low)
        return np.asarray(np.clip(theta, self.low, self.high))

    def columns(self, theta: Array) -> dict[str, Array]:
        """The values (N,) of each label, as `LinearLoop.rows` takes them."""
        return dict(zip(self.labels, theta.T, strict=True))

    def values(self, theta: Array) -> dict[str, float]:
        """One draw (d,) as values by label, as `linear_loop` takes them."""
        return dict(zip(self.labels, theta.tolist(), strict=True))

    def __str__(self) -> str:
        ends = zip(self.labels, self.low, self.high, strict=True)
        return ", ".join(f"{label} in [{low:.6g}, {high:.6g}]" for label, low, high in ends)


def _range(call: str, parameters: Layout, name: str, pair: object) -> tuple[list[str], Array, Array]:
    """The labels of a name, with both ends of each."""
    known_name(
        name, [*parameters.names, *(n for n in parameters.labels if n not in parameters)], "parameters of this loop"
    )
    places = list(parameters.indices(name))
    labels = [parameters.labels[place] for place in places]
    entry = next(one for one in parameters.entries if name == one.name or name in one.labels())
    try:
        low, high = (as_array(end) for end in (pair if isinstance(pair, Iterable) else ()))
    except (TypeError, ValueError):
        raise refusal(f"{call}", f"a pair (low, high) for '{name}'", pair) from None
    if low is None or high is None or low.size not in (1, len(labels)) or high.size not in (1, len(labels)):
        raise refusal(f"{call}", f"a pair (low, high) for '{name}', of {len(labels)} number(s) each", pair)
    first, last = (np.broadcast_to(end.ravel(), len(labels)).copy() for end in (low, high))
    if not (np.isfinite(first).all() and np.isfinite(last).all() and (first < last).all()):
        advice = ": leave out what does not vary" if (first == last).any() else ""
        raise refusal(f"{call}", f"finite ends low < high for '{name}'", pair, advice)
    if not (entry.bounds.allow(first).all() and entry.bounds.allow(last).all()):
        unit = f" [{entry.unit}]" if entry.unit not in ("", "1") else ""
        raise refusal(f"{call}", f"within the bounds of '{name}', {entry.bounds}{unit}", pair)
    return labels, first, last
