"""The rule `matched` of `c2d`: each pole and zero s by z = e^(s h), and the gain for slow signals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.exponentials import held_map
from workbench.design.frequency.pole_zero_structure import pole_zero_structure
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex, DesignError, pole_text

if TYPE_CHECKING:
    import control

MATCH_TOLERANCE = 1e-8  # relative, between the response of a state space and its poles, zeros and gain
LOOKED_AT = 20  # frequencies at which the two are compared
Roots = tuple[Complex, Complex, float]


def matched_polynomials(num: Array, den: Array, h: float) -> tuple[Array, Array]:
    """Numerator and denominator in z of a transfer function whose denominator is monic."""
    zeros, poles, gain = _match_roots(_roots(num), _roots(den), float(num[0]), h)
    with np.errstate(all="ignore"):
        return np.atleast_1d((gain * np.poly(1 + zeros)).real), np.atleast_1d(np.poly(1 + poles).real)


def _roots(p: Array) -> Complex:
    """The roots of a polynomial, highest power first."""
    return np.asarray(np.roots(p), dtype=complex)


def matched_space(system: control.StateSpace, h: float) -> tuple[Array, Array, Array, Array]:
    """A, B, C and D in z, with the states and the row C of a system with one input and one output.

    With E = A - 1 the matrix that maps w, where C E^k w is 0 for k < n - 1 and 1 for k = n - 1, to its product with
    E - (z_i - 1) for all zeros is B (the formula of Ackermann, transposed).

    Raises
    ------
    DesignError
        If the output does not show all states well enough, the system has no gain, or it has more than 40 states.
    """
    A, B, Cy, D = state_space("c2d", system)
    n = len(A)
    if not n:
        return A, B, Cy, D
    structure = pole_zero_structure(system)
    degree = structure.relative_degree
    if degree is None or math.isinf(degree):
        raise DesignError(
            "`c2d(method='matched')` equals the gain, and this system has none: its output is always zero."
        )
    leading = D if degree == 0 else Cy @ np.linalg.matrix_power(A, int(degree) - 1) @ B
    roots = _match_roots(structure.invariant_zeros.values, structure.poles.values, float(leading[0, 0]), h)
    zeros, _, gain = roots
    E, _ = held_map(A, B, h)
    w = _seen_last(E, Cy)
    for zero in zeros:
        w = E @ w - zero * w
    direct = gain if len(zeros) == n else 0.0
    matrices = np.eye(n) + E, (gain * w.real)[:, np.newaxis], Cy, np.array([[direct]])
    _refuse_rounding(system.name, matrices, roots)
    return matrices


def _seen_last(E: Array, C: Array) -> Complex:
    """The w with C E^k w = 0 for k < n - 1, and 1 for k = n - 1; NaN if the output does not show all states."""
    rows, size, last = [], 1.0, np.zeros(len(E))
    row = C[0]
    for _ in range(len(E)):  # each of the size one, as powers of E may leave the range of doubles
        largest = float(np.abs(row).max()) or 1.0
        rows.append(row / largest)
        size *= largest
        row = rows[-1] @ E
    last[-1] = 1 / size
    try:
        return np.asarray(np.linalg.solve(np.array(rows), last) + 0j)
    except np.linalg.LinAlgError:
        return np.full(len(E), np.nan + 0j)


def _match_roots(zeros: Complex, poles: Complex, leading_coefficient: float, h: float) -> Roots:
    """The zeros and poles in z less one, and the gain: zeros at infinity but one go to -1."""
    lost = max(len(poles) - len(zeros) - 1, 0)
    gain: complex = leading_coefficient / 2**lost
    for roots, sign in ((poles, 1), (zeros, -1)):
        for root in roots:
            with np.errstate(over="ignore", invalid="ignore"):
                grown = np.expm1(root * h) / (root * h) if root else 1.0  # (1 - e^(s h)) / (-s h)
            if abs(grown) <= 1e3 * EPS:
                raise DesignError(
                    f"`c2d(method='matched')` has no gain for slow signals where a pole or zero, here "
                    f"{pole_text(root)} 1/s, is a multiple of the sampling frequency {2 * math.pi / h:.6g} rad/s; take "
                    "another period."
                )
            gain = gain * (grown * h) ** sign
    with np.errstate(all="ignore"):
        return np.concatenate([np.expm1(zeros * h), -2 * np.ones(lost)]) + 0j, np.expm1(poles * h) + 0j, gain.real


def _refuse_rounding(name: str, matrices: tuple[Array, Array, Array, Array], roots: Roots) -> None:
    """Refuse matrices whose response is not that of the zeros, poles and gain."""
    A, B, C, D = matrices
    zeros, poles, gain = roots
    turn = np.expm1(1j * np.linspace(0.1, 3.1, LOOKED_AT))  # z - 1
    with np.errstate(all="ignore"):
        wanted = gain * np.prod(turn[:, np.newaxis] - zeros, axis=1) / np.prod(turn[:, np.newaxis] - poles, axis=1)
        points = turn[:, np.newaxis, np.newaxis] * np.eye(len(A)) - (A - np.eye(len(A)))
        reached = (C @ np.linalg.solve(points, np.broadcast_to(B + 0j, (LOOKED_AT, *B.shape))) + D)[:, 0, 0]
    if not (np.abs(reached - wanted) <= MATCH_TOLERANCE * np.abs(wanted).max()).all():
        raise DesignError(
            f"`c2d(method='matched')` finds what the input does to the states by what the output shows of them, and "
            f"that of '{name}' shows too little within rounding; give `control.tf(system)`, or take 'zoh' or 'tustin'."
        )
