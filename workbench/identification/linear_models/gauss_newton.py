"""Gauss-Newton with damping on prediction errors, within the region where predictor and noise model are stable."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.identification.linear_models.polynomial_structure import PolynomialStructure, clip
from workbench.identification.linear_models.prediction_errors import Errors, Predictor

RADIUS = 1 - 1e-6  # the largest absolute root of C, D and F
MULTIPLE = 1e-6  # a smaller slope at a root: it is a multiple one, which moves with no first order
AT_LIMIT = 1e-7  # a root that is as near to RADIUS is at it
ROUNDING = 1e-8  # of roots, computed from a polynomial
MOST = 120  # steps
NEAR = 1e-7  # standard errors: the length of the last Gauss-Newton step, at which the search ends
STALL, STALLS = 1e-13, 4  # relative decrease of a step, and how many such steps in a row end the search
FIRST = 20  # steps of each start, before the best ends go on
BEST = 8  # different ends that go on
ALIKE = 1e-7  # relative: two sums of squares that differ by less are of one end
STEEPEST = 1e12  # the damping at which no step is left


@dataclass(frozen=True, eq=False)
class SearchDescent:
    """The end of one search: parameters, sum of squares, errors, and the last step in standard errors."""

    theta: Array
    squares: float
    errors: Errors
    distance: float
    steps: int

    @property
    def is_minimum(self) -> bool:
        """True if the last Gauss-Newton step is far below a standard error."""
        return self.distance < 1e-3


def squares_at(predictor: Predictor, theta: Array) -> float:
    """The sum of squares at theta; infinite where the predictor or the noise model is not stable."""
    if not np.isfinite(theta).all() or predictor.structure.polynomials(theta).radius() > RADIUS:
        return np.inf
    e = predictor.errors(theta, gradients=False).e
    total = float(e @ e)
    return total if np.isfinite(total) else np.inf


def clip_roots(structure: PolynomialStructure, theta: Array) -> Array:
    """The parameters with roots of C, D and F beyond RADIUS moved to it."""
    if not np.isfinite(theta).all() or structure.polynomials(theta).radius() <= RADIUS:
        return theta
    clipped = theta.copy()
    for letter, i in (("c", 0), ("d", 0), *(("f", i) for i in range(structure.nu))):
        places = structure.places(letter, i)
        clipped[places] = clip(np.concatenate([[1.0], theta[places]]), RADIUS - ROUNDING)[1:]
    return clipped


def tangent(structure: PolynomialStructure, theta: Array, errors: Errors) -> Array:
    """The directions (size, k) that keep roots at their limit which a Gauss-Newton step would take beyond it."""
    everything = np.eye(len(theta))
    if structure.polynomials(theta).radius() < RADIUS - AT_LIMIT:
        return everything
    normals = []
    for letter, i in (("c", 0), ("d", 0), *(("f", i) for i in range(structure.nu))):
        places = structure.places(letter, i)
        polynomial = np.concatenate([[1.0], theta[places]])
        for root in np.roots(polynomial) if len(polynomial) > 1 else ():
            if abs(root) > RADIUS - AT_LIMIT and root.imag >= 0:
                normal = np.zeros(len(theta))
                powers = root ** np.arange(len(polynomial) - 2, -1, -1)
                slope = np.polyval(np.polyder(polynomial), root)
                if abs(slope) > MULTIPLE:
                    normal[places] = np.real(-np.conj(root) * powers / slope)
                    normals.append(normal)
    step = np.linalg.lstsq(errors.J, -errors.e, rcond=None)[0]
    outward = np.array([normal for normal in normals if normal @ step > 0])
    if not len(outward):
        return everything
    rank = np.linalg.matrix_rank(outward)
    return np.asarray(np.linalg.svd(outward)[2][rank:].T)


def descend(predictor: Predictor, theta: Array, most: int = MOST) -> SearchDescent | None:
    """The minimum below theta by Levenberg's and Marquardt's steps; None if theta itself is not stable."""
    squares = squares_at(predictor, theta)
    if not np.isfinite(squares):
        return None
    damping, errors, distance, stalls = 1e-3, predictor.errors(theta), np.inf, 0
    for count in range(most):
        free = tangent(predictor.structure, theta, errors)
        J = errors.J @ free
        scale = np.linalg.norm(J, axis=0)
        scale[scale == 0] = 1.0
        U, s, V = np.linalg.svd(J / scale, full_matrices=False)
        pull = U.T @ errors.e
        sigma = np.sqrt(squares / max(len(errors.e) - len(theta), 1))
        distance = float(np.linalg.norm(pull)) / sigma if sigma > 0 else 0.0
        if distance < NEAR:
            return SearchDescent(theta, squares, errors, distance, count)
        while damping < STEEPEST:
            step = -free @ ((V.T @ (s / (s**2 + damping) * pull)) / scale)
            trial = clip_roots(predictor.structure, theta + step)
            reached = squares_at(predictor, trial)
            if reached < squares:
                break
            damping *= 4
        else:
            return SearchDescent(theta, squares, errors, distance, count)
        stalls = stalls + 1 if squares - reached < STALL * squares else 0
        theta, squares, damping = trial, reached, damping / 9
        if stalls == STALLS:
            return SearchDescent(theta, squares, predictor.errors(theta), distance, count)
        errors = predictor.errors(theta)
    return SearchDescent(theta, squares, errors, distance, most)


@dataclass(frozen=True)
@show
class LocalMinimum:
    """One end of a search: the name of its start, its sum of squares, and how often the starts came there."""

    start: str
    squares: float
    times: int


def search(predictor: Predictor, starts: Iterable[tuple[str, Array]]) -> tuple[SearchDescent, tuple[LocalMinimum, ...]]:
    """The lowest minimum below some starts, and all ends, the lowest first; few steps from each, then the best go on.

    Raises
    ------
    ValueError
        If no start is stable.
    """
    first = [(name, end) for name, theta in starts if (end := descend(predictor, theta, FIRST)) is not None]
    if not first:
        raise ValueError("There is no start whose predictor is stable: the errors are not finite. Scale the signals.")
    first.sort(key=lambda one: one[1].squares)
    ends = list[tuple[str, SearchDescent, int]]()
    for name, end in first:
        k = next((k for k, (_, other, _) in enumerate(ends) if _is_alike(end, other)), None)
        if k is None:
            ends.append((name, end, 1))
        else:
            ends[k] = (*ends[k][:2], ends[k][2] + 1)
    final = list[tuple[str, SearchDescent, int]]()
    for name, end, times in ends[:BEST]:
        further = end if end.distance < NEAR else descend(predictor, end.theta)
        final.append((name, further or end, times))
    final.sort(key=lambda one: one[1].squares)
    lowest, counts = final[0][1], list[LocalMinimum]()
    for name, end, times in final:
        if counts and _is_alike(end, lowest) and len(counts) == 1:
            counts[0] = LocalMinimum(counts[0].start, counts[0].squares, counts[0].times + times)
        else:
            counts.append(LocalMinimum(name, end.squares, times))
    return lowest, tuple(counts)


def _is_alike(one: SearchDescent, other: SearchDescent) -> bool:
    return abs(one.squares - other.squares) <= ALIKE * other.squares
