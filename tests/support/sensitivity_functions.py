"""Functions of uniform numbers whose indices are known in closed form, for tests."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.study.uncertainty import AbstractDesign


@dataclass(frozen=True)
class Exact:
    """First-order and total indices (d,), second-order ones by pairs, and the variance."""

    S1: Array
    ST: Array
    S2: dict[tuple[int, int], float]
    variance: float


def ishigami(u: Array) -> Array:
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 over (-pi, pi)^3."""
    x = np.pi * (2 * u - 1)
    return np.asarray(np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))


def ishigami_exact() -> Exact:
    """Ishigami and Homma (1990): the variances of the terms of the decomposition, by hand."""
    V1, V2, V13 = (1 + 0.1 * np.pi**4 / 5) ** 2 / 2, 49 / 8, 0.01 * np.pi**8 * 8 / 225
    V = V1 + V2 + V13
    return Exact(
        np.array([V1, V2, 0]) / V, np.array([V1 + V13, V2, V13]) / V, {(0, 1): 0, (0, 2): V13 / V, (1, 2): 0}, V
    )


def sobol_g(u: Array, a: Array) -> Array:
    """The product of (|4 u_i - 2| + a_i) / (1 + a_i)."""
    return np.asarray(np.prod((np.abs(4 * u - 2) + a) / (1 + a), axis=1))


def sobol_g_exact(a: Array) -> Exact:
    """Saltelli and Sobol (1995): a product of factors with mean 1 and variances V_i."""
    Vi = 1 / (3 * (1 + a) ** 2)
    V = float(np.prod(1 + Vi) - 1)
    ST = [Vi[i] * np.prod(np.delete(1 + Vi, i)) / V for i in range(len(a))]
    S2 = {(i, j): Vi[i] * Vi[j] / V for i in range(len(a)) for j in range(i + 1, len(a))}
    return Exact(Vi / V, np.array(ST), S2, V)


def linear(u: Array, c: Array) -> Array:
    """c . u, whose indices are c_i^2 / c . c and nothing else."""
    return np.asarray(u @ c)


def over(design: AbstractDesign, function: Callable[..., Array], *numbers: Array) -> Array:
    """A function at all points of a design."""
    return function(design.points(), *numbers)
