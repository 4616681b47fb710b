"""The gain of a system at one frequency, from below and with the response around which it is proved.

With approximations X of P^-1 B and Y of C P^-1, where G = D + C P^-1 B at this frequency,

    G = D + C X + Y (B - P X) + (C - Y P) P^-1 (B - P X),

whose last term is of second order in the errors, so that a bound of it will do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.design.frequency.modal_systems import ModalSystem
from workbench.design.frequency.wide_matrices import U, Wide, bounded_product, bounds_of_solution, stack


@dataclass(frozen=True, eq=False)
class PointGain:
    """A number `low` that the largest singular value at a frequency is not below, and the response there.

    The real `response` (2 ny, 2 nu) has the blocks Re G, -Im G, Im G, Re G.
    """

    low: float
    response: Wide


def point_gain(system: ModalSystem, place: float) -> PointGain | None:
    """The gain at s = j place, or at z = (1 + j place) / (1 - j place); None where no bound is proved."""
    response = _response(system, place)
    if response is None:
        return None
    ny = len(system.D.high)
    real, imaginary = response[:ny, :], response[ny:, :]
    whole = stack([[real, -imaginary], [imaginary, real]])
    return PointGain(largest_gain(whole), whole)


def _response(system: ModalSystem, place: float) -> Wide | None:
    """Re G over Im G, (2 ny, nu)."""
    D, C = system.D, system.C
    direct = stack([[D], [Wide.of(np.zeros_like(D.high))]])
    if not system.discrete and math.isinf(place):
        return direct
    P, entering = _equations(system, place)
    none = Wide.of(np.zeros_like(C.high))
    seen = stack([[C, none], [none, C]])
    try:
        inverse = np.asarray(np.linalg.inv(P.high))
    except np.linalg.LinAlgError:
        return None
    X, Y = inverse @ entering.high, seen.high @ inverse
    short = entering - P @ X
    beyond = bounds_of_solution(inverse, P, short)
    if beyond is None:
        return None
    missed = (seen - Wide.of(Y) @ P).size
    last, radius = bounded_product(missed, beyond)
    answer = direct + seen @ X + Wide.of(Y) @ short
    return Wide(answer.high, answer.low, answer.radius + (last + radius) * (1 + 8 * U))


def _equations(system: ModalSystem, place: float) -> tuple[Wide, Wide]:
    """P and what it drives, as real matrices [[Re, -Im], [Im, Re]] and [Re, Im]."""
    E, A, B = system.E, system.A, system.B
    none = Wide.of(np.zeros_like(B.high))
    turn = place * np.eye(len(A.high))
    if not system.discrete:
        real, imaginary, entering = -A, E @ turn, stack([[B], [none]])
    elif math.isinf(place):  # z = -1
        real, imaginary, entering = -E - A, Wide.of(np.zeros_like(turn)), stack([[B], [none]])
    else:  # both sides times 1 - j place
        real, imaginary, entering = E - A, (E + A) @ turn, stack([[B], [-(Wide.of(turn) @ B)]])
    return stack([[real, -imaginary], [imaginary, real]]), entering


def largest_gain(response: Wide) -> float:
    """A number that the largest singular value of the matrix is not below, by its singular vector as computed."""
    if not np.isfinite(response.high).all():
        return 0.0
    vector = np.linalg.svd(response.high)[2][:1]
    image, radius = bounded_product(vector, response.T)
    reached = np.linalg.norm(np.maximum(np.abs(image) - radius, 0)) / np.linalg.norm(vector)
    return float(reached * (1 - 2 * (sum(response.high.shape) + 8) * U))
