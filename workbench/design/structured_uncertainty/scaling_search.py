"""The scalings D and G of the least upper bound, found on the path of analytic centres.

For a level t = beta^2 the scalings are sought for which

    t D - M'DM - j (G M - M'G) > 0,    D > 0,

which is linear in both. The centre of this set is followed while t falls, by a tangent step and Newton's method.

References
----------
Fan, Tits and Doyle (1991), Robustness in the presence of mixed parametric uncertainty and unmodeled dynamics, IEEE
Trans. Autom. Control 36. Boyd and El Ghaoui (1993), Method of centers for minimizing generalized eigenvalues, Linear
Algebra and its Applications 188.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.matrices import Complex
from workbench.design.structured_uncertainty.uncertainty_blocks import Places

Stack: TypeAlias = NDArray[np.complex128]  # (variables, n, n)
LARGEST_G = 1e6  # times the size of M: how far G may grow beside D
MOST_STEPS, MOST_NEWTON = 80, 40
CENTRED = 0.1  # the decrement of Newton's method at which a point counts as a centre
SHARE = 0.9  # of the way to the boundary that a tangent step goes
ENOUGH = 1e-10  # relative: the distance of the level from the bound at which the search ends


@dataclass(frozen=True, eq=False)
class Scalings:
    """D, positive definite, and G, Hermitian and zero outside real blocks: both commute with each perturbation."""

    D: Complex
    G: Complex

    def form(self, M: Complex) -> Complex:
        """M'DM + j (G M - M'G), whose largest eigenvalue relative to D is the square of a bound."""
        cross = 1j * self.G @ M
        form = M.conj().T @ self.D @ M + cross + cross.conj().T
        return np.asarray((form + form.conj().T) / 2)

    def square(self, M: Complex) -> float:
        """The square of the bound, not rounded upward; it may be negative."""
        n = len(M)
        return float(linalg.eigh(self.form(M), self.D, eigvals_only=True, subset_by_index=[n - 1, n - 1])[0])


@dataclass(frozen=True, eq=False)
class _Sets:
    """The matrices of each variable in D, in G, and in the form."""

    D: Stack
    G: Stack
    forms: Stack
    real: list[int]
    largest: float

    @staticmethod
    def of(M: Complex, places: tuple[Places, ...], share: float) -> _Sets:
        n, only_real = len(M), not M.imag.any()
        Ds, Gs = [], []
        for place in places:
            basis = [_placed(np.eye(place.size), place, n)]
            if not place.full:
                basis = [_placed(E, place, n) for E in _hermitian(place.size, only_real)]
            Ds += basis
            Gs += [np.zeros((n, n), dtype=complex)] * len(basis)
            if place.real:
                basis = [_placed(E, place, n) for E in _hermitian_of_g(place.size, only_real)]
                Ds += [np.zeros((n, n), dtype=complex)] * len(basis)
                Gs += basis
        forms = np.array([Scalings(D, G).form(M) for D, G in zip(Ds, Gs, strict=True)])
        real = [i for place in places if place.real for i in range(n)[place.span]]
        return _Sets(np.array(Ds), np.array(Gs), forms, real, share * float(np.linalg.norm(M, 2)))

    def constraints(self, t: float) -> Iterator[Stack]:
        """The matrices of each condition: a weighted sum of them must be positive definite."""
        yield t * self.D - self.forms
        yield self.D
        if self.real and self.G.any():
            part = np.ix_(range(len(self.D)), self.real, self.real)
            yield self.largest * self.D[part] - self.G[part]
            yield self.largest * self.D[part] + self.G[part]

    def scalings(self, x: Array) -> Scalings:
        return Scalings(np.tensordot(x, self.D, 1), np.tensordot(x, self.G, 1))


@np.errstate(all="ignore")  # what leaves the range of doubles ends the search
def best_scalings(
    M: Complex,
    places: tuple[Places, ...],
    enough: float = ENOUGH,
    largest: float = LARGEST_G,
    level: float = -np.inf,
) -> Scalings:
    """Scalings whose bound is near to the least: `enough` is the relative distance of its square.

    With a smaller `largest`, G is smaller beside D and M, and what is made of it is better conditioned. With a `level`
    of the square, the centre for this level is returned, if it has one: it is far from each limit.
    """
    if not M.any():
        return Scalings(np.eye(len(M), dtype=complex), np.zeros_like(M))
    units = even_units(M, places)
    scalings = _path_of_centres(M * units[:, None] / units, places, enough, largest, level)
    outer = np.multiply.outer(units, units)
    return Scalings(scalings.D * outer, scalings.G * outer)


def even_units(M: Complex, places: tuple[Places, ...]) -> Array:
    """Powers of two, equal within a full block, that make rows and columns of a matrix similar in size (Osborne)."""
    units: Array = np.ones(len(M))
    sizes: Array = np.abs(M)
    np.fill_diagonal(sizes, 0.0)
    spans = [np.arange(len(M))[place.span] for place in places]
    groups = [
        part for place, span in zip(places, spans, strict=True) for part in ([span] if place.full else span[:, None])
    ]
    for _ in range(8):
        for group in groups:
            scaled = sizes * units[:, None] / units
            scaled[np.ix_(group, group)] = 0.0
            row, column = float(np.linalg.norm(scaled[group])), float(np.linalg.norm(scaled[:, group]))
            if row > 0 and column > 0:
                units[group] *= math.ldexp(1.0, round(math.log2(column / row) / 2))
    return units


def _path_of_centres(M: Complex, places: tuple[Places, ...], enough: float, largest: float, level: float) -> Scalings:
    """The scalings on the path of centres whose bound is the least."""
    sets = _Sets.of(M, places, largest)
    n, trace = len(M), np.trace(sets.D, axis1=1, axis2=2).real
    x = np.array([1.0 if np.allclose(D, np.diag(np.diag(D).real)) else 0.0 for D in sets.D]) * (trace > 0)
    square = sets.scalings(x).square(M)
    best, least, scale = x, square, square
    t = 1.5 * square
    for _ in range(MOST_STEPS):
        try:
            if square < level * (1 - enough):
                return sets.scalings(_centre(sets, x, level, trace / n)[0])
            x, tangent = _centre(sets, x, t, trace / n)
            square = sets.scalings(x).square(M)
        except ValueError:  # a least bound that only singular scalings have is approached as far as doubles allow
            break
        if square < least:
            best, least = x, square
        if least <= 0 or t - least <= enough * max(t, enough * scale):
            break
        x, t = _tangent_step(sets, M, x, tangent, t)
    return sets.scalings(best)


def _tangent_step(sets: _Sets, M: Complex, x: Array, tangent: Array, t: float) -> tuple[Array, float]:
    """A smaller level and the point that the tangent of the path has there, both well inside."""
    square = sets.scalings(x).square(M)
    plain = square + (1 - SHARE) * (t - square)
    step = (t - square) * 64
    while step > t - plain:
        point, level = x - tangent * step, t - step
        scalings = sets.scalings(point)
        if _inside(sets, point, level):
            low = scalings.square(M)
            if low < plain and _inside(sets, x - SHARE * step * tangent, t - SHARE * step):
                return x - SHARE * step * tangent, t - SHARE * step
        step /= 2
    return x, plain


def _inside(sets: _Sets, x: Array, t: float) -> bool:
    try:
        for stack in sets.constraints(t):
            np.linalg.cholesky(np.tensordot(x, stack, 1))
    except np.linalg.LinAlgError:
        return False
    return True


def _centre(sets: _Sets, x: Array, t: float, weights: Array) -> tuple[Array, Array]:
    """The centre for a level, with the trace of D kept, and the tangent of the path of centres by the level."""
    stacks = list(sets.constraints(t))
    m = len(x)
    for _ in range(MOST_NEWTON):
        gradient, hessian, moving = np.zeros(m), np.zeros((m, m)), np.zeros(m)
        for place, stack in enumerate(stacks):
            inverse = np.linalg.inv(np.tensordot(x, stack, 1))
            parts = inverse @ stack
            gradient -= np.trace(parts, axis1=1, axis2=2).real
            flat = parts.reshape(m, -1)
            hessian += (flat @ parts.transpose(0, 2, 1).reshape(m, -1).T).real
            if place == 0:  # the part of the gradient that moves with t
                D = inverse @ np.tensordot(x, sets.D, 1)
                moving += np.einsum("kij,jl,li->k", parts, D, np.eye(len(D)), optimize=True).real
                moving -= np.trace(inverse @ sets.D, axis1=1, axis2=2).real
        scale = 1 / np.sqrt(np.maximum(np.diag(hessian), 1e-300))
        matrix = np.block([[hessian * scale[:, None] * scale, (weights * scale)[:, None]], [weights * scale, 0]])
        matrix[:m, :m] += 1e-13 * np.eye(m)
        right = np.zeros((m + 1, 2))
        right[:m] = -np.stack([gradient, moving], axis=1) * scale[:, None]
        solved = np.linalg.lstsq(matrix, right, rcond=None)[0] if m < 2 else np.linalg.solve(matrix, right)
        step, tangent = solved[:m, 0] * scale, solved[:m, 1] * scale
        decrement = math.sqrt(max(-float(gradient @ step), 0.0))
        length = 1.0 if decrement < 0.25 else 1 / (1 + decrement)
        while length > 1e-8 and not _inside(sets, x + length * step, t):
            length /= 2
        if not np.isfinite(step).all() or not _inside(sets, x + length * step, t):
            raise np.linalg.LinAlgError("no centre")
        x = x + length * step
        if decrement < CENTRED:
            break
    return x, tangent


def _hermitian(k: int, only_real: bool) -> list[Complex]:
    """A basis of the Hermitian matrices, or of the symmetric ones."""
    basis = []
    for i in range(k):
        for j in range(i, k):
            E = np.zeros((k, k), dtype=complex)
            E[i, j] = E[j, i] = 1
            basis.append(E)
            if i != j and not only_real:
                E = np.zeros((k, k), dtype=complex)
                E[i, j], E[j, i] = 1j, -1j
                basis.append(E)
    return basis


def _hermitian_of_g(k: int, only_real: bool) -> list[Complex]:
    """A basis for G: of a real M, an imaginary one suffices."""
    basis = _hermitian(k, False)
    return [E for E in basis if not E.real.any()] if only_real else basis


def _placed(E: Array | Complex, place: Places, n: int) -> Complex:
    whole = np.zeros((n, n), dtype=complex)
    whole[place.span, place.span] = E
    return whole


def schur_scalings(M: Complex) -> list[Scalings]:
    """Scalings of one repeated complex scalar whose bounds fall towards the spectral radius, for a defective M too.

    In the basis of Schur's form, powers of a small number shrink what is above the diagonal.
    """
    _, Z = linalg.schur(M, output="complex")
    powers = np.arange(len(M))
    zero = np.zeros_like(M)
    bases = [Z * 10.0 ** (-k * (len(M) - 1 - powers)) for k in (1, 2, 3, 4, 5, 6)]
    return [Scalings(np.asarray((base @ base.conj().T + (base @ base.conj().T).conj().T) / 2), zero) for base in bases]
