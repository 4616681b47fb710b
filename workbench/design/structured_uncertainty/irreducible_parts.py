"""The parts of a matrix that act on each other in both directions: its structured singular value is their largest."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from workbench.design.matrices import Complex
from workbench.design.structured_uncertainty.uncertainty_blocks import Places


def irreducible_parts(M: Complex, places: tuple[Places, ...]) -> list[list[int]]:
    """The rows of each part; in some order of the parts, M is block triangular, as I - M Delta is.

    A full block stays whole, and a repeated scalar may be divided.
    """
    n = len(M)
    links = M != 0
    for place in places:
        if place.full:
            links[place.span, place.span] = True
    _, labels = connected_components(csr_matrix(links), directed=True, connection="strong")
    return [[i for i in range(n) if labels[i] == label] for label in range(labels.max() + 1)]


def part_of(places: tuple[Places, ...], rows: list[int]) -> tuple[Places, ...]:
    """The blocks of a part, each with its place in it."""
    parts, start = [], 0
    for place in places:
        size = sum(place.start <= i < place.start + place.size for i in rows)
        if size:
            parts.append(Places(place.block, start, size))
            start += size
    return tuple(parts)


def whole_of(places: tuple[Places, ...], rows: list[int], Delta: Complex) -> Complex:
    """The perturbation of the whole matrix whose blocks are those of a part, or zero."""
    n = sum(place.size for place in places)
    whole, part = np.zeros((n, n), dtype=complex), np.zeros((n, n), dtype=complex)
    part[np.ix_(rows, rows)] = Delta
    for place in places:
        inside = [i for i in rows if place.start <= i < place.start + place.size]
        if inside and place.full:
            whole[place.span, place.span] = part[place.span, place.span]
        elif inside:
            whole[place.span, place.span] = part[inside[0], inside[0]] * np.eye(place.size)
    return whole
