"""Poles, zeros, minimal order, normal rank and relative degree of a linear system, every rank decided exactly."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.complex_roots import complex_roots
from workbench.design.frequency.exact_systems import exact_state_space
from workbench.design.frequency.integer_polynomials import Polynomial, common_divisor
from workbench.design.frequency.rational_matrices import markov_parameters, whole
from workbench.design.frequency.rational_systems import RationalSystem
from workbench.design.frequency.transfer_polynomials import TransferPolynomials
from workbench.design.matrices import Complex

if TYPE_CHECKING:
    import control

MOST_CHANNELS = 6  # of a system whose determinant is expanded
COMBINATIONS = (3, 7)  # powers of these weigh the outputs or inputs that are too many


@dataclass(frozen=True, eq=False)
@show
class Roots:
    """The roots of a polynomial: `values` (n,), a repeated one as often as it occurs, and the multiplicity of each."""

    values: Complex
    multiplicities: tuple[int, ...]

    def __len__(self) -> int:
        """The number of roots, each with its multiplicity."""
        return len(self.values)


@dataclass(frozen=True, eq=False)
@show
class PoleZeroStructure:
    """The poles and zeros of a system, accurate to the last digits of a double, and its orders and ranks, exactly.

    `poles` are the eigenvalues of A, `invariant_zeros` the roots of the Smith form of the system pencil [A - s I, B;
    C, D], `transmission_zeros` those of a minimal realisation, which has `minimal_order` states. `normal_rank` is the
    rank of the transfer matrix at almost every s, and `relative_degree` the order of its zero at infinity, inf for a
    transfer function that is zero and None for more than one input or output.
    """

    poles: Roots
    invariant_zeros: Roots
    transmission_zeros: Roots
    minimal_order: int
    normal_rank: int
    relative_degree: float | None


@check_arguments
def pole_zero_structure(system: control.StateSpace) -> PoleZeroStructure:
    """The poles and zeros of a system, continuous or discrete, with their multiplicities.

    The matrices are taken as exact numbers, and all ranks are computed exactly, so that no tolerance decides what
    cancels. A cancellation that rounding has spoilt appears as a pole and a zero near each other.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace` with finite matrices.
    DesignError
        If the system has more than 40 states, or two different poles or zeros are too near to each other to be
        distinguished in 2,048 binary digits.

    References
    ----------
    MacFarlane and Karcanias (1976), Poles and zeros of linear multivariable systems, Int. J. Control 24.
    Emami-Naeini and Van Dooren (1982), Computation of zeros of linear multivariable systems, Automatica 18.

    Examples
    --------
    >>> import control
    >>> tanks = control.ss([[-1.0, 1.0], [0.0, -2.0]], [[1.0], [1.0]], [[1.0, 0.0]], 0.0)
    >>> wb.pole_zero_structure(tanks).transmission_zeros.values
    array([-3.+0.j])
    """
    A, B, C, D = exact_state_space("pole_zero_structure", system)
    exact = RationalSystem.of(A, B, C, D)
    minimal = exact.minimal()
    transfer = TransferPolynomials.of(A, B, C, D, discrete=False)
    invariant, rank = _zeros(exact, transfer)
    return PoleZeroStructure(
        _roots(transfer.in_variable(transfer.denominator)),
        invariant,
        invariant if minimal.order == exact.order else _roots(minimal.zero_dynamics().zeros_polynomial()),
        minimal.order,
        rank,
        _relative_degree(A, B, C, D) if D.shape == (1, 1) else None,
    )


def _zeros(exact: RationalSystem, transfer: TransferPolynomials) -> tuple[Roots, int]:
    """The invariant zeros and the normal rank.

    Of a square system with a determinant they are the roots of that of the pencil. A zero of a tall or wide system is
    one of each system that combines its outputs or inputs: where two of these share none, there is none.
    """
    size = min(len(exact.D), exact.nu)
    if size <= MOST_CHANNELS:
        determinants = [transfer.combine_channels(weights).minors()[-1].popitem()[1] for weights in COMBINATIONS]
        if len(exact.D) == exact.nu and any(determinants[0]):
            return _roots(transfer.in_variable(determinants[0])), size
        if len(exact.D) != exact.nu and all(map(any, determinants)) and len(common_divisor(*determinants)) == 1:
            return _roots([1]), size
    reduced = exact.zero_dynamics()
    return _roots(reduced.zeros_polynomial()), len(reduced.D)


def _roots(polynomial: Polynomial) -> Roots:
    values, multiplicities = complex_roots(polynomial)
    return Roots(values, tuple(multiplicities))


def _relative_degree(A: Array, B: Array, C: Array, D: Array) -> float:
    """The number of integrations (or periods) between input and output, by the first of D, C B, ... that is not 0."""
    if D.any():
        return 0
    (a, _), (b, _), (c, _) = whole(A), whole(B), whole(C)
    parameters = markov_parameters(a, b, c, len(A))
    return next((k + 1 for k, parameter in enumerate(parameters) if parameter[0, 0]), math.inf)
