"""The H-infinity norm of a stable linear system, proved from both sides."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.frequency.certified_values import (
    INFINITE,
    CertifiedPeak,
    CertifiedValue,
    enclosing_root,
    rounded_root,
)
from workbench.design.frequency.exact_systems import (
    FEW_STATES,
    count_minors,
    not_stable,
    refuse_many_channels,
    refuse_many_states,
)
from workbench.design.frequency.gain_polynomials import GainPolynomials, exceeds, largest_square
from workbench.design.frequency.positive_roots import positive_roots
from workbench.design.frequency.proved_norm import ProvedNorm, proved_norm
from workbench.design.frequency.transfer_polynomials import TransferPolynomials
from workbench.design.frequency.wide_matrices import Wide
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import DesignError

if TYPE_CHECKING:
    import control

NARROW = Fraction(1, 10**12)  # the relative width of an enclosure
WIDEST = Fraction(1, 10**9)
LEAST_BITS, MOST_BITS = 40, 320  # of a frequency at which a singular value meets a level
MOST_STATES = 150  # a second in floating point
FEW_MINORS = 300  # five inputs by five outputs have 251
LEVELS = 60  # most levels that are tried; the search converges quadratically and takes some five


@check_arguments
def hinf_norm(system: control.StateSpace) -> CertifiedPeak:
    """The H-infinity norm of a system, continuous or discrete, with a frequency that attains it.

    A level is raised in the way of Bruinsma and Steinbuch. The frequencies at which a singular value meets a level are
    the imaginary eigenvalues of a Hamiltonian (or symplectic) matrix. The lower bound is a singular value at a
    frequency, the upper one a level that no singular value meets. For up to 10 states this is decided in exact
    arithmetic, as doubles are rationals: by Descartes' rule for the characteristic polynomial of that matrix. For more
    states and for many channels it is proved in floating point, with a bound of every rounding: by the eigenvectors of
    that matrix. Where one way fails, the other is tried. A system with a pole on the limit of stability or beyond,
    hidden modes included, has an infinite norm.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace` with finite matrices.
    DesignError
        If the system has more than 150 states, or if no enclosure of 1e-9 is proved; exact arithmetic takes at most 40
        states and some six inputs by six outputs.

    References
    ----------
    Boyd and Balakrishnan (1990), A regularity result for the singular values of a transfer matrix and a quadratically
    convergent algorithm for computing its L-infinity norm, Systems and Control Letters 15.
    Bruinsma and Steinbuch (1990), A fast algorithm to compute the H-infinity norm of a transfer function matrix,
    Systems and Control Letters 14.

    Examples
    --------
    >>> import control
    >>> resonance = control.ss([[-0.0002, -1.0], [1.0, 0.0]], [[1.0], [0.0]], [[0.0, 1.0]], 0.0)
    >>> norm = wb.hinf_norm(resonance)
    >>> round(norm.gain.value, 6), round(norm.frequency, 6)
    (5000.000025, 1.0)
    """
    A, B, C, D = state_space("hinf_norm", system)
    if len(A) > MOST_STATES:
        raise DesignError(
            f"`hinf_norm(system)` proves the norms of systems of at most {MOST_STATES} states; '{system.name}' has "
            f"{len(A)}. Reduce its order first, by `control.balred` with Slycot say."
        )
    discrete = bool(system.isdtime(strict=True))
    if len(A) > FEW_STATES or count_minors(*D.shape) > FEW_MINORS:
        bounds = proved_norm(Wide.of(A), Wide.of(B), Wide.of(C), Wide.of(D), discrete)
        if bounds is not None:
            return peak_of(bounds, A, system.dt if discrete else None)
        refuse_many_states("hinf_norm", system, len(A))
        refuse_many_channels("hinf_norm", *D.shape)
    transfer = TransferPolynomials.of(A, B, C, D, discrete)
    if not transfer.stable:
        return CertifiedPeak(INFINITE, math.nan, not_stable(A, discrete))
    low, high, x = _enclose(GainPolynomials.of(transfer), _candidates(A, discrete))
    return CertifiedPeak(enclosing_root(low, high), _frequency(x, system.dt if discrete else None))


def peak_of(bounds: ProvedNorm, A: Array, dt: float | None) -> CertifiedPeak:
    """The answer for a norm that is proved in floating point; `dt` is the period of a discrete system, or None."""
    if math.isinf(bounds.low):
        return CertifiedPeak(INFINITE, math.nan, not_stable(A, dt is not None))
    gain = CertifiedValue(bounds.low + (bounds.high - bounds.low) / 2, bounds.low, bounds.high)
    return CertifiedPeak(gain, bounds.place if dt is None else 2 / dt * math.atan(bounds.place))


def _candidates(A: Array, discrete: bool) -> list[Fraction | None]:
    """Values of x at which a peak is likely: zero, infinity, and the frequencies of the poles."""
    poles = np.linalg.eigvals(A) if len(A) else np.zeros(0)
    with np.errstate(all="ignore"):
        squares = np.tan(np.angle(poles) / 2) ** 2 if discrete else np.concatenate([np.abs(poles), poles.imag]) ** 2
    likely = np.unique(squares[np.isfinite(squares) & (squares > 0)])
    return [Fraction(0), None, *map(Fraction, likely.tolist())]


def _enclose(gains: GainPolynomials, candidates: list[Fraction | None]) -> tuple[Fraction, Fraction, Fraction | None]:
    """The squares of both sides, and the x at which the lower one is reached."""
    low, x, width, bits = Fraction(-1), candidates[0], NARROW, LEAST_BITS
    for _ in range(LEVELS):
        squares = [largest_square(gains.at(candidate)) for candidate in candidates]
        best = max(range(len(squares)), key=squares.__getitem__)
        if squares[best] > low:
            low, x = squares[best], candidates[best]
        elif bits < MOST_BITS:
            bits *= 2
        else:
            width *= 4
        if low == 0 and not any(any(polynomial) for polynomial in gains.E[1:]):
            return low, low, x
        level = _round_up(low * (1 + 2 * width))
        roots = positive_roots(gains.level(level), bits)
        if not roots and exceeds(level, gains.at(None)) and exceeds(level, gains.at(Fraction(0))):
            return low, level, x
        if width > WIDEST:
            break
        last = 2 * roots[-1].high if roots else Fraction(1)
        ends = [Fraction(0), *(end for root in roots for end in (root.low, root.high)), last]
        candidates = [Fraction(0), None, *((a + b) / 2 for a, b in pairwise(ends))]
    raise DesignError(
        "`hinf_norm(system)` must enclose the norm within 1e-9, and did not; balance the system or choose other units."
    )


def _round_up(square: Fraction) -> Fraction:
    """The square rounded up to 80 binary digits, so that the numbers of a polynomial stay short."""
    unit = Fraction(2) ** (square.numerator.bit_length() - square.denominator.bit_length() - 80)
    return unit * -(-square // unit)


def _frequency(x: Fraction | None, dt: float | None) -> float:
    """The frequency [rad/s] of a value of x, of a discrete system with this period; a period of True counts as 1 s."""
    if dt is not None:
        return float(np.pi / dt) if x is None else 2 / dt * float(np.arctan(rounded_root(x, up=False)))
    return np.inf if x is None else rounded_root(x, up=False)
