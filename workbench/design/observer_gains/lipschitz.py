r"""How strongly an arm can drive its observer's error: (15) with a constant each for positions and velocities,

    |Delta| <= rho_q |q~| + rho_v |qd~|,    rho_q = max |df/dq|, rho_v = max |df/dqd| over a region,

proved by intervals; the norms are 2-norms. Without a bound of the torque there is no such constant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from workbench.core.layout import Array
from workbench.design.certificates import Refused
from workbench.design.observer_gains.certificate import refuse_unfit
from workbench.design.observer_gains.inequality import Inequality, prove
from workbench.design.observer_gains.mismatch import Mismatch
from workbench.design.observer_gains.region import Region
from workbench.proofs.grid_search import sequence
from workbench.validation.doors import door
from workbench.validation.views import show

# Shares above the largest norm that is known, of which the first that can be proved is taken; samples of states.
SHARES, SAMPLES = (0.01, 0.03, 0.1, 0.3), 20_000


@dataclass(frozen=True)
@show
class Bound:
    """`seen` is reached at a state of the region; no state exceeds `proved`."""

    seen: float
    proved: float


@dataclass(frozen=True)
@show
class Lipschitz:
    """rho_q in 1/s^2 and rho_v in 1/s."""

    position: Bound
    velocity: Bound


@door
def lipschitz(mismatch: Mismatch, region: Region) -> Lipschitz:
    """The Lipschitz constants of the mismatch (14) over a region.

    Raises
    ------
    ValueError
        If the region is that of another arm, or any position is allowed to equations that do not repeat.
    Refused
        If no bound within 30 % of what is seen was proved.
    """
    refuse_unfit("lipschitz", mismatch, None, region)
    n = mismatch.joints
    J = mismatch.at(*extremes(region))
    return Lipschitz(*(_bound(mismatch, region, J, slice(i, i + n)) for i in (0, n)))


def extremes(region: Region) -> tuple[Array, Array, Array]:
    """Positions spread over a region, and with them speeds and torques that are each zero or extreme, (N, n) each."""
    n, (low, high) = region.joints, region.box
    u = sequence(SAMPLES, 3 * n)
    speeds, torques = np.floor(3 * u[:, n : 2 * n]) - 1, 2 * np.floor(2 * u[:, 2 * n :]) - 1
    return low + u[:, :n] * (high - low), speeds * region.speed, torques * region.torque


def _bound(mismatch: Mismatch, region: Region, J: Array, columns: slice) -> Bound:
    """The norm of a half of J: t bounds it if [[t I, J], [J', t I]] > 0."""
    n, seen = mismatch.joints, float(np.linalg.norm(J[..., columns], 2, axis=(1, 2)).max())
    F, G = np.vstack([np.eye(n), np.zeros((n, n))]), np.zeros((2 * n, 2 * n))
    G[columns, n:] = np.eye(n)
    for share in SHARES:
        t = max((1 + share) * seen, 1e-9)
        try:
            prove(Inequality(t * np.eye(2 * n), F, G, t * np.eye(2 * n)), mismatch, region, "A Lipschitz constant")
        except Refused:
            continue
        return Bound(seen, t)
    raise Refused(
        f"No Lipschitz constant up to {1 + SHARES[-1]:g} times {seen:.4g}, which is seen, was proved: take a smaller "
        "region, or one without poles."
    )
