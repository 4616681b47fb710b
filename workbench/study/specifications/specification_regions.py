"""Limits as regions of pictures: what a gain must not reach over frequency, and disks about the critical point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from workbench.core.validation.refusals import one_of
from workbench.study.document.gain_bounds import Disk, GainBound
from workbench.study.specifications.limits import FigureLimit

LOWEST, HIGHEST = 1e-12, 1e12  # rad/s, beyond all pictures
HALF_POWER = 10 ** (-3 / 20)


def gain_bounds_of(limits: Sequence[FigureLimit], of: str) -> tuple[GainBound, ...]:
    """The bounds of the gain of S, of T or of CS."""
    one_of("Specification.gain_bounds(of=...)", of, ("S", "T", "CS"))
    held = {limit.kind.name: limit for limit in limits}
    names = {"S": ("Ms",), "T": ("Mt",), "CS": ("noise_gain",)}[of]
    bounds = [_level(held[name].words, held[name].high) for name in names if name in held]
    if of == "T" and "bandwidth" in held:
        low, high = held["bandwidth"].low, held["bandwidth"].high
        if low > LOWEST:
            bounds.append(_level(f"bandwidth >= {low:g} rad/s", HALF_POWER, LOWEST, low, "below"))
        if high < HIGHEST:
            bounds.append(_level(f"bandwidth <= {high:g} rad/s", HALF_POWER, high, HIGHEST))
    return tuple(bounds)


def disks_of(limits: Sequence[FigureLimit]) -> tuple[Disk, ...]:
    """The disks |1 + L| < 1 / Ms, |L / (1 + L)| > Mt, and |(1 - L) / (1 + L)| > 2 / alpha."""
    held, disks = {limit.kind.name: limit for limit in limits}, list[Disk]()
    if "Ms" in held:
        disks.append(Disk.of_Ms(held["Ms"].high))
    if "Mt" in held and held["Mt"].high > 1:
        square = held["Mt"].high ** 2
        disks.append(Disk(f"|T| > {held['Mt'].high:.4g}", -square / (square - 1), math.sqrt(square) / (square - 1)))
    if "disk_margin" in held and held["disk_margin"].low < 2:
        alpha = held["disk_margin"].low
        near, far = -(2 - alpha) / (2 + alpha), -(2 + alpha) / (2 - alpha)
        disks.append(Disk(f"disk margin {alpha:.4g}", (near + far) / 2, (near - far) / 2))
    return tuple(disks)


def _level(
    label: str, level: float, low: float = LOWEST, high: float = HIGHEST, forbidden: Literal["above", "below"] = "above"
) -> GainBound:
    return GainBound(label, np.array([low, high]), np.array([level, level]), forbidden)
