r"""Conditions on a linear system x' = A x + B u, y = C x + D u that one quadratic form x' P x proves, P > 0.

    decay above sigma       -(A' P + P A) - 2 sigma P > 0
    damping above zeta      H > 0,  H = -(A' P + P A) - j tan(phi) (P A - A' P),  sin phi = zeta
    gain below gamma        [gamma-blocks] - [A' P + P A, P B, C'; B' P, 0, D'; C, D, 0] > 0

The last is the bounded real lemma. Each left side is linear in (A, B, C, D) once P is chosen, so that what holds of P
over a box of matrices is a question on symmetric matrices alone.

References
----------
Boyd, El Ghaoui, Feron and Balakrishnan (1994), Linear Matrix Inequalities in System and Control Theory, chapters 2, 6.
Chilali and Gahinet (1996), H-infinity design with pole placement constraints, IEEE Trans. Automatic Control 41.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.switching_functions import Mask
from workbench.design.loop_boxes.loop_family import LoopFamily
from workbench.design.matrices import Complex
from workbench.proofs.enclosures import UNIT

DEFECTIVE = 1e9  # the condition of eigenvectors beyond which they give no form
WEIGHTS = 10.0 ** np.arange(1, -6, -1)  # of the states in a Riccati equation
SLACKS = (0.05, 0.005, 0.0)  # shares of the level that are left free


class AbstractCondition(ABC):
    """A condition on the matrices M = [A, B; C, D] of a loop family, as a form S(M) > 0 that is linear in M."""

    @abstractmethod
    def candidates(self, family: LoopFamily, M: Array) -> Iterator[Array]:
        """Symmetric forms P (b, n, n), as computed, with which the condition may hold of M (b, q, w); NaN for none."""

    @abstractmethod
    def constant(self, family: LoopFamily, P: Array) -> tuple[Array, Array]:
        """The part (b, m, m) of S that M has no share in, and a bound of its rounding."""

    @abstractmethod
    def linear(self, family: LoopFamily, P: Array, M: Array) -> Array:
        """The part (b, m, m) of S that is linear in M (b, q, w)."""

    @abstractmethod
    def linear_bound(self, family: LoopFamily, P: Array, size: Array) -> Array:
        """A bound (b, m, m) of the linear part of all M with |M| <= size (b, q, w)."""


def form(condition: AbstractCondition, family: LoopFamily, P: Array, M: Array) -> Array:
    """S(M), as computed."""
    return np.asarray(condition.constant(family, P)[0] + condition.linear(family, P, M))


@dataclass(frozen=True)
class DecayAbove(AbstractCondition):
    """The condition that every pole has a real part below -sigma, in 1/s."""

    sigma: float

    def candidates(self, family: LoopFamily, M: Array) -> Iterator[Array]:
        """Forms of the eigenvectors, in which each mode decays at its own rate, with several weights of the modes."""
        return _modal_forms(M[:, : family.order, : family.order], self.sigma)

    def constant(self, family: LoopFamily, P: Array) -> tuple[Array, Array]:
        """-2 sigma P."""
        part = -2 * self.sigma * P
        return part, 4 * UNIT * np.abs(part)

    def linear(self, family: LoopFamily, P: Array, M: Array) -> Array:
        """-(A' P + P A)."""
        return -_lyapunov(P, M[:, : family.order, : family.order])

    def linear_bound(self, family: LoopFamily, P: Array, size: Array) -> Array:
        """The same with absolute values."""
        return _lyapunov(np.abs(P), size[:, : family.order, : family.order])


@dataclass(frozen=True)
class DampingAbove(AbstractCondition):
    """The condition that every pole has a damping above zeta, 0 <= zeta < 1, and decays."""

    zeta: float

    @property
    def tangent(self) -> float:
        """The tangent of asin(zeta), rounded up."""
        return math.nextafter(self.zeta / math.sqrt((1 - self.zeta) * (1 + self.zeta)) * (1 + 8 * UNIT), math.inf)

    def candidates(self, family: LoopFamily, M: Array) -> Iterator[Array]:
        """Forms of the eigenvectors, in which each mode turns and decays by itself, with several weights."""
        return _modal_forms(M[:, : family.order, : family.order], 0.0)

    def constant(self, family: LoopFamily, P: Array) -> tuple[Array, Array]:
        """Nothing."""
        zero = np.zeros((len(P), 2 * family.order, 2 * family.order))
        return zero, zero

    def linear(self, family: LoopFamily, P: Array, M: Array) -> Array:
        """The real form of H: its real part on the diagonal, its imaginary part beside it."""
        A = M[:, : family.order, : family.order]
        PA = P @ A
        turned = PA.swapaxes(1, 2)
        real, imaginary = -(PA + turned), -self.tangent * (PA - turned)
        return np.asarray(np.block([[real, -imaginary], [imaginary, real]]))

    def linear_bound(self, family: LoopFamily, P: Array, size: Array) -> Array:
        """The same with absolute values."""
        sums = _lyapunov(np.abs(P), size[:, : family.order, : family.order])
        return np.asarray(np.block([[sums, self.tangent * sums], [self.tangent * sums, sums]]))


@dataclass(frozen=True)
class GainBelow(AbstractCondition):
    """The condition that the largest gain from some inputs to some outputs is below `level`, and the loop stable.

    Of a square system `shift` is added to the diagonal of D: with the answers of what is cut to what is added there it
    gives S for 1, T for 0, and (S - T) / 2 for 1 / 2.
    """

    level: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    shift: float = 0.0

    def candidates(self, family: LoopFamily, M: Array) -> Iterator[Array]:
        """Solutions of the Riccati equation of the bounded real lemma, with more or less weight on all states."""
        A, B, C, D = self._parts(family, M)
        D = D + self._diagonal(D.shape[1:])
        V = next(_modal_forms(A, 0.0), np.full_like(A, np.nan))
        with np.errstate(all="ignore"):
            size = np.trace(C.swapaxes(1, 2) @ C, axis1=1, axis2=2) / self.level / np.trace(V, axis1=1, axis2=2)
        Q = V * size[:, np.newaxis, np.newaxis]
        for slack in SLACKS:
            for weight in WEIGHTS:
                yield _riccati(A, B, C, D, self.level * (1 - slack), weight * Q)

    def constant(self, family: LoopFamily, P: Array) -> tuple[Array, Array]:
        """The level on the diagonals of inputs and outputs, less the shift."""
        n, m, k = family.order, len(self.inputs), len(self.outputs)
        part = np.zeros((n + m + k, n + m + k))
        part[n:, n:] = self.level * np.eye(m + k)
        diagonal = self._diagonal((k, m))
        part[n + m :, n : n + m] -= diagonal
        part[n : n + m, n + m :] -= diagonal.T
        whole = np.tile(part, (len(P), 1, 1))
        return whole, np.zeros_like(whole)

    def linear(self, family: LoopFamily, P: Array, M: Array) -> Array:
        """Minus the matrix of the bounded real lemma."""
        return -self._lemma(family, P, M)

    def linear_bound(self, family: LoopFamily, P: Array, size: Array) -> Array:
        """The same with absolute values."""
        return self._lemma(family, np.abs(P), size)

    def _lemma(self, family: LoopFamily, P: Array, M: Array) -> Array:
        A, B, C, D = self._parts(family, M)
        PB, zero = P @ B, np.zeros
        b, m, k = len(M), B.shape[2], C.shape[1]
        turned = [part.swapaxes(1, 2) for part in (PB, C, D)]
        rows = [
            [_lyapunov(P, A), PB, turned[1]],
            [turned[0], zero((b, m, m)), turned[2]],
            [C, D, zero((b, k, k))],
        ]
        return np.asarray(np.block(rows))

    def _parts(self, family: LoopFamily, M: Array) -> tuple[Array, Array, Array, Array]:
        """A, B, C and D, each (b, ...)."""
        n = family.order
        rows = [n + family.outputs.index(name) for name in self.outputs]
        columns = [n + family.inputs.index(name) for name in self.inputs]
        return M[:, :n, :n], M[:, :n][:, :, columns], M[:, rows][:, :, :n], M[:, rows][:, :, columns]

    def _diagonal(self, shape: tuple[int, ...]) -> Array:
        return np.asarray(self.shift * np.eye(shape[0], shape[1]))


def _lyapunov(P: Array, A: Array) -> Array:
    PA = P @ A
    return np.asarray(PA + PA.swapaxes(1, 2))


def _modal_forms(A: Array, sigma: float) -> Iterator[Array]:
    """P = V^-H W V^-1 of the eigenvectors V of A (b, n, n), with weights W of modes that decay faster than sigma."""
    sound: Mask = np.asarray(np.isfinite(A).all(axis=(1, 2)))
    values, V = np.linalg.eig(np.where(sound[:, np.newaxis, np.newaxis], A, -np.eye(A.shape[1])))
    decay = -values.real - sigma
    sound &= (decay > 0).all(axis=1)
    with np.errstate(all="ignore"):
        sound &= np.linalg.cond(V) < DEFECTIVE
        inverse = _inverses(V, sound)
        for power in (0.0, 0.5, 1.0):
            weights = np.where(sound[:, np.newaxis], decay, 1.0) ** -power
            P = np.real(inverse.conj().swapaxes(1, 2) @ (weights[:, :, np.newaxis] * inverse))
            yield _symmetric(P, sound)


def _riccati(A: Array, B: Array, C: Array, D: Array, level: float, Q: Array) -> Array:
    """The stabilising solutions (b, n, n) of the Riccati equation of a gain below a level, with Q more; NaN for none.

    They are P = X2 X1^-1 of the stable subspace [X1; X2] of a Hamiltonian matrix. Their rounding is of no concern: a
    form is put to the test, wherever it comes from.
    """
    n, turned = A.shape[1], [part.swapaxes(1, 2) for part in (A, B, C, D)]
    R = level * np.eye(D.shape[2]) - turned[3] @ D / level
    finite = np.isfinite(Q).all(axis=(1, 2)) & np.isfinite(A).all(axis=(1, 2))
    sound: Mask = np.asarray((np.linalg.eigvalsh(R)[:, 0] > 0) & finite)
    R = np.where(sound[:, np.newaxis, np.newaxis], R, np.eye(D.shape[2]))
    by = np.linalg.solve(R, turned[1]), np.linalg.solve(R, turned[3] @ C) / level
    moved = A + B @ by[1]
    top = np.concatenate([moved, B @ by[0]], axis=2)
    weight = Q + turned[2] @ C / level + turned[2] @ D @ by[1] / level
    H = np.concatenate([top, np.concatenate([-weight, -moved.swapaxes(1, 2)], axis=2)], axis=1)
    H = np.where(sound[:, np.newaxis, np.newaxis], H, np.diag(np.repeat([-1.0, 1.0], n)))
    values, vectors = np.linalg.eig(H)
    order = np.argsort(values.real, axis=1)[:, :n]
    sound &= (values.real < 0).sum(axis=1) == n
    X = np.take_along_axis(vectors, order[:, np.newaxis, :], axis=2)
    return _symmetric(np.real(X[:, n:] @ _inverses(X[:, :n], sound)), sound)


def _inverses(matrices: Complex, sound: Mask) -> Complex:
    """The inverses (b, n, n) of the sound ones; the unit matrix for the others and for singular ones."""
    held = np.where(sound[:, np.newaxis, np.newaxis], matrices, np.eye(matrices.shape[1]))
    with np.errstate(all="ignore"):
        singular = ~(np.abs(np.linalg.det(held)) > 0)
    return np.asarray(np.linalg.inv(np.where(singular[:, np.newaxis, np.newaxis], np.eye(held.shape[1]), held)))


def _symmetric(P: Array, sound: Mask) -> Array:
    return np.where(sound[:, np.newaxis, np.newaxis], (P + P.swapaxes(1, 2)) / 2, np.nan)
