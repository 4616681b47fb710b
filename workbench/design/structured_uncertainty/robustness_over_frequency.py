"""The largest structured singular value over all frequencies, between two bounds that hold between samples, too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from workbench.core.validation.notebook_display import show
from workbench.core.validation.refusals import Array
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.frequency.exact_systems import is_stable, not_stable
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import Complex, DesignError, one_thread
from workbench.design.structured_uncertainty.axis_places import ROUGH, frequency_at, largest_square, place_of
from workbench.design.structured_uncertainty.frequency_bands import PerturbedSystem, clear_band
from workbench.design.structured_uncertainty.frequency_search import FrequencyPeak, frequency_peaks
from workbench.design.structured_uncertainty.irreducible_parts import whole_of
from workbench.design.structured_uncertainty.scaling_search import best_scalings
from workbench.design.structured_uncertainty.structured_singular_value import MOST_ROWS, matrix_bounds
from workbench.design.structured_uncertainty.uncertainty_blocks import (
    Places,
    UncertaintyBlock,
    pad,
    places_of,
    refuse_shape,
    unpad,
)

MOST_STATES = 60
TIGHT = 5e-4  # relative: what the upper bound adds so that bands have a width
MOST_BANDS = 400
FIRST_FREQUENCIES, MOST_FREQUENCIES = 2, 8  # at which a search for perturbations starts, and starts again
LARGEST_G = (1e1, 1e3, 1e6)  # beside D and the matrix, tried one after the other


@dataclass(frozen=True, eq=False)
@show
class ScaledBand:
    """The frequencies from `low` to `high`, in rad/s, at which the scalings D and G prove the upper bound."""

    low: float
    high: float
    D: Complex
    G: Complex


@dataclass(frozen=True, eq=False)
@show
class StructuredPeak:
    """Bounds of the supremum of mu over frequency; a `perturbation` attains the lower one at the `frequency` in rad/s.

    The loop of M and Delta stays stable for each stable Delta of these blocks whose H-infinity norm is below 1 /
    `upper`. One of the size 1 / `lower` takes it to the limit of stability. `perturbation` is known to rounding, and
    None if none was found. The `bands` cover all frequencies. For a discrete system their ends are values of v =
    tan(omega dt / 2).
    """

    lower: float
    upper: float
    frequency: float
    perturbation: Complex | None
    bands: tuple[ScaledBand, ...]

    @property
    def margin(self) -> tuple[float, float]:
        """Two numbers that enclose the size of the smallest destabilising perturbation."""
        low, high = (1 / bound if bound > 0 else math.inf for bound in (self.upper, self.lower))
        return low, high


@check_arguments
def robustness_over_frequency(
    system: System, blocks: Sequence[UncertaintyBlock], width: float = TIGHT
) -> StructuredPeak:
    """The supremum over frequency of the structured singular value of a stable system, between two bounds.

    Constant scalings D and G prove the upper bound in bands that cover all frequencies, so between samples, too. A
    perturbation at one frequency attains the lower bound. With real blocks mu may jump, which is found.

    Parameters
    ----------
    system, blocks
        The M of a loop of M and Delta, a `StateSpace`, continuous or discrete, and the blocks of Delta in their order.
    width
        The relative distance, from 1e-5 to 0.1, of the upper bound from the largest one at a frequency: it gives the
        bands their width. A mu that is flat over frequency, as after `dk_iteration`, needs about 0.005.

    Raises
    ------
    ValueError
        If the system is not a `StateSpace` with finite matrices, the blocks do not fit, or the width is out of range.
    DesignError
        If the system is not stable, has more than 60 states or 40 channels, or no bands cover the axis.

    References
    ----------
    Packard and Doyle (1993), The complex structured singular value, Automatica 29. Ferreres, Magni and Biannic (2003),
    Robustness analysis of flexible structures: practical algorithms, Int. J. Robust Nonlinear Control 13 (bands).

    Examples
    --------
    >>> import control
    >>> mu = wb.structured_uncertainty
    >>> loop = control.ss([[0.0, 1.0], [-1.0, -0.2]], [[0.0], [1.0]], [[1.0, 0.0]], 0.0)
    >>> answer = mu.robustness_over_frequency(loop, [mu.FullBlock(1)])
    >>> round(answer.frequency, 3), answer.lower < 5.02519 < answer.upper
    (0.99, True)
    """
    call = "robustness_over_frequency"
    A, B, C, D = state_space(call, system)
    discrete = bool(system.isdtime(strict=True))
    refuse_shape(f"{call}(system, blocks)", D.shape, blocks)
    if len(A) > MOST_STATES or max(D.shape) > MOST_ROWS:
        raise DesignError(
            f"`{call}(system, blocks)` takes at most {MOST_STATES} states and {MOST_ROWS} channels; '{system.name}' "
            f"has {len(A)} states and {max(D.shape)} channels. Reduce its order first, by `wb.reduction`."
        )
    if not is_stable(A, discrete):
        raise DesignError(
            f"`{call}(system, blocks)`: {not_stable(A, discrete)}; close a loop that stabilises it first."
        )
    if not 1e-5 <= width <= 0.1:
        raise ValueError(f"`{call}(width=...)` must lie between 1e-5 and 0.1; got {width}.")
    step = None
    if discrete:
        step = 1.0 if system.dt is True else float(system.dt)
        A, B, C, D = _bilinear(A, B, C, D)
    places = places_of(blocks)
    matrix = PerturbedSystem(*_padded(A, B, C, D, blocks))
    return _answer(call, matrix, places, blocks, step, width)


def _bilinear(A: Array, B: Array, C: Array, D: Array) -> tuple[Array, Array, Array, Array]:
    """The system with z = (1 + s) / (1 - s)."""
    shift = A + np.eye(len(A))
    inside: Array = np.asarray(np.linalg.solve(shift, A - np.eye(len(A))), dtype=float)
    inputs: Array = np.asarray(np.linalg.solve(shift, B), dtype=float)
    return inside, np.asarray(2 * np.linalg.solve(shift, inputs), dtype=float), C, D - C @ inputs


def _padded(
    A: Array, B: Array, C: Array, D: Array, blocks: Sequence[UncertaintyBlock]
) -> tuple[Array, Array, Array, Array]:
    """The system with channels of zeros where blocks are filled up, in states of similar size."""
    n, (ny, nu) = len(A), D.shape
    whole, used = pad(D.astype(complex), blocks).real, pad(np.ones((ny, nu), dtype=complex), blocks).real > 0
    rows, columns = used.any(axis=1), used.any(axis=0)
    inputs, outputs = np.zeros((n, len(whole))), np.zeros((len(whole), n))
    inputs[:, columns], outputs[rows] = B, C
    if n:
        _, (scale, _) = linalg.matrix_balance(A, permute=False, separate=True)
        A, inputs, outputs = A * scale / scale[:, None], inputs / scale[:, None], outputs * scale
    return A, inputs, outputs, whole


@one_thread()
def _answer(
    call: str,
    matrix: PerturbedSystem,
    places: tuple[Places, ...],
    blocks: Sequence[UncertaintyBlock],
    step: float | None,
    tight: float,
) -> StructuredPeak:
    jumps = all(place.real for place in places)  # mu may be large at a frequency beside which it is small
    peak = _largest_lower(matrix, places, MOST_FREQUENCIES if jumps else FIRST_FREQUENCIES)
    bands, upper, highest = _cover(call, matrix, places, peak.lower if peak else 0.0, tight)
    if upper > (1 + 3 * tight) * (peak.lower if peak else 0.0):
        others = [peak, None if jumps else _largest_lower(matrix, places, MOST_FREQUENCIES)]
        if highest is not None:
            scalings = best_scalings(matrix.at(highest), places, ROUGH)
            others.append(frequency_peaks(matrix, places, scalings, highest, MOST_FREQUENCIES))
        peak = max((other for other in others if other), key=lambda other: other.lower, default=None)
    if peak is None:
        return StructuredPeak(0.0, upper, math.nan, None, bands)
    omega = peak.omega
    if step is not None:
        omega = math.pi / step if math.isinf(omega) else 2 / step * math.atan(omega)
    return StructuredPeak(min(peak.lower, upper), upper, omega, unpad(peak.Delta, blocks), bands)


def _frequencies(matrix: PerturbedSystem) -> list[float]:
    """Positive frequencies near to which a peak is likely."""
    poles = np.linalg.eigvals(matrix.A) if len(matrix.A) else np.zeros(0)
    sizes = np.unique(np.concatenate([np.abs(poles), np.abs(poles.imag)]))
    sizes = sizes[sizes > 0]
    if not len(sizes):
        return [1.0]
    spread = np.geomspace(sizes[0] / 10, sizes[-1] * 10, 8)
    kept: list[float] = []
    for omega in np.sort(np.concatenate([sizes, spread])):
        if not kept or omega > 1.05 * kept[-1]:
            kept.append(float(omega))
    if len(kept) > 3 * MOST_FREQUENCIES:
        kept = [kept[i] for i in np.linspace(0, len(kept) - 1, 3 * MOST_FREQUENCIES).astype(int)]
    return kept


def _largest_lower(matrix: PerturbedSystem, places: tuple[Places, ...], count: int) -> FrequencyPeak | None:
    """The best perturbation at zero, at infinity, or found from starts at the frequencies of the largest bounds."""
    best: FrequencyPeak | None = None
    for omega in (0.0, math.inf):
        part = max(matrix_bounds(matrix.at(omega), places), key=lambda part: part.lower)
        if part.Delta is not None and (best is None or part.lower > best.lower):
            best = FrequencyPeak(part.lower, omega, whole_of(places, part.rows, part.Delta))
    frequencies = _frequencies(matrix) if len(matrix.A) else []
    scalings = {omega: best_scalings(matrix.at(omega), places, ROUGH) for omega in frequencies}
    squares = {omega: scalings[omega].square(matrix.at(omega)) for omega in frequencies}
    jumps = all(place.real for place in places)
    for seed, omega in enumerate(sorted(frequencies, key=lambda omega: -squares[omega])[:count]):
        if best and squares[omega] < best.lower**2 and not jumps:
            break
        peak = frequency_peaks(matrix, places, scalings[omega], omega, seed)
        if peak and (best is None or peak.lower > best.lower):
            best = peak
    return best


def _cover(
    call: str, matrix: PerturbedSystem, places: tuple[Places, ...], lower: float, tight: float
) -> tuple[tuple[ScaledBand, ...], float, float | None]:
    """Bands over all frequencies, the bound that their scalings prove, and the frequency that last raised it."""
    scale = float(np.median(_frequencies(matrix)))
    size = max(float(np.linalg.norm(matrix.at(omega), 2)) for omega in (0.0, scale, math.inf))
    beta = max(lower * (1 + tight), 1e-7 * size, 1e-300)
    bands: list[ScaledBand] = []
    rest, highest, failures = [(0.0, 1.0)], None, 0
    for _ in range(MOST_BANDS):
        if not rest:
            return tuple(sorted(bands, key=lambda band: band.low)), beta, highest
        low, high = rest.pop()
        middle = low if low == 0 else high if high == 1 else (low + high) / 2
        omega = frequency_at(middle, scale)
        found, square = _band_at(matrix, places, beta, omega)
        if found is None and square > (beta / (1 + tight / 4)) ** 2:
            square, place = largest_square(matrix, places, low, high, scale, square)
            beta = math.sqrt(square) * (1 + tight)
            highest = frequency_at(place, scale) if 0 < place < 1 else highest
            found, _ = _band_at(matrix, places, beta, omega)
        if found is None:  # rounding hides the crossings: some other scalings or frequency do not
            failures += 1
            beta *= 1 + tight * 2.0 ** min(failures - 20, 12) if failures > 20 else 1.0
            rest = [(low, (low + middle) / 2), ((low + middle) / 2, high), *rest] if low < middle < high else rest
            if not low < middle < high:
                beta *= 1 + tight
                rest.append((low, high))
            continue
        bands.append(found)
        first, last = place_of(found.low, scale), place_of(found.high, scale)
        rest += [
            (a, b) for a, b in ((low, min(first, high)), (max(last, low), high)) if b > a and (a, b) != (low, high)
        ]
    raise DesignError(
        f"`{call}(system, blocks)`: no {MOST_BANDS} bands of frequency cover the axis, as mu jumps too often; give "
        "some real block a small complex one beside it."
    )


def _band_at(
    matrix: PerturbedSystem, places: tuple[Places, ...], beta: float, omega: float
) -> tuple[ScaledBand | None, float]:
    """The band about a frequency by scalings whose G is as small as it may be, and the square of the bound there."""
    M, square, mixed = matrix.at(omega), math.inf, any(place.real for place in places)
    for largest in LARGEST_G if mixed else LARGEST_G[-1:]:
        scalings = best_scalings(M, places, ROUGH, largest, beta**2)
        square = min(square, scalings.square(M))
        band = clear_band(matrix, beta, scalings, omega) if square < beta**2 else None
        if band is not None:
            return ScaledBand(*band, scalings.D, scalings.G), square
    return None, square
