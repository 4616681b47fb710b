"""A tornado: what each factor by itself does to an output, the others held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.study.uncertainty.one_at_a_time import OneAtATime
from workbench.study.uncertainty.outputs import check_shape, columns_of, factor_names, outputs_of, place_of, refuse_all
from workbench.validation.refusals import Array, Integers
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Tornado:
    """Outputs with one of d factors moved, of k outputs, or of a single one, which leaves the axis k out.

    Attributes
    ----------
    base
        (k,), with no factor moved.
    moved
        (k, d, levels), with one factor at each of the design's levels.
    refused
        The reason for each output that has none; its numbers are NaN.
    """

    names: tuple[str, ...]
    factors: tuple[str, ...]
    levels: tuple[float, ...]
    base: Array
    moved: Array
    refused: Mapping[str, str]

    def __post_init__(self) -> None:
        check_shape("Tornado(base=...)", self.base, self.names)
        check_shape("Tornado(moved=...)", self.moved, self.names, len(self.factors), len(self.levels))

    @property
    def swing(self) -> Array:
        """How far apart the outermost outputs of each factor are, that of the base among them, (k, d)."""
        whole = np.concatenate(
            [self.moved, np.broadcast_to(self.base[..., None, None], (*self.moved.shape[:-1], 1))], -1
        )
        return np.asarray(np.ptp(whole, axis=-1))

    @property
    def order(self) -> Integers:
        """The places of the factors, the widest bar first, (k, d)."""
        return np.argsort(-self.swing, axis=-1, kind="stable")

    @door
    def __getitem__(self, name: str) -> Tornado:
        """The tornado of one output; one that was refused is refused again, with its reason."""
        j = place_of(self.names, self.refused, name)
        return replace(self, names=(name,), base=self.base[j], moved=self.moved[j], refused={})


@door
def tornado(
    design: OneAtATime,
    outputs: Any,
    names: Sequence[str] | None = None,
    *,
    factors: Sequence[str] | None = None,
) -> Tornado:
    """The outputs of a one-at-a-time design, by factor and level. They say nothing of factors that act together.

    Parameters
    ----------
    outputs
        (N,) or (N, k) in the order of the design's points.
    names, factors
        Of the k outputs and the d factors.

    Raises
    ------
    ValueError
        If an argument has the wrong kind or shape, or if every output is refused: for failed runs, infinities, or
        no variation beyond rounding.
    """
    named = factor_names("tornado", design, factors)
    held = outputs_of("tornado", design, outputs, names)
    refuse_all("tornado", held)
    values = np.where(held.known, columns_of("tornado", design, outputs, names)[1], np.nan)
    moved = values[1:].reshape(design.dimensions, len(design.levels), -1)
    return Tornado(held.names, named, design.levels, values[0], np.moveaxis(moved, -1, 0), held.refused)
