"""The frequency axis as places from 0 to 1, and a search on it for the largest bound."""

from __future__ import annotations

import math

from workbench.design.structured_uncertainty.frequency_bands import PerturbedSystem
from workbench.design.structured_uncertainty.scaling_search import best_scalings
from workbench.design.structured_uncertainty.uncertainty_blocks import Places

GOLDEN = 12  # frequencies of a search for the largest bound between two
ROUGH = 2e-5  # of the square of a bound within a band


def frequency_at(place: float, scale: float) -> float:
    """The frequency in rad/s at a place from 0 to 1 of the axis."""
    return math.inf if place >= 1 else scale * place / (1 - place)


def place_of(omega: float, scale: float) -> float:
    """The place of a frequency, which may be infinite."""
    return 1.0 if math.isinf(omega) else omega / (omega + scale)


def largest_square(
    matrix: PerturbedSystem, places: tuple[Places, ...], low: float, high: float, scale: float, middle: float
) -> tuple[float, float]:
    """The largest square of the bound that a golden-section search between two places finds, and the place."""

    def at(place: float) -> float:
        M = matrix.at(frequency_at(place, scale))
        return best_scalings(M, places, ROUGH).square(M)

    ratio = (math.sqrt(5) - 1) / 2
    a, b = low, high
    inner = [b - ratio * (b - a), a + ratio * (b - a)]
    values = [at(place) for place in inner]
    best = max((middle, (low + high) / 2), *zip(values, inner, strict=True))
    for _ in range(GOLDEN):
        if values[0] > values[1]:
            b, inner = inner[1], [inner[1] - ratio * (inner[1] - a), inner[0]]
            values = [at(inner[0]), values[0]]
        else:
            a, inner = inner[0], [inner[1], inner[0] + ratio * (b - inner[0])]
            values = [values[1], at(inner[1])]
        best = max(best, *zip(values, inner, strict=True))
    return best
