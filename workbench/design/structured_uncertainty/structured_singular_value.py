"""The structured singular value between two bounds, each with what proves it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.notebook_display import show
from workbench.core.validation.number_types import Numbers
from workbench.core.validation.refusals import as_array, refusal
from workbench.core.validation.signatures import check_arguments
from workbench.design.control_system import System
from workbench.design.matrices import Complex, DesignError, one_thread
from workbench.design.structured_uncertainty.irreducible_parts import irreducible_parts, part_of, whole_of
from workbench.design.structured_uncertainty.perturbation_search import perturbation_peaks
from workbench.design.structured_uncertainty.proved_perturbations import proved_perturbation, real_eigenvalue_bound
from workbench.design.structured_uncertainty.proved_scalings import proved_bound
from workbench.design.structured_uncertainty.scaling_search import Scalings, best_scalings, schur_scalings
from workbench.design.structured_uncertainty.uncertainty_blocks import (
    ComplexScalar,
    Places,
    UncertaintyBlock,
    pad,
    places_of,
    refuse_shape,
    unpad,
)

MOST_ROWS = 40


@dataclass(frozen=True, eq=False)
@show
class StructuredSingularValue:
    """Bounds of mu: no perturbation below 1 / `upper` makes I - M Delta singular, and one of the size 1 / `lower` does.

    `perturbation` is the Delta of the lower bound, to rounding; it is None if none was found. `residual` is the least
    singular value of I - M Delta. `D` and `G` are the scalings of the upper bound. They are separate for each part of
    M whose rows act on each other, and blocks that are not square are filled up with zeros.
    """

    lower: float
    upper: float
    perturbation: Complex | None
    residual: float
    D: Complex
    G: Complex


@dataclass(frozen=True, eq=False)
class PartBounds:
    """The bounds of one part of a matrix, with its scalings and perturbation."""

    rows: list[int]
    lower: float
    upper: float
    Delta: Complex | None
    scalings: Scalings


@check_arguments
def structured_singular_value(M: Numbers | System, blocks: Sequence[UncertaintyBlock]) -> StructuredSingularValue:
    """The structured singular value of a matrix, enclosed by a lower and an upper bound.

    It is the inverse of the size (largest singular value) of the smallest Delta = diag(blocks) that makes I - M Delta
    singular, and zero if none does. The upper bound comes from scalings D and G; a Cholesky factor with an allowance
    for rounding proves it. The lower bound comes from a perturbation; a change of sign proves that an exact one is
    near. The bounds meet for up to three complex blocks, of which repeated scalars count twice.

    Parameters
    ----------
    M
        The matrix, real or complex. For a system, take its gain at one frequency, as `system(1j * omega)`.
    blocks
        A list of `FullBlock`, `ComplexScalar` and `RealScalar`, in the order of the rows of M. Delta has the shape of
        the transpose of M.

    Raises
    ------
    ValueError
        If M is not a matrix of finite numbers, or the blocks do not fit its shape.
    DesignError
        If M has more than 40 rows.

    References
    ----------
    Doyle (1982), Analysis of feedback systems with structured uncertainties, IEE Proceedings D 129. Fan, Tits and Doyle
    (1991), Robustness in the presence of mixed parametric uncertainty and unmodeled dynamics, IEEE Trans. Autom.
    Control 36.

    Examples
    --------
    >>> mu = wb.structured_uncertainty
    >>> answer = mu.structured_singular_value([[1.0, 2.0], [0.5, 0.7]], [mu.FullBlock(1), mu.RealScalar(1)])
    >>> round(answer.lower, 4), round(answer.upper, 4)
    (1.8612, 1.8612)
    """
    call = "structured_singular_value(M, blocks)"
    matrix = complex_matrix("structured_singular_value", M)
    refuse_shape(call, matrix.shape, blocks)
    places, padded = places_of(blocks), pad(matrix, blocks)
    if len(padded) > MOST_ROWS:
        raise DesignError(f"`{call}` takes seconds for {MOST_ROWS} rows and minutes for more; M has {len(padded)}.")
    parts = matrix_bounds(padded, places)
    best = max(parts, key=lambda part: part.lower)
    Delta = None if best.Delta is None else unpad(whole_of(places, best.rows, best.Delta), blocks)
    residual = math.inf
    if Delta is not None:
        residual = float(np.linalg.svd(np.eye(len(matrix)) - matrix @ Delta, compute_uv=False)[-1])
    D, G = np.eye(len(padded), dtype=complex), np.zeros(padded.shape, dtype=complex)
    for part in parts:
        D[np.ix_(part.rows, part.rows)], G[np.ix_(part.rows, part.rows)] = part.scalings.D, part.scalings.G
    return StructuredSingularValue(best.lower, max(part.upper for part in parts), Delta, residual, D, G)


@one_thread()
def matrix_bounds(M: Complex, places: tuple[Places, ...]) -> list[PartBounds]:
    """The bounds of each irreducible part of a square matrix."""
    return [_part_bounds(M[np.ix_(rows, rows)], part_of(places, rows), rows) for rows in irreducible_parts(M, places)]


def _part_bounds(M: Complex, places: tuple[Places, ...], rows: list[int]) -> PartBounds:
    n, size = len(M), float(np.abs(M).max())
    if size == 0:
        return PartBounds(rows, 0.0, 0.0, None, Scalings(np.eye(n, dtype=complex), np.zeros((n, n), dtype=complex)))
    if n == 1:
        return _number_bounds(complex(M[0, 0]), places[0], rows)
    unit = math.ldexp(1.0, math.frexp(size)[1])  # a power of two, so that nothing is rounded
    M = M / unit
    candidates = [best_scalings(M, places)]
    if len(places) == 1 and isinstance(places[0].block, ComplexScalar):
        candidates += schur_scalings(M)
    candidates.append(Scalings(np.eye(n, dtype=complex), np.zeros((n, n), dtype=complex)))
    uppers = [proved_bound(M, candidate) for candidate in candidates]
    upper, scalings = min(uppers), candidates[int(np.argmin(uppers))]
    if len(places) == 1 and places[0].real and not M.imag.any():
        proved = real_eigenvalue_bound(M.real)
    else:
        peaks = perturbation_peaks(M, places, scalings, upper) if upper > 0 else []
        proved = proved_perturbation(M, places, peaks)
    scalings = Scalings(scalings.D, scalings.G * unit)
    if proved is None:
        return PartBounds(rows, 0.0, upper * unit, None, scalings)
    return PartBounds(rows, min(proved.lower, upper) * unit, upper * unit, proved.Delta / unit, scalings)


def _number_bounds(m: complex, place: Places, rows: list[int]) -> PartBounds:
    """The bounds of a single number: its modulus, or zero if it is not real and its perturbation is."""
    D, size = np.eye(1, dtype=complex), abs(m)
    if place.real and m.imag:
        return PartBounds(rows, 0.0, 0.0, None, Scalings(D, np.array([[size**2 / m.imag]], dtype=complex)))
    low, high = (size, size) if m.imag == 0 else (math.nextafter(size, 0.0), math.nextafter(size, math.inf))
    return PartBounds(rows, low, high, np.array([[1 / m]]), Scalings(D, np.zeros((1, 1), dtype=complex)))


def complex_matrix(call: str, M: object) -> Complex:
    """A matrix of finite numbers, real or complex."""
    must = "a matrix of finite numbers, real or complex"
    try:
        parts = as_array(np.real(M)), as_array(np.imag(M))  # type: ignore[call-overload]
    except Exception:  # an object of the user's may raise anything when it is asked for its parts
        raise refusal(f"{call}(M=...)", must, M) from None
    real, imaginary = parts
    if real is None or imaginary is None or real.ndim != 2 or real.size == 0:
        raise refusal(f"{call}(M=...)", must, M)
    matrix = real + 1j * imaginary
    if not np.isfinite(matrix).all() or not np.abs(matrix).max() < 1e150:
        raise refusal(f"{call}(M=...)", f"{must}, below 1e150", M)
    return np.asarray(matrix)
