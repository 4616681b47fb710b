"""The smallest perturbation that makes I - M Delta singular, sought by many starts over unitary and real blocks.

The structured singular value is the largest positive eigenvalue of M Q over all Q whose complex blocks are unitary and
whose real numbers lie between -1 and 1. Each local maximum is a lower bound.

References
----------
Packard and Doyle (1993), The complex structured singular value, Automatica 29. Young and Doyle (1990), Computation of
mu with real and complex uncertainties, Proc. 29th CDC.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import optimize

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.structured_uncertainty.scaling_search import Scalings
from workbench.design.structured_uncertainty.uncertainty_blocks import Places

STARTS = 16
MOST_SIGNS = 5  # of real numbers whose vertices are all tried
CLOSE = 1e-9  # relative: a lower bound this near to the upper one ends the search
SEED = 20261129
MOST_STEPS = 80  # of a search for a maximum


@dataclass(frozen=True)
class EigenvaluePeak:
    """An eigenvalue of M Q at parameters p of Q."""

    value: complex
    p: Array


@dataclass(frozen=True, eq=False)
class Directions:
    """The map from parameters p to Q: an angle of a complex scalar, a number of a real one, two vectors of a block."""

    places: tuple[Places, ...]
    n: int

    def counts(self) -> list[int]:
        """The number of parameters of each block."""
        return [4 * place.size if place.full else 1 for place in self.places]

    def parts(self, p: Array) -> Iterator[tuple[Places, slice]]:
        """Each block with the places of its parameters."""
        start = 0
        for place, count in zip(self.places, self.counts(), strict=True):
            yield place, slice(start, start + count)
            start += count

    def Q(self, p: Array) -> Complex:
        """The perturbation of norm one (at most, for real numbers)."""
        Q = np.zeros((self.n, self.n), dtype=complex)
        for place, part in self.parts(p):
            Q[place.span, place.span] = self._block(place, p[part])
        return Q

    def _block(self, place: Places, p: Array) -> Complex:
        if place.full:
            u, v = _vectors(p)
            return np.multiply.outer(u / np.linalg.norm(u), v.conj() / np.linalg.norm(v))
        factor = p[0] if place.real else np.exp(1j * p[0])
        return np.asarray(factor * np.eye(place.size), dtype=complex)

    def slopes(self, p: Array, a: Complex, x: Complex) -> Complex:
        """The derivatives by each parameter of a' Q x."""
        slopes = np.zeros(len(p), dtype=complex)
        for place, part in self.parts(p):
            ai, xi = a[place.span], x[place.span]
            if not place.full:
                slopes[part] = ai.conj() @ xi * (1.0 if place.real else 1j * np.exp(1j * p[part][0]))
                continue
            u, v = _vectors(p[part])
            ru, rv = np.linalg.norm(u), np.linalg.norm(v)
            left, right = (ai.conj() @ u) / ru, (v.conj() @ xi) / rv
            du, dv = ai.conj() / ru, xi / rv  # of the parts that are linear in u and in v'
            both = left * right
            slopes[part] = np.concatenate(
                [
                    du * right - both * u.real / ru**2,
                    1j * du * right - both * u.imag / ru**2,
                    dv * left - both * v.real / rv**2,
                    -1j * dv * left - both * v.imag / rv**2,
                ]
            )
        return slopes

    def bounds(self) -> optimize.Bounds:
        """The range of each parameter."""
        low, high = [], []
        for place, count in zip(self.places, self.counts(), strict=True):
            low += [-1.0 if place.real else -np.inf] * count
            high += [1.0 if place.real else np.inf] * count
        return optimize.Bounds(np.array(low), np.array(high))

    def random(self, rng: np.random.Generator) -> Array:
        """Parameters of a random Q."""
        p = rng.normal(size=sum(self.counts()))
        for place, part in self.parts(p):
            if place.real:
                p[part] = rng.choice([-1.0, 1.0, rng.uniform(-1, 1)])
            elif not place.full:
                p[part] = rng.uniform(-np.pi, np.pi)
        return p

    def align(self, u: Complex, v: Complex) -> Array:
        """Parameters of a Q that turns each part of u towards that of v."""
        p = np.zeros(sum(self.counts()))
        for place, part in self.parts(p):
            ui, vi = u[place.span], v[place.span]
            if place.full:
                ui, vi = (x + 1e-9 if np.linalg.norm(x) < 1e-9 else x for x in (ui, vi))
                p[part] = np.concatenate([vi.real, vi.imag, ui.real, ui.imag])
            elif place.real:
                p[part] = np.sign((ui.conj() @ vi).real) or 1.0
            else:
                p[part] = np.angle(ui.conj() @ vi)
        return p


def _vectors(p: Array) -> tuple[Complex, Complex]:
    k = len(p) // 4
    return p[:k] + 1j * p[k : 2 * k], p[2 * k : 3 * k] + 1j * p[3 * k :]


def eigenvalue(M: Complex, Q: Complex, near: complex | None) -> tuple[complex, Complex, Complex, Complex]:
    """An eigenvalue of M Q, the largest or that nearest to a number, with y' / (y'x), x and all others."""
    values, vectors = np.linalg.eig(M @ Q)
    k = int(np.argmax(np.abs(values)) if near is None else np.argmin(np.abs(values - near)))
    unit = np.zeros(len(M), dtype=complex)
    unit[k] = 1
    try:
        y = np.linalg.solve(vectors.T, unit).conj()
    except np.linalg.LinAlgError:
        y = vectors[:, k]
    return complex(values[k]), y, vectors[:, k], np.asarray(values, dtype=complex)


