"""Curves of a figure as data: series and bands, checked before anyone draws them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from workbench.notation.formula import Formula
from workbench.validation.refusals import Array, described
from workbench.validation.signatures import door

__all__ = ["STYLES", "Array", "Band", "Label", "Series", "Style", "check_style", "store"]

Label: TypeAlias = str | Formula | tuple[str | Formula, ...]
Style: TypeAlias = int | Literal["reference", "bound"]

STYLES = 12


@dataclass(frozen=True, eq=False)
@door
class Series:
    """A curve of points (N,): a NaN in `y` is a gap, as where a run has diverged.

    `style` 0 to 11 fixes its look, so that one law looks the same in all figures of a report; the
    styles 'reference' (what is wanted) and 'bound' (what is promised) stand apart from all laws.
    `look` draws it as a line, as steps that hold each value until the next (a sampled law), or as
    marks alone. Series with the same label and style share one line of the legend; the label '' is
    left out of it. At most 600 points of a series are drawn: extremes are kept, so that chattering
    stays visible as a band.
    """

    label: Label
    x: Array
    y: Array
    style: Style = 0
    look: Literal["line", "steps", "marks"] = "line"

    def __post_init__(self) -> None:
        check_style(f"Series({described(self.label)})", self.style)
        store(self, f"Series({described(self.label)})", ("x", "y"), gaps=("y",))

    @property
    def curves(self) -> tuple[Array, ...]:
        """The abscissa, then the ordinates: float arrays (N,)."""
        return self.x, self.y

    @property
    def spans(self) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        """All numbers along the abscissa, and all along the ordinate."""
        return self.curves[:1], self.curves[1:]


@dataclass(frozen=True, eq=False)
@door
class Band:
    """The strip between two curves of points (N,), as between two quantiles of many runs."""

    label: Label
    x: Array
    low: Array
    high: Array
    style: Style = 0

    def __post_init__(self) -> None:
        check_style(f"Band({described(self.label)})", self.style)
        store(self, f"Band({described(self.label)})", ("x", "low", "high"), gaps=())

    @property
    def curves(self) -> tuple[Array, ...]:
        """The abscissa, then the ordinates: float arrays (N,)."""
        return self.x, self.low, self.high

    @property
    def spans(self) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        """All numbers along the abscissa, and all along the ordinate."""
        return self.curves[:1], self.curves[1:]


def check_style(call: str, style: Style) -> None:
    """Refuse a style that no figure has."""
    if style not in (*range(STYLES), "reference", "bound"):
        raise ValueError(f"`{call}` takes a style of 0 to {STYLES - 1}, 'reference' or 'bound'; got {style!r}.")


def store(mark: object, call: str, names: tuple[str, ...], gaps: tuple[str, ...]) -> None:
    """Copy the named fields to read-only float arrays of one length, finite but for NaN in `gaps`."""
    shapes = set()
    for name in names:
        array = getattr(mark, name).copy()
        shapes.add(array.shape)
        if np.isinf(array).any() or (name not in gaps and np.isnan(array).any()):
            rule = "finite, or NaN for a gap" if name in gaps else "finite"
            raise ValueError(f"`{call}` needs a {name} that is {rule}; got one that is not.")
        array.flags.writeable = False
        object.__setattr__(mark, name, array)
    if len(shapes) != 1 or any(len(shape) != 1 or shape == (0,) for shape in shapes):
        raise ValueError(f"`{call}` needs {' and '.join(names)} of one length N >= 1; got the shapes {sorted(shapes)}.")
