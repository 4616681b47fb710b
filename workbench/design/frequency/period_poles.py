"""Poles of the map of one period, with an error for each; those at zero are split off first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, matrix_balance, svd

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.design.matrices import EPS, Complex, DesignError


@dataclass(frozen=True, eq=False)
@show
class PeriodPoles:
    """The poles z, `values` (nx,), of the map of one period of `period` s, the largest first, and their `errors` (nx,).

    The error is a first-order estimate for rounding of the matrix: about the condition of the pole times the rounding
    unit.
    """

    period: float
    values: Complex
    errors: Array

    @property
    def stable(self) -> bool:
        """True if all poles lie inside the unit circle by more than their errors."""
        return bool((np.abs(self.values) + self.errors < 1).all())


def period_poles(call: str, period: float, change: Array, products: int = 1) -> PeriodPoles:
    """The poles of I + `change`, where `change` (nx, nx) is that of the state over a period, from so many products.

    Near z = 1, where all poles of a fast computer lie, they are as accurate as the change is, not as I is. A chain of
    delays that no feedback closes has a defective pole at zero, which rounding would scatter: null spaces of the map
    are split off until none is left.
    """
    change, zeros = _without_zeros(change)
    values, errors = np.zeros(0, complex), np.zeros(0)
    if len(change):
        found, left, right = eig(change, left=True, right=True)  # type: ignore[misc]
        across = np.abs(np.einsum("ij,ij->j", left.conj(), right))  # both have columns of length one
        values = 1 + found
        with np.errstate(divide="ignore"):
            errors = (len(change) + products) * EPS * (1 + np.linalg.norm(change, 2) / across)
    values, errors = np.concatenate([values, np.zeros(zeros)]), np.concatenate([errors, np.full(zeros, EPS)])
    if not np.isfinite(values).all():
        raise DesignError(f"`{call}`: the poles of the period's map leave the range of floating-point numbers.")
    order = np.lexsort((-values.imag, -np.round(np.abs(values), 12)))
    return PeriodPoles(period, values[order], errors[order])


def _without_zeros(change: Array) -> tuple[Array, int]:
    """The change without the part on which the map I + change is nilpotent, and the size of that part."""
    size = len(change)
    while len(change):
        change = np.asarray(matrix_balance(change, permute=False)[0])
        _, sizes, rows = svd(np.eye(len(change)) + change)
        kept = int((sizes > 10 * size * EPS * max(sizes[0], 1.0)).sum())
        if kept == len(change):
            break
        rest = rows[:kept].T  # what is orthogonal to the null space
        change = rest.T @ change @ rest
    return change, size - len(change)