def perturbation_peaks(
    M: Complex, places: tuple[Places, ...], scalings: Scalings, upper: float
) -> list[EigenvaluePeak]:
    """Local maxima, the largest first; the search ends where one reaches the upper bound."""
    directions, rng = Directions(places, len(M)), np.random.default_rng(SEED)
    mixed = any(place.real for place in places)
    peaks: list[EigenvaluePeak] = []
    for p in start_points(M, directions, scalings, rng):
        peaks += _mixed_peaks(M, directions, p) if mixed else [complex_peak(M, directions, p)]
        if peaks and max(peak.value.real for peak in peaks) >= upper * (1 - CLOSE):
            break
    return sorted(peaks, key=lambda peak: -peak.value.real)


def start_points(M: Complex, directions: Directions, scalings: Scalings, rng: np.random.Generator) -> Iterator[Array]:
    """Parameters to start from: of the singular vectors of the scaled matrix, of vertices, and random ones."""
    values, vectors = np.linalg.eigh(scalings.D)
    root = (vectors * np.sqrt(np.maximum(values, 1e-300))) @ vectors.conj().T
    left, _, right = np.linalg.svd(root @ np.linalg.solve(root.T, M.T).T)
    # M v = sigma u, and Q u = v makes v an eigenvector of M Q in scaled states
    yield directions.align(left[:, 0], right[0].conj())
    real = [part.start for place, part in directions.parts(np.zeros(0)) if place.real]
    if real and len(real) <= MOST_SIGNS:
        for signs in product((1.0, -1.0), repeat=len(real)):
            p = directions.random(rng)
            p[real] = signs
            yield p
    for _ in range(STARTS):
        yield directions.random(rng)


def complex_peak(M: Complex, directions: Directions, p: Array) -> EigenvaluePeak:
    """A local maximum of the spectral radius; a turn of all blocks by one angle makes the eigenvalue positive."""

    def negative(p: Array) -> tuple[float, Array]:
        value, y, x, _ = eigenvalue(M, directions.Q(p), None)
        size = max(abs(value), 1e-300)
        return -size, -np.real(np.conj(value) / size * directions.slopes(p, M.conj().T @ y, x))

    found = optimize.minimize(negative, p, jac=True, method="BFGS", options={"gtol": 1e-12, "maxiter": 300})
    return _turned(M, directions, np.asarray(found.x))


def _turned(M: Complex, directions: Directions, p: Array) -> EigenvaluePeak:
    value, *_ = eigenvalue(M, directions.Q(p), None)
    turn, p = np.angle(value), p.copy()
    for place, part in directions.parts(p):
        if place.full:
            u, v = _vectors(p[part])
            u = u * np.exp(-1j * turn)
            p[part] = np.concatenate([u.real, u.imag, v.real, v.imag])
        else:
            p[part] -= turn
    return EigenvaluePeak(complex(abs(value)), p)


def _mixed_peaks(M: Complex, directions: Directions, p: Array) -> list[EigenvaluePeak]:
    """Local maxima of the real eigenvalues, from the eigenvalues at a start that lie most to the right."""
    *_, values = eigenvalue(M, directions.Q(p), None)
    starts = sorted({complex(v) for v in values if v.real > 0 or v.imag}, key=lambda v: -v.real)[:2]
    return [peak for near in starts if (peak := _mixed_peak(M, directions, p, near)) is not None]


def largest_real_value(
    of: Callable[[Array], tuple[complex, Complex]], start: Array, bounds: optimize.Bounds, tolerance: float
) -> Array:
    """The place of a local maximum of a function with its slopes, where its value is real."""

    def objective(p: Array) -> tuple[float, Array]:
        value, slopes = of(p)
        return -value.real, -slopes.real

    is_real = {"type": "eq", "fun": lambda p: of(p)[0].imag, "jac": lambda p: of(p)[1].imag}
    # SciPy's stub has no objective that returns its slopes, too
    result = optimize.minimize(  # type: ignore[call-overload]
        objective,
        start,
        jac=True,
        method="SLSQP",
        bounds=bounds,
        constraints=[is_real],
        options={"ftol": tolerance, "maxiter": MOST_STEPS},
    )
    return np.asarray(result.x)


def _mixed_peak(M: Complex, directions: Directions, p: Array, near: complex) -> EigenvaluePeak | None:
    last: list[tuple[Array, complex, Complex]] = [(p + np.nan, near, np.zeros(0, dtype=complex))]

    def of(p: Array) -> tuple[complex, Complex]:
        if not np.array_equal(p, last[0][0]):
            value, y, x, _ = eigenvalue(M, directions.Q(p), last[0][1])
            last[0] = p.copy(), value, directions.slopes(p, M.conj().T @ y, x)
        return last[0][1:]

    p = largest_real_value(of, p, directions.bounds(), 1e-14)
    value = of(p)[0]
    if not value.real > 0 or abs(value.imag) > 1e-6 * abs(value):
        return None
    return EigenvaluePeak(value, p)
