"""The poles of an observer's error with arm, estimate and torque frozen: at states of a region and along a path.

They judge nothing by themselves: frozen poles may all decay and the error grow, or the reverse.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.layout import Array
from workbench.design.observer_gains.certificate import refuse_unfit
from workbench.design.observer_gains.gains import Gains
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.region import Region
from workbench.proofs.grid_search import sequence
from workbench.validation.doors import door
from workbench.validation.views import show
from workbench.validation.words import whole

SAMPLES = 20_000


@dataclass(frozen=True, eq=False)
@show
class Frozen:
    """Poles at N states of a region.

    Parameters
    ----------
    q, qd, tau
        (N, n), in rad, rad/s, N m.
    poles
        (N, 2n), in 1/s.
    """

    q: Array
    qd: Array
    tau: Array
    poles: Array

    @property
    def rates(self) -> Array:
        """How fast the slowest mode decays at each state, in 1/s, (N,); negative where it grows."""
        return np.asarray(-self.poles.real.max(axis=1))

    @property
    def slowest(self) -> float:
        """The least of the rates."""
        return float(self.rates.min())

    @property
    def unstable(self) -> float:
        """The share of the states at which a mode grows."""
        return float((self.rates < 0).mean())


@door
def frozen_poles(mismatch: Mismatch, gains: Gains, q: Array, qd: Array, tau: Array) -> Array:
    """The eigenvalues (N, 2n) of the exact error Jacobian [[-L1, I], [df/dq - L2, df/dqd]] at N states, in 1/s.

    Raises
    ------
    ValueError
        If the states are not a row of n finite numbers each.
    """
    q, qd, tau = _rows("frozen_poles", mismatch, q, qd, tau)
    return np.asarray(np.linalg.eigvals(gains.error_matrix(mismatch.at(q, qd, tau))))


@door
def over(mismatch: Mismatch, gains: Gains, region: Region, samples: int = SAMPLES) -> Frozen:
    """The frozen poles at states spread evenly over a region: what is seen, not a bound.

    Raises
    ------
    ValueError
        If region or gains are those of another arm, or there are no samples.
    """
    whole("over(samples=...)", samples)
    refuse_unfit("over", mismatch, gains, region)
    n, (low, high) = region.joints, region.box
    u = sequence(samples, 3 * n)
    q = low + u[:, :n] * (high - low)
    qd, tau = (2 * u[:, n : 2 * n] - 1) * region.speed, (2 * u[:, 2 * n :] - 1) * region.torque
    return Frozen(q, qd, tau, frozen_poles(mismatch, gains, q, qd, tau))


@door
def along(mismatch: Mismatch, gains: Gains, region: Region, q: Array, qd: Array, tau: Array) -> Frozen:
    """The frozen poles along a path (N, n) of positions, velocities and torques.

    Raises
    ------
    ValueError
        If the path has not a row of n finite numbers each, or leaves the region.
    """
    refuse_unfit("along", mismatch, gains, region)
    path = _rows("along", mismatch, q, qd, tau)
    if (gone := region.outside(*path)).any():
        row = int(np.argmax(gone))
        raise ValueError(
            f"`along(q, qd, tau)` must stay in the region; its row {row} leaves it, with q = {path[0][row].tolist()}, "
            f"qd = {path[1][row].tolist()}, tau = {path[2][row].tolist()}."
        )
    return Frozen(*path, frozen_poles(mismatch, gains, *path))


def _rows(call: str, mismatch: Mismatch, *given: Array) -> tuple[Array, Array, Array]:
    """States and torques (N, n), checked."""
    path = list(given)
    shapes = {part.shape for part in path}
    if len(shapes) > 1 or path[0].ndim != 2 or path[0].shape[1] != mismatch.joints or not len(path[0]):
        raise ValueError(
            f"`{call}(q, qd, tau)` must be {mismatch.joints} numbers a row each; got shapes "
            f"{[part.shape for part in path]}."
        )
    if not all(np.isfinite(part).all() for part in path):
        raise ValueError(f"`{call}(q, qd, tau)` must be finite numbers; it holds NaN or infinity.")
    q, qd, tau = path
    return q, qd, tau
