"""Where the links of a planar chain are, how fast they move, and what energy that takes.

Velocities are kept as components along the links' own directions, whose inner products are cosines
and sines of relative angles: the energies then come out as a book writes them, with no squares of
sines and cosines left to cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import casadi as ca

# The direction of the first link at q = 0, as (to the right, upward).
DIRECTIONS = {"down": (0, -1), "right": (1, 0), "up": (0, 1)}


class Body(Protocol):
    """What a link must tell."""

    @property
    def mass(self) -> Any: ...  # noqa: D102
    @property
    def length(self) -> Any: ...  # noqa: D102
    @property
    def com(self) -> Any: ...  # noqa: D102
    @property
    def offset(self) -> Any: ...  # noqa: D102
    @property
    def inertia(self) -> Any: ...  # noqa: D102


def turn(q: ca.SX, first: int, last: int) -> tuple[ca.SX, ca.SX]:
    """Cosine and sine of the sum of q[first] ... q[last]; of no angle where last is before first."""
    return turns(waves(q)[first : last + 1])[-1]


def waves(q: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
    """Cosine and sine of each angle."""
    return [(ca.cos(angle), ca.sin(angle)) for angle in ca.vertsplit(q)]


def turns(waves: Sequence[tuple[ca.SX, ca.SX]]) -> list[tuple[ca.SX, ca.SX]]:
    """Cosine and sine of the sums of the first 0, 1, 2, ... angles, by the addition theorems.

    They keep full accuracy after many turns, where the rounded sum of two large angles does not.
    """
    c, s = ca.SX(1), ca.SX(0)
    found = [(c, s)]
    for cos, sin in waves:
        c, s = c * cos - s * sin, s * cos + c * sin
        found.append((c, s))
    return found


def directions(zero: str, q: ca.SX) -> list[tuple[ca.SX, ca.SX]]:
    """The unit vectors along each link and to its left, each (2, 1): to the right and upward."""
    right, up = DIRECTIONS[zero]
    found = []
    for c, s in turns(waves(q))[1:]:
        along = ca.vertcat(right * c - up * s, up * c + right * s)
        found.append((along, ca.vertcat(-along[1], along[0])))
    return found


def positions(links: Sequence[Body], zero: str, q: ca.SX) -> list[ca.SX]:
    """Where the joints are, then the tip, each (2, 1) in m from the base."""
    places = [ca.SX(2, 1)]
    for link, (along, _) in zip(links, directions(zero, q), strict=True):
        places.append(places[-1] + link.length * along)
    return places


def centres_of_mass(links: Sequence[Body], zero: str, q: ca.SX) -> list[ca.SX]:
    """Where the links' centres of mass are, each (2, 1) in m from the base."""
    rows = zip(links, positions(links, zero, q), directions(zero, q), strict=False)
    return [place + link.com * along + link.offset * left for link, place, (along, left) in rows]


def potential_energy(links: Sequence[Body], gravity: Any, zero: str, q: ca.SX) -> ca.SX:
    """The sum of m g times height, in J."""
    energy = ca.SX(0)
    for link, place in zip(links, centres_of_mass(links, zero, q), strict=True):
        energy += link.mass * gravity * place[1]
    return energy


def kinetic_energy(links: Sequence[Body], q: ca.SX, qd: ca.SX) -> ca.SX:
    """The sum of m v^2 / 2 + I omega^2 / 2, in J."""
    omegas = [sum((qd[j] for j in range(k + 1)), ca.SX(0)) for k in range(len(links))]
    angles = waves(q)
    bends = [turns(angles[j + 1 :]) for j in range(len(links))]
    energy = ca.SX(0)
    for k, link in enumerate(links):
        energy += link.mass * _speed_squared(links[: k + 1], omegas, bends) / 2 + link.inertia * omegas[k] ** 2 / 2
    return energy


def _speed_squared(links: Sequence[Body], omegas: Sequence[ca.SX], bends: Sequence[Sequence[Any]]) -> ca.SX:
    """The squared speed of the last link's centre of mass, in m^2/s^2.

    Body j turns at omega_j and adds omega_j (a_j left_j - b_j along_j) to the velocity, where
    (a, b) is (length, 0) for the links before and (com, offset) for the last; bends[j][k] has cosine
    and sine of the angle from body j to body j + k.
    """
    arms = [*((link.length, 0) for link in links[:-1]), (links[-1].com, links[-1].offset)]
    square = ca.SX(0)
    for i, (a_i, b_i) in enumerate(arms):
        square += omegas[i] ** 2 * (a_i**2 + b_i**2)
        for j in range(i):
            c, s = bends[j][i - j]
            square += 2 * omegas[i] * omegas[j] * arms[j][0] * (a_i * c - b_i * s)
    return square
