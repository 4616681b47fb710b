"""Sobol indices of columns of runs from means of products, with the jackknife over independent scrambles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.study.sampling import SobolDesign
from workbench.study.sampling.sobol import SCRAMBLES
from workbench.study.sensitivity.outputs import Estimate, Flags
from workbench.validation.words import Array

Means = dict[str, Array]


@dataclass(frozen=True, eq=False)
class Judged:
    """Some columns: S1, ST and S2 (c, ...), where a factor moves nothing (c, d), and the standard deviations (c,)."""

    indices: tuple[Estimate, Estimate, Estimate]
    unmoved: Flags
    deviation: Array


def judged(design: SobolDesign, y: Array, t: float) -> Judged:
    """What the runs say of some columns (N, c)."""
    d = design.dimensions
    runs = y.reshape(SCRAMBLES, -1, design.block, y.shape[1])  # (scrambles, pairs of points, block, c)
    A, AB, BA, B = runs[:, :, :1], runs[:, :, 1 : 1 + d], runs[:, :, 1 + d : -1], runs[:, :, -1:]
    unmoved = (AB == A).all(axis=(0, 1))
    means = _means_of_both(A, AB, BA, B) if design.second_order else _means(A, AB, B)
    statistic = _of_both if design.second_order else _of_one
    deviation = np.concatenate([A, B], axis=2).std(axis=(0, 1, 2))
    return Judged(_jackknife(means, statistic, t), unmoved.T, deviation)


def _means(A: Array, AB: Array, B: Array) -> Means:
    """Of the products behind S1 and ST, (scrambles, 1 or d, c) each."""
    return {
        "first": (B * (AB - A)).mean(axis=1),
        "total": ((A - AB) ** 2).mean(axis=1) / 2,
        "mean": (A + B).mean(axis=1) / 2,
        "square": (A**2 + B**2).mean(axis=1) / 2,
    }


def _of_one(m: Means) -> tuple[Array, Array, Array]:
    variance = m["square"] - m["mean"] ** 2
    return m["first"] / variance, m["total"] / variance, np.empty((*m["first"].shape[:-2], 0, m["first"].shape[-1]))


def _means_of_both(A: Array, AB: Array, BA: Array, B: Array) -> Means:
    """Of the products behind all three orders, each from both halves of the runs.

    E((BA_i - B)(AB_j - A)) is V_ij, the variance of the interaction, and for i = j it is -2 V_i.
    """
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


def _jackknife(
    means: Means, statistic: Callable[[Means], tuple[Array, Array, Array]], t: float
) -> tuple[Estimate, Estimate, Estimate]:
    """A statistic of means with its intervals, from those of the scrambles and of all scrambles but one."""
    with np.errstate(divide="ignore", invalid="ignore"):  # no variance without the one scramble that has all of it
        values = statistic({key: mean.mean(axis=0) for key, mean in means.items()})
        without = statistic({k: (m.sum(axis=0) - m) / (SCRAMBLES - 1) for k, m in means.items()})
    first, total, second = (_estimate(v, w, t) for v, w in zip(values, without, strict=True))
    return first, total, second


def _estimate(value: Array, without: Array, t: float) -> Estimate:
    """From a value (i, c) and those without each scramble, (scrambles, i, c), to (c, i)."""
    with np.errstate(invalid="ignore"):
        half = t * np.sqrt((SCRAMBLES - 1) * without.var(axis=0))
    return Estimate(value.T, np.where(np.isfinite(half), half, np.inf).T)
