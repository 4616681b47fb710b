"""The gains L1, L2 of a state observer of Luenberger's structure, as numbers that were checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.validation.refusals import Array
from workbench.validation.signatures import door


@dataclass(frozen=True, eq=False)
@door
class Gains:
    """L1 (n, n) in 1/s and L2 (n, n) in 1/s^2 of

        q_hat'  = qd_hat + L1 (q - q_hat)
        qd_hat' = f(q_hat, qd_hat, tau) + L2 (q - q_hat),    f = M^-1 (tau - C qd - G).

    They have the right sign if the error decays where the model adds nothing to it: all eigenvalues of
    [[-L1, I], [-L2, 0]] have a negative real part. For one joint that is L1 > 0 and L2 > 0.

    Raises
    ------
    ValueError
        If L1 or L2 is not square and finite, they differ in size, or have the wrong sign.
    """

    L1: Array
    L2: Array

    def __post_init__(self) -> None:
        L1, L2 = (_square(name, getattr(self, name)) for name in ("L1", "L2"))
        if L1.shape != L2.shape:
            raise ValueError(f"`Gains(L1, L2)` must be of one size, a row a joint; got {L1.shape} and {L2.shape}.")
        for name, L in (("L1", L1), ("L2", L2)):
            L.flags.writeable = False
            object.__setattr__(self, name, L)
        slowest = max(np.linalg.eigvals(self.error_matrix()), key=lambda s: float(s.real))
        if slowest.real >= 0:
            raise ValueError(
                "`Gains(L1, L2)` must have the sign that lets the error decay where the model adds nothing to it, as "
                f"positive definite ones do; with these [[-L1, I], [-L2, 0]] has the eigenvalue {slowest:.4g} 1/s."
            )

    @property
    def joints(self) -> int:
        """The number of joints n."""
        return len(self.L1)

    @property
    def stacked(self) -> Array:
        """L = [L1; L2], (2n, n)."""
        return np.vstack([self.L1, self.L2])

    @door
    def error_matrix(self, J: Array | None = None) -> Array:
        """A = [[-L1, I], [-L2, 0] + J], (..., 2n, 2n): the error's rate by the error (x1~, x2~).

        Parameters
        ----------
        J
            [df/dq, df/dqd], (..., n, 2n); none for an f that does not depend on the state.
        """
        n = self.joints
        if J is not None and J.shape[-2:] != (n, 2 * n):
            raise ValueError(f"`error_matrix(J=...)` must have shape (..., {n}, {2 * n}); got {J.shape}.")
        lower = np.hstack([-self.L2, np.zeros((n, n))])
        lower = lower if J is None else lower + J
        upper = np.broadcast_to(np.hstack([-self.L1, np.eye(n)]), lower.shape)
        return np.concatenate([upper, lower], axis=-2)


def _square(name: str, given: Array) -> Array:
    L = given.copy()
    if L.ndim != 2 or L.shape[0] != L.shape[1] or not L.size:
        raise ValueError(f"`Gains({name}=...)` must be square, a row and a column a joint; got shape {L.shape}.")
    if not np.isfinite(L).all():
        i, j = np.argwhere(~np.isfinite(L))[0]
        raise ValueError(f"`Gains({name}=...)` must be finite; its entry [{i}, {j}] is {L[i, j]}.")
    return L
