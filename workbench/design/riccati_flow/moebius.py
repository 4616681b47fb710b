"""What a piece of time does to P: a Moebius map of symmetric matrices, applied and composed without losing symmetry."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from workbench.validation.refusals import Array


@dataclass(frozen=True, eq=False)
class Moebius:
    """P -> Pi + Phi' P (I + Gamma P)^-1 Phi.

    The flow of P' = A'P + PA - PGP + Q over any piece of time is such a map, and so is that of a symplectic
    integrator. Pi is where P = 0 comes to, Gamma the Gramian of G over the piece, and Phi the transition matrix
    that the poles of both leave. All three stay bounded where exp(tH) grows: composing them is stable.

    Parameters
    ----------
    Phi, Gamma, Pi
        (n, n); Gamma and Pi symmetric, Gamma positive semidefinite but for rounding.
    """

    Phi: Array
    Gamma: Array
    Pi: Array

    @cached_property
    def root(self) -> Array:
        """F (n, n) with Gamma = F' F; a negative eigenvalue can only be rounding, and counts as zero."""
        w, V = np.linalg.eigh(self.Gamma)
        root: Array = np.sqrt(np.maximum(w, 0))[:, None] * V.T
        return root

    @property
    def finite(self) -> bool:
        """Whether all entries are finite."""
        return bool(np.isfinite(self.Phi).all() and np.isfinite(self.Gamma).all() and np.isfinite(self.Pi).all())


@dataclass(frozen=True, eq=False)
class Image:
    """Where a map takes P, or that P escapes to infinity on the way.

    Parameters
    ----------
    P
        (n, n), symmetric; zeros where P escapes.
    escaped
        Whether P has a pole within the piece of time.
    loss
        By how much rounding of the map is magnified in P, relative to P.
    """

    P: Array
    escaped: bool
    loss: float


def hamiltonian(A: Array, G: Array, Q: Array) -> Array:
    """H (2n, 2n) of [U; V]' = H [U; V], whose quotient P = V U^-1 obeys P' = A'P + PA - PGP + Q."""
    return np.block([[-A, G], [Q, A.T]])


def of_transition(E: Array) -> Moebius:
    """The map of a transition matrix E (2n, 2n) of [U; V] over a piece so short that its U, from U = I, is regular."""
    n = len(E) // 2
    Phi: Array = np.array(np.linalg.inv(E[:n, :n]))
    return Moebius(Phi, _symmetric(Phi @ E[:n, n:]), _symmetric(E[n:, :n] @ Phi))


def applied(piece: Moebius, P: Array) -> Image:
    """The image of a symmetric P (n, n).

    With P = L S L', S a diagonal of signs, P (I + Gamma P)^-1 = L X^-1 L' where X = S + L' Gamma L is symmetric.
    Gamma grows with the length of the piece, so the eigenvalues of X only rise: P has had a pole within the
    piece if and only if X has fewer negative eigenvalues than S. (Gamma must be positive semidefinite.)

    References
    ----------
    Reid (1972), Riccati Differential Equations, chapter II (comparison, conjugate points).
    """
    w, V = np.linalg.eigh(P)
    w, L = w[w != 0], (V * np.sqrt(np.abs(w)))[:, w != 0]
    M = piece.root @ L
    if (w > 0).all():  # X = I + M'M by its root, which rounding leaves regular
        root = np.linalg.qr(np.vstack([np.eye(w.size), M]), mode="r")
        half = scipy.linalg.solve_triangular(root, L.T, trans="T", check_finite=False)
        inner = half.T @ half
    else:
        mu, Y = np.linalg.eigh(np.diag(np.sign(w)) + M.T @ M)
        if (mu < 0).sum() != (w < 0).sum() or not mu.all():
            return Image(np.zeros_like(P), True, np.inf)
        inner = (L @ Y / mu) @ (L @ Y).T
    image = _symmetric(piece.Pi + piece.Phi.T @ inner @ piece.Phi)
    reach = _norm(inner @ piece.Phi)
    terms = reach * reach * _norm(piece.Gamma) + 2 * reach * _norm(piece.Phi) + _norm(piece.Pi)
    size = _norm(image)
    return Image(image, False, terms / size if size else 1.0)


def composed(first: Moebius, then: Moebius) -> Moebius | None:
    """One map for two pieces of time in succession; None if P escapes between from P = 0."""
    through = applied(then, first.Pi)
    if through.escaped:
        return None
    n = len(first.Phi)
    W = np.linalg.solve(np.eye(n) + then.Gamma @ first.Pi, np.hstack([then.Phi, then.Gamma @ first.Phi.T]))
    return Moebius(first.Phi @ W[:, :n], _symmetric(first.Gamma + first.Phi @ W[:, n:]), through.P)


def _symmetric(X: Array) -> Array:
    half: Array = (X + X.T) / 2
    return half


def _norm(X: Array) -> float:
    return float(np.linalg.norm(X))
