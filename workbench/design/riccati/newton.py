"""Newton's method on a Riccati equation, with its residual in twice the working precision.

References
----------
Kleinman (1968), On an iterative technique for Riccati equation computations, IEEE Trans. Autom. Control 13.
Hewer (1971), An iterative technique for the computation of the steady state gains for the discrete optimal
regulator, IEEE Trans. Autom. Control 16.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.layout import Array
from workbench.design.riccati.equation import AbstractEquation, Point
from workbench.design.riccati.operators import AbstractOperator

MOST_STEPS = 60  # far from the solution a step about halves the way, near it doubles the digits


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

    Raises
    ------
    LinAlgError
        If a gain or a step does not exist.
    """
    point = equation.at(X)
    for steps in range(MOST_STEPS):
        operator = equation.operator(point)
        correction = operator.solve(-point.left)
        following = equation.at(point.X + correction)
        if not following.relative < point.relative:
            return Refined(point, operator, steps, correction)
        point = following
    raise np.linalg.LinAlgError("Newton's method did not end")
