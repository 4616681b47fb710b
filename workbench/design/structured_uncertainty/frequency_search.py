"""Frequencies at which a structured perturbation of the least size makes the loop singular, sought with the
perturbation itself: the frequency is one more parameter, and with real blocks the one that makes an eigenvalue real.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice

import numpy as np
from scipy import optimize

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.structured_uncertainty.frequency_bands import PerturbedSystem
from workbench.design.structured_uncertainty.perturbation_search import (
    Directions,
    EigenvaluePeak,
    complex_peak,
    eigenvalue,
    largest_real_value,
    start_points,
)
from workbench.design.structured_uncertainty.proved_perturbations import SHIFTS, eigenvalue_error
from workbench.design.structured_uncertainty.scaling_search import Scalings
from workbench.design.structured_uncertainty.uncertainty_blocks import Places

SPAN = np.log(10.0)  # how far a search may move the logarithm of a frequency
STARTS, COMPLEX_STARTS = 6, 3  # at each frequency, with and without real blocks


@dataclass(frozen=True, eq=False)
class FrequencyPeak:
    """A lower bound of the supremum over frequency, with the frequency and the perturbation that attain it."""

    lower: float
    omega: float
    Delta: Complex


def frequency_peaks(
    system: PerturbedSystem, places: tuple[Places, ...], scalings: Scalings, omega: float, seed: int
) -> FrequencyPeak | None:
    """The best local maximum over perturbations and frequencies from some starts at one positive frequency."""
    directions, rng = Directions(places, len(system.D)), np.random.default_rng(seed)
    mixed = any(place.real for place in places)
    unit = _relative_width(system, omega)
    best: FrequencyPeak | None = None
    M = system.at(omega)
    for p in islice(start_points(M, directions, scalings, rng), STARTS if mixed else COMPLEX_STARTS):
        if mixed:
            *_, values = eigenvalue(M, directions.Q(p), None)
            starts = [EigenvaluePeak(complex(value), p) for value in sorted(values, key=lambda v: -v.real)[:2]]
        else:
            starts = [complex_peak(M, directions, p)]
        for start in starts:
            peak = _peak(system, directions, start, omega, unit)
            proved = _proved(system, directions, peak) if peak else None
            if proved and (best is None or proved.lower > best.lower):
                best = proved
    return best


def _relative_width(system: PerturbedSystem, omega: float) -> float:
    """The relative width of the resonance of the nearest pole, at most one: the unit of a frequency's logarithm."""
    poles = np.linalg.eigvals(system.A)
    nearest = poles[np.abs(1j * omega - poles).argmin()]
    return float(np.clip(np.abs(1j * omega - nearest) / omega, 1e-12, 1.0))


def _slopes(system: PerturbedSystem, directions: Directions, q: Array, near: complex) -> tuple[complex, Complex]:
    """An eigenvalue of M Q and its derivatives by the parameters of Q and the logarithm of the frequency."""
    p, omega = q[:-1], float(np.exp(q[-1]))
    M, Q = system.at(omega), directions.Q(p)
    value, y, x, _ = eigenvalue(M, Q, near)
    by_frequency = omega * (y.conj() @ system.slope(omega) @ Q @ x)
    return value, np.append(directions.slopes(p, M.conj().T @ y, x), by_frequency)


def _peak(
    system: PerturbedSystem, directions: Directions, start: EigenvaluePeak, omega: float, unit: float
) -> EigenvaluePeak | None:
    """A local maximum of a real eigenvalue; values count in units of the first, and frequencies in units of a width."""
    size = max(abs(start.value), 1e-300)
    units = np.append(np.ones(len(start.p)), unit)
    center = np.append(np.zeros(len(start.p)), np.log(omega))
    last: list[tuple[Array, complex, Complex]] = [(np.append(start.p, np.nan), start.value, np.zeros(0, dtype=complex))]

    def of(r: Array) -> tuple[complex, Complex]:
        if not np.array_equal(r, last[0][0]):
            value, slopes = _slopes(system, directions, center + units * r, last[0][1])
            last[0] = r.copy(), value, slopes * units
        return last[0][1] / size, last[0][2] / size

    box = directions.bounds()
    bounds = optimize.Bounds(np.append(box.lb, -SPAN / unit), np.append(box.ub, SPAN / unit))
    r = largest_real_value(of, np.append(start.p, 0.0), bounds, 1e-13)
    value = of(r)[0] * size
    return (
        EigenvaluePeak(value, center + units * r) if value.real > 0 and abs(value.imag) <= 1e-6 * abs(value) else None
    )


def _proved(system: PerturbedSystem, directions: Directions, peak: EigenvaluePeak) -> FrequencyPeak | None:
    """The peak with a bound that an exact frequency and perturbation beside it attain, by a change of sign."""
    q = peak.p
    value, slopes = _slopes(system, directions, q, peak.value)
    M, Q = system.at(float(np.exp(q[-1]))), directions.Q(q[:-1])
    error = eigenvalue_error(M, Q, value)
    direction = slopes.imag / max(float(np.abs(slopes.imag).max()), 1e-300)
    for shift in SHIFTS:
        ends = [_slopes(system, directions, q + s * shift * direction, value)[0] for s in (1, -1)]
        if ends[0].imag > error and ends[1].imag < -error:
            lower = (min(end.real for end in ends) - error) / (1 + shift)
            return FrequencyPeak(lower, float(np.exp(q[-1])), Q / value.real) if lower > 0 else None
    return None
