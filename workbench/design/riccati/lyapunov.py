"""The equations of Lyapunov and Stein, refined, with a certificate.

References
----------
Higham (2002), Accuracy and Stability of Numerical Algorithms, 2nd ed., section 16.4 (conditioning).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import linalg

from workbench.core.layout import Array
from workbench.design.certificates import Certificate, Refused
from workbench.design.matrices import EPS, invertible, square, symmetric
from workbench.design.riccati.answers import Lyapunov
from workbench.design.riccati.double_double import twice
from workbench.design.riccati.equation import norm
from workbench.design.riccati.operators import AbstractOperator, lyapunov_operator, stein_operator
from workbench.design.riccati.synthesis import WORST_ERROR, WORST_MOVE, WORTH_A_WARNING

MOST_STEPS = 10  # each gains about as many digits as the first solution has
POWER_STEPS = 12  # of the iteration for the norm of the inverse, which soon has its first digit


def lyapunov(A: Any, Q: Any, E: Any = None) -> Lyapunov:
    """The symmetric X of A X E' + E X A' + Q = 0: the covariance or Gramian of E x' = A x driven by Q.

    X is unique as long as no two eigenvalues of A (of the pencil A - lambda E) add up to zero. The form
    A'X + X A + Q = 0 of Lyapunov's function is `lyapunov(A.T, Q)`.

    Parameters
    ----------
    A, E
        (n, n); without E, the identity.
    Q
        (n, n), symmetric.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q not symmetric, or E singular.
    Refused
        If X is not unique, or cannot be trusted.
    """
    return _solve(_Equation("lyapunov(A, Q)", *_checked("lyapunov(A, Q)", A, Q, E), discrete=False))


def discrete_lyapunov(A: Any, Q: Any, E: Any = None) -> Lyapunov:
    """The symmetric X of A X A' - E X E' + Q = 0: the covariance or Gramian of E x+ = A x driven by Q.

    X is unique as long as no two eigenvalues of A (of the pencil A - lambda E) have the product 1. The form
    A'X A - X + Q = 0 of Lyapunov's function is `discrete_lyapunov(A.T, Q)`.

    Parameters
    ----------
    A, E
        (n, n); without E, the identity.
    Q
        (n, n), symmetric.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q not symmetric, or E singular.
    Refused
        If X is not unique, or cannot be trusted.
    """
    call = "discrete_lyapunov(A, Q)"
    return _solve(_Equation(call, *_checked(call, A, Q, E), discrete=True))


def _checked(call: str, A: Any, Q: Any, E: Any) -> tuple[Array, Array, Array | None]:
    a = square(call, "A", A)
    return a, symmetric(call, "Q", Q, len(a)), None if E is None else invertible(call, "E", E, len(a))


@dataclass(frozen=True)
class _Equation:
    call: str
    A: Array
    Q: Array
    E: Array | None
    discrete: bool

    def operator(self, adjoint: bool = False) -> AbstractOperator:
        """X -> A X E' + E X A' or A X A' - E X E', or its adjoint."""
        A, E = (self.A if adjoint else self.A.T), self.E if adjoint or self.E is None else self.E.T
        return stein_operator(A, E) if self.discrete else lyapunov_operator(A, E)

    def left(self, X: Array) -> tuple[Array, float]:
        """The residual (n, n), and the norm of its terms."""
        A, E, x = twice(self.A), None if self.E is None else twice(self.E), twice(X)
        beside = x if E is None else x @ E.T
        if self.discrete:
            left = A @ (x @ A.T) - (beside if E is None else E @ beside) + self.Q
            size = norm(self.A) ** 2 + (1.0 if self.E is None else norm(self.E) ** 2)
        else:
            half = A @ beside
            left = half + half.T + self.Q
            size = 2 * norm(self.A) * (1.0 if self.E is None else norm(self.E))
        return (left.high + left.high.T) / 2, size * norm(X) + norm(self.Q)


def _solve(equation: _Equation) -> Lyapunov:
    """X in good units, refined as long as the residual falls."""
    _, (scale, _) = linalg.matrix_balance(np.abs(equation.A), permute=False, separate=True)
    E = None if equation.E is None else equation.E / scale[:, None] * scale
    scaled = _Equation(
        equation.call, equation.A / scale[:, None] * scale, equation.Q / scale[:, None] / scale, E, equation.discrete
    )  # fmt: skip
    try:
        operator = scaled.operator()
        X, steps, correction = _refined(scaled, operator)
        condition = _condition(scaled, operator, X)
    except np.linalg.LinAlgError:
        raise Refused(_not_unique(equation, "is singular in floating-point numbers")) from None
    left, size = scaled.left(X)
    full = X * scale[:, None] * scale
    error = norm(correction * scale[:, None] * scale) / norm(full) if full.any() else 0.0
    if not (error <= WORST_ERROR and condition * EPS <= WORST_MOVE):
        raise Refused(
            _not_unique(equation, f"has the condition number {condition:.1e}, and X a relative error of {error:.1e}")
        )
    certificate = Certificate(
        residual=norm(left) / size if size > 0 else 0.0,
        error=max(error, EPS / 2) if full.any() else 0.0,
        condition=condition,
        margin=operator.margin,
        refined=steps,
        warnings=tuple(_warnings(operator.margin, condition)),
    )
    return Lyapunov(full, operator.poles, certificate)


def _refined(equation: _Equation, operator: AbstractOperator) -> tuple[Array, int, Array]:
    """X, the number of refinements kept, and the correction that was not."""
    X = np.zeros_like(equation.Q)
    left, _ = equation.left(X)
    for step in range(MOST_STEPS):
        correction = operator.solve(-left)
        following, _ = equation.left(X + correction)
        if not norm(following) < norm(left):
            break
        X, left = X + correction, following
    return X, max(step - 1, 0), correction


def _condition(equation: _Equation, operator: AbstractOperator, X: Array) -> float:
    """A bound of the relative change of X over that of A, E and Q, by the norm of the operator's inverse."""
    if not X.any():
        return 0.0
    adjoint = equation.operator(adjoint=True)
    size = equation.left(X)[1]
    probe, most = np.eye(len(X)) + norm(X) ** -1 * X, 0.0
    for _ in range(POWER_STEPS):  # of power iteration for its largest singular value
        image = operator.solve(probe / norm(probe))
        most = max(most, norm(image))
        probe = adjoint.solve(image / norm(image))
    return most * 2 * size / norm(X)


def _not_unique(equation: _Equation, what: str) -> str:
    values = np.atleast_1d(linalg.eigvals(equation.A, equation.E))
    meeting = np.abs(np.multiply.outer(values, values) - 1 if equation.discrete else np.add.outer(values, values))
    i, j = np.unravel_index(meeting.argmin(), meeting.shape)
    return (
        f"`{equation.call}`: no X can be trusted, as the equation {what}: the eigenvalues {values[i]:.4g} and "
        f"{values[j]:.4g} of A {'have nearly the product 1' if equation.discrete else 'add up to nearly zero'}."
    )


def _warnings(margin: float, condition: float) -> Iterator[str]:
    if not margin > 0:
        yield "A is not stable: X solves the equation, but is no covariance and no Gramian"
    if condition * EPS > WORTH_A_WARNING:
        yield f"rounding the data can change X by up to {condition * EPS:.1e} of its size"
