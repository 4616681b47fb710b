"""Newton's method on a Riccati equation, with its residual in twice the working precision.

References
----------
Kleinman (1968), On an iterative technique for Riccati equation computations, IEEE Trans. Autom. Control 13.
Hewer (1971), An iterative technique for the computation of the steady state gains for the discrete optimal
regulator, IEEE Trans. Autom. Control 16.
"""

from __future__ import annotations

from dataclasses import dataclass

from workbench.design.matrices import EPS
from workbench.design.riccati.equation import AbstractEquation, Point, norm
from workbench.design.riccati.operators import AbstractOperator
from workbench.validation.refusals import Array

MOST_STEPS = 30  # near a solution a step doubles the digits, far from it or at the edge of stability it halves the way


@dataclass(frozen=True)
class Refined:
    """Where Newton's method ended.

    Parameters
    ----------
    point, operator
        The equation at the last X that was kept, and its derivative there.
    steps
        How many steps were kept.
    correction
        The next step (n, n), which was not kept: to first order, what X still lacks.
    """

    point: Point
    operator: AbstractOperator
    steps: int
    correction: Array


def refine(equation: AbstractEquation, X: Array) -> Refined:
    """Newton's method from X, as long as each step makes the residual smaller.

    Where the residual is below the working precision it says no more: there the next step must be shorter by half,
    until it is below the last digit of X.

    Raises
    ------
    LinAlgError
        If there is no gain or no step at an X on the way.
    """
    now = _looked_at(equation, X, 0)
    while now.steps < MOST_STEPS:
        if norm(now.correction) <= EPS * norm(now.point.X):
            return now
        blind = now.point.relative <= EPS
        following = equation.at(now.point.X + now.correction)
        if following.relative > EPS and not following.relative < now.point.relative:
            return now
        then = _looked_at(equation, following.X, now.steps + 1)
        if blind and not 2 * norm(then.correction) < norm(now.correction):
            return now
        now = then
    return now  # what is left is judged as any other answer


def _looked_at(equation: AbstractEquation, X: Array, steps: int) -> Refined:
    point = equation.at(X)
    operator = equation.operator(point)
    return Refined(point, operator, steps, operator.solve(-point.left))
