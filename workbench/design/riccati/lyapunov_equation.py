"""The equations of Lyapunov and Stein, which are Riccati equations without inputs, refined, with a certificate.

References
----------
Higham (2002), Accuracy and Stability of Numerical Algorithms, 2nd ed., section 16.4 (conditioning).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.matrices import (
    EPS,
    Certificate,
    Complex,
    DesignError,
    invertible,
    one_thread,
    pole_text,
    square,
    symmetric,
)
from workbench.design.riccati.algebraic_equation import Data, Operator, RiccatiEquation, norm, size
from workbench.design.riccati.conditioning import BinaryUnits, conditioning, good_units, in_range
from workbench.design.riccati.newton import NewtonResult
from workbench.design.riccati.stabilising_solution import (
    RESIDUAL_ROUNDING,
    ROUNDING,
    WORST_ERROR,
    WORST_MOVE,
    WORST_RESIDUAL,
    doubts,
)

MOST_STEPS = 40  # each gains about as many digits as the first solution has
UNSTABLE = "A is not stable: X solves the equation, but is no covariance and no Gramian"
POWER_STEPS = 12  # of the iteration for the norm of the inverse, which soon has its first digit


@dataclass(frozen=True)
@show
class Lyapunov:
    """The solution X (n, n) of a Lyapunov equation; the `poles` (n,) are the eigenvalues of A; with a certificate."""

    X: Array
    poles: Complex
    certificate: Certificate


@check_arguments
def lyapunov(A: Numbers, Q: Numbers, E: Numbers | None = None) -> Lyapunov:
    """The symmetric X of A X E' + E X A' + Q = 0: the covariance or Gramian of E x' = A x driven by Q.

    X is unique as long as no two eigenvalues of A (of the pencil A - lambda E) add up to zero. The form
    A'X + X A + Q = 0 of Lyapunov's function is `lyapunov(A.T, Q)`.

    Parameters
    ----------
    A, E, Q
        (n, n), Q symmetric; without E, the identity.

    Raises
    ------
    ValueError
        If a matrix is not real, finite, or of its shape, Q not symmetric, or E singular.
    DesignError
        If X is not unique, or cannot be trusted.

    Examples
    --------
    >>> from workbench.design.riccati import lyapunov
    >>> lyapunov(np.diag([-1.0, -2.0]), np.eye(2)).X.round(3)
    array([[0.5 , 0.  ],
           [0.  , 0.25]])
    """
    return _solve("lyapunov(A, Q)", A, Q, E, discrete=False)


@check_arguments
def discrete_lyapunov(A: Numbers, Q: Numbers, E: Numbers | None = None) -> Lyapunov:
    """The symmetric X of A X A' - E X E' + Q = 0: the covariance or Gramian of E x+ = A x driven by Q.

    X is unique as long as no two eigenvalues of A (of the pencil A - lambda E) have the product 1. Shapes and refusals
    are those of `lyapunov`.

    Examples
    --------
    >>> from workbench.design.riccati import discrete_lyapunov
    >>> discrete_lyapunov(np.diag([0.5, 0.25]), np.eye(2)).X.round(3)
    array([[1.333, 0.   ],
           [0.   , 1.067]])
    """
    return _solve("discrete_lyapunov(A, Q)", A, Q, E, discrete=True)


@one_thread()
@np.errstate(all="ignore")  # what leaves the range of floats is seen in residual and error
def _solve(call: str, A: Numbers, Q: Numbers, E: Numbers | None, discrete: bool) -> Lyapunov:
    a = square(call, "A", A)
    n, nothing = len(a), np.zeros((len(a), 1))
    e = None if E is None else invertible(call, "E", E, n).T
    data = Data(A=a.T, B=nothing, Q=symmetric(call, "Q", Q, n), R=np.eye(1), S=nothing, E=e)
    units = good_units(data)
    equation = RiccatiEquation(units.into(data), discrete)
    try:
        found = _refine(equation)
        X = in_range(call, "X", units.out_of(found.point.X), found.point.X)
        condition, response = _condition(equation, found, units)
    except DesignError:
        raise
    except ValueError:  # SciPy's answer to what is not finite, and the parent of LinAlgError
        raise DesignError(_not_unique(call, equation, "is singular within rounding")) from None
    point, margin = found.point, found.operator.margin
    seen = norm(units.out_of(found.correction)) / norm(X) if X.any() else 0.0
    error = seen + RESIDUAL_ROUNDING * point.terms * response  # a bound of what lies below the digits of the residual
    if not (seen <= WORST_ERROR and error <= WORST_MOVE and point.relative <= WORST_RESIDUAL):
        what = f"leaves X a relative error of up to {error:.1e} and a residual of {point.relative:.1e}"
        raise DesignError(_not_unique(call, equation, what))
    certificate = Certificate(
        residual=point.relative,
        error=max(error, EPS / 2) if X.any() else 0.0,
        condition=condition,
        decay_rate=margin,
        newton_steps=found.steps,
        warnings=(*(() if margin > 0 else (UNSTABLE,)), *doubts(condition, error)),
    )
    return Lyapunov(X, found.operator.poles, certificate)


def _refine(equation: RiccatiEquation) -> NewtonResult:
    """X with the smallest correction, refined until two corrections in a row are no smaller than that one."""
    d = equation.data
    operator = Operator.of(d.A, d.E, equation.discrete)
    if _nearest_pair(operator.poles, equation.discrete)[0] <= ROUNDING * d.n:
        raise np.linalg.LinAlgError("two eigenvalues meet")
    X, best, failures = operator.solve(-d.Q), None, 0
    for steps in range(MOST_STEPS + 1):
        point = equation.at(X)
        correction = operator.solve(-point.residual)
        # where the first solution has few digits, a correction may be larger than the one before it, once
        failures = 0 if best is None or norm(correction) < norm(best.correction) else failures + 1
        if best is None or not failures:
            best = NewtonResult(point, operator, steps, correction)
        if failures == 2:
            break
        X = X + correction
    assert best is not None
    return best


def _condition(equation: RiccatiEquation, solution: NewtonResult, units: BinaryUnits) -> tuple[float, float]:
    """A bound of the relative change of X over that of A, E and Q, and over the norm of a change of the equation.

    If all poles lie on one side of the boundary, the bound is that of a Riccati equation; if not, it is made of the
    norm of the operator's inverse.
    """
    X, d, operator = solution.point.X, equation.data, solution.operator
    if not X.any():
        return 0.0, 0.0
    whole = size(units.out_of(X))
    stable = operator.margins > 0
    if stable.all() or not stable.any():
        known = conditioning(equation, solution, units)
        return known.condition, known.response / whole
    adjoint = Operator.of(d.A.T, None if d.E is None else d.E.T, equation.discrete)
    probe, most = np.eye(len(X)) + X / norm(X), 0.0
    for _ in range(POWER_STEPS):  # of power iteration for its largest singular value
        image = units.out_of(operator.solve(probe / norm(probe)))
        most = max(most, norm(image))
        probe = adjoint.solve(units.out_of(image / norm(image)))
    return 2 * solution.point.terms * most / whole, most / whole


def _not_unique(call: str, equation: RiccatiEquation, what: str) -> str:
    values = np.asarray(linalg.eigvals(equation.data.A, equation.data.E), dtype=complex)
    _, first, second = _nearest_pair(values, equation.discrete)
    return (
        f"`{call}`: no X can be trusted, as the equation {what}: the eigenvalues {pole_text(first)} and "
        f"{pole_text(second)} of A {'have nearly the product 1' if equation.discrete else 'add up to nearly zero'}."
    )


def _nearest_pair(values: Complex, discrete: bool) -> tuple[float, complex, complex]:
    """The least distance of two eigenvalues from the sum 0, or the product 1, relative to the largest; and the two."""
    both = np.multiply.outer(values, values) - 1 if discrete else np.add.outer(values, values)
    i, j = np.unravel_index(np.abs(both).argmin(), both.shape)
    largest = np.abs(values).max()
    near = float(np.abs(both[i, j]) / (max(1.0, largest * largest) if discrete else max(largest, np.finfo(float).tiny)))
    return near, complex(values[i]), complex(values[j])
