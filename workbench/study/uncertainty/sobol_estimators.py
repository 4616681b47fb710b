"""Sobol indices of columns of runs from means of products, with the jackknife over independent scrambles.

A quadratic polynomial serves as control variate: what it explains has exact indices, and only the rest is estimated.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.study.uncertainty.sobol_design import SCRAMBLES, SobolDesign

Means = dict[str, Array]
EACH = 4  # runs for each coefficient, below which a fit follows the runs instead of the function


def column_indices(design: SobolDesign, y: Array, t: float, groups: Array, control: bool) -> tuple[object, ...]:
    """Of columns (N, c) the values and halves of intervals (c, ...) of S1, of ST, of S2 and of the sums of S1 and of ST
    over groups (G, d) of factors; True where a factor moves nothing (c, d); and the standard deviations (c,).
    """
    blocks = (SCRAMBLES, -1, design.block, y.shape[1])
    runs = y.reshape(blocks)  # (scrambles, pairs of points, block, c)
    unmoved = (runs[:, :, 1 : 1 + design.dimensions] == runs[:, :, :1]).all(axis=(0, 1))
    means_of = _means_of_both if design.second_order else _means
    means = means_of(runs, design.dimensions)
    if control:
        fitted, b = polynomials(design, y)
        of_fit, known = means_of(fitted.reshape(blocks), design.dimensions), exact(design, b)
        means = {name: mean - of_fit[name] + known[name] for name, mean in means.items()}
    order = _of_both if design.second_order else _of_one
    deviation = runs[:, :, [0, -1]].std(axis=(0, 1, 2))

    def statistic(m: Means) -> tuple[Array, ...]:
        first, total, second = order(m)
        return first, total, second, *(np.einsum("gd,...dc->...gc", groups, part) for part in (first, total))

    return *_jackknife(means, statistic, t), unmoved.T, deviation


def _means(runs: Array, d: int) -> Means:
    """The means of the products behind S1 and ST, (scrambles, 1 or d, c) each."""
    A, AB, B = runs[:, :, :1], runs[:, :, 1 : 1 + d], runs[:, :, -1:]
    return {
        "first": (B * (AB - A)).mean(axis=1),
        "total": ((A - AB) ** 2).mean(axis=1) / 2,
        "mean": (A + B).mean(axis=1) / 2,
        "square": (A**2 + B**2).mean(axis=1) / 2,
    }


def _of_one(m: Means) -> tuple[Array, Array, Array]:
    variance = m["square"] - m["mean"] ** 2
    return m["first"] / variance, m["total"] / variance, np.empty((*m["first"].shape[:-2], 0, m["first"].shape[-1]))


def _means_of_both(runs: Array, d: int) -> Means:
    """The means of the products behind all three orders of indices, each from both halves of the runs."""
    A, AB, BA, B = runs[:, :, :1], runs[:, :, 1 : 1 + d], runs[:, :, 1 + d : -1], runs[:, :, -1:]
    from_A, from_B = AB - A, BA - B
    cross = np.einsum("smic,smjc->sijc", from_B, from_A, optimize=True) / A.shape[1]
    i, j = np.triu_indices(AB.shape[2], 1)
    variance = (((A - B) ** 2).mean(axis=1) + ((AB - BA) ** 2).mean(axis=1)) / 4
    return {
        "first": -np.einsum("siic->sic", cross) / 2,
        "total": ((from_A**2).mean(axis=1) + (from_B**2).mean(axis=1)) / 4,
        "second": (cross[:, i, j] + cross[:, j, i]) / 2,
        "variance": variance,
        "variance of pairs": (variance[:, i] + variance[:, j]) / 2,
    }


def _of_both(m: Means) -> tuple[Array, Array, Array]:
    return m["first"] / m["variance"], m["total"] / m["variance"], m["second"] / m["variance of pairs"]


def _jackknife(means: Means, statistic: Callable[[Means], tuple[Array, ...]], t: float) -> tuple[Array, ...]:
    """A statistic of means with its intervals, from those of the scrambles and of all scrambles but one."""
    with np.errstate(divide="ignore", invalid="ignore"):  # no variance without the one scramble that has all of it
        values = statistic({key: mean.mean(axis=0) for key, mean in means.items()})
        without = statistic({k: (m.sum(axis=0) - m) / (SCRAMBLES - 1) for k, m in means.items()})
        halves = [t * np.sqrt((SCRAMBLES - 1) * part.var(axis=0)) for part in without]
    bounded = (np.where(np.isfinite(half), half, np.inf) for half in halves)
    return tuple(part.T for pair in zip(values, bounded, strict=True) for part in pair)


def terms(dimensions: int) -> int:
    """The number of terms of the polynomial beside its constant."""
    return dimensions * (dimensions + 3) // 2


def basis(u: Array) -> Array:
    """Orthonormal polynomials at points (N, d) of the unit cube, (N, terms): lines, parabolas, products of lines."""
    i, j = np.triu_indices(u.shape[1], 1)
    line = 12**0.5 * (u - 0.5)
    return np.concatenate([line, 5**0.5 * (line**2 - 1) / 2, line[:, i] * line[:, j]], axis=1)


def polynomials(design: SobolDesign, y: Array) -> tuple[Array, Array]:
    """The polynomials of columns (N, c) in each scramble, fitted to the runs of all other scrambles: their values
    (N, c), without the constant, and their coefficients (scrambles, terms, c).
    """
    u = design.points()
    X = np.column_stack([np.ones(len(u)), basis(u)]).reshape(SCRAMBLES, len(u) // SCRAMBLES, -1)
    # normal equations: over so many points the polynomials are nearly orthonormal, so that no digits are lost
    squares, products = np.swapaxes(X, 1, 2) @ X, np.swapaxes(X, 1, 2) @ y.reshape(*X.shape[:2], -1)
    b = np.linalg.solve(squares.sum(axis=0) - squares, products.sum(axis=0) - products)[:, 1:]
    return (X[:, :, 1:] @ b).reshape(y.shape), b


def exact(design: SobolDesign, b: Array) -> dict[str, Array]:
    """The expectations of all means of products for polynomials with coefficients (scrambles, terms, c)."""
    d = design.dimensions
    i, j = np.triu_indices(d, 1)
    squares = b**2
    alone, pairs = squares[:, :d] + squares[:, d : 2 * d], squares[:, 2 * d :]
    inside = (np.arange(d)[:, np.newaxis] == i) | (np.arange(d)[:, np.newaxis] == j)
    variance = squares.sum(axis=1, keepdims=True)
    return {
        "first": alone,
        "total": alone + np.einsum("dk,skc->sdc", inside, pairs),
        "second": pairs,
        "mean": 0 * variance,
        "square": variance,
        "variance": variance,
        "variance of pairs": variance,
    }
