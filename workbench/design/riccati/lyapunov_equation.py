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

from workbench.design.matrices import EPS, Certificate, Complex, Refused, invertible, one_thread, square, symmetric
from workbench.design.riccati.algebraic_equation import norm, size
from workbench.design.riccati.conditioning import Exponents, balance, in_range, nearest, times
from workbench.design.riccati.double_double import twice
from workbench.design.riccati.operators import AbstractOperator, lyapunov_operator, stein_operator
from workbench.design.riccati.stabilisation import (
    ROUNDING,
    UNSEEN,
    WORST_ERROR,
    WORST_MOVE,
    WORST_RESIDUAL,
    WORTH_A_WARNING,
    figure,
)
from workbench.validation.refusals import Array
from workbench.validation.signatures import door
from workbench.validation.views import show

MOST_STEPS = 40  # each gains about as many digits as the first solution has
POWER_STEPS = 12  # of the iteration for the norm of the inverse, which soon has its first digit


@door
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


@door
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
@show
class Lyapunov:
    """The solution X (n, n) of a Lyapunov equation, the eigenvalues (n,) of A, and how far X can be trusted."""

    X: Array
    poles: Complex
    certificate: Certificate


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

    def scaled(self, x: Exponents) -> _Equation:
        """The same equation in units of 2^x."""
        E = None if self.E is None else times(self.E, -x, x)
        return replace(self, A=times(self.A, -x, x), Q=times(self.Q, -x, -x), E=E)

    @property
    def reach(self) -> float:
        """The size of the terms with X over that of X."""
        A, E = norm(self.A), 1.0 if self.E is None else norm(self.E)
        return A * A + E * E if self.discrete else 2 * A * E

    def left(self, X: Array) -> tuple[Array, float]:
        """The residual (n, n), and the norm of its terms."""
        A, E, x = twice(self.A), None if self.E is None else twice(self.E), twice(X)
        beside = x if E is None else x @ E.T
        if self.discrete:
            left = A @ (x @ A.T) - (beside if E is None else E @ beside) + self.Q
        else:
            half = A @ beside
            left = half + half.T + self.Q
        return (left.high + left.high.T) / 2, self.reach * norm(X) + norm(self.Q)


@one_thread()
@np.errstate(all="ignore")  # what leaves the range of floats is seen in residual and error
def _solve(equation: _Equation) -> Lyapunov:
    """X in good units, refined as long as it settles."""
    units = _good_units(equation)
    scaled = equation.scaled(units)
    try:
        operator = scaled.operator()
        if _meeting(operator.poles, equation.discrete)[0] <= ROUNDING * len(units):
            raise np.linalg.LinAlgError("two eigenvalues meet")
        X, steps, correction = _refined(scaled, operator)
        condition, response = _condition(scaled, operator, X, units)
    except ValueError:  # SciPy's answer to what is not finite, and the parent of LinAlgError
        raise Refused(_not_unique(scaled, "is singular within rounding")) from None
    left, terms = scaled.left(X)
    full = in_range(equation.call, "X", times(X, units, units), X)
    residual = norm(left) / terms if terms > 0 else 0.0
    seen = norm(times(correction, units, units)) / norm(full) if full.any() else 0.0
    error = seen + UNSEEN * terms * response  # a bound of what lies below the digits of the residual
    if not (seen <= WORST_ERROR and error <= WORST_MOVE and residual <= WORST_RESIDUAL):
        what = f"leaves X a relative error of up to {error:.1e} and a residual of {residual:.1e}"
        raise Refused(_not_unique(scaled, what))
    certificate = Certificate(
        residual=residual,
        error=max(error, EPS / 2) if full.any() else 0.0,
        condition=condition,
        margin=operator.margin,
        refined=steps,
        warnings=tuple(_warnings(operator.margin, condition, error)),
    )
    return Lyapunov(full, operator.poles, certificate)


