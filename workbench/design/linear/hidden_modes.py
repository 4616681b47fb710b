"""The modes of a linear system that no input moves or no output shows, also of hundreds of states in seconds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from workbench.core.validation.refusals import Array
from workbench.design.linear.linear_modes import TOLERANCE, HautusMode, hautus_mode, mode_at
from workbench.design.linear.operating_point import state_space
from workbench.design.matrices import EPS, Complex

if TYPE_CHECKING:
    import control

LARGE = 64  # states, from which a singular value takes so long that no minimum is sought nearby
HUGE = 1e100  # beyond it the inverse of the eigenvectors has no digits, and its square is not finite
MOST = 24  # modes of such a system that are decided by a singular value: some seconds
Mask = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


def hidden_modes(system: control.StateSpace, kind: str, dead: float = 0.0) -> tuple[tuple[HautusMode, ...], int]:
    """The modes that fail the test of Hautus, and the number of those that are not decided; of a pair only one.

    `kind` is "controllable" or "observable". Modes whose size is below `dead` are left out. See `controllability` for
    the tolerance.

    A mode that its eigenvectors prove to pass needs no singular value. A mode of a system with many states is not
    decided if rounding errors may move its eigenvalue too far, or if more than `MOST` modes are in doubt.
    """
    A, B, Cy, _ = state_space(kind, system)
    if kind == "observable":
        A, B = A.T, Cy.T
    values, radii, passing = _proved_modes(A, B)
    doubtful = np.flatnonzero(~passing & (values.imag >= -1e-9 * np.abs(values)) & (np.abs(values) >= dead))
    names, scale = system.state_labels, float(np.linalg.norm(np.hstack([A, B]), 2)) or 1.0
    found, undecided = list[HautusMode](), max(len(doubtful) - MOST, 0) if len(A) > LARGE else 0
    for k in doubtful[: len(doubtful) - undecided]:
        if len(A) <= LARGE:
            mode, sure = hautus_mode(A, B, complex(values[k]), scale, names), True
        else:
            mode = mode_at(A, B, complex(values[k]), scale, names)
            sure = mode.margin <= TOLERANCE or mode.margin - radii[k] / scale > TOLERANCE
        if mode.margin <= TOLERANCE and abs(mode.value) >= dead:  # a multiple z = 0 is found when it is refined
            found.append(mode)
        undecided += not sure
    return tuple(sorted(found, key=lambda mode: mode.margin)), undecided


def _proved_modes(A: Array, B: Array) -> tuple[Complex, Array, Mask]:
    """The eigenvalues (n,), the distances by which rounding may move them, and the mask of those that pass the test.

    With unit right eigenvectors and rows w_k of the inverse of their matrix, let g_k = |w_k B| / |w_k| and S_k the sum
    of |w_j| / |lambda_k - lambda_j| over j. A unit row v with |v (lambda_k I - A)| <= s has parts s / |lambda_k -
    lambda_j| at most along w_j. So |v B| <= s only if s >= g_k / (1 + S_k (g_k + |B|)).
    """
    n, size, drive = len(A), float(np.linalg.norm(A, 2)), float(np.linalg.norm(B, 2))
    values, right = np.linalg.eig(A)
    values = values.astype(complex)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        left = np.full_like(right, np.inf)
    if not (np.abs(left) < HUGE).all():  # a defective eigenvalue
        return values, np.full(n, size), np.zeros(n, dtype=bool)
    condition, error = np.linalg.norm(left, axis=1), n * EPS * float(np.linalg.norm(left, 2) * np.linalg.norm(right, 2))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        apart = np.abs(values[:, np.newaxis] - values)
        np.fill_diagonal(apart, np.inf)
        spread = (condition / apart).sum(axis=1)
        reach = np.maximum(np.linalg.norm(left @ B, axis=1) / condition - error * drive, 0.0)
        least = reach / (1 + spread * (reach + drive))
    radii = n * EPS * size * np.minimum(condition, 1 / EPS)
    scale = float(np.linalg.norm(np.hstack([A, B]), 2)) or 1.0
    return values, radii, np.asarray(least - radii > TOLERANCE * scale)
