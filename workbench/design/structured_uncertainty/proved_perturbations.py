"""A lower bound from a perturbation that is near to a singular one: there is an exact one beside it.

References
----------
Stewart and Sun (1990), Matrix Perturbation Theory, chapters IV.1 (Elsner's theorem) and V.2 (condition of an
eigenvalue).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.integer_polynomials import mirror
from workbench.design.frequency.positive_roots import positive_roots
from workbench.design.frequency.rational_matrices import integer_characteristic_polynomial, whole
from workbench.design.matrices import EPS, Complex
from workbench.design.structured_uncertainty.perturbation_search import Directions, EigenvaluePeak, eigenvalue
from workbench.design.structured_uncertainty.uncertainty_blocks import Places

SHIFTS = tuple(
    10.0**-k for k in range(9, 3, -1)
)  # of real numbers and angles, over which an imaginary part changes sign
MOST_PEAKS = 12  # candidates that are looked at


@dataclass(frozen=True, eq=False)
class ProvedPerturbation:
    """A number `lower` below an exact structured singular value, and the perturbation beside it."""

    lower: float
    Delta: Complex


def proved_perturbation(
    M: Complex, places: tuple[Places, ...], peaks: list[EigenvaluePeak]
) -> ProvedPerturbation | None:
    """The best perturbation of some peaks for which an exact one is proved to be near, or None."""
    directions = Directions(places, len(M))
    best: ProvedPerturbation | None = None
    for peak in peaks[:MOST_PEAKS]:
        if best is not None and peak.value.real <= best.lower:
            break
        lower = _lower(M, directions, peak)
        if lower > 0 and (best is None or lower > best.lower):
            best = ProvedPerturbation(lower, directions.Q(peak.p) / peak.value.real)
    return best


def _lower(M: Complex, directions: Directions, peak: EigenvaluePeak) -> float:
    Q = directions.Q(peak.p)
    value, y, x, values = eigenvalue(M, Q, peak.value)
    error = eigenvalue_error(M, Q, value)
    if not any(place.real for place in directions.places):
        return abs(value) - error
    if _surely_real(M, directions, Q, value, values, error):
        return value.real - error
    slopes = directions.slopes(peak.p, M.conj().T @ y, x).imag
    if not np.abs(slopes).max() > 0:
        return 0.0
    direction = slopes / np.abs(slopes).max()
    for shift in SHIFTS:
        ends = [eigenvalue(M, directions.Q(peak.p + s * shift * direction), value)[0] for s in (1, -1)]
        if ends[0].imag > error and ends[1].imag < -error:
            # between both ends the imaginary part vanishes; real numbers have grown by the shift at most
            return (min(end.real for end in ends) - error) / (1 + shift)
    return 0.0


def eigenvalue_error(M: Complex, Q: Complex, value: complex) -> float:
    """A bound of the error of a computed eigenvalue of M Q: that of its condition, or Elsner's where it is smaller."""
    n, size = len(M), float(np.linalg.norm(M))
    change = 16 * n * EPS * size
    values, vectors = np.linalg.eig(M @ Q)
    k = int(np.argmin(np.abs(values - value)))
    condition = float(np.linalg.norm(np.linalg.pinv(vectors)[k]))  # of the eigenvalue, as columns have length one
    first = 2 * change * condition
    gap = np.delete(np.abs(values - values[k]), k).min(initial=np.inf)
    if first > gap / 4:  # the condition is that of small changes
        first = np.inf
    return float(min(first, (2 * size) ** (1 - 1 / n) * change ** (1 / n)))


def _surely_real(M: Complex, directions: Directions, Q: Complex, value: complex, values: Complex, error: float) -> bool:
    """True if the exact eigenvalue is real: of a Hermitian matrix, or alone of a real one."""
    if len(directions.places) == 1 and np.array_equal(M, M.conj().T):
        return True
    real = all(place.real for place in directions.places) and not M.imag.any()
    others: Array = np.abs(values - value)
    return bool(real and (others <= 4 * error).sum() == 1 and abs(value.imag) <= error)


def real_eigenvalue_bound(M: Array) -> ProvedPerturbation | None:
    """The largest modulus of a real eigenvalue, from the isolated roots of the characteristic polynomial."""
    numbers, rate = whole(M)
    p = integer_characteristic_polynomial(numbers)
    ends = [(roots[-1].low / rate, sign) for sign, q in ((1, p), (-1, mirror(p))) if (roots := positive_roots(q, 80))]
    if not ends:
        return None
    largest, sign = max(ends)
    lower = math.nextafter(float(largest), 0.0)
    return ProvedPerturbation(lower, np.asarray(np.eye(len(M)) * (sign / lower), dtype=complex)) if lower > 0 else None
