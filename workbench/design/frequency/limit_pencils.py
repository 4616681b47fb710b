"""A proof that a pencil M - s N of doubles is singular nowhere on the limit of stability, from its eigenvectors.

Let V have the eigenvectors as columns, as they are computed, and let the residual be R = M V - N V diag(l). Then

    (M - s N) V = Y diag(l - s) + R,     Y = N V,

which is regular if I + W R diag(l - s)^-1 is, but for the rounding of W, nearly Y^-1. This holds at every s on the
limit if the spectral radius of |I - W Y| + |W R| diag(m)^-1 is below one, where m_j is the distance of l_j from the
limit. Making R smaller by t from 1 to 0 keeps that, so as many eigenvalues lie on each side as l_j do. Eigenvalues
beyond the circle, and infinite ones, have M and N change places. Pairs of conjugate eigenvalues are taken by real and
imaginary part, so that all matrices are real.

References
----------
Rump (2001), Computational error bounds for multiple or nearly multiple eigenvalues, Linear Algebra Appl. 324 (bounds
from approximate eigenvectors). Dongarra, Moler, Wilkinson (1983), Improving the accuracy of computed eigenvalues and
eigenvectors, SIAM J. Numer. Anal. 20 (the refinement).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.frequency.wide_matrices import U, Wide, is_contraction
from workbench.design.matrices import Complex

STEPS = 4  # of refinement; each doubles the digits
NEAR = 1e-12  # relative: eigenvalues that are nearer to each other are not separated


@dataclass(frozen=True, eq=False)
class Pencil:
    """The pencil M - s N, (k, k), on the imaginary axis or, `discrete`, on the circle; N has `free` last columns zero.

    As they stand, these columns are those of eigenvalues at infinity.
    """

    M: Wide
    N: Wide
    free: int
    discrete: bool


@dataclass(frozen=True, eq=False)
class Eigensystem:
    """Eigenvalues alpha / beta (n,) of a pencil, one of both being 1, and vectors (k, n).

    Conjugate eigenvalues are neighbours; their two columns are the real and the imaginary part of the first vector.
    """

    alpha: Complex
    beta: Complex
    vectors: Wide

    @staticmethod
    def of(alpha: Complex, beta: Complex, vectors: Complex, discrete: bool) -> Eigensystem:
        """The eigensystem of complex vectors, conjugate ones being neighbours."""
        size = np.abs(vectors).max(axis=0)
        columns, k = (vectors / np.where(size > 0, size, 1)).real.copy(), 0
        while k < len(alpha):
            if alpha[k].imag != 0 or beta[k].imag != 0:
                columns[:, k + 1] = (vectors[:, k] / size[k]).imag
                k += 1
            k += 1
        inside = np.abs(alpha) <= np.abs(beta) if discrete else np.ones(len(alpha), dtype=bool)
        one = np.ones(len(alpha))
        with np.errstate(all="ignore"):
            return Eigensystem(
                np.where(inside, alpha / beta, one), np.where(inside, one, beta / alpha), Wide.of(columns)
            )

    @property
    def values(self) -> Complex:
        """The finite or infinite eigenvalues."""
        with np.errstate(all="ignore"):
            return np.asarray(self.alpha / self.beta)

    @property
    def blocks(self) -> list[tuple[int, int]]:
        """The first place and the number of columns of each real eigenvalue or conjugate pair."""
        blocks, k = [], 0
        while k < len(self.alpha):
            count = 2 if self.alpha[k].imag != 0 or self.beta[k].imag != 0 else 1
            blocks.append((k, count))
            k += count
        return blocks


@dataclass(frozen=True, eq=False)
class LimitProof:
    """True if it `is_proved` that no eigenvalue lies on the limit; the `values` as they are refined."""

    is_proved: bool
    values: Complex

    def outside(self, discrete: bool) -> int:
        """The number of eigenvalues right of the axis or beyond the circle, once it is proved that none lies on it."""
        return int((np.abs(self.values) > 1 if discrete else self.values.real > 0).sum())


def refine(pencil: Pencil, system: Eigensystem, steps: int) -> Eigensystem:
    """The eigensystem after some steps of refinement; fewer where one fails."""
    for _ in range(steps):
        step = _Step.of(pencil, system)
        if step is None:
            break
        system = step.improve()
    return system


def prove_off_limit(pencil: Pencil, system: Eigensystem) -> LimitProof:
    """The proof with the eigenvectors as they are, or else refined in twice the precision."""
    best = system.values
    for _ in range(STEPS + 1):
        step = _Step.of(pencil, system)
        if step is None:
            break
        best = system.values
        if step.proves(pencil.discrete):
            return LimitProof(True, best)
        system = step.improve()
    return LimitProof(False, best)


@dataclass(frozen=True, eq=False)
class _Step:
    """An eigensystem with Y, its inverse W as computed, and the residual R, all in real columns."""

    system: Eigensystem
    Y: Wide
    W: Wide
    R: Wide
    free: int

    @staticmethod
    def of(pencil: Pencil, system: Eigensystem) -> _Step | None:
        """The step, or None where Y has no inverse."""
        V, n, inside = system.vectors, len(system.alpha), system.beta == 1
        MV, NV = pencil.M @ V, pencil.N @ V
        near = _choose(inside, NV, MV)
        R = _choose(inside, MV, NV) - near @ _real_blocks(system, np.where(inside, system.alpha, system.beta))
        own = pencil.M[:, len(pencil.M.high) - pencil.free :]
        Y = Wide(*(np.hstack(parts) for parts in zip(_parts(near), _parts(own), strict=True)))
        if not (np.isfinite(Y.high).all() and np.isfinite(R.high).all()):
            return None
        try:
            W = wide_inverse(Y)
        except np.linalg.LinAlgError:
            return None
        return _Step(system, Y, W, R, pencil.free) if np.isfinite(W.high).all() and n else None

    def proves(self, discrete: bool) -> bool:
        """True if the spectral radius is below one."""
        system, n = self.system, len(self.system.alpha)
        G = (self.W @ self.Y - np.eye(len(self.Y.high))).size
        small = np.where(system.beta == 1, system.alpha, system.beta)
        apart = 1 - np.abs(small) - 8 * U if discrete else np.abs(small.real)
        if not (apart > 0).all():
            return False
        moved = (self.W @ self.R).size
        for first_column, count in system.blocks:
            columns = slice(first_column, first_column + count)
            moved[:, columns] = moved[:, columns].sum(axis=1, keepdims=True)
        G[:, :n] += moved / apart * (1 + 16 * U)
        return is_contraction(G * (1 + 16 * U))

    def improve(self) -> Eigensystem:
        """The eigensystem after a step of first order."""
        system, n = self.system, len(self.system.alpha)
        Q, inverse = _complex_basis(system)
        moved = self.W.high @ self.R.high
        S = np.vstack([inverse @ moved[:n], moved[n:]]) @ Q
        inside, one = system.beta == 1, np.ones(self.free)
        alpha, beta = np.concatenate([system.alpha, one]), np.concatenate([system.beta, 0 * one])
        across = alpha[:, None] * system.beta - beta[:, None] * system.alpha
        X = np.where(inside, -S, S) / np.where(np.abs(across) > 0, across, np.inf)
        scale = np.hypot(np.abs(alpha), np.abs(beta))
        X[np.abs(across) <= NEAR * scale[:, None] * scale[:n]] = 0
        own = np.diag(S[:n]).copy()
        real = (np.vstack([Q @ X[:n], X[n:]]) @ inverse).real
        for first, count in system.blocks:
            own[first : first + count] = own[first].real if count == 1 else [own[first], own[first].conj()]
        V = system.vectors
        change = V.high @ real[:n]
        if self.free:
            change[-self.free :] += real[n:]
        low = V.low + change
        total = V.high + low
        vectors = Wide(total, low - (total - V.high), np.zeros_like(total))
        return Eigensystem(np.where(inside, system.alpha + own, 1), np.where(inside, 1, system.beta + own), vectors)


def _parts(M: Wide) -> tuple[Array, Array, Array]:
    return M.high, M.low, M.radius


def _choose(inside: Array, first: Wide, second: Wide) -> Wide:
    """The columns of the first matrix where they are inside, and those of the second elsewhere."""
    return Wide(*(np.where(inside, a, b) for a, b in zip(_parts(first), _parts(second), strict=True)))


def _real_blocks(system: Eigensystem, values: Complex) -> Array:
    """The real block diagonal matrix with these eigenvalues."""
    blocks = np.zeros((len(values), len(values)))
    for k, count in system.blocks:
        a, b = values[k].real, values[k].imag
        blocks[k : k + count, k : k + count] = [[a]] if count == 1 else [[a, b], [-b, a]]
    return blocks


def _complex_basis(system: Eigensystem) -> tuple[Complex, Complex]:
    """The matrix that takes real columns to a vector and its conjugate, and its inverse."""
    n = len(system.alpha)
    Q, inverse = np.eye(n, dtype=complex), np.eye(n, dtype=complex)
    for k, count in system.blocks:
        if count == 2:
            Q[k : k + 2, k : k + 2] = [[1, 1], [1j, -1j]]
            inverse[k : k + 2, k : k + 2] = [[0.5, -0.5j], [0.5, 0.5j]]
    return Q, inverse


def wide_inverse(Y: Wide) -> Wide:
    """Nearly the inverse, as a matrix without a radius, computed with rows and columns of one size."""
    rows = np.exp2(-np.round(np.log2(np.abs(Y.high).max(axis=1))))[:, None]
    columns = np.exp2(-np.round(np.log2((np.abs(Y.high) * rows).max(axis=0))))
    scaled = Wide(Y.high * rows * columns, Y.low * rows * columns, np.zeros_like(Y.high))
    first = Wide.of(np.asarray(np.linalg.inv(scaled.high)))
    W = first + first @ (Wide.of(np.eye(len(rows))) - scaled @ first)
    return Wide(W.high * columns[:, None] * rows.T, W.low * columns[:, None] * rows.T, np.zeros_like(W.high))
