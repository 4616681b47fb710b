"""Bounds of |1 + L|^2, of |1 + 1 / L|^2 and of the balance of S and T, while L stays in a sector of the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

LARGEST = 300.0  # of log |L| in what follows: exp of more would leave the doubles
Span = tuple[float, float]


@dataclass(frozen=True)
class Sector:
    """Bounds of rho = log |L| and of phi, the phase of L, and of their slopes, over an interval of frequencies."""

    rho: Span
    phi: Span
    rho_slope: Span
    phi_slope: Span


@dataclass(frozen=True)
class SectorBound:
    """A lower bound of a function f over a sector, and one of |f'|; zero where f' has no zero inside."""

    below: float
    steepest: float


def distance(rho: float, phi: float) -> float:
    """The value |1 + L|^2, whose root is 1 / |S|."""
    if rho > LARGEST:
        return math.inf
    r = math.exp(rho)
    return (1 + r * math.cos(phi)) ** 2 + (r * math.sin(phi)) ** 2 if r else 1.0


def inverse_distance(rho: float, phi: float) -> float:
    """The value |1 + 1 / L|^2, whose root is 1 / |T|."""
    return distance(-rho, -phi)


def balance(rho: float, phi: float) -> float:
    """The value g = 1 + cos(phi) / cosh(rho), of which |S - T|^2 = (2 - g) / g."""
    if abs(rho) > LARGEST:
        return 1.0
    return 2 * (math.sinh(rho / 2) ** 2 + math.cos(phi / 2) ** 2) / math.cosh(rho)


def distance_bound(sector: Sector) -> SectorBound:
    """The bounds of |1 + L|^2, with the slope 2 r (rho' (r + cos phi) - phi' sin phi)."""
    r_low, r_high = (math.exp(min(rho, LARGEST)) for rho in sector.rho)
    c, s = cosine(sector.phi), cosine((sector.phi[0] - math.pi / 2, sector.phi[1] - math.pi / 2))
    nearest = min(max(-c[0], r_low), r_high)
    below = (nearest + c[0]) ** 2 + max(1 - c[0] ** 2, 0.0)
    if not _regular(sector):
        return SectorBound(below, math.inf)
    radial, around = times(sector.rho_slope, (r_low + c[0], r_high + c[1])), times(sector.phi_slope, s)
    return SectorBound(below, _steepest((radial[0] - around[1], radial[1] - around[0]), 2 * r_high))


def inverse_distance_bound(sector: Sector) -> SectorBound:
    """The bounds of |1 + 1 / L|^2: those of |1 + L|^2 over the sector of 1 / L."""
    spans = (sector.rho, sector.phi, sector.rho_slope, sector.phi_slope)
    return distance_bound(Sector(*((-high, -low) for low, high in spans)))


def balance_bound(sector: Sector) -> SectorBound:
    """The bounds of g, with the slope -(phi' sin phi + rho' cos phi tanh rho) / cosh rho."""
    c, s = cosine(sector.phi), cosine((sector.phi[0] - math.pi / 2, sector.phi[1] - math.pi / 2))
    least, most = (abs(rho) for rho in sorted(sector.rho, key=abs))
    least = 0.0 if sector.rho[0] <= 0 <= sector.rho[1] else least
    h = [1 / math.cosh(min(rho, LARGEST)) for rho in (most, least)]
    below = 1 + (c[0] * h[1] if c[0] < 0 else c[0] * h[0])
    if not _regular(sector):
        return SectorBound(below, math.inf)
    radial = times(times(c, (math.tanh(sector.rho[0]), math.tanh(sector.rho[1]))), sector.rho_slope)
    around = times(s, sector.phi_slope)
    return SectorBound(below, _steepest((radial[0] + around[0], radial[1] + around[1]), h[1]))


def _regular(sector: Sector) -> bool:
    return all(map(math.isfinite, (*sector.rho, *sector.rho_slope, *sector.phi_slope)))


def _steepest(slope: Span, factor: float) -> float:
    return 0.0 if slope[0] > 0 or slope[1] < 0 else factor * max(map(abs, slope))


def cosine(phi: Span) -> Span:
    """The bounds of the cosine over an interval."""
    low, high = sorted(map(math.cos, phi))
    first, last = math.ceil(phi[0] / math.pi), math.floor(phi[1] / math.pi)
    for k in range(first, min(last, first + 1) + 1):
        low, high = (-1.0, high) if k % 2 else (low, 1.0)
    return low, high


def times(p: Span, q: Span) -> Span:
    """The bounds of a product."""
    ends = [a * b for a, b in product(p, q)]
    return min(ends), max(ends)
