"""The equations of Lyapunov and Stein, refined, with a certificate.

References
----------
Higham (2002), Accuracy and Stability of Numerical Algorithms, 2nd ed., section 16.4 (conditioning).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy import linalg

from workbench.core.layout import Array
from workbench.design.certificates import Certificate, Refused
from workbench.design.matrices import EPS, Complex, invertible, square, symmetric
from workbench.design.riccati.answers import Lyapunov
from workbench.design.riccati.diagnosis import figure
from workbench.design.riccati.double_double import twice
from workbench.design.riccati.equation import norm, size
from workbench.design.riccati.one_thread import one_thread
from workbench.design.riccati.operators import AbstractOperator, lyapunov_operator, stein_operator
from workbench.design.riccati.synthesis import ROUNDING, WORST_ERROR, WORST_RESIDUAL, WORTH_A_WARNING
from workbench.design.riccati.units import balance

MOST_STEPS = 40  # each gains about as many digits as the first solution has
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
            terms = norm(self.A) ** 2 + (1.0 if self.E is None else norm(self.E) ** 2)
        else:
            half = A @ beside
            left = half + half.T + self.Q
            terms = 2 * norm(self.A) * (1.0 if self.E is None else norm(self.E))
        return (left.high + left.high.T) / 2, terms * norm(X) + norm(self.Q)


@one_thread()
def _solve(equation: _Equation) -> Lyapunov:
    """X in good units, refined as long as it settles."""
    scale = _good_units(equation)
    scaled = _measured(equation, scale)
    try:
        operator = scaled.operator()
        if _meeting(operator.poles, equation.discrete)[0] <= ROUNDING * len(scale):
            raise Refused(_not_unique(equation, "is singular within rounding"))
        X, steps, correction = _refined(scaled, operator)
        full = X * scale[:, None] * scale
        error = norm(correction * scale[:, None] * scale) / norm(full) if full.any() else 0.0
        condition = _condition(scaled, operator, X, scale)
    except np.linalg.LinAlgError:
        raise Refused(_not_unique(equation, "is singular in floating-point numbers")) from None
    left, terms = scaled.left(X)
    residual = norm(left) / terms if terms > 0 else 0.0
    if not (error <= WORST_ERROR and residual <= WORST_RESIDUAL):
        raise Refused(
            _not_unique(equation, f"leaves X a relative error of {error:.1e} and a residual of {residual:.1e}")
        )
    certificate = Certificate(
        residual=residual,
        error=max(error, EPS / 2) if full.any() else 0.0,
        condition=condition,
        margin=operator.margin,
        refined=steps,
        warnings=tuple(_warnings(operator.margin, condition)),
    )
    return Lyapunov(full, operator.poles, certificate)


def _good_units(equation: _Equation) -> Array:
    """Powers of two that the states are measured by, (n,): the pencil of the equation has rows and columns alike."""
    A = np.abs(equation.A) + (0.0 if equation.E is None else np.abs(equation.E))
    return balance(np.block([[A, np.abs(equation.Q)], [np.zeros_like(A), A.T]]), len(A))


def _measured(equation: _Equation, scale: Array) -> _Equation:
    E = None if equation.E is None else equation.E / scale[:, None] * scale
    A, Q = equation.A / scale[:, None] * scale, equation.Q / scale[:, None] / scale
    return replace(equation, A=A, Q=Q, E=E)


def _refined(equation: _Equation, operator: AbstractOperator) -> tuple[Array, int, Array]:
    """X, the number of refinements kept, and the correction that was not: the first that is no smaller.

    The residual falls to rounding at once, also where X has no digit yet; the corrections show how X settles.
    """
    X = operator.solve(-equation.Q)
    last = np.inf
    for step in range(MOST_STEPS):
        correction = operator.solve(-equation.left(X)[0])
        if not norm(correction) < last:
            return X, step, correction
        X, last = X + correction, norm(correction)
    return X, MOST_STEPS, correction


def _condition(equation: _Equation, operator: AbstractOperator, X: Array, scale: Array) -> float:
    """A bound of the relative change of X over that of A, E and Q, in 2-norms.

    If all poles lie on one side of the boundary, it is Kenney's and Hewer's, as for a Riccati equation; if not,
    it is made of the norm of the operator's inverse.
    """
    if not X.any():
        return 0.0
    beside = X if equation.E is None else X @ equation.E.T
    ahead = X @ equation.A.T
    sizes = [0.0 if matrix is None else size(matrix) for matrix in (equation.Q, equation.A, equation.E)]
    whole = size(X * scale[:, None] * scale)
    sides = operator.margins() > 0
    if sides.all() or not sides.any():
        one, by_A, by_E = (
            size(operator.solve(P @ P.T) * scale[:, None] * scale)
            for P in ((np.eye(len(X)), ahead, beside) if equation.discrete else (np.eye(len(X)), beside, ahead))
        )
        return float(sizes[0] * one + 2 * sizes[1] * np.sqrt(one * by_A) + 2 * sizes[2] * np.sqrt(one * by_E)) / whole
    adjoint = equation.operator(adjoint=True)
    probe, most = np.eye(len(X)) + X / norm(X), 0.0
    for _ in range(POWER_STEPS):  # of power iteration for its largest singular value
        image = operator.solve(probe / norm(probe))
        most = max(most, norm(image))
        probe = adjoint.solve(image / norm(image))
    return most * 2 * equation.left(X)[1] * float(scale.max() ** 2) / whole


def _not_unique(equation: _Equation, what: str) -> str:
    values = np.asarray(linalg.eigvals(equation.A, equation.E), dtype=complex)
    _, first, second = _meeting(values, equation.discrete)
    return (
        f"`{equation.call}`: no X can be trusted, as the equation {what}: the eigenvalues {figure(first)} and "
        f"{figure(second)} of A {'have nearly the product 1' if equation.discrete else 'add up to nearly zero'}."
    )


def _meeting(values: Complex, discrete: bool) -> tuple[float, complex, complex]:
    """How near two eigenvalues come to the sum 0, or the product 1, over the largest one or its square; and which."""
    both = np.multiply.outer(values, values) - 1 if discrete else np.add.outer(values, values)
    i, j = np.unravel_index(np.abs(both).argmin(), both.shape)
    largest = float(np.abs(values).max())
    near = float(np.abs(both[i, j])) / (max(1.0, largest**2) if discrete else max(largest, np.finfo(float).tiny))
    return near, complex(values[i]), complex(values[j])


def _warnings(margin: float, condition: float) -> Iterator[str]:
    if not margin > 0:
        yield "A is not stable: X solves the equation, but is no covariance and no Gramian"
    if condition * EPS > WORTH_A_WARNING:
        yield f"rounding the data can change X by up to {condition * EPS:.1e} of its size"
