"""The H-infinity norm between two bounds that are proved in floating point, in milliseconds where exact numbers take
seconds; None where this way proves none.

Below stands the gain at one frequency, above a level that no singular value meets. A level that is met names the
frequencies where: between them lies a higher gain, as in the algorithm of Bruinsma and Steinbuch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from workbench.core.validation.refusals import Array
from workbench.design.frequency.gain_levels import is_below, prove_level, prove_poles
from workbench.design.frequency.modal_systems import ModalSystem
from workbench.design.frequency.point_gains import PointGain, largest_gain, point_gain
from workbench.design.frequency.wide_matrices import Wide
from workbench.design.matrices import LARGEST, SMALLEST, Complex, one_thread

NARROW, WIDEST = 1e-12, 1e-9  # relative widths of an enclosure
STEPS = 3  # of refinement of the modes; where modes nearly coincide, none is better
ROUNDS = 40
BEST = 3  # of the candidates, which are taken to their local maximum
GROWTH = 8.0  # of a bracket about a local maximum
FIRST, LAST = 1e-9, 0.5  # relative half widths of such brackets
NEAR_AXIS = 0.3  # of the modulus: the real part of an eigenvalue whose frequency is worth a look


@dataclass(frozen=True)
class ProvedNorm:
    """The norm is not below `low` and not above `high`; the gain at s = j place, or on the circle, is `low` at least.

    Both are infinite for a system that is proved not to be stable.
    """

    low: float
    high: float
    place: float


@one_thread()
def proved_norm(A: Wide, B: Wide, C: Wide, D: Wide, discrete: bool) -> ProvedNorm | None:
    """The norm in the coordinates in which it can be proved: the modes of the system, or its states in good units."""
    if not all(_in_range(part.high) for part in (A, B, C, D)):
        return None
    if not A.high.size:
        low = largest_gain(D)
        level = low * (1 + NARROW)
        return ProvedNorm(low, level, 0.0) if low > 0 and is_below(D, level) else None
    with np.errstate(all="ignore"):
        try:
            plain = ModalSystem.in_good_units(A, B, C, D, discrete)
            for steps in (STEPS, 0, None):
                system = plain if steps is None else plain.by_modes(steps)
                if system is None:
                    continue
                poles = prove_poles(system)
                if poles.is_proved and poles.outside(discrete):
                    return ProvedNorm(math.inf, math.inf, math.nan)
                if poles.is_proved and (answer := _enclose(system)) is not None:
                    return answer
        except np.linalg.LinAlgError:
            return None
    return None


@one_thread()
def proved_stability(A: Array, discrete: bool) -> bool | None:
    """True or False for a matrix that is proved to have all eigenvalues inside the region of stability, or not all."""
    if not A.size or not _in_range(A):
        return None
    none = Wide.of(np.zeros((len(A), 1)))
    with np.errstate(all="ignore"):
        try:
            plain = ModalSystem.in_good_units(Wide.of(A), none, none.T, Wide.of(np.zeros((1, 1))), discrete)
            poles = prove_poles(plain)
        except np.linalg.LinAlgError:
            return None
    return not poles.outside(discrete) if poles.is_proved else None


def _in_range(M: Array) -> bool:
    """True if no entry is so large or small that products with it leave the range of doubles."""
    sizes = np.abs(M[M != 0])
    return bool(((sizes >= SMALLEST) & (sizes <= LARGEST)).all())


def _enclose(system: ModalSystem) -> ProvedNorm | None:
    best, place = _highest(system, _places(np.asarray(np.linalg.eigvals(system.continuous[0]), dtype=complex)))
    width = NARROW
    for _ in range(ROUNDS):
        if best is None or not best.low > 0 or width > WIDEST:
            return None
        level = best.low * (1 + width)
        proof = prove_level(system, level)
        if proof.is_proved:
            return ProvedNorm(best.low, level, place) if starts_below(system, level) else None
        other, where = _highest(system, _places(_on_axis(proof.values, system.discrete)))
        if other is not None and other.low > best.low * (1 + width / 4):
            best, place = other, where
        else:
            width *= 4
    return None


def starts_below(system: ModalSystem, level: float) -> bool:
    """True if all singular values are proved to be below a level at one place."""
    anchor = point_gain(system, 0.0 if system.discrete else math.inf)
    return anchor is not None and is_below(anchor.response, level)


def _on_axis(values: Complex, discrete: bool) -> Complex:
    """Eigenvalues of a level as those of the continuous form."""
    return (values - 1) / (values + 1) if discrete else values


def _places(values: Complex) -> Array:
    """Places at which a peak is likely: the ends of the axis, and the frequencies of eigenvalues and between them."""
    near = values[np.abs(values.real) <= NEAR_AXIS * np.abs(values)]
    frequencies = np.concatenate([np.abs(near.imag), np.abs(values)])
    frequencies = np.unique(frequencies[np.isfinite(frequencies) & (frequencies > 0)])
    left, right = frequencies[:-1], frequencies[1:]
    return np.concatenate([[0.0, np.inf], frequencies, (left + right) / 2, np.sqrt(left * right)])


def _highest(system: ModalSystem, places: Array) -> tuple[PointGain | None, float]:
    """The largest proved gain near to some places, and where it is reached."""
    gains = [_gain_and_slope(system, place)[0] for place in places]
    order = np.argsort(gains)[::-1][:BEST]
    tops = [_summit(system, float(places[k])) for k in order]
    known = [(gain, top) for top in dict.fromkeys(tops) if (gain := point_gain(system, top)) is not None]
    return max(known, key=lambda one: one[0].low, default=(None, 0.0))


def _gain_and_slope(system: ModalSystem, place: float) -> tuple[float, float]:
    """The largest singular value at a place, with rounding, and its derivative."""
    A, B, C, D = system.continuous
    if math.isinf(place):
        return float(np.linalg.norm(D, 2)), 0.0
    P = 1j * place * np.eye(len(A)) - A
    X = np.linalg.solve(P, B)
    U, values, V = np.linalg.svd(C @ X + D)
    slope = U[:, 0].conj() @ (C @ np.linalg.solve(P, X @ V[0].conj()))
    return float(values[0]), float((-1j * slope).real)


def _summit(system: ModalSystem, place: float) -> float:
    """The local maximum of the gain near to a place."""
    if place == 0 or math.isinf(place):
        return place

    def slope(logarithm: float) -> float:
        return _gain_and_slope(system, math.exp(logarithm))[1]

    middle, half = math.log(place), FIRST
    while half < LAST:
        if slope(middle - half) > 0 > slope(middle + half):
            return math.exp(optimize.brentq(slope, middle - half, middle + half, xtol=1e-16, rtol=1e-15))
        half *= GROWTH
    return place
