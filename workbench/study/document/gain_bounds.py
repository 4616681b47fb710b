"""Specifications as regions of a picture: bounds of a gain over frequency, and disks that a curve must not enter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from workbench.core.validation.refusals import Array, numbers, positive, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.study.document.figure import Area, Label
from workbench.study.document.frequency_curves import Complex, check_frequencies, decibels

FAR = 1000.0  # decibels beyond all pictures
TURN = np.linspace(0, 2 * np.pi, 181)[:-1]

if TYPE_CHECKING:
    Point: TypeAlias = complex
else:
    Point = object  # any number, real ones too, which `Disk` makes complex


@dataclass(frozen=True, eq=False)
@check_arguments
class GainBound:
    """A bound on the gain in a Bode plot: absolute `gains` (k,) at `frequencies` (k,) in rad/s.

    The `forbidden_side` of the bound is shaded.

    Between the frequencies the bound is a straight line in logarithmic axes.

    Examples
    --------
    >>> import control
    >>> bound = wb.GainBound("no gain there", [1.0, 100.0], [1.0, 0.01])
    >>> wb.bode(control.tf([1], [1, 1]), bounds=[bound]).figure.name
    'bode'
    """

    label: Label
    frequencies: Array
    gains: Array
    forbidden_side: Literal["above", "below"] = "above"

    def __post_init__(self) -> None:
        omega = check_frequencies("GainBound(frequencies=...)", self.frequencies, None)
        gains = numbers("GainBound(gains=...)", self.gains, 1)
        if gains.shape != omega.shape or not np.isfinite(gains).all() or (gains <= 0).any() or omega[0] <= 0:
            raise refusal("GainBound(gains=...)", "a positive factor for each frequency above zero", self.gains)
        object.__setattr__(self, "frequencies", omega)
        object.__setattr__(self, "gains", gains)


@dataclass(frozen=True, eq=False)
@check_arguments
class Disk:
    """A disk in the Nyquist plot that the curve of L must not enter, by its centre and its radius."""

    label: Label
    centre: Point
    radius: float

    def __post_init__(self) -> None:
        try:
            centre = complex(self.centre)
        except Exception:  # an object of the user's may raise anything
            raise refusal("Disk(centre=...)", "a complex number", self.centre) from None
        if not (math.isfinite(centre.real) and math.isfinite(centre.imag)):
            raise refusal("Disk(centre=...)", "a finite complex number", self.centre)
        positive("Disk(radius=...)", self.radius)
        object.__setattr__(self, "centre", centre)

    @property
    def edge(self) -> Complex:
        """Points on the circle."""
        return np.asarray(self.centre + self.radius * np.exp(1j * TURN))

    @staticmethod
    @check_arguments
    def of_Ms(Ms: float) -> Disk:
        """The disk |1 + L| < 1 / Ms, where the gain of S is above Ms > 1.

        Raises
        ------
        ValueError
            If Ms is not above one: no loop has a smaller peak.
        """
        if not 1 < Ms < math.inf:
            raise refusal("Disk.of_Ms(Ms=...)", "a peak of S above one", Ms)
        return Disk(f"|S| > {Ms:.4g}", -1.0, 1 / Ms)


def shaded_bounds(bounds: Sequence[GainBound]) -> list[Area]:
    """A region in decibels over frequency for each bound."""
    return [
        Area(
            bound.label,
            np.concatenate([bound.frequencies, bound.frequencies[::-1]]),
            np.concatenate(
                [
                    decibels(bound.gains.astype(complex)),
                    np.full(len(bound.gains), FAR if bound.forbidden_side == "above" else -FAR),
                ]
            ),
            "reference",
        )
        for bound in bounds
    ]


def shaded_disks(disks: Sequence[Disk]) -> list[Area]:
    """A region of the plane for each disk."""
    return [Area(disk.label, disk.edge.real, disk.edge.imag, "reference") for disk in disks]
