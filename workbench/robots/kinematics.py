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
    """Cosine and sine of the sum of q[first] ... q[last], by the addition theorems.

    They keep full accuracy after many turns, where the rounded sum of two large angles does not.
    """
    c, s = ca.SX(1), ca.SX(0)
    for j in range(first, last + 1):
        cos, sin = ca.cos(q[j]), ca.sin(q[j])
        c, s = c * cos - s * sin, s * cos + c * sin
    return c, s


def directions(zero: str, q: ca.SX, link: int) -> tuple[ca.SX, ca.SX]:
    """The unit vectors along a link and to its left, each (2, 1): to the right and upward."""
    right, up = DIRECTIONS[zero]
    c, s = turn(q, 0, link)
    along = ca.vertcat(right * c - up * s, up * c + right * s)
    return along, ca.vertcat(-along[1], along[0])


def position(links: Sequence[Body], zero: str, q: ca.SX, joint: int) -> ca.SX:
    """Where joint number `joint` is, (2, 1) in m from the base; joint n is the tip."""
    place = ca.SX(2, 1)
    for j in range(joint):
        place += links[j].length * directions(zero, q, j)[0]
    return place


def centre_of_mass(links: Sequence[Body], zero: str, q: ca.SX, link: int) -> ca.SX:
    """Where the centre of mass of a link is, (2, 1) in m from the base."""
    along, left = directions(zero, q, link)
    place: ca.SX = position(links, zero, q, link) + links[link].com * along + links[link].offset * left
    return place


def potential_energy(links: Sequence[Body], gravity: Any, zero: str, q: ca.SX) -> ca.SX:
    """The sum of m g times height, in J."""
    energy = ca.SX(0)
    for k, link in enumerate(links):
        energy += link.mass * gravity * centre_of_mass(links, zero, q, k)[1]
    return energy


def kinetic_energy(links: Sequence[Body], q: ca.SX, qd: ca.SX) -> ca.SX:
    """The sum of m v^2 / 2 + I omega^2 / 2, in J."""
    energy = ca.SX(0)
    for k, link in enumerate(links):
        omega = sum((qd[j] for j in range(k + 1)), ca.SX(0))
        energy += link.mass * _speed_squared(links, q, qd, k) / 2 + link.inertia * omega**2 / 2
    return energy


def _speed_squared(links: Sequence[Body], q: ca.SX, qd: ca.SX, link: int) -> ca.SX:
    """The squared speed of a link's centre of mass, in m^2/s^2.

    Body j turns at omega_j and adds omega_j (a_j left_j - b_j along_j) to the velocity, where
    (a, b) is (length, 0) for the links before and (com, offset) for the link itself.
    """
    arms = [(links[j].length, 0) for j in range(link)] + [(links[link].com, links[link].offset)]
    omegas = [sum((qd[j] for j in range(k + 1)), ca.SX(0)) for k in range(link + 1)]
    square = ca.SX(0)
    for i, (a_i, b_i) in enumerate(arms):
        square += omegas[i] ** 2 * (a_i**2 + b_i**2)
        for j in range(i):
            a_j = arms[j][0]
            c, s = turn(q, j + 1, i)
            square += 2 * omegas[i] * omegas[j] * a_j * (a_i * c - b_i * s)
    return square
