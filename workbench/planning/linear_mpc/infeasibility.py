r"""Proof that no input keeps the limits from a state: a Farkas vector, checked in exact rational arithmetic.

For any multipliers lambda of the rows that are no inputs, every u within the rows has

    p_0'x_0 + sum c_k'u_k  =  sum lambda_i y_i  <=  sum (lambda_i^+ high_i - lambda_i^- low_i),

p_k = A'p_{k+1} + F'lambda_k, c_k = B'p_{k+1} + E'lambda_k. If the least value of the left side over the box of the
inputs exceeds the right side, no u exists. The check needs no property of lambda, so that it is a proof for the
matrices as given whatever rounding made lambda. Reference: Boyd and Vandenberghe (2004), section 5.8.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.planning.linear_mpc.linear_problem import LinearMpc

KEPT = 1e-9  # of the largest multiplier: smaller ones are rounding, and the proof does without them


@dataclass(frozen=True, eq=False)
@show
class InfeasibilityProof:
    """A proof that a problem has no solution from a state.

    Parameters
    ----------
    limits
        The names of limits that conflict: without any one of them the others named here can be kept.
    multipliers
        (N, nc), the Farkas vector; zero for the inputs.
    margin
        By how much the limits are missed, for multipliers of largest entry 1.
    is_proved
        True if the margin is above zero in exact arithmetic. It is False where an input without limits acts on the
        sum: then the conflict holds to rounding.
    """

    limits: tuple[str, ...]
    multipliers: Array
    margin: float
    is_proved: bool


class MpcConflictError(ValueError):
    """The error of a state from which no input keeps all limits; `proof` has the limits at fault and their proof."""

    def __init__(self, message: str, proof: InfeasibilityProof) -> None:
        ValueError.__init__(self, message)
        self.proof = proof


def farkas_margin(problem: LinearMpc, x: Array, multipliers: Array) -> tuple[float, bool]:
    """The margin by which multipliers (N, nc) refute the limits from x (nx,), and True if it is exact."""
    nu = problem.B.shape[1]
    lam = np.where(np.abs(multipliers) > KEPT * np.abs(multipliers).max(), multipliers, 0.0)
    lam[:, :nu] = 0.0
    if not lam.any():
        return 0.0, False
    A, B, F, E = (_exact(m) for m in (problem.A, problem.B, problem.rows.F, problem.rows.E))
    low, high = problem.rows.low, problem.rows.high
    p, total, is_exact = [Fraction(0)] * len(problem.A), Fraction(0), True
    for row in lam[::-1]:
        weights = [Fraction(float(value)) for value in row]
        for c, a, b in zip(_sum(B, p, E, weights), low, high, strict=False):
            end = b if c < 0 else a
            if c and not np.isfinite(end):
                is_exact = False
            elif c:
                total += c * Fraction(float(end))
        for weight, a, b in zip(weights, low, high, strict=True):
            if weight:
                total -= weight * Fraction(float(b if weight > 0 else a))
        p = _sum(A, p, F, weights)
    total += sum((Fraction(float(value)) * entry for value, entry in zip(x, p, strict=True)), Fraction(0))
    margin = float(total / Fraction(float(np.abs(lam).max())))
    return margin, is_exact and total > 0


def _exact(matrix: Array) -> list[list[tuple[int, Fraction]]]:
    """The columns of a matrix by their entries that are not zero."""
    return [[(int(i), Fraction(float(column[i]))) for i in np.flatnonzero(column)] for column in matrix.T]


def _sum(
    first: list[list[tuple[int, Fraction]]],
    p: Sequence[Fraction],
    second: list[list[tuple[int, Fraction]]],
    weights: Sequence[Fraction],
) -> list[Fraction]:
    """first'p + second'weights."""
    return [
        sum((value * p[i] for i, value in a), Fraction(0)) + sum((value * weights[i] for i, value in b), Fraction(0))
        for a, b in zip(first, second, strict=True)
    ]
