"""The balanced realisation of a stable system: both Gramians are the diagonal matrix of its Hankel singular values.

References
----------
Moore (1981), Principal component analysis in linear systems, IEEE Trans. Autom. Control 26.
Laub, Heath, Paige and Ward (1987), Computation of system balancing transformations, the same, 32.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.exact_systems import is_stable, not_stable
from workbench.design.frequency.rational_systems import RationalSystem
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError, one_thread
from workbench.design.reduction.fixed_point import FixedPoint
from workbench.design.reduction.gramians import factored_gramians
from workbench.design.reduction.jacobi_rotations import orthogonal_columns

MOST_STATES = 60  # a minute; 30 states take two seconds
WORST_ERROR = 1e-10  # relative, of a Hankel value


@dataclass(frozen=True)
@show
class HankelValues:
    """The Hankel singular values (n,) of a stable system in descending order.

    Each one that is not zero has a relative error of at most `error`, which is measured on both Gramians after
    balancing. The first `minimal_order` are not zero. The others belong to modes that no input drives or no output
    shows, which is decided exactly.
    """

    values: Array
    minimal_order: int
    error: float


@dataclass(frozen=True, eq=False)
class BalancedRealization:
    """The matrices of a balanced realisation of minimal order, with the Hankel values of the whole system."""

    A: Array
    B: Array
    C: Array
    D: Array
    discrete: bool
    hankel: HankelValues

    @property
    def values(self) -> Array:
        """The Hankel values that are not zero."""
        return self.hankel.values[: self.hankel.minimal_order]


@check_arguments
def hankel_values(system: System) -> HankelValues:
    """The Hankel singular values of a stable `StateSpace`, continuous or discrete, to the same relative accuracy.

    They are the square roots of the eigenvalues of the product of both Gramians, and say what each state of the
    balanced realisation adds. No model of order k has an H-infinity error below the value k + 1.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace` with finite matrices.
    DesignError
        If the system is not stable, has more than 60 states, or no digits can be trusted.

    References
    ----------
    Glover (1984), All optimal Hankel-norm approximations of linear multivariable systems and their L-infinity error
    bounds, International Journal of Control 39.

    Examples
    --------
    >>> import control
    >>> wb.reduction.hankel_values(control.ss(-1.0, 1.0, 1.0, 0.0)).values
    array([0.5])
    """
    return balanced_realization("hankel_values", system).hankel


@one_thread()
def balanced_realization(call: str, system: System) -> BalancedRealization:
    """The balanced realisation of a system, or a refusal in the name of a call."""
    A, B, C, D = state_space(call, system)
    n, discrete = len(A), bool(system.isdtime(strict=True))
    if n > MOST_STATES:
        raise DesignError(
            f"`{call}(system)` computes Gramians in long numbers, of at most {MOST_STATES} states; '{system.name}' has "
            f"{n}. Reduce it to {MOST_STATES} states first, by `control.balred` with Slycot say."
        )
    _refuse_unstable(call, A, discrete)
    minimal = RationalSystem.of(A, B, C, D).minimal()
    order = minimal.order
    if order == 0:
        empty = np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((len(D), 0))
        return BalancedRealization(*empty, D, discrete, HankelValues(np.zeros(n), 0, 0.0))
    g = factored_gramians(call, minimal, discrete)
    T = _balancing_states(g.X, g.Y)
    inverse = T.solve(FixedPoint.identity(order, T.bits)) if T is not None else None
    if T is None or inverse is None:
        raise DesignError(_no_digits(call, np.inf))
    values, error = _measured_values(inverse @ g.X, T.T @ g.Y)
    if not error <= WORST_ERROR:
        raise DesignError(_no_digits(call, error))
    hankel = HankelValues(np.concatenate([values, np.zeros(n - order)]), order, error)
    matrices = (inverse @ g.A @ T).doubles(), (inverse @ g.B).doubles(), (g.C @ T).doubles()
    return BalancedRealization(*matrices, D, discrete, hankel)


def _refuse_unstable(call: str, A: Array, discrete: bool) -> None:
    if not is_stable(A, discrete):
        raise DesignError(
            f"`{call}(system)` needs Gramians, and {not_stable(A, discrete)}; stabilise it first, or reduce its stable "
            "part alone."
        )


def _balancing_states(X: FixedPoint, Y: FixedPoint) -> FixedPoint | None:
    """T = X V S^-1/2 for Y'X = U S V', with P = X X' and Q = Y Y'."""
    R, order = (Y.T @ X).pivoted_triangle()
    W = orthogonal_columns(R)
    n, bits = len(order), X.bits
    lengths = [math.isqrt(int(W.numbers[:, j] @ W.numbers[:, j])) for j in range(n)]
    if not all(lengths):
        return None
    V = W.numbers.copy()
    for place, row in zip(order, W.numbers, strict=True):
        V[place] = [(int(x) << bits) // length for x, length in zip(row, lengths, strict=True)]
    descending = sorted(range(n), key=lambda j: -lengths[j])
    factors = [1 / Fraction(math.isqrt(lengths[j] << bits), 2**bits) for j in descending]
    return (X @ FixedPoint(V[:, descending], bits)).scale_columns(factors)


def _measured_values(X: FixedPoint, Y: FixedPoint) -> tuple[Array, float]:
    """The Hankel values from factors of nearly balanced Gramians, with a bound of their relative error.

    If P = G (I + E) G and Q = G (I + F) G with diagonal G, then Ostrowski's theorem bounds the change of each
    eigenvalue of P Q from that of G^4 by the factor (1 + |E|)(1 + |F|), and its inverse with minus signs.
    """
    P, Q = X @ X.T, Y @ Y.T
    n, unit = len(P.numbers), 2**P.bits
    squares = [Fraction(int(P.numbers[i, i]), unit) * Fraction(int(Q.numbers[i, i]), unit) for i in range(n)]
    values = np.sqrt(np.array([float(s) for s in squares]))
    off = 0.0
    for M in (P, Q):
        d = [Fraction(int(M.numbers[i, i]), unit) for i in range(n)]
        pairs = [(i, j) for i in range(n) for j in range(n) if i != j]
        part = sum(float(Fraction(int(M.numbers[i, j]), unit) ** 2 / (d[i] * d[j])) for i, j in pairs)
        off = max(off, float(np.sqrt(part)))
    error = off / (1 - off) + 2.0**-51 if off < 1 else np.inf
    order = np.argsort(-values)
    return values[order], error


def _no_digits(call: str, error: float) -> str:
    return (
        f"`{call}(system)` must know each Hankel value within {WORST_ERROR:g}, and knows them within {error:.1e}; "
        "choose other units, or leave out the weakest modes."
    )
