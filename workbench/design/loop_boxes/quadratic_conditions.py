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
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from workbench.design.loop_boxes.loop_family import LoopFamily
from workbench.proofs.enclosures import UNIT
from workbench.validation.refusals import Array

DEFECTIVE = 1e7  # the condition of eigenvectors from which a Lyapunov equation serves better
WEIGHTS = 10.0 ** np.arange(1.5, -6.1, -0.5)  # of the state in a Riccati equation, the heaviest first
SLACKS = (0.1, 0.03, 0.01, 1e-3, 1e-4)  # shares of the level that are left free


class AbstractCondition(ABC):
    """A condition on the matrices M = [A, B; C, D] of a loop family, as a form S(M) > 0 that is linear in M."""

    @abstractmethod
    def certificate(self, family: LoopFamily, M: Array) -> Array | None:
        """A symmetric P (n, n) with which the condition holds of one M (q, w), as computed; None if none is found."""

    @abstractmethod
    def constant(self, family: LoopFamily, P: Array) -> tuple[Array, Array]:
        """The part (b, m, m) of S that M has no share in, and a bound of its rounding."""

    @abstractmethod
    def linear(self, family: LoopFamily, P: Array, M: Array) -> Array:
        """The part (b, m, m) of S that is linear in M (b, q, w)."""

    @abstractmethod
    def spread(self, family: LoopFamily, P: Array, size: Array) -> Array:
        """A bound (b, m, m) of the linear part of all M with |M| <= size (b, q, w)."""


def form(condition: AbstractCondition, family: LoopFamily, P: Array, M: Array) -> Array:
    """S(M), as computed."""
    return np.asarray(condition.constant(family, P)[0] + condition.linear(family, P, M))


@dataclass(frozen=True)
class PolesDecay(AbstractCondition):
    """The condition that every pole has a real part below -sigma, in 1/s."""

    sigma: float

    def certificate(self, family: LoopFamily, M: Array) -> Array | None:
        """The form of the eigenvectors, in which each mode decays at its own rate."""
        n = family.order
        return _accepted(self, family, M, _modal_form(M[:n, :n] + self.sigma * np.eye(n)))

    def constant(self, family: LoopFamily, P: Array) -> tuple[Array, Array]:
        """-2 sigma P."""
        part = -2 * self.sigma * P
        return part, 4 * UNIT * np.abs(part)

    def linear(self, family: LoopFamily, P: Array, M: Array) -> Array:
        """-(A' P + P A)."""
        return -_lyapunov(P, M[:, : family.order, : family.order])

    def spread(self, family: LoopFamily, P: Array, size: Array) -> Array:
        """The same with absolute values."""
        return _lyapunov(np.abs(P), size[:, : family.order, : family.order])


@dataclass(frozen=True)
class PolesDamped(AbstractCondition):
    """The condition that every pole has a damping above zeta, 0 <= zeta < 1, and decays."""

    zeta: float

    @property
    def tangent(self) -> float:
        """The tangent of asin(zeta), rounded up."""
        return math.nextafter(self.zeta / math.sqrt((1 - self.zeta) * (1 + self.zeta)) * (1 + 8 * UNIT), math.inf)

    def certificate(self, family: LoopFamily, M: Array) -> Array | None:
        """The form of the eigenvectors, in which each mode turns and decays by itself."""
        n = family.order
        return _accepted(self, family, M, _modal_form(M[:n, :n]))

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

    def spread(self, family: LoopFamily, P: Array, size: Array) -> Array:
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

    def certificate(self, family: LoopFamily, M: Array) -> Array | None:
        """A solution of the Riccati equation of the bounded real lemma, with weight on all states and room below."""
        A, B, C, D = (part[0] for part in self._parts(family, M[np.newaxis]))
        D = D + self._diagonal(D.shape)
        if not len(A) or not np.isfinite(M).all() or np.linalg.norm(D, 2) >= self.level:
            return None
        V = _modal_form(A)
        if V is None:
            return None
        Q = V * (np.trace(C.T @ C) / self.level / np.trace(V) + 1e-300)
        for weight in WEIGHTS:
            P = _accepted(self, family, M, _riccati(A, B, C, D, self.level, weight * Q))
            if P is None:
                continue
            room = (_riccati(A, B, C, D, self.level * (1 - slack), weight / 3 * Q) for slack in SLACKS)
            roomy = (_accepted(self, family, M, one) for one in room)
            return next((one for one in roomy if one is not None), P)
        return None

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

    def spread(self, family: LoopFamily, P: Array, size: Array) -> Array:
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
        return self.shift * np.eye(*shape)


def _lyapunov(P: Array, A: Array) -> Array:
    PA = P @ A
    return np.asarray(PA + PA.swapaxes(1, 2))


def _modal_form(A: Array) -> Array | None:
    """P = V^-H V^-1 of the eigenvectors V of A, or of a defective A the solution of A' P + P A = -I."""
    if not len(A) or not np.isfinite(A).all():
        return None
    values, V = np.linalg.eig(A)
    if values.real.max() >= 0:
        return None
    if np.linalg.cond(V) < DEFECTIVE:
        W = np.linalg.inv(V)
        P = np.real(W.conj().T @ W)
    else:
        P = scipy.linalg.solve_continuous_lyapunov(A.T, -np.eye(len(A)))
    return np.asarray((P + P.T) / 2)


def _riccati(A: Array, B: Array, C: Array, D: Array, level: float, Q: Array) -> Array | None:
    """The stabilising solution of the Riccati equation of a gain below a level, with Q more; None if there is none."""
    R = D.T @ D / level - level * np.eye(D.shape[1])
    if np.linalg.eigvalsh(R).max() >= 0:
        return None
    try:
        with np.errstate(all="ignore"):
            P = scipy.linalg.solve_continuous_are(A, B, C.T @ C / level + Q, R, s=C.T @ D / level)
    except (np.linalg.LinAlgError, ValueError):
        return None
    P = np.asarray((P + P.T) / 2)
    return P if np.isfinite(P).all() and np.linalg.eigvalsh(P)[0] > 0 else None


def _accepted(condition: AbstractCondition, family: LoopFamily, M: Array, P: Array | None) -> Array | None:
    """P, if the condition holds with it at the one M (q, w), as computed."""
    if P is None:
        return None
    S = form(condition, family, P[np.newaxis], M[np.newaxis])[0]
    return P if np.isfinite(S).all() and np.linalg.eigvalsh(S)[0] > 0 else None
