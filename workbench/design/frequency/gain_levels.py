"""A proof in floating point that no singular value of a transfer matrix G meets a level g on the limit of stability.

A singular value of G(s) is g for some u, y with g y = G(s) u and g u = G(s)* y. With the states x of G and z of its
adjoint this is the singularity of a pencil, M - s N, whose entries are those of A, B, C, D and g as they are:

    s x = A x + B u,   s z = -A'z - C'y,   g y = C x + D u,   g u = B'z + D'y      on the axis,
    s x = A x + B u,   z = s A'z + C'y,    g y = C x + D u,   g u = s B'z + D'y    on the circle.

Its finite eigenvalues on the axis are those of the Hamiltonian matrix of the bounded real lemma, from which the
approximations come. As no singular value meets g, and all are below it at one point, they are below it everywhere.

References
----------
Boyd, Balakrishnan, Kabamba (1989), A bisection method for computing the H-infinity norm of a transfer matrix and
related problems, Math. Control Signals Systems 2, theorem 2. Boyd, El Ghaoui, Feron, Balakrishnan (1994), Linear Matrix
Inequalities in System and Control Theory, section 2.7.2 (bounded real lemma).
"""

from __future__ import annotations

import numpy as np
from scipy import linalg

from workbench.core.validation.refusals import Array
from workbench.design.frequency.limit_pencils import Eigensystem, LimitProof, Pencil, prove_off_limit
from workbench.design.frequency.modal_systems import ModalSystem
from workbench.design.frequency.wide_matrices import Wide, is_positive_definite, stack


def prove_poles(system: ModalSystem) -> LimitProof:
    """The proof that no pole lies on the limit of stability."""
    values, vectors = np.linalg.eig(system.A.high)
    pencil = Pencil(system.A, system.E, 0, system.discrete)
    return prove_off_limit(pencil, Eigensystem.of(values, np.ones_like(values), vectors, system.discrete))


def hamiltonian_of_level(system: ModalSystem, level: float) -> tuple[Array, Array]:
    """The Hamiltonian matrix (2 n, 2 n) of the continuous form at a level, and the matrix from x, z to u, y."""
    A, B, C, D = system.continuous
    n, (ny, nu) = len(A), D.shape
    direct = np.block([[D, -level * np.eye(ny)], [-level * np.eye(nu), D.T]])
    seen = linalg.block_diag(C, B.T)
    signals = np.asarray(-np.linalg.solve(direct, seen))
    H = linalg.block_diag(A, -A.T)
    H[:n] += B @ signals[:nu]
    H[n:] -= C.T @ signals[nu:]
    return H, signals


def prove_level(system: ModalSystem, level: float) -> LimitProof:
    """The proof that no singular value on the limit of stability is the level."""
    H, signals = hamiltonian_of_level(system, level)
    values, vectors = np.linalg.eig(H)
    alpha, beta = values, np.ones_like(values)
    if system.discrete:  # s = (z - 1) / (z + 1), and the states there are (z + 1) / 2 times those of the system
        alpha, beta = 1 + values, 1 - values
    whole = np.vstack([vectors * (beta / np.sqrt(2.0) if system.discrete else 1), signals @ vectors])
    return prove_off_limit(_pencil(system, level), Eigensystem.of(alpha, beta, whole, system.discrete))


def _pencil(system: ModalSystem, level: float) -> Pencil:
    E, A, B, C, D = system.E, system.A, system.B, system.C, system.D
    ny, nu = D.high.shape
    n = len(A.high)

    def none(rows: int, columns: int) -> Wide:
        return Wide.of(np.zeros((rows, columns)))

    of_u, of_y = Wide.of(-level * np.eye(nu)), Wide.of(-level * np.eye(ny))
    last = [none(nu, n), none(nu, n), of_u, D.T]
    own, moved, seen = (-A.T, E.T, B.T) if not system.discrete else (E.T, A.T, -B.T)
    if not system.discrete:
        last[1], seen = seen, none(nu, n)
    M = [[A, none(n, n), B, none(n, ny)], [none(n, n), own, none(n, nu), -C.T], [C, none(ny, n), D, of_y], last]
    rest = [none(n, nu), none(n, ny)]
    N = [
        [E, none(n, n), *rest],
        [none(n, n), moved, *rest],
        [none(ny, n), none(ny, n), none(ny, nu), none(ny, ny)],
        [none(nu, n), seen, none(nu, nu), none(nu, ny)],
    ]
    return Pencil(stack(M), stack(N), nu + ny, system.discrete)


def is_below(response: Wide, level: float) -> bool:
    """True only if every singular value of a real matrix is below a level: g^2 I - T'T is positive definite."""
    g = level * np.eye(response.high.shape[1])
    return is_positive_definite(Wide.of(g) @ g - response.T @ response)
