"""Both Gramians of a stable minimal system, with as many digits as their factors need.

A squared Smith iteration sums P = B B' + A B B' A' + ... by doubling the number of its terms. Its numbers are whole
ones over a power of two, so that the digits that stiff or lightly damped modes lose are bought by longer numbers.

References
----------
Penzl (1998), Numerical solution of generalized Lyapunov equations, Adv. Comput. Math. 8 (squared Smith method).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.rational_matrices import Matrix
from workbench.design.frequency.rational_systems import RationalSystem
from workbench.design.matrices import DesignError
from workbench.design.reduction.fixed_point import FixedPoint

MOST_DOUBLINGS = 200
FIRST_BITS, MOST_BITS = 384, 6144
SURE = 128  # bits of the Gramians that must be right beyond their smallest pivot


@dataclass(frozen=True, eq=False)
class FactoredGramians:
    """A system (A, B, C), and lower triangular factors of its Gramians P = X X' and Q = Y Y'."""

    A: FixedPoint
    B: FixedPoint
    C: FixedPoint
    X: FixedPoint
    Y: FixedPoint


def factored_gramians(call: str, system: RationalSystem, discrete: bool) -> FactoredGramians:
    """The Gramians of a stable system without hidden modes."""
    scaled = _scale_states(system)
    bits = FIRST_BITS
    while bits <= MOST_BITS:
        factors = _try(scaled, discrete, bits)
        if factors is not None:
            return factors
        bits *= 2
    raise DesignError(
        f"`{call}(system)` needs Gramians with more than {MOST_BITS} binary digits: some mode is too slow, or too "
        "weakly driven or seen, beside the others. Leave it out, or choose other units."
    )


def _scale_states(system: RationalSystem) -> RationalSystem:
    """The system in states of similar size, by powers of two."""
    n = system.order
    A, B, C = (_doubles(M, shape) for M, shape in ((system.A, (n, n)), (system.B, (n, -1)), (system.C, (-1, n))))
    size = np.ones(n)
    for _ in range(12):
        off = A * (1 - np.eye(n))
        inward = np.abs(np.hstack([off, B])).max(axis=1, initial=0.0)
        outward = np.abs(np.vstack([off, C])).max(axis=0, initial=0.0)
        step = np.exp2(np.round(np.log2(np.where((inward > 0) & (outward > 0), inward / outward, 1.0)) / 2))
        size, A, B, C = size * step, A * step / step[:, None], B / step[:, None], C * step
        if (step == 1).all():
            break
    powers = [Fraction(float(x)) for x in size]
    return RationalSystem(
        [[a * powers[j] / powers[i] for j, a in enumerate(row)] for i, row in enumerate(system.A)],
        [[b / powers[i] for b in row] for i, row in enumerate(system.B)],
        [[c * powers[j] for j, c in enumerate(row)] for row in system.C],
        system.D,
        system.nu,
    )


def _doubles(M: Matrix, shape: tuple[int, int]) -> Array:
    return np.array([[float(x) for x in row] for row in M], dtype=float).reshape(shape)


def _try(system: RationalSystem, discrete: bool, bits: int) -> FactoredGramians | None:
    n, ny = system.order, len(system.C)
    A = FixedPoint.of(system.A, (n, n), bits)
    B = FixedPoint.of(system.B, (n, system.nu), bits)
    C = FixedPoint.of(system.C, (ny, n), bits)
    factors = []
    # both by the same function, so that its checks hold for both
    for M, N in ((A, B), (A.T, C.T)):
        gramian = _gramian(M, N, discrete)
        factor = gramian.cholesky() if gramian is not None else None
        if gramian is None or factor is None or not _digits_suffice(M, N, gramian, factor, discrete):
            return None
        factors.append(factor)
    return FactoredGramians(A, B, C, *factors)


def _gramian(A: FixedPoint, B: FixedPoint, discrete: bool) -> FixedPoint | None:
    """P = A P A' + B B', or 0 = A P + P A' + B B' by Cayley's transform, which has the same solution."""
    if not discrete:
        rate = _rate(A.doubles())
        shift = FixedPoint.identity(len(A.numbers), A.bits).scale_by_power(rate)
        solved = (shift - A).solve(FixedPoint(np.hstack([(shift + A).numbers, B.numbers]), A.bits))
        if solved is None:
            return None
        n = len(A.numbers)
        A, B = FixedPoint(solved.numbers[:, :n], A.bits), FixedPoint(solved.numbers[:, n:], A.bits)
        P = (B @ B.T).scale_by_power(rate + 1)
    else:
        P = B @ B.T
    for _ in range(MOST_DOUBLINGS):
        P = P + A @ P @ A.T
        A = A @ A
        if A.largest() <= Fraction(len(A.numbers), 2 ** (A.bits - 2)):  # what rounding down leaves of zero
            return FixedPoint((P.numbers + P.numbers.T) >> 1, P.bits)
    return None


def _rate(A: Array) -> int:
    """The exponent of a power of two between the slowest and the fastest mode."""
    poles = np.abs(np.linalg.eigvals(A))
    poles = poles[poles > 0]
    return int(np.round(np.log2(poles).mean())) if len(poles) else 0


def _digits_suffice(A: FixedPoint, B: FixedPoint, P: FixedPoint, factor: FixedPoint, discrete: bool) -> bool:
    """True if the residual of the equation lies far below the smallest pivot of the Gramian."""
    product = A @ P
    residual = product @ A.T - P if discrete else product + product.T
    least = min(Fraction(int(x), 2**P.bits) for x in np.diag(factor.numbers)) ** 2
    size = max(A.largest(), Fraction(1)) ** 2
    return bool((residual + B @ B.T).largest() * 2**SURE < least / size)