def _good_units(equation: _Equation) -> Exponents:
    """The exponents (n,) of units in which the pencil of the equation has rows and columns alike, and X is near one."""
    A = np.abs(equation.A) + (0.0 if equation.E is None else np.abs(equation.E))
    alike = balance(np.block([[A, np.abs(equation.Q)], [np.zeros_like(A), A.T]]), len(A))
    scaled = equation.scaled(alike)
    return np.asarray(alike + nearest(norm(scaled.Q), 2) - nearest(scaled.reach, 2))


def _refined(equation: _Equation, operator: AbstractOperator) -> tuple[Array, int, Array]:
    """X, the number of refinements kept, and the correction that was not kept: the first that is no smaller."""
    X = operator.solve(-equation.Q)
    last = np.inf
    for step in range(MOST_STEPS):
        correction = operator.solve(-equation.left(X)[0])
        if not norm(correction) < last:
            return X, step, correction
        X, last = X + correction, norm(correction)
    return X, MOST_STEPS, correction


def _condition(equation: _Equation, operator: AbstractOperator, X: Array, units: Exponents) -> tuple[float, float]:
    """A bound of the relative change of X over that of A, E and Q, and over the norm of a change of the equation.

    The norms are 2-norms, X in the units of the caller. If all poles lie on one side of the boundary, the bound is
    Kenney's and Hewer's, as for a Riccati equation; if not, it is made of the norm of the operator's inverse.
    """
    if not X.any():
        return 0.0, 0.0
    beside = X if equation.E is None else X @ equation.E.T
    ahead, one = X @ equation.A.T, np.eye(len(X))
    whole = size(times(X, units, units))
    sides = operator.margins() > 0
    if sides.all() or not sides.any():
        both = (ahead, beside) if equation.discrete else (beside, ahead)
        moved = [size(times(operator.solve(P @ P.T), units, units)) / whole for P in (one, *both)]
        E = 0.0 if equation.E is None else size(equation.E)
        sizes = size(equation.Q), 2 * size(equation.A), 2 * E
        total = sum(r * np.sqrt(moved[0]) * np.sqrt(by) for r, by in zip(sizes, moved, strict=True) if r)
        return float(total), moved[0]
    adjoint = equation.operator(adjoint=True)
    probe, most = one + X / norm(X), 0.0
    for _ in range(POWER_STEPS):  # of power iteration for its largest singular value
        image = times(operator.solve(probe / norm(probe)), units, units)
        most = max(most, norm(image))
        probe = adjoint.solve(times(image / norm(image), units, units))
    return 2 * equation.left(X)[1] * most / whole, most / whole


def _not_unique(equation: _Equation, what: str) -> str:
    values = np.asarray(linalg.eigvals(equation.A, equation.E), dtype=complex)
    _, first, second = _meeting(values, equation.discrete)
    return (
        f"`{equation.call}`: no X can be trusted, as the equation {what}: the eigenvalues {figure(first)} and "
        f"{figure(second)} of A {'have nearly the product 1' if equation.discrete else 'add up to nearly zero'}."
    )


def _meeting(values: Complex, discrete: bool) -> tuple[float, complex, complex]:
    """The least distance of two eigenvalues from the sum 0, or the product 1, relative to the largest; and the two."""
    both = np.multiply.outer(values, values) - 1 if discrete else np.add.outer(values, values)
    i, j = np.unravel_index(np.abs(both).argmin(), both.shape)
    largest = np.abs(values).max()
    near = float(np.abs(both[i, j]) / (max(1.0, largest * largest) if discrete else max(largest, np.finfo(float).tiny)))
    return near, complex(values[i]), complex(values[j])


def _warnings(margin: float, condition: float, error: float) -> Iterator[str]:
    if not margin > 0:
        yield "A is not stable: X solves the equation, but is no covariance and no Gramian"
    if condition * EPS > WORTH_A_WARNING:
        yield f"rounding the data can change X by up to {condition * EPS:.1e} of its size"
    if error > WORTH_A_WARNING:
        yield f"X is known to a relative error of about {error:.1e} only"
